"""Excitations of a test: kinds, units of levels, profiles."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

Excitation: TypeAlias = Literal[
    "sine sweep", "random", "sine", "multisine", "stepped sine", "sine on random", "shock",
    "hammer", "free decay", "measured",
]  # fmt: skip

PULSES: Final[tuple[Excitation, ...]] = ("shock", "hammer", "free decay")
"""Kinds of excitation that are over soon, and whose shape no key of the log says."""

BROADBAND: Final[tuple[Excitation, ...]] = ("random", "multisine", "sine on random")
"""Kinds of excitation whose level is a density or an rms value."""

LevelUnit: TypeAlias = Literal[
    "m/s^2", "(m/s^2)^2/Hz", "m/s^2 rms", "N", "N^2/Hz", "N rms",
    "rad/s^2", "(rad/s^2)^2/Hz", "rad/s^2 rms", "N m", "(N m)^2/Hz", "N m rms",
]  # fmt: skip

LevelKind: TypeAlias = Literal["amplitude", "density", "rms"]

LEVELS: Final[Mapping[LevelUnit, tuple[LevelKind, str]]] = MappingProxyType({
    "m/s^2": ("amplitude", "m/s^2"),
    "N": ("amplitude", "N"),
    "rad/s^2": ("amplitude", "rad/s^2"),
    "N m": ("amplitude", "N m"),
    "(m/s^2)^2/Hz": ("density", "m/s^2"),
    "N^2/Hz": ("density", "N"),
    "(rad/s^2)^2/Hz": ("density", "rad/s^2"),
    "(N m)^2/Hz": ("density", "N m"),
    "m/s^2 rms": ("rms", "m/s^2"),
    "N rms": ("rms", "N"),
    "rad/s^2 rms": ("rms", "rad/s^2"),
    "N m rms": ("rms", "N m"),
})
"""Kind of level that a unit stands for, and the SI unit of the signal it is the level of."""

FORCES: Final = frozenset({"N", "N m"})
"""SI units of the signals that drive a specimen as a force or a torque."""


def amplitude_unit(unit: LevelUnit) -> LevelUnit:
    """Return the unit of the amplitude of the signal that a level is of."""
    signal = LEVELS[unit][1]
    return next(one for one, level in LEVELS.items() if level == ("amplitude", signal))


@final
@dataclass(frozen=True, slots=True)
class ProfileNotch:
    """A part of a profile in which the plan allows the control to be lower.

    Attributes
    ----------
    low, high : float
        From where to where [Hz].
    depth : float
        By how much the lower alarm and abort lines go down [dB].
    """

    low: float
    high: float
    depth: float


@final
@dataclass(frozen=True, slots=True)
class Profile:
    """Demanded level at every frequency: breakpoints, straight lines on log axes.

    Attributes
    ----------
    name : str
        As the log has it.
    unit : LevelUnit
        Of the level: a density for random excitation, an amplitude for a sweep.
    frequency_hz, level : tuple of float
        Rising breakpoints [Hz], and the demand at each [unit].
    alarm_db, abort_db : tuple of float
        Tolerance either way from each breakpoint up to the next [dB].
    notches : tuple of ProfileNotch
        Where the plan allows less.
    """

    name: str
    unit: LevelUnit
    frequency_hz: tuple[float, ...]
    level: tuple[float, ...]
    alarm_db: tuple[float, ...]
    abort_db: tuple[float, ...]
    notches: tuple[ProfileNotch, ...] = ()

    @property
    def signal_unit(self) -> str:
        """SI unit of the signal that it is the level of."""
        return LEVELS[self.unit][1]
