"""Which tests use up the play: at which frequencies, on one side or both, at which level."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.planning.joints import AbstractJoint, Walls
from shakerproc.planning.shaker import (
    PEAK_FACTOR,
    AbstractInput,
    RandomInput,
    ShakerLimits,
    SineInput,
)

Contact: TypeAlias = Literal["none", "one side", "both sides"]
Band: TypeAlias = tuple[float, float]
Function: TypeAlias = Callable[[FloatArray], FloatArray]

POINTS: Final = 600
"""Frequencies on a grid over the band, besides those about each resonance."""


@final
@dataclass(frozen=True, slots=True)
class Reach:
    """Where a test takes the joint, as long as nothing touches.

    Attributes
    ----------
    displacement : float
        Largest relative displacement: an amplitude, or 3 sigma [m].
    at_hz : float, optional
        Frequency of the largest amplitude; None for random motion [Hz].
    contact : {"none", "one side", "both sides"}
        What it touches.
    one_side_hz, both_sides_hz : tuple of (float, float)
        Bands of a sine in which it does [Hz].
    contacts_per_second : float, optional
        Random motion: how often the joint leaves its play, both sides together [1/s].
    factor_one_side, factor_both_sides : float
        How many times the amplitude of the test would just touch [-].
    """

    displacement: float
    at_hz: float | None
    contact: Contact
    one_side_hz: tuple[Band, ...]
    both_sides_hz: tuple[Band, ...]
    contacts_per_second: float | None
    factor_one_side: float
    factor_both_sides: float


@final
@dataclass(frozen=True, slots=True)
class _SineMotion:
    joint: AbstractJoint
    shaken: SineInput

    def amplitude(self, frequency: FloatArray) -> FloatArray:
        return self.shaken.amplitude * np.abs(self.joint.gain(frequency))

    def curve(self, frequency: FloatArray) -> FloatArray:
        return self.amplitude(frequency)

    def reach(self, walls: Walls) -> Reach:
        low, high = self.shaken.low, self.shaken.high
        grid = frequencies_of(self.joint, low, high)
        at, largest = _largest(self.amplitude, grid)
        return Reach(
            largest,
            at,
            _contact(largest, walls),
            bands_above(self.amplitude, grid, walls.near),
            bands_above(self.amplitude, grid, walls.far),
            None,
            walls.near / largest,
            walls.far / largest,
        )


@final
@dataclass(frozen=True, slots=True)
class _RandomMotion:
    joint: AbstractJoint
    shaken: RandomInput

    def rms(self) -> tuple[float, float]:
        """Return rms of relative displacement [m] and velocity [m/s]."""
        grid = frequencies_of(self.joint, self.shaken.low, self.shaken.high, fine=8)
        density = self.shaken.density * np.abs(self.joint.gain(grid)) ** 2
        swift = density * (2.0 * np.pi * grid) ** 2
        rms_values = [
            float(np.sqrt(np.sum(_pieces(grid, values)))) for values in (density, swift)
        ]
        return rms_values[0], rms_values[1]

    def curve(self, frequency: FloatArray) -> FloatArray:
        grid = frequencies_of(self.joint, self.shaken.low, self.shaken.high, fine=8)
        grid = np.union1d(grid, frequency[(frequency > grid[0]) & (frequency < grid[-1])])
        pieces = _pieces(grid, self.shaken.density * np.abs(self.joint.gain(grid)) ** 2)
        above = np.concatenate([np.cumsum(pieces[::-1])[::-1], [0.0]])
        height: FloatArray = PEAK_FACTOR * np.sqrt(np.interp(frequency, grid, above))
        return height

    def reach(self, walls: Walls) -> Reach:
        sigma, swift = self.rms()
        # Rice: crossings of a level per second by a Gaussian motion
        rates = [
            swift / (2.0 * np.pi * sigma) * _gaussian(wall / sigma)
            for wall in (walls.positive, walls.negative)
        ]
        largest = PEAK_FACTOR * sigma
        return Reach(
            largest,
            None,
            _contact(largest, walls),
            (),
            (),
            sum(rates),
            walls.near / largest,
            walls.far / largest,
        )


def reach(joint: AbstractJoint, shaken: AbstractInput, walls: Walls) -> Reach:
    """Return where a test takes a joint.

    Until the first contact the motion is exactly linear, so that amplitudes, frequencies and
    levels at which the play is just used up are exact; beyond it only that there is contact.

    Parameters
    ----------
    joint : AbstractJoint
        What moves.
    shaken : AbstractInput
        What shakes it.
    walls : Walls
        Free play to either side.
    """
    return _motion(joint, shaken).reach(walls)


def curve(joint: AbstractJoint, shaken: AbstractInput, frequency: FloatArray) -> FloatArray:
    """Return the relative displacement of a joint over frequencies [Hz], (n,) array [m].

    Of a sine its amplitude there; of random motion 3 sigma of all that lies above.
    """
    return _motion(joint, shaken).curve(frequency)


def _motion(joint: AbstractJoint, shaken: AbstractInput) -> "_SineMotion | _RandomMotion":
    """Return the motion of a joint.

    Raises
    ------
    ValueError
        If the kind of input is not known.
    """
    if isinstance(shaken, SineInput):
        return _SineMotion(joint, shaken)
    if isinstance(shaken, RandomInput):
        return _RandomMotion(joint, shaken)
    raise ValueError(f"no motion is known for {type(shaken).__name__}")


def bands_within_limits(
    joint: AbstractJoint, limits: ShakerLimits, band: Band, displacement: float
) -> tuple[Band, ...]:
    """Return where in a band [Hz] the shaker at its limits moves a joint by so much [m].

    Returns
    -------
    tuple of (float, float)
        Bands of a sine [Hz].
    """
    grid = np.union1d(
        frequencies_of(joint, *band),
        [f for f in limits.crossovers() if band[0] < f < band[1]],
    )
    return bands_above(
        lambda f: limits.largest_acceleration(f) * np.abs(joint.gain(f)), grid, displacement
    )


def frequencies_of(joint: AbstractJoint, low: float, high: float, fine: int = 1) -> FloatArray:
    """Return frequencies over a band that miss no resonance of a joint, (n,) array [Hz]."""
    if low == high:
        return np.array([low])
    parts = [np.geomspace(low, high, fine * POINTS)]
    widths = np.concatenate([[0.0], np.geomspace(1e-3, 30.0, 60 * fine)])
    for mode in joint.modes():
        half = max(mode.damping_ratio, 1e-6) * mode.frequency * widths
        parts += [mode.frequency - half, mode.frequency + half]
    grid = np.unique(np.concatenate(parts))
    return grid[(grid >= low) & (grid <= high)]


def bands_above(function: Function, grid: FloatArray, threshold: float) -> tuple[Band, ...]:
    """Return the bands in which a function of frequency reaches a threshold [Hz].

    Their edges are located between the points of the grid.
    """
    above = function(grid) >= threshold
    if not np.any(above):
        return ()
    edges = np.flatnonzero(np.diff(above.astype(int)))
    places = [
        float(
            scipy.optimize.brentq(
                lambda f: _log_ratio(function, f, threshold), a, b, xtol=1e-12
            )
        )
        for a, b in zip(grid[edges], grid[edges + 1], strict=True)
    ]
    if above[0]:
        places.insert(0, float(grid[0]))
    if above[-1]:
        places.append(float(grid[-1]))
    return tuple(zip(places[::2], places[1::2], strict=True))


def _log_ratio(function: Function, frequency: float, threshold: float) -> float:
    return float(np.log(function(np.array([frequency]))[0] / threshold))


def _largest(function: Function, grid: FloatArray) -> tuple[float, float]:
    """Return where a function is largest, and the value."""
    values = function(grid)
    i = int(np.argmax(values))
    if not 0 < i < grid.size - 1:
        return float(grid[i]), float(values[i])
    optimum = scipy.optimize.minimize_scalar(
        lambda f: -float(function(np.array([f]))[0]),
        bounds=(grid[i - 1], grid[i + 1]),
        method="bounded",
        options={"xatol": 1e-10 * float(grid[i])},
    )
    return float(optimum.x), float(-optimum.fun)


def _contact(largest: float, walls: Walls) -> Contact:
    if largest >= walls.far:
        return "both sides"
    return "one side" if largest >= walls.near else "none"


def _gaussian(ratio: float) -> float:
    return float(np.exp(-0.5 * min(ratio, 35.0) ** 2)) if ratio < inf else 0.0


def _pieces(frequency: FloatArray, values: FloatArray) -> FloatArray:
    """Return the integrals between frequencies of lines straight on double-log paper."""
    f, y = frequency, np.maximum(values, 1e-300)
    ratio = np.log(f[1:] / f[:-1])
    power = np.log(y[1:] / y[:-1]) / ratio + 1.0
    # y ~ f^(power - 1); where power is 0 the integral is a logarithm, not a power
    safe = np.where(np.abs(power * ratio) < 1e-8, 1.0, power)
    pieces = f[:-1] * y[:-1] * np.expm1(safe * ratio) / safe
    level = f[:-1] * y[:-1] * ratio
    return np.where(np.abs(power * ratio) < 1e-8, level, pieces)
