"""Properties of an effect by which it is looked for in measurements.

Which numbers are free, in which transform and between which bounds, where to start for a joint
that moves like this, and which simpler effects it contains. Every length, force and time here
is a multiple of a scale of the measured motion, `JointScales`.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Literal, TypeAlias, final

import numpy as np

from shakerproc.models.conditions import Scale

Values: TypeAlias = Mapping[str, float | str]
"""Coordinates and fixed words or numbers, by name [SI]."""


BEYOND = 2.0
"""Resonance over the highest frequency of the band from which on a contact passes for rigid: at
the very end of the band it then moves a third more than far below [-]."""


@final
@dataclass(frozen=True, slots=True)
class JointScales:
    """How a joint moves in the tests at hand.

    Attributes
    ----------
    displacement, velocity : float
        Largest relative displacement [m] and velocity [m/s].
    force : float
        Largest force that the joint carries, known from the masses and their accelerations
        even where the joint does not move [N].
    stiffness : float
        Linear stiffness of the joint in the model; 0 where it has none [N/m].
    mass : float
        Reduced mass of its two places [kg].
    duration : float
        Length of the longest test [s].
    band : float
        Highest frequency at which the tests are judged; infinite where a motion is imposed,
        which no resonance limits [Hz].
    """

    displacement: float
    velocity: float
    force: float
    stiffness: float
    mass: float
    duration: float
    band: float

    @property
    def rigid(self) -> float:
        """Stiffness beside the joint's own that moves next to nothing in the band [N/m].

        The joint then resonates beyond `BEYOND` times the band.
        """
        return self.stiffness + self.mass * (2.0 * math.pi * BEYOND * self.band) ** 2

    @property
    def steepness(self) -> float:
        """The larger of the joint's stiffness and of largest force over displacement [N/m]."""
        return max(self.stiffness, self.force / self.displacement)

    @property
    def frequency(self) -> float:
        """Natural frequency of the reduced mass on the joint [Hz].

        Where the joint has no stiffness, that at which its largest velocity and displacement
        belong to one harmonic motion.
        """
        if self.stiffness > 0.0:
            return math.sqrt(self.stiffness / self.mass) / (2.0 * math.pi)
        return self.velocity / (2.0 * math.pi * self.displacement)

    @property
    def critical_damping(self) -> float:
        """Damping that lets the reduced mass just not oscillate on `steepness` [N s/m]."""
        return 2.0 * math.sqrt(self.steepness * self.mass)


@final
@dataclass(frozen=True, slots=True)
class Free:
    """One free coordinate of an effect.

    Attributes
    ----------
    low, high : float
        Bounds for this motion [SI].
    transform : {"logarithm", "identity"}
        In which it is estimated: the logarithm of what is positive, else as it is.
    size : float
        Its typical size for this motion, above 0; the unit of `to_fitted` [SI].
    """

    low: float
    high: float
    transform: Literal["logarithm", "identity"]
    size: float

    def to_fitted(self, value: float) -> float:
        """Return the dimensionless number that is estimated, for a value [SI]."""
        kept = min(max(value, self.low), self.high)
        return math.log(kept / self.size) if self.transform == "logarithm" else kept / self.size

    def from_fitted(self, number: float) -> float:
        """Return the value [SI] of a number that is estimated, kept in bounds."""
        if self.transform == "identity":
            return min(max(number * self.size, self.low), self.high)
        lowest, highest = math.log(self.low / self.size), math.log(self.high / self.size)
        value = self.size * math.exp(min(max(number, lowest), highest))
        return min(max(value, self.low), self.high)  # exp(log(x)) may miss x by a bit


def positive(size: float, down: float = 1e-4, up: float = 1e4) -> Free:
    """Return a positive coordinate, between these multiples of its typical size [SI]."""
    return Free(down * size, up * size, "logarithm", size)


def signed(size: float, reach: float = 1e3) -> Free:
    """Return a coordinate of either sign, up to this multiple of its typical size [SI]."""
    return Free(-reach * size, reach * size, "identity", size)


@final
@dataclass(frozen=True, slots=True)
class Contained:
    """A simpler effect that an effect can imitate.

    Attributes
    ----------
    kind : str
        Its key in `EFFECTS`.
    extend : callable
        From its fitted coordinates (and words) to sets of this effect's to start from, among
        them one whose law is nearly that of the simpler effect; none where it cannot be.
    limit : bool
        Whether the simpler law is a limit of this one. Else it is only alike: a good place to
        start from, whose error this effect need not reach.
    """

    kind: str
    extend: Callable[[Values], tuple[Values, ...]]
    limit: bool = True


