"""What is told of a test: rms, largest value and peak frequency of responses, joints, drive."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts.extremes import largest_in
from shakerproc.forecasts.motion import Motion, What
from shakerproc.models import BASE, Model
from shakerproc.spectra import cross_spectra, find_peaks, psd

Whose: TypeAlias = Literal["response", "joint", "force", "shaker"]

SEGMENTS: Final = 24
"""Welch segments at least of the density of a test, as `compare` keeps them [-]."""

LONGEST_SEGMENT: Final = 8192
"""Samples of a Welch segment at most."""


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


Largest: TypeAlias = Callable[[FloatArray], float]
"""From samples to the largest size of them in the whole duration of a test."""


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
    """Return the density of each row.

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
    found = cross_spectra(rows, sample_rate, segment=segment, window="hann", inputs=[0])
    return tuple(Density(found.frequency, one, band) for one in psd(found))


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
    motion: Motion,
    spectra: Sequence[Density],
    largest: Largest,
    carried: float | None = None,
) -> dict[Quantity, float]:
    """Return all quantities of a simulated test.

    Parameters
    ----------
    model : Model
        What was shaken.
    motion : Motion
        What it did.
    spectra : sequence of Density
        Of its responses.
    largest : callable
        Tells the largest size in the whole duration.
    carried : float, optional
        Mass that the shaker moves besides the model; None where it is not known [kg].
    """
    found: dict[Quantity, float] = {}
    for (name, samples), spectrum in zip(motion.responses.items(), spectra, strict=True):
        unit = model.sensor_unit(model.sensors[name])
        found |= values_of_response(name, unit, samples, spectrum, largest)
    others = samples_besides(model, motion, carried)
    return found | {quantity: largest(samples) for quantity, samples in others.items()}


def samples_besides(
    model: Model, motion: Motion, carried: float | None = None
) -> dict[Quantity, FloatArray]:
    """Return the samples of joints, force and shaker of a simulated test, (n,) arrays.

    `carried` is the mass that the shaker moves besides the model [kg].
    """
    found: dict[Quantity, FloatArray] = {}
    metre, newton = model.unit_of("m"), model.unit_of("N")
    for pair, joint in motion.joints.items():
        name = "-".join(pair)
        found[Quantity("joint", name, "displacement", metre)] = joint.displacement
        found[Quantity("joint", name, "force", newton)] = joint.force
    into = _force_into(model, motion)
    found[Quantity("force", "", "force", newton)] = into
    for what, samples, unit in motion.table:
        found[Quantity("shaker", "", what, unit)] = samples
        if what == "acceleration" and carried is not None:
            found[Quantity("shaker", "", "force", newton)] = carried * samples - into
    return found


def samples_of(
    quantity: Quantity, model: Model, motion: Motion, carried: float | None
) -> FloatArray:
    """Return the samples of one quantity of a simulated test, (n,) array [its unit]."""
    if quantity.whose == "response":
        return motion.responses[quantity.name]
    return samples_besides(model, motion, carried)[quantity]


def _force_into(model: Model, motion: Motion) -> FloatArray:
    """Return the force of the base, or the one that drives, on the specimen, (n,) array [N]."""
    if not model.excitation.moves_base:
        return motion.drive
    signs = [float(first == BASE) - float(second == BASE) for first, second in motion.joints]
    forces = np.array([joint.force for joint in motion.joints.values()])
    return np.asarray(np.array(signs) @ forces)
