"""Signals of the sensors of a model in windows of a test, mean accelerations among them.

The mean over a sample lets through much of what jumps hold above half the sample rate, and that
folds back. Displacement and velocity at the samples together tell a motion up to the whole
rate, so that what folds back from below it can be taken away [1]_.

References
----------
.. [1] A. Papoulis, "Generalized sampling expansion", IEEE Transactions on Circuits and Systems
   24 (11), 652-654, 1977.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import pairwise
from types import MappingProxyType
from typing import Final, TypeAlias, final
from weakref import WeakKeyDictionary

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Switch
from shakerproc.models.model import BASE, Measures, Model
from shakerproc.simulation.assembly import System
from shakerproc.simulation.inputs import Input
from shakerproc.simulation.response import integrated

HALF: Final = 12
"""Samples on each side of the middle of an interval that tell its second differences [-]."""

REACH: Final = 15
"""Samples on each side that tell what folds back [-]."""

EDGE: Final = HALF + REACH + 1
"""Samples at both ends of a run that keep their plain means [-]."""

_BAND: Final = 0.8 * np.pi  # up to which the filter is right, in radians a sample
_NEAR: Final = 1e-9  # beside a switch, as a share of where it is

Samples: TypeAlias = NDArray[np.int64] | slice

Along: TypeAlias = Callable[[FloatArray], FloatArray]
"""Motion of a place by that of the coordinates; see `System.along`."""


def has_jumps(model: Model) -> bool:
    """Return whether a force of a model jumps where its law switches."""
    return any(_jumps(element.effect) for element in model.elements)


def is_smooth(model: Model) -> bool:
    """Return whether no law of a model changes its formula or remembers where it turned."""
    return all(
        isinstance(element.effect, AbstractMemorylessEffect) and not element.effect.switches()
        for element in model.elements
    )


def _jumps(effect: AbstractEffect) -> bool:
    if not isinstance(effect, AbstractMemorylessEffect):
        return False
    return any(_jumps_at(effect, switch) for switch in effect.switches())


def _jumps_at(effect: AbstractMemorylessEffect, switch: Switch) -> bool:
    """Return whether forces on the two sides of a switch stay apart as they are approached.

    At 1 m/s, or at rest.
    """
    near = np.array([-_NEAR, _NEAR, -1e3 * _NEAR, 1e3 * _NEAR])
    near = switch.at + near * max(abs(switch.at), 1e3 * _NEAR)
    if switch.variable == "velocity":
        forces = effect.force_at(np.zeros(4), near)
    else:
        forces = effect.force_at(near, np.ones(4))
    close, farther = np.abs(forces[1::2] - forces[::2])
    return bool(close > 0.5 * farther)


def mean_accelerations(
    displacement: FloatArray, velocity: FloatArray, sample_rate: float
) -> FloatArray:
    """Return mean accelerations over the interval after each sample, (n - 1,) array [m/s^2].

    Up to 0.4 of the rate nothing folds back from between half the rate and the whole rate;
    `EDGE` samples at both ends keep their plain means.

    Parameters
    ----------
    displacement, velocity : (n,) array
        At the samples [m], [m/s].
    sample_rate : float
        Samples per second [Hz].
    """
    plain = np.diff(velocity) * sample_rate
    if plain.size <= 2 * EDGE:
        return plain
    second = np.diff(displacement, 2) * sample_rate**2
    halfway, fold = _filters()
    smooth = np.zeros(plain.size)  # means of what the second differences tell
    inner = slice(HALF, plain.size - HALF)
    smooth[inner] = np.convolve(second, halfway, "valid")
    difference = np.zeros(plain.size)
    difference[inner] = smooth[inner] - plain[inner]
    taken = scipy.ndimage.convolve1d(difference, fold, mode="constant")
    plain[EDGE:-EDGE] += taken[EDGE:-EDGE]
    return plain


@cache
def _filters() -> tuple[FloatArray, FloatArray]:
    """Return coefficients of both filters, (2 HALF,) and (2 REACH + 1,) array [-].

    The first makes means over an interval of second differences around it. These hold another
    share of what folds back than the means do: 1 - f / rate of what both differ by at each
    frequency f, which the second filter adds, leaves none.
    """
    turn = np.linspace(1e-6, _BAND, 512)
    cosines = 2.0 * np.cos(np.outer(turn, np.arange(HALF) + 0.5))
    wanted = 0.5 * turn / np.sin(0.5 * turn)
    half = np.linalg.lstsq(cosines, wanted, rcond=None)[0]
    n = np.arange(-REACH, REACH + 1)
    odd = n % 2 == 1
    fold = np.where(odd, 1.0 / (np.pi * np.where(odd, n, 1)) ** 2, 0.0)
    fold[REACH] = 0.75
    return np.concatenate([half[::-1], half]), fold


@final
class BaseMotion:
    """How the base moves in a test, from rest at its first sample; computed where needed.

    Parameters
    ----------
    given : Input
        Acceleration of the base [m/s^2].
    """

    def __init__(self, given: Input) -> None:
        self._pieces, self._stride = given.pieces, given.stride
        self._rate = given.sample_rate
        self.acceleration = given.samples

    @cached_property
    def mean(self) -> FloatArray:
        """Mean acceleration over the interval after each sample; the last is repeated."""
        of_parts = self._pieces @ (1.0 / np.arange(1, self._pieces.shape[1] + 1))
        mean = of_parts.reshape(-1, self._stride).mean(axis=1)
        return np.append(mean, mean[-1])

    @cached_property
    def motion(self) -> tuple[FloatArray, FloatArray]:
        """Velocity [m/s] and displacement [m] at the samples."""
        return integrated(self._pieces, self._stride, self._rate)


_BASES: Final[WeakKeyDictionary[Input, BaseMotion]] = WeakKeyDictionary()


@final
@dataclass(frozen=True, eq=False)
class WindowMotion:
    """Rows of the motion of a model, not all of one window, and where the base is meanwhile.

    Attributes
    ----------
    rows : (n, n_motions) array
        Displacements, velocities and states, relative to the base.
    acceleration : (n, n_masses) array
        Relative to the base [m/s^2]; one more is the force that imposes a displacement [N].
    samples : slice or (n,) array of int
        Sample of the test at each row.
    base : BaseMotion, optional
        Where the base moves.
    jumps : bool
        Whether accelerations jump.
    nudged : (n, 2 n_masses) array, optional
        By how much displacements and velocities were nudged at each row, after it.
    rate : float
        Samples per second [Hz].
    """

    rows: FloatArray
    acceleration: FloatArray
    samples: Samples
    base: BaseMotion | None
    jumps: bool = False
    nudged: FloatArray | None = None
    rate: float = 1.0

    @cached_property
    def accelerated(self) -> FloatArray:
        """The rows as their accelerations alone move them, each window from where it begins."""
        if self.nudged is None:
            return self.rows
        n = self.nudged.shape[1] // 2
        before = np.zeros_like(self.nudged)
        before[1:] = np.cumsum(self.nudged[:-1], axis=0)
        rows = self.rows.copy()
        rows[:, n : 2 * n] -= before[:, n:]
        rows[:, :n] -= before[:, :n] + np.cumsum(before[:, n:], axis=0) / self.rate
        return rows

    @property
    def parts(self) -> list[slice]:
        """Rows of each window."""
        if isinstance(self.samples, slice):
            return [slice(0, len(self.rows))]
        ends = np.flatnonzero(np.diff(self.samples) != 1) + 1
        return [slice(a, b) for a, b in pairwise([0, *ends.tolist(), len(self.rows)])]


def base_motion(model: Model, given: Input) -> BaseMotion | None:
    """Return how the base of a model moves in a test; None where it rests."""
    if not model.excitation.moves_base:
        return None
    if given not in _BASES:
        _BASES[given] = BaseMotion(given)
    return _BASES[given]


def sense(
    model: Model, system: System, motion: WindowMotion, rate: float, *, means: bool
) -> FloatArray:
    """Return the signal of every sensor, faults apart, (n_sensors, n) array [SI].

    Parameters
    ----------
    motion : WindowMotion
        Consecutive rows.
    rate : float
        Samples per second [Hz].
    means : bool
        Whether accelerations are means over the interval to the next row; 0 in the last.
    """
    n = len(system.names)
    out = np.zeros((len(model.sensors), len(motion.rows)))
    for i, sensor in enumerate(model.sensors.values()):
        at = None if sensor.at == BASE else partial(system.along, sensor.at)
        _RECORDED[sensor.measures](motion, n, at, rate if means else 0.0, out[i])
    return out


def _acceleration(
    m: WindowMotion, n: int, at: Along | None, rate: float, out: FloatArray
) -> None:
    if at is not None and rate and m.jumps:
        for part in m.parts:
            rows = m.accelerated[part]
            x, v = at(rows[:, :n]), at(rows[:, n : 2 * n])
            out[part][:-1] = mean_accelerations(x, v, rate)
    elif at is not None and rate:
        out[:-1] = np.diff(at(m.accelerated[:, n : 2 * n])) * rate
    elif at is not None:
        out[:] = at(m.acceleration[:, :n])
    if m.base is not None:
        out += (m.base.mean if rate else m.base.acceleration)[m.samples]


def _velocity(m: WindowMotion, n: int, at: Along | None, rate: float, out: FloatArray) -> None:
    _relative_velocity(m, n, at, rate, out)
    if m.base is not None:
        out += m.base.motion[0][m.samples]


def _displacement(
    m: WindowMotion, n: int, at: Along | None, rate: float, out: FloatArray
) -> None:
    _relative_displacement(m, n, at, rate, out)
    if m.base is not None:
        out += m.base.motion[1][m.samples]


def _relative_velocity(
    m: WindowMotion, n: int, at: Along | None, _: float, out: FloatArray
) -> None:
    if at is not None:
        out[:] = at(m.rows[:, n : 2 * n])


def _relative_displacement(
    m: WindowMotion, n: int, at: Along | None, _: float, out: FloatArray
) -> None:
    if at is not None:
        out[:] = at(m.rows[:, :n])


def _force(m: WindowMotion, n: int, _at: Along | None, _: float, out: FloatArray) -> None:
    out[:] = m.acceleration[:, n]


_RECORDED: Final[Mapping[Measures, Callable[..., None]]] = MappingProxyType({
    "acceleration": _acceleration,
    "displacement": _displacement,
    "velocity": _velocity,
    "relative displacement": _relative_displacement,
    "relative velocity": _relative_velocity,
    "force": _force,
})