def _as_they_are(values: Values) -> Values:
    return values


@final
@dataclass(frozen=True, slots=True)
class Identification:
    """Properties of an effect by which it is identified, for one joint.

    Attributes
    ----------
    free : mapping of str to Free
        The coordinates, in order.
    starts : tuple of mapping
        Complete sets of coordinates and fixed words and numbers. Sets that differ in a word
        are variants of the effect, such as the two sides of a stop.
    contains : tuple of Contained
        Simpler effects.
    numbers : callable
        From coordinates and fixed values to what `AbstractEffect.of_numbers` takes: the
        keyword arguments of the effect, unless it says otherwise (`estimated`).
    scaled : tuple of str
        Coordinates that the force is proportional to, taken together; none if there are none.
    scaled_by : Scale, optional
        Condition of a test that the force is proportional to, too.
    """

    free: Mapping[str, Free]
    starts: tuple[Values, ...]
    contains: tuple[Contained, ...] = ()
    numbers: Callable[[Values], Values] = _as_they_are
    scaled: tuple[str, ...] = ()
    scaled_by: Scale | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "free", MappingProxyType(dict(self.free)))
        starts = tuple(MappingProxyType(self.within_bounds(start)) for start in self.starts)
        object.__setattr__(self, "starts", starts)

    def within_bounds(self, values: Values) -> dict[str, float | str]:
        """Return values with every coordinate taken into its bounds."""
        return {
            name: self.free[name].from_fitted(self.free[name].to_fitted(float(value)))
            if name in self.free
            else value
            for name, value in values.items()
        }


def grid(**axes: Iterable[float | str]) -> tuple[Values, ...]:
    """Return every combination of the values of each name.

    Values are in the units of the parameters.
    """
    names = tuple(axes)
    return tuple(
        dict(zip(names, values, strict=True)) for values in product(*map(tuple, axes.values()))
    )


def spread(low: float, high: float, n: int, scale: float = 1.0) -> tuple[float, ...]:
    """Return n numbers from low to high, in equal ratios, times a scale.

    `low` and `high` are in any unit, `scale` multiplies them.
    """
    return tuple(float(scale * share) for share in np.geomspace(low, high, n))


def number(values: Values, name: str) -> float:
    """Return a value that is a number."""
    return float(values[name])


FRICTION_SHARES = (0.004, 0.015, 0.05, 0.15, 0.4, 1.1)
"""Friction forces to start from, as shares of the largest force that the joint carries [-].

From what hardly damps a random vibration (whose peaks are four times its rms) to what holds
the joint locked throughout.
"""

CONTACT_SHARES = (0.6, 3.0)
"""Stiffnesses of a contact to start from, as shares of `JointScales.steepness` [-]."""


def clearance(at: JointScales, reach: float = 1.5) -> Free:
    """Return a clearance as a coordinate.

    Parameters
    ----------
    reach : float
        Upper bound as a multiple of the largest displacement: beyond 1 nothing is touched [-].
    """
    return positive(0.3 * at.displacement, 1e-3, reach / 0.3)


def clearances(at: JointScales, n: int) -> tuple[float, ...]:
    """Return clearances to start from, 3 to 92 % of the largest displacement [m]."""
    return spread(0.03, 0.92, n, at.displacement)


def contact(at: JointScales) -> Free:
    """Return the stiffness of a contact as a coordinate."""
    return positive(at.steepness)


def sticking_stiffness(at: JointScales) -> Free:
    """Return the stiffness of a contact that sticks, as a coordinate: none beyond rigid."""
    size = min(at.steepness, at.rigid)
    return Free(1e-4 * size, min(at.rigid, 1e4 * size), "logarithm", size)


def contacts(at: JointScales) -> tuple[float, ...]:
    """Return stiffnesses of a contact to start from [N/m]."""
    return tuple(share * at.steepness for share in CONTACT_SHARES)


DRY_SHARES = tuple(map(float, np.geomspace(FRICTION_SHARES[0], FRICTION_SHARES[-1], 48)))
"""The same of friction without a spring, which nothing simpler leads to: 1.13 from one to the
next, as a joint that mostly sticks always does where its force is missed by a tenth [-]."""


def friction(at: JointScales) -> Free:
    """Return a friction force as a coordinate."""
    return positive(0.1 * at.force, 1e-4, 1e3)


def frictions(at: JointScales, shares: Sequence[float] = FRICTION_SHARES) -> tuple[float, ...]:
    """Return friction forces to start from [N]."""
    return tuple(share * at.force for share in shares)
