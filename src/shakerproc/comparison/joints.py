"""The force in each joint as the recordings tell it, and the model's over the same motion."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.equilibrium import Joint, joints_of
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.noise import EXCEEDS
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models import BASE, Element, Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.motion import shown_in
from shakerproc.numerals import numeral
from shakerproc.spectra import periodogram

BINS: Final = 24
"""Parts that the range of displacement or velocity is cut into."""

PER_OCTAVE: Final = 3
"""Bands in an octave in which motion and noise are compared."""

FLANK: Final = 0.2
"""Half of the width of the high-pass flank, over its frequency: narrow beside a third octave,
wide enough to settle within five of its periods [-]."""

_FEWEST: Final = 20  # samples in a bin


@final
@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Force and motion in one joint during one test, all within one band.

    Attributes
    ----------
    between : (str, str)
        The two places; displacement is that of the second against the first.
    displacement, velocity : (n,) array
        As measured, about their means [m], [m/s].
    force, force_model : (n,) array
        Measured, and by the laws of the model over the measured motion [N].
    band : (float, float)
        Within which motion and force are told [Hz].
    unsure : float
        Rms of displacement that noise makes within the band or may hide below it; not a
        number where the noise is unknown [m].
    """

    between: tuple[str, str]
    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    force_model: FloatArray
    band: tuple[float, float]
    unsure: float


@final
@dataclass(frozen=True, slots=True)
class NotTold:
    """A joint of which the recordings do not tell force and motion together.

    Attributes
    ----------
    between : (str, str)
        The two places.
    why : str
        What is lacking.
    force_rms, displacement_rms : float, optional
        What is told all the same [N], [m].
    """

    between: tuple[str, str]
    why: str
    force_rms: float | None = None
    displacement_rms: float | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class JointErrors:
    """Force that the model lacks in a joint, by range of displacement or velocity.

    Attributes
    ----------
    centre : (n_bins,) array
        Middle of each bin [m or m/s].
    mean : (n_bins,) array
        Mean measured force less the model's [N].
    error : (n_bins,) array
        Rms of the difference in the bin over the rms force of the whole test [-]; not a
        number where fewer than 20 samples fall in it.
    """

    centre: FloatArray
    mean: FloatArray
    error: FloatArray


def joint_motions(
    model: Model, measured: Measured
) -> tuple[tuple[JointMotion, ...], tuple[NotTold, ...]]:
    r"""Return force and motion of every joint that the recordings tell, and the others.

    .. math:: q = \sum_i w_i (m_i a_i - f_i), \qquad
        z = \mathcal F^{-1}\left\{ G(f) \frac{A_2 - A_1}{-\omega^2} \right\}

    Of the model, only masses and connections play a part in what is called measured. The gain
    :math:`G` is 1 from the lowest third octave in which the relative acceleration exceeds its
    noise, or that is driven, up to the end of the compared band.

    Parameters
    ----------
    model : Model
        Its masses; its laws give the modelled force along the measured motion.
    measured : Measured
        What the sensors recorded.
    """
    motion = _Recorded(model.under(measured.conditions), measured)
    told, open_ = [], []
    for joint in joints_of(model, motion.sensed):
        found = _judged(motion, joint)
        if isinstance(found, JointMotion):
            told.append(found)
        else:
            open_.append(found)
    return tuple(told), tuple(open_)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Signal:
    """An acceleration: spectrum [m/s^2], and density of its noise at the noise's bins."""

    spectrum: ComplexArray
    noise: FloatArray

    def __sub__(self, other: "_Signal") -> "_Signal":
        return _Signal(self.spectrum - other.spectrum, self.noise + other.noise)


