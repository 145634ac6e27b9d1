"""The values of a test log: texts and quantities, with what is refused of each.

Quantities are written with their unit and held in SI.
"""

import math
import re
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BeforeValidator

from shakerproc.data import ROLE_UNITS
from shakerproc.units import (
    fits_sensitivity,
    in_unit,
    is_unit_of,
    numbered,
    problem_of_unit,
    quoted,
    spelled,
)

CHANNEL_UNITS = tuple(dict.fromkeys(unit for units in ROLE_UNITS.values() for unit in units))
"""SI unit of each quantity that a channel may measure."""

Hertz: TypeAlias = Annotated[float | None, in_unit("Hz", positive=True)]
Seconds: TypeAlias = Annotated[float | None, in_unit("s", not_negative=True)]
Length: TypeAlias = Annotated[float | None, in_unit("m", not_negative=True)]
Decibels: TypeAlias = Annotated[float | None, in_unit("dB", positive=True)]


def one_line(text: str) -> str:
    """Return a text that is one line of at most 200 characters.

    Raises
    ------
    ValueError
        If it is none.
    """
    if not text.strip() or not text.isprintable() or len(text) > 200:
        raise ValueError(f"expected one line of text, got {quoted(text)}")
    return text.strip()


def _checked_remark(text: str) -> str:
    if len(text) > 5000:
        raise ValueError("expected text of at most 5000 characters")
    return " ".join(text.split())


def _checked_unit(text: str) -> str:
    number, plain = numbered(text)
    unit = spelled(plain)
    problem = problem_of_unit(unit)
    if problem is None and not any(is_unit_of(unit, wanted) for wanted in CHANNEL_UNITS):
        problem = "no channel measures that"
    if problem is None and not 0.0 < number < math.inf:
        problem = "the number before it has to be more than 0"
    if problem is not None:
        raise ValueError(
            f"expected a unit such as g, m/s^2 or N, got {quoted(text)}; {problem}"
        )
    return unit if number == 1.0 else f"{repr(number).removesuffix('.0')} {unit}"


def _checked_sensitivity(text: str) -> str:
    if any(fits_sensitivity(text, unit) for unit in CHANNEL_UNITS):
        return text
    raise ValueError(f"expected volts per unit, such as 100 mV/g, got {quoted(text)}")


def _checked_id(identity: int | str) -> int | str:
    text = str(identity)
    if len(text) > 60 or re.fullmatch(r"\w(?:[\w .,+=@()#-]*[\w)#+])?", text) is None:
        raise ValueError(
            f"expected an id of letters, digits and - _ . +, such as 7 or 7b, "
            f"got {quoted(text)}; it becomes part of file names"
        )
    return identity


def _checked_hash(text: str) -> str:
    if re.fullmatch(r"[0-9a-fA-F]{64}", text) is None:
        raise ValueError(f"expected 64 hexadecimal digits, got {quoted(text)}")
    return text.lower()


_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def _direction(written: object) -> tuple[float, ...]:
    """Return the unit vector of a direction: an axis such as -z, or three numbers.

    Raises
    ------
    ValueError
        If it is neither.
    """
    if isinstance(written, str) and written.strip().lower().lstrip("+-") in _AXES:
        axis = written.strip().lower()
        return tuple(-v if axis[0] == "-" and v else v for v in _AXES[axis.lstrip("+-")])
    numbers = written if isinstance(written, list | tuple) else ()
    plain = all(isinstance(v, int | float) and not isinstance(v, bool) for v in numbers)
    length = math.hypot(*numbers) if plain and len(numbers) == 3 else 0.0
    if not 0.0 < length < math.inf:
        raise ValueError(
            f"expected x, y, z, -x, -y, -z or three numbers such as [0, 0.5, 0.5], got "
            f"{quoted(written)}"
        )
    return tuple(v / length for v in numbers)


def as_text(written: object) -> object:
    """Return a number as text: what lacks its unit is told of by those who know which."""
    return str(written) if type(written) in {int, float} else written


UnitText: TypeAlias = Annotated[str, AfterValidator(_checked_unit)]
SensitivityText: TypeAlias = Annotated[
    str, BeforeValidator(as_text), AfterValidator(_checked_sensitivity)
]
HashText: TypeAlias = Annotated[str, AfterValidator(_checked_hash)]
Direction: TypeAlias = Annotated[tuple[float, float, float], BeforeValidator(_direction)]
Written: TypeAlias = Annotated[str, BeforeValidator(as_text)]
Metre: TypeAlias = Annotated[float, in_unit("m")]
Text: TypeAlias = Annotated[str, AfterValidator(one_line)]
Remark: TypeAlias = Annotated[str, AfterValidator(_checked_remark)]
Identity: TypeAlias = Annotated[int | str, AfterValidator(_checked_id)]
