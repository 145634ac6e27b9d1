"""Level and rate of a test, in the units that its kind of excitation allows."""

import re
from typing import Final

from shakerproc.testlog.excitation import BROADBAND, LEVELS, Excitation, LevelUnit
from shakerproc.units import is_unit_of, quoted, to_si

_AMPLITUDES: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "amplitude")
_DENSITIES: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "density")
_RMS: Final = tuple(unit for unit, (kind, _) in LEVELS.items() if kind == "rms")

_UNIT: Final = re.compile(r"^\s*[+-]?[0-9.,]*(?:[eE][+-]?[0-9]+)?\s*")
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")


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
            "a level: an amplitude such as 0.5 g or 20 N, a density such as 0.0002 g^2/Hz or "
            "an rms value such as 0.45 g rms"
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
