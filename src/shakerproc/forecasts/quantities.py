"""Quantities of a test (rms, largest value, peak frequency), their 90 % bands and limits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts.motion import TestMotion, What
from shakerproc.models import BASE, Model
from shakerproc.spectra import cross_spectra, find_peaks, psd

BLOCKS: Final = 32
"""Parts of the samples whose largest values tell the law of the largest of all [-]."""

EULER: Final = 0.5772156649015329
"""Mean of the standard Gumbel law [-]."""

Whose: TypeAlias = Literal["response", "joint", "force", "shaker"]

SEGMENTS: Final = 24
"""Welch segments at least of the density of a test, as `compare` keeps them [-]."""

LONGEST_SEGMENT: Final = 8192
"""Samples of a Welch segment at most."""

Largest: TypeAlias = Callable[[FloatArray], float]
"""From samples to the largest size of them in the whole duration of a test."""

BAND: Final = 0.9
"""Probability that the truth lies within a band [-]."""

REPEATS: Final = 200
"""Draws of the model error for each simulated test: probabilities to a tenth of a per mille
[-]."""

_PER_DB: Final = np.log(10.0) / 20.0


def largest_in(samples: FloatArray, longer: float = 1.0, chance: float = 0.5) -> float:
    r"""Return the largest size in a duration, drawn where it is longer than the samples.

    .. math:: x_T^2 = u + \beta \left(\ln \frac{T}{B} - \ln(-\ln p)\right), \qquad
        \beta = \frac{\sqrt 6}{\pi} s_B, \quad u = m_B - \gamma \beta

    with mean :math:`m_B` and standard deviation :math:`s_B` of the squares of the largest sizes
    in blocks of length :math:`B`: those of narrow-band Gaussian response follow Gumbel's law
    with one scale whatever the length, twice the variance [2]_. Never below the largest of the
    samples themselves.

    Parameters
    ----------
    samples : (n,) array
        A motion [any unit].
    longer : float
        The duration over that of the samples, 1 where they are all of it [-].
    chance : float
        Quantile :math:`p` of the largest value in the rest, drawn evenly from 0 to 1 [-].

    References
    ----------
    .. [1] E. J. Gumbel, "Statistics of Extremes", Columbia, 1958, ch. 5.
    .. [2] A. G. Davenport, "Note on the distribution of the largest value of a random function
       with application to gust loading", Proc. ICE 28, 187-196, 1964.
    """
    size = np.abs(samples - np.mean(samples))
    own = float(np.max(size))
    if longer <= 1.0 + 1e-9 or size.size < 2 * BLOCKS:
        return own
    n = size.size // BLOCKS
    largest = size[: n * BLOCKS].reshape(BLOCKS, n).max(axis=1) ** 2
    scale = float(np.sqrt(6.0) / np.pi * np.std(largest, ddof=1))
    place = float(np.mean(largest)) - EULER * scale
    rest = BLOCKS * (longer - 1.0)
    square = place + scale * float(np.log(rest) - np.log(-np.log(chance or 1e-12)))
    return max(own, float(np.sqrt(max(square, 0.0))))


@final
@dataclass(frozen=True, slots=True)
class Quantity:
    """One number that is told of a test.

    Attributes
    ----------
    whose : {"response", "joint", "force", "shaker"}
        A sensor, a joint, the force into the specimen, or the table of the shaker.
    name : str
        Sensor, or the places of the joint as ``base-coupon``.
    what : str
        Which number; of joint, force and shaker the largest size in the whole duration.
    unit : str
        SI unit.
    """

    whose: Whose
    name: str
    what: What
    unit: str


@final
@dataclass(frozen=True, slots=True, eq=False)
class Density:
    """Power spectral density of one response.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        From 0 [Hz].
    values : (n_frequencies,) array
        One-sided [unit^2/Hz].
    band : (float, float)
        What is excited [Hz].
    """

    frequency: FloatArray
    values: FloatArray
    band: tuple[float, float]

    @property
    def peak_frequency(self) -> float:
        """Frequency of the largest peak in the excited band [Hz]."""
        peaks = find_peaks(self.frequency, self.values, self.band, count=1)
        if peaks:
            return peaks[0].frequency
        inside = (self.frequency >= self.band[0]) & (self.frequency <= self.band[1])
        return float(self.frequency[np.argmax(np.where(inside, self.values, -1.0))])


def densities(
    rows: FloatArray, sample_rate: float, band: tuple[float, float]
) -> tuple[Density, ...]:
    """Return the density of each row, in which every moment of a sweep counts alike.

    Squares of Hann's window sum to a constant at three quarters of overlap; at a half, the
    resonance of a sweep seems to lie where a segment happens to have its middle.

    Parameters
    ----------
    rows : (n_rows, n) array
        Samples [any unit].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        What is excited [Hz].
    """
    segment = segment_of(rows.shape[1])
    cross = cross_spectra(
        rows, sample_rate, segment=segment, overlap=3 * segment // 4, window="hann", inputs=[0]
    )  # fmt: skip
    return tuple(Density(cross.frequency, one, band) for one in psd(cross))


def segment_of(n_samples: int) -> int:
    """Return the samples of a Welch segment of a test of so many [-]."""
    longest = 1 << int(np.log2(max(n_samples // SEGMENTS, 64)))
    return min(LONGEST_SEGMENT, longest, n_samples)


def values_of_response(
    name: str, unit: str, samples: FloatArray, spectrum: Density, largest: Largest = largest_in
) -> dict[Quantity, float]:
    """Return rms, largest value and peak frequency of a response.

    Parameters
    ----------
    name, unit : str
        Of the sensor.
    samples : (n,) array
        Within the compared band [unit].
    spectrum : Density
        Of the same samples.
    largest : callable
        Tells the largest size; by default that of the samples.
    """
    return {
        Quantity("response", name, "rms", unit): float(np.std(samples)),
        Quantity("response", name, "peak", unit): largest(samples),
        Quantity("response", name, "peak_frequency_hz", "Hz"): spectrum.peak_frequency,
    }


def values_of_motion(
    model: Model,
    motion: TestMotion,
    spectra: Sequence[Density],
    largest: Largest,
    shaker_mass: float | None = None,
) -> dict[Quantity, float]:
    """Return all quantities of a simulated test.

    Parameters
    ----------
    model : Model
        What was shaken.
    motion : TestMotion
        What it did.
    spectra : sequence of Density
        Of its responses.
    largest : callable
        Tells the largest size in the whole duration.
    shaker_mass : float, optional
        Mass that the shaker moves besides the model; None where it is not known [kg].
    """
    values: dict[Quantity, float] = {}
    for (name, samples), spectrum in zip(motion.responses.items(), spectra, strict=True):
        unit = model.sensor_unit(model.sensors[name])
        values |= values_of_response(name, unit, samples, spectrum, largest)
    others = samples_besides(model, motion, shaker_mass)
    return values | {quantity: largest(samples) for quantity, samples in others.items()}


def samples_besides(
    model: Model, motion: TestMotion, shaker_mass: float | None = None
) -> dict[Quantity, FloatArray]:
    """Return the samples of joints, force and shaker of a simulated test, (n,) arrays.

    `shaker_mass` is the mass that the shaker moves besides the model [kg].
    """
    arrays: dict[Quantity, FloatArray] = {}
    metre, newton = model.unit_of("m"), model.unit_of("N")
    for pair, joint in motion.joints.items():
        name = "-".join(pair)
        arrays[Quantity("joint", name, "displacement", metre)] = joint.displacement
        arrays[Quantity("joint", name, "force", newton)] = joint.force
    into = _force_into(model, motion)
    arrays[Quantity("force", "", "force", newton)] = into
    for what, samples, unit in motion.table:
        arrays[Quantity("shaker", "", what, unit)] = samples
        if what == "acceleration" and shaker_mass is not None:
            arrays[Quantity("shaker", "", "force", newton)] = shaker_mass * samples - into
    return arrays


def samples_of(
    quantity: Quantity, model: Model, motion: TestMotion, shaker_mass: float | None
) -> FloatArray:
    """Return the samples of one quantity of a simulated test, (n,) array [its unit]."""
    if quantity.whose == "response":
        return motion.responses[quantity.name]
    return samples_besides(model, motion, shaker_mass)[quantity]


def _force_into(model: Model, motion: TestMotion) -> FloatArray:
    """Return the force of the base, or the one that drives, on the specimen, (n,) array [N]."""
    if not model.excitation.moves_base:
        return motion.drive
    signs = [float(first == BASE) - float(second == BASE) for first, second in motion.joints]
    forces = np.array([joint.force for joint in motion.joints.values()])
    return np.asarray(np.array(signs) @ forces)


@final
@dataclass(frozen=True, slots=True, eq=False)
class UncertainQuantity:
    """A quantity with all that leaves it open.

    Attributes
    ----------
    drawn : (n_draws,) array
        Simulated values, without model error [unit of the quantity].
    all : (n_draws * REPEATS,) array
        The same with model error [unit of the quantity].
    """

    drawn: FloatArray
    all: FloatArray

    @property
    def value(self) -> float:
        """The median."""
        return float(np.median(self.drawn))

    @property
    def band(self) -> tuple[float, float]:
        """The 90 % band."""
        low, high = np.quantile(self.all, [0.5 * (1.0 - BAND), 0.5 * (1.0 + BAND)])
        return float(low), float(high)

    def holds(self, value: float) -> bool:
        """Return whether the 90 % band holds a value [unit of the quantity]."""
        low, high = self.band
        return low <= value <= high

    def quantile(self, probability: float) -> float:
        """Return the value that the quantity does not exceed with a probability [its unit]."""
        return float(np.quantile(self.all, probability))

    def exceeds(self, limit: float) -> float:
        """Return the probability that the quantity exceeds a limit [-]."""
        return float(np.mean(self.all > limit))


def spread_of(
    drawn: FloatArray, error_db: float, freedom: float, read: float = 0.0
) -> UncertainQuantity:
    r"""Return a quantity with its model error and that of its sensor.

    .. math:: x = x_i \, e^{\kappa z} \, 10^{\sigma t_\nu / 20}, \qquad
        \kappa^2 = s^2 n^{-2/3} + r^2

    with the simulated values :math:`x_i`, Student's :math:`t_\nu`, a standard normal :math:`z`,
    the width of the kernel that makes a law of :math:`n` values with the standard deviation
    :math:`s` of their logarithms [1]_, and the uncertainty :math:`r` of a sensor's gain: what
    multiplies a value is drawn for each error of the model, not once for each simulated test.

    Parameters
    ----------
    drawn : (n_draws,) array
        Simulated values, above 0 [unit of the quantity].
    error_db : float
        Scale :math:`\sigma` of the model error [dB].
    freedom : float
        Degrees of freedom :math:`\nu` [-].
    read : float
        Standard uncertainty :math:`r` of what the quantity is read with [-].

    References
    ----------
    .. [1] A. Azzalini, "A note on the estimation of a distribution function and quantiles by a
       kernel method", Biometrika 68, 326-328, 1981.
    """
    generator = np.random.default_rng(0)
    logs = np.log(np.maximum(drawn, np.finfo(float).tiny))
    kernel = float(np.hypot(np.std(logs) * drawn.size ** (-1.0 / 3.0), read))
    size = (drawn.size, REPEATS)
    law = generator.standard_t(freedom, size) if error_db else np.zeros(size)
    moved = _PER_DB * error_db * law
    moved = np.clip(moved, -50.0, 50.0) + kernel * generator.standard_normal(size)
    return UncertainQuantity(drawn, np.exp(logs[:, None] + moved).ravel())