@final
class _Recorded:
    """Accelerations of the base and of every mass with a sensor, from the recordings alone."""

    def __init__(self, model: Model, measured: Measured) -> None:
        self.model, self.measured = model, measured
        self.n = measured.input.size
        slowest = 1.0 / (FLANK * measured.band[0])
        settled = min(round(slowest * measured.sample_rate), self.n)
        self.size = scipy.fft.next_fast_len(self.n + max(2048, settled), real=True)
        self.frequency = scipy.fft.rfftfreq(self.size, 1.0 / measured.sample_rate)
        self.omega = 2.0 * np.pi * self.frequency
        start, stop = measured.start, measured.stop
        most = (stop - start) // 4
        first = max(start, min(settled, start + most))
        self.judged = slice(first, min(stop, max(self.n - settled, stop - most)))
        if model.excitation.imposed:  # where in its play a joint stands counts
            self.judged = slice(start, stop)

    def transform(self, samples: FloatArray) -> ComplexArray:
        """Return the spectrum of samples that a straight line leads back to their start."""
        bridge = np.linspace(samples[-1], samples[0], self.size - self.n + 2)[1:-1]
        spectrum: ComplexArray = scipy.fft.rfft(np.concatenate([samples, bridge]))
        return spectrum

    def back(self, spectrum: ComplexArray) -> FloatArray:
        """Return all samples of a spectrum."""
        samples: FloatArray = scipy.fft.irfft(spectrum, self.size)[: self.n]
        return samples

    @cached_property
    def base(self) -> _Signal:
        """Acceleration of the base."""
        noise = self.measured.noise
        if self.model.excitation.moves_base:
            return _Signal(self.transform(self.measured.input), noise.input)
        return _Signal(np.zeros_like(self.omega, complex), np.zeros_like(noise.frequency))

    @cached_property
    def sensors(self) -> Mapping[str, list[int]]:
        """Rows of the sensors of motion on each mass, the least often integrated first."""
        found: dict[str, list[int]] = {}
        for row, name in enumerate(self.measured.sensors):
            sensor = self.model.sensors[name]
            if sensor.at != BASE and sensor.measures != "force":
                found.setdefault(sensor.at, []).append(row)
        return {at: sorted(rows, key=self._order) for at, rows in found.items()}

    @cached_property
    def sensed(self) -> set[str]:
        """Masses whose motion is measured."""
        kinds = {self._measures(row) for row in range(len(self.measured.sensors))}
        imposed = self.model.excitation.imposed and "force" in kinds
        return set(self.sensors) | ({str(self.model.excitation.on)} if imposed else set())

    def _measures(self, row: int) -> str:
        return self.model.sensors[self.measured.sensors[row]].measures

    def _order(self, row: int) -> int:
        """Return how often a sensor's signal is differentiated to an acceleration."""
        return {"acceleration": 0, "velocity": 1}.get(self._measures(row).split()[-1], 2)

    def acceleration(self, mass: str) -> _Signal:
        """Return the absolute acceleration of a mass."""
        return self._of(mass, against_base=False)

    def relative(self, first: str, second: str) -> _Signal:
        """Return the acceleration of one place against another."""
        if BASE not in (first, second):
            return self.acceleration(second) - self.acceleration(first)
        zero = np.zeros_like(self.measured.noise.frequency)
        against = self._of(second if first == BASE else first, against_base=True)
        still = _Signal(np.zeros_like(against.spectrum), zero)
        return against if first == BASE else still - against

    def _of(self, mass: str, *, against_base: bool) -> _Signal:
        """Return the mean of the sensors of a mass, each by the inverse of its noise."""
        if self.model.excitation.imposed and mass == self.model.excitation.on:
            zero = np.zeros_like(self.measured.noise.frequency)
            return _Signal(-(self.omega**2) * self.transform(self.measured.input), zero)
        noise, base = self.measured.noise, self.base
        signals = []
        for row in self.sensors[mass]:
            order = self._order(row)
            spectrum = self.transform(self.measured.responses[row]) * (1j * self.omega) ** order
            own = noise.responses[row] * (2.0 * np.pi * noise.frequency) ** (2 * order)
            by_base = self._measures(row).startswith("relative")
            sign = float(by_base) - float(against_base)
            signals.append(
                _Signal(spectrum + sign * base.spectrum, own + abs(sign) * base.noise)
            )
        if len(signals) == 1 or not noise.known:
            return signals[0]
        noises = np.array([signal.noise for signal in signals])
        least = np.finfo(float).tiny + 1e-12 * noises.max()
        shares = 1.0 / np.maximum(noises, least)
        shares /= shares.sum(axis=0)
        rows = [np.interp(self.frequency, noise.frequency, share) for share in shares]
        return _Signal(
            np.sum([w * s.spectrum for w, s in zip(rows, signals, strict=True)], axis=0),
            np.sum(shares**2 * noises, axis=0),
        )

    def external(self, mass: str) -> ComplexArray | float:
        """Return the measured force on a mass, spectrum [N]."""
        if mass != self.model.excitation.on:
            return 0.0
        if not self.model.excitation.imposed:
            return self.transform(self.measured.input)
        kinds = [self._measures(row) for row in range(len(self.measured.sensors))]
        return self.transform(self.measured.responses[kinds.index("force")])

    def band(self, against: _Signal) -> tuple[tuple[float, float] | None, float]:
        """Return the band in which a motion is told [Hz], and how unsure its rms is [m]."""
        low, high = self.measured.band
        if self.model.excitation.imposed:
            return (0.0, self.measured.error_band[1]), float("nan")
        samples = self.back(against.spectrum)[self.judged]
        window = np.hanning(samples.size)  # else a resonance leaks into the bands below it
        samples = (samples - samples.mean()) * window / np.sqrt(np.mean(window**2))
        frequency, (power,) = periodogram(samples[np.newaxis], self.measured.sample_rate)
        power = power * frequency[1]
        width = float(frequency[1])
        noise = np.interp(frequency, self.measured.noise.frequency, against.noise) * width
        count = int(np.ceil(np.log2(high / low) * PER_OCTAVE))
        edges = low * 2.0 ** (np.arange(count + 1) / PER_OCTAVE)
        which = np.searchsorted(edges, frequency, side="right") - 1
        inside = (which >= 0) & (which < count)
        which, power, noise = which[inside], power[inside], noise[inside]
        quartic = (2.0 * np.pi * frequency[inside]) ** 4
        seen, hum, moved, unsure = (
            np.bincount(which, values, count)
            for values in (power, noise, power / quartic, noise / quartic)
        )
        told = seen > EXCEEDS * hum
        if not told.any():
            return None, float(np.sqrt(moved.sum()))
        first = int(np.argmax(np.where(told, moved, 0.0)))
        while first > 0 and (told[first - 1] or not seen[first - 1]):
            first -= 1
        hidden = float(np.sqrt(moved[:first].sum() + unsure[first:].sum()))
        known = self.measured.noise.known
        return (float(edges[first]), high), hidden if known else float("nan")

    def gain(self, band: tuple[float, float]) -> FloatArray:
        """Return 1 within a band, with cosine flanks [-]."""
        low, high = band
        fall = np.clip((self.frequency / high - 0.9) / 0.2, 0.0, 1.0)
        gain: FloatArray = 0.5 * (1.0 + np.cos(np.pi * fall))
        if low > 0.0:
            rise = np.clip((self.frequency / low - 1.0 + FLANK) / (2.0 * FLANK), 0.0, 1.0)
            gain = gain * 0.5 * (1.0 - np.cos(np.pi * rise))
        return gain


