"""The force in each joint, as measured and as the model has it, over the measured motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.free_run_error import edges
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models import BASE, Element, Model
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.parallel_elements import resolved

BINS: Final = 24
"""Parts that the range of displacement or velocity is cut into."""

_CROSSOVER: Final = 0.4  # of the resonance: below it the model completes the motion
_FEWEST: Final = 20  # samples in a bin


@final
@dataclass(frozen=True, slots=True, eq=False)
class JointMotion:
    """Force and motion in one joint during one test.

    Attributes
    ----------
    between : (str, str)
        The two places; displacement is that of the second against the first.
    displacement, velocity : (n,) array
        As measured, completed by the model at low frequencies [m], [m/s].
    force, force_model : (n,) array
        Measured, and by the laws of the model over the measured motion [N].
    """

    between: tuple[str, str]
    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    force_model: FloatArray


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


def joint_motions(model: Model, prediction: Prediction) -> tuple[JointMotion, ...]:
    """Return force and motion of every joint that the sensors can judge.

    A joint can be judged where cutting it parts the structure, every mass on the far side has
    a sensor, and so has the place on the near side: the force in it is then what accelerates
    the far side.
    """
    if model.excitation.imposed:  # the force is what is measured
        return ()
    measured = prediction.measured
    size = scipy.fft.next_fast_len(measured.input.size + 2048, real=True)
    frequency = scipy.fft.rfftfreq(size, 1.0 / measured.sample_rate)
    laboratory = _Laboratory(model, prediction, frequency, size)
    found = []
    for pair in _pairs(model):
        far = _far_side(model, pair)
        if far is None or not far | ({pair[0]} - {BASE}) <= laboratory.sensed:
            continue
        found.append(_motion(laboratory, pair, sorted(far)))
    return tuple(found)


def _pairs(model: Model) -> list[tuple[str, str]]:
    """Return every joint once, in the direction in which it is first written."""
    pairs: dict[frozenset[str], tuple[str, str]] = {}
    for element in model.elements:
        if not isinstance(element.effect, AttachedMode):
            pairs.setdefault(frozenset(element.between), element.between)
    return list(pairs.values())


def _far_side(model: Model, pair: tuple[str, str]) -> set[str] | None:
    """Return the masses that only this joint holds to the base, or None if there are none.

    The second place must be among them, so that the force is the one that drives it.
    """
    neighbours: dict[str, set[str]] = {place: set() for place in (BASE, *model.masses)}
    for element in model.elements:
        one, other = element.between
        if {one, other} != set(pair):
            neighbours[one].add(other)
            neighbours[other].add(one)
    reached, front = {BASE}, [BASE]
    while front:
        new = neighbours[front.pop()] - reached
        reached |= new
        front += new
    far = set(model.masses) - reached
    return far if pair[1] in far and pair[0] not in far else None


@final
class _Laboratory:
    """Spectra of the motion of every mass against the base, measured and simulated."""

    def __init__(
        self, model: Model, prediction: Prediction, frequency: FloatArray, size: int
    ) -> None:
        self.model = model
        self.measured = prediction.measured
        self.simulation = prediction.simulation
        self.frequency = frequency
        self.size = size
        self.omega = 2.0 * np.pi * frequency
        by_force = model.excitation.on is not None
        drive = scipy.fft.rfft(self.measured.input, size)
        self.base = np.zeros_like(drive) if by_force else drive
        self.force = drive if by_force else np.zeros_like(drive)
        self.sensor_of = _sensor_of(model, self.measured)

    @property
    def sensed(self) -> set[str]:
        return set(self.sensor_of)

    def acceleration(self, mass: str) -> ComplexArray:
        """Return the absolute acceleration of a mass, spectrum [m/s^2]."""
        row, measures = self.sensor_of[mass]
        spectrum: ComplexArray = scipy.fft.rfft(self.measured.responses[row], self.size)
        order = {"acceleration": 0, "velocity": 1, "relative velocity": 1}.get(measures, 2)
        raised: ComplexArray = spectrum * (1j * self.omega) ** order
        return raised + self.base if measures.startswith("relative") else raised

    def relative(self, mass: str) -> ComplexArray:
        """Return the displacement of a mass against the base, spectrum [m]."""
        if mass == BASE:
            return np.zeros_like(self.base)
        against = self.acceleration(mass) - self.base
        square = -(np.maximum(self.omega, self.omega[1]) ** 2)
        low = self.crossover
        take = 0.5 * (1.0 - np.cos(np.pi * np.clip((self.frequency / low - 0.5), 0.0, 1.0)))
        row = self.simulation.masses.index(mass)
        modelled = scipy.fft.rfft(self.simulation.displacement[row], self.size)
        mixed: ComplexArray = take * against / square + (1.0 - take) * modelled
        return mixed

    @property
    def crossover(self) -> float:
        """Frequency below which the model completes the displacement [Hz]."""
        density = np.abs(scipy.fft.rfft(self.simulation.displacement[0], self.size)) ** 2
        low, high = self.measured.excited
        density[(self.frequency < low) | (self.frequency > high)] = 0.0
        resonance = float(self.frequency[np.argmax(density)])
        return max(_CROSSOVER * resonance, float(self.frequency[1]))

    def back(self, spectrum: ComplexArray) -> FloatArray:
        """Return the judged samples of a spectrum, within the compared band's upper end."""
        upper = edges(self.frequency, (1e-3, self.measured.band[1]))
        whole: FloatArray = scipy.fft.irfft(spectrum * upper, self.size)
        return whole[self.measured.start : self.measured.stop]


def _sensor_of(model: Model, measured: Measured) -> Mapping[str, tuple[int, str]]:
    """Return for each mass the row of its best sensor and what that measures."""
    rank = ("acceleration", "velocity", "relative velocity", "displacement", "")
    best: dict[str, tuple[int, str]] = {}
    for row, name in enumerate(measured.sensors):
        sensor = model.sensors[name]
        kind = sensor.measures if sensor.measures in rank else ""
        held = best.get(sensor.at)
        if held is None or rank.index(kind) < rank.index(held[1] if held[1] in rank else ""):
            best[sensor.at] = (row, sensor.measures)
    best.pop(BASE, None)
    return best


def _motion(lab: _Laboratory, pair: tuple[str, str], far: Sequence[str]) -> JointMotion:
    spectrum = lab.relative(pair[1]) - lab.relative(pair[0])
    displacement, velocity = lab.back(spectrum), lab.back(1j * lab.omega * spectrum)
    inertia = np.zeros_like(lab.base)
    for mass in far:
        inertia += lab.model.masses[mass] * lab.acceleration(mass)
    driven = lab.force if lab.model.excitation.on in far else 0.0
    rate = lab.measured.sample_rate
    laws = np.zeros_like(displacement)
    for element in resolved(lab.model):
        if set(element.between) == set(pair) and not isinstance(element.effect, AttachedMode):
            laws = laws + _law(element, pair, displacement, velocity, rate)
    return JointMotion(pair, displacement, velocity, lab.back(driven - inertia), laws)


def _law(
    element: Element,
    pair: tuple[str, str],
    displacement: FloatArray,
    velocity: FloatArray,
    rate: float,
) -> FloatArray:
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
