"""Excitations of a test: kinds, levels and rates, profiles, blows, multisines, tones."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal, NamedTuple, TypeAlias, final

from shakerproc.units import is_unit_of, quoted, to_si

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

_AMPLITUDES: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "amplitude")
_DENSITIES: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "density")
_RMS: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "rms")

_UNIT: Final = re.compile(r"^\s*[+-]?[0-9.,]*(?:[eE][+-]?[0-9]+)?\s*")
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")

LineGrid: TypeAlias = Literal["all", "odd", "odd with detection"]


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


def level_of(written: object, excitation: Excitation | None) -> tuple[float, LevelUnit]:
    """Return the level of a test in SI, and its unit.

    A sine has an amplitude (``0.5 g``, ``20 N``), random excitation a density
    (``0.0002 g^2/Hz``) or an rms value (``0.45 g rms``).

    Raises
    ------
    ValueError
        If the level is no number with such a unit.
    """
    allowed = _allowed(excitation)
    unit, is_rms = _unit_of(written)
    for candidate in allowed:
        wanted = candidate.removesuffix(" rms")
        if unit and is_rms == candidate.endswith(" rms") and is_unit_of(unit, wanted):
            return _positive(to_si(_without_rms(written), wanted), written), candidate
    if isinstance(written, str) and "," not in written and _is_a_level(unit):
        raise ValueError(f"expected {_examples(excitation)}, got {quoted(written)}")
    first = allowed[0].removesuffix(" rms")
    density = "Hz" in first or ("hz" in unit.casefold() and excitation is None)
    to_si(_without_rms(written), "g^2/Hz" if density else first)  # says what is wrong
    raise ValueError(f"expected {_examples(excitation)}, got {quoted(written)}")


def rate_of(written: object) -> tuple[float | None, float | None]:
    """Return the rate of a sweep [oct/min], or [Hz/s] where it is linear.

    Raises
    ------
    ValueError
        If it is neither.
    """
    unit, _ = _unit_of(written)
    if unit and is_unit_of(unit, "Hz/s"):
        return None, _positive(to_si(written, "Hz/s"), written)
    return _positive(to_si(written, "oct/min") * 60.0, written), None


def threshold_of(written: object) -> float:
    """Return a threshold in SI.

    Raises
    ------
    ValueError
        If it is no positive acceleration or force.
    """
    unit = written.lstrip("+-0123456789.eE ") if isinstance(written, str) else ""
    wanted = next((one for one in _AMPLITUDES if unit and is_unit_of(unit, one)), "m/s^2")
    value = to_si(written, wanted)
    if value <= 0.0:
        raise ValueError(f"expected more than 0, such as 0.45 g, got {quoted(written)}")
    return value


def tidy(written: object) -> str:
    """Return a quantity with its number in the shortest form, so that 1.0 g and 1 g group."""
    text = " ".join(str(written).split())
    number = _NUMBER.match(text)
    if number is None:
        return text
    return f"{float(number[0]):.9g} {text[number.end() :].strip()}"


def _allowed(excitation: Excitation | None) -> tuple[LevelUnit, ...]:
    if excitation in BROADBAND:
        return _DENSITIES + _RMS
    return _AMPLITUDES if excitation is not None else _AMPLITUDES + _DENSITIES + _RMS


def _examples(excitation: Excitation | None) -> str:
    if excitation in BROADBAND:
        return (
            f"the level of a {excitation} test as a density, such as 0.0002 g^2/Hz, "
            "or an rms value, such as 0.45 g rms"
        )
    if excitation is None:
        return (
            "a level: an amplitude (0.5 g, 20 N), a density (0.0002 g^2/Hz) or an rms value "
            "(0.45 g rms)"
        )
    return f"the level of a {excitation} test as an amplitude, such as 0.5 g or 20 N"


def _is_a_level(unit: str) -> bool:
    """Return whether a unit would do for another kind of excitation."""
    return bool(unit) and any(is_unit_of(unit, wanted) for wanted in _AMPLITUDES + _DENSITIES)


def _unit_of(written: object) -> tuple[str, bool]:
    """Return the unit of a quantity and whether it is marked as an rms value."""
    if not isinstance(written, str):
        return "", False
    plain = _without_rms(written)
    return _UNIT.sub("", str(plain)).strip(), plain != written


def _without_rms(written: object) -> object:
    if not isinstance(written, str) or not written.rstrip().lower().endswith("rms"):
        return written
    return re.sub(r"(?<=[A-Za-z2²])[\s_]*rms\s*$", "", written, flags=re.IGNORECASE)


def _positive(value: float, written: object) -> float:
    """Return a value above 0.

    Raises
    ------
    ValueError
        If it is not.
    """
    if value <= 0.0:
        raise ValueError(f"expected more than 0, got {quoted(written)}")
    return value


class Amount(NamedTuple):
    """A quantity that may be given in two ways, with the unit that it was given in."""

    value: float
    unit: str


USUAL_TRIGGER: Final = Amount(0.1, "1")
"""Share of the largest force at which a blow begins where the log does not say it."""


@final
@dataclass(frozen=True, slots=True)
class Hammer:
    """How the blows of a hammer test are cut out and windowed.

    Attributes
    ----------
    trigger : Amount
        Force at which a blow begins [N], or its share of the largest force [1].
    pretrigger : float, optional
        What of a block lies before [s]; by default a hundredth of it.
    length : float, optional
        Of a block [s]; by default until the next blow.
    force_window : float, optional
        After this time from the trigger the force is set to 0, as before it [s]; by default
        it is left as it was measured.
    exponential : Amount, optional
        Time constant of the exponential window [s], or what is left at the end of a block
        [1]; by default there is no such window.
    """

    trigger: Amount = USUAL_TRIGGER
    pretrigger: float | None = None
    length: float | None = None
    force_window: float | None = None
    exponential: Amount | None = None


@final
@dataclass(frozen=True, slots=True)
class Multisine:
    """How a multisine repeats.

    Attributes
    ----------
    period : float
        After this time it repeats; one over it is the distance of its lines [s].
    periods : int, optional
        How many each realisation lasts; by default as many as the run holds.
    realisations : int
        How many with phases of their own follow each other in the recording.
    every : float, optional
        From the beginning of one realisation to that of the next [s]; by default they follow
        each other without a pause.
    lines : {"all", "odd", "odd with detection"}
        Which multiples of one over the period are excited where a test is simulated: of the
        last, one of four odd ones in a row, at random, is left out. Of a recording they are
        found in its input.
    """

    period: float
    periods: int | None = None
    realisations: int = 1
    every: float | None = None
    lines: LineGrid = "odd with detection"

    @property
    def duration(self) -> float | None:
        """How long all realisations take [s]; None where their periods are not said."""
        if self.periods is None:
            return None
        one = self.periods * self.period
        return one + (self.realisations - 1) * (one if self.every is None else self.every)


@final
@dataclass(frozen=True, slots=True)
class DemandedTone:
    """A sine of fixed frequency in a test of sine on random.

    Attributes
    ----------
    frequency : float
        Where it is [Hz].
    level : float, optional
        Amplitude demanded, in SI, of the signal that the level of the test is of.
    """

    frequency: float
    level: float | None = None