def _judged(motion: _Recorded, joint: Joint) -> JointMotion | NotTold:
    """Return force and motion of a joint, or why the recordings do not tell both."""
    force = None if joint.weights is None else _force(motion, joint.weights)
    blind = [place for place in joint.between if place not in {BASE, *motion.sensed}]
    if blind:
        why = joint.why or f"no sensor on {' and '.join(blind)}, so its motion is not measured"
        return NotTold(joint.between, why, force_rms=_rms(motion, force, motion.measured.band))
    against = motion.relative(*joint.between)
    band, unsure = motion.band(against)
    if band is None:
        why = joint.why or (
            "band too narrow: its motion does not exceed the noise in any third octave"
        )
        return NotTold(joint.between, why, _rms(motion, force, motion.measured.band))
    spectrum = _integrated(motion, against) * motion.gain(band)
    displacement = motion.back(spectrum)
    size = float(np.std(displacement[motion.judged]))
    if force is None:
        return NotTold(joint.between, joint.why, displacement_rms=size)
    if unsure > size:
        unit, factor = shown_in("m", motion.model.motion, unsure)
        why = (
            f"band too narrow: {numeral(size * factor, 2)} {unit} rms are told from "
            f"{numeral(band[0])} Hz on, and noise may hide {numeral(unsure * factor, 2)} {unit}"
        )
        return NotTold(joint.between, why, _rms(motion, force, band))
    return _motion(motion, joint, spectrum, force, (band, unsure))


def _motion(
    motion: _Recorded,
    joint: Joint,
    spectrum: ComplexArray,
    force: ComplexArray,
    told: tuple[tuple[float, float], float],
) -> JointMotion:
    """Return force and motion of a joint, the modelled force in the band of the measured."""
    band, unsure = told
    displacement = motion.back(spectrum)
    velocity = motion.back(1j * motion.omega * spectrum)
    rate = motion.measured.sample_rate
    laws = np.zeros_like(displacement)
    for element in resolved(motion.model):
        if set(element.between) == set(joint.between) and not isinstance(
            element.effect, AttachedMode
        ):
            laws = laws + law_along(element, joint.between, displacement, velocity, rate)
    gain, judged = motion.gain(band), motion.judged
    return JointMotion(
        joint.between,
        displacement[judged],
        velocity[judged],
        motion.back(force * gain)[judged],
        motion.back(motion.transform(laws) * gain)[judged],
        band,
        unsure,
    )


def _force(motion: _Recorded, weights: Mapping[str, float]) -> ComplexArray:
    """Return the force that moves masses, spectrum [N]."""
    masses = motion.model.rigid_masses
    force = np.zeros_like(motion.base.spectrum)
    for mass, weight in weights.items():
        inertia = masses[mass] * motion.acceleration(mass).spectrum
        force += weight * (inertia - motion.external(mass))
    return force


def _integrated(motion: _Recorded, against: _Signal) -> ComplexArray:
    """Return the displacement of an acceleration, spectrum [m]."""
    if motion.model.excitation.imposed:  # its mean counts, and nothing was differentiated
        return motion.transform(motion.measured.input)
    square = -(np.maximum(motion.omega, motion.omega[1]) ** 2)
    displacement: ComplexArray = against.spectrum / square
    return displacement


def _rms(
    motion: _Recorded, force: ComplexArray | None, band: tuple[float, float]
) -> float | None:
    """Return the rms of a force within a band [N]."""
    if force is None:
        return None
    return float(np.std(motion.back(force * motion.gain(band))[motion.judged]))


def law_along(
    element: Element,
    pair: tuple[str, str],
    displacement: FloatArray,
    velocity: FloatArray,
    rate: float,
) -> FloatArray:
    """Return the force of an element along a motion of its joint, (n,) array [N].

    Parameters
    ----------
    element : Element
        The law and its two places.
    pair : (str, str)
        The places of the joint, in its direction.
    displacement, velocity : (n,) array
        Motion of the second place against the first [m], [m/s].
    rate : float
        Samples per second [Hz].
    """
    turn = 1.0 if element.between == pair else -1.0
    force = element.effect.force_along(turn * displacement, turn * velocity, rate)
    return turn * force


def by_range(motion: JointMotion, along: FloatArray) -> JointErrors:
    """Return the force that the model lacks, by ranges of displacement or velocity.

    Parameters
    ----------
    motion : JointMotion
        Force and motion.
    along : (n,) array
        Its displacement or velocity [m or m/s].
    """
    reach = float(np.max(np.abs(along))) or 1.0
    limits = np.linspace(-reach, reach, BINS + 1)
    which = np.clip(np.searchsorted(limits, along, side="right") - 1, 0, BINS - 1)
    count = np.bincount(which, minlength=BINS)
    lack = motion.force - motion.force_model
    total = np.sqrt(np.mean(motion.force**2)) or 1.0
    enough = count >= _FEWEST
    number = np.where(enough, count, 1)
    mean = np.bincount(which, lack, BINS) / number
    square = np.bincount(which, lack**2, BINS) / number
    return JointErrors(
        centre=0.5 * (limits[1:] + limits[:-1]),
        mean=np.where(enough, mean, np.nan),
        error=np.where(enough, np.sqrt(square) / total, np.nan),
    )
