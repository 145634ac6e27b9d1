"""The values of a test log: texts, quantities, files below its folder; their refusals.

Quantities are written with their unit and held in SI.
"""

import csv
import io
import math
import os
import re
import stat
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias, final

from pydantic import AfterValidator, BeforeValidator

from shakerproc.data import ROLE_UNITS
from shakerproc.errors import LogError
from shakerproc.units import (
    any_quantity,
    fits_sensitivity,
    in_unit,
    is_unit_of,
    numbered,
    problem_of_unit,
    quoted,
    spelled,
)

if TYPE_CHECKING:
    from shakerproc.documents import Key


class MisfitError(Exception):
    """Something does not fit, at a key below the section that is looked at.

    Attributes
    ----------
    place : tuple of str and int
        Keys from the section to what does not fit.
    """

    def __init__(self, message: str, *place: "Key") -> None:
        self.place = place
        super().__init__(message)


CHANNEL_UNITS = tuple(dict.fromkeys(unit for units in ROLE_UNITS.values() for unit in units))
"""SI unit of each quantity that a channel may measure."""

Hertz: TypeAlias = Annotated[float | None, in_unit("Hz", positive=True)]
Seconds: TypeAlias = Annotated[float | None, in_unit("s", not_negative=True)]
Length: TypeAlias = Annotated[float | None, in_unit("m", not_negative=True)]
Decibels: TypeAlias = Annotated[float | None, in_unit("dB", positive=True)]


def _checked_quantity(written: object) -> object:
    any_quantity(written)
    return written


Quantity: TypeAlias = Annotated[str, BeforeValidator(_checked_quantity)]
"""A quantity of any kind, with its unit."""


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
    """Return a number as text: a missing unit is reported by the caller."""
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


_ORDINARY: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]*(?:\.[A-Za-z0-9_]+)?")
_DEVICE: Final = re.compile(
    r"(con|prn|aux|nul|clock\$|conin\$|conout\$|(com|lpt)[0-9¹²³])", re.IGNORECASE
)


def relative_path(text: str) -> str:
    r"""Return a path written in a log with ``\`` understood as ``/``.

    Raises
    ------
    ValueError
        If it could lead out of the folder that it starts in, or means a device on some system.
    """
    if len(text) < 200 and all(map(_is_ordinary, text.split("/"))):
        return text
    plain = text.replace("\\", "/")
    for pattern, is_wrong in _WRONG.items():
        if is_wrong(plain):
            raise ValueError(
                f"expected a path below the folder, such as Test_1/Acceleration.tdms, "
                f"got {quoted(text)} with {pattern}"
            )
    return plain


@final
class Below:
    """A folder and its content; remembers which of its folders were looked at."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder.absolute()
        self._plain: dict[str, bool] = {}

    def path(self, text: str) -> Path:
        """Return the absolute path of something below the folder, which need not exist.

        Raises
        ------
        ValueError
            If the text is no such path, or a link on the way leads out of the folder.
        """
        relative = relative_path(text)
        path = self.folder / relative
        if not self._holds(relative.split("/")) and not is_inside(path, self.folder):
            raise ValueError(
                f"expected a path below {self.folder}, got {quoted(text)}, "
                "a link that leads outside"
            )
        return path

    def _holds(self, parts: list[str]) -> bool:
        """Return whether no link stands on the way, which is quick to find out."""
        way = str(self.folder)
        for part in parts[:-1]:
            way = f"{way}{os.sep}{part}"
            if way not in self._plain:
                self._plain[way] = not _is_link(way)
            if not self._plain[way]:
                return False
        return not _is_link(f"{way}{os.sep}{parts[-1]}")


def _is_link(path: str) -> bool:
    """Return whether a path is a link of any kind, a junction of Windows among them."""
    try:
        status = os.lstat(path)
    except (OSError, ValueError):
        return False
    return stat.S_ISLNK(status.st_mode) or getattr(status, "st_reparse_tag", 0) != 0


def is_inside(path: Path, folder: Path) -> bool:
    """Return whether a path lies below a folder once all links are followed."""
    try:
        return path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # a loop of links
        return False


@lru_cache(maxsize=1024)
def _is_ordinary(part: str) -> bool:
    """Return whether a name is like nearly all others, and so needs no further question."""
    return _ORDINARY.fullmatch(part) is not None and not _is_device(part)


def _is_device(part: str) -> bool:
    return _DEVICE.fullmatch(part.partition(".")[0].strip()) is not None


_WRONG: Final[Mapping[str, Callable[[str], bool]]] = {
    "nothing in it": lambda path: not path.strip(),
    "more than 500 characters": lambda path: len(path) > 500,
    "a slash in front": lambda path: path.startswith("/"),
    "a drive letter or a colon": lambda path: ":" in path,
    '"~" in front': lambda path: path.startswith("~"),
    '"..", which leads out of it': lambda path: ".." in path.split("/"),
    "a control character": lambda path: not path.isprintable(),
    "the name of a device": lambda path: any(map(_is_device, path.split("/"))),
    "a space around a name": lambda path: any(p != p.strip() for p in path.split("/")),
    "a dot at the end of a name": lambda path: any(
        p.endswith(".") and p != "." for p in path.split("/")
    ),
    'one of < > " | ? *': lambda path: re.search(r'[<>"|?*]', path) is not None,
}
"""What a path may not have, in the order that it is asked."""


def csv_cells(raw: bytes, path: Path, *, comments: bool = False) -> list[tuple[int, list[str]]]:
    """Return number and cells of every line.

    The first line that says something tells whether semicolons or commas part them.

    Parameters
    ----------
    raw : bytes
        What the file holds.
    path : Path
        Of the file, for messages.
    comments : bool
        Whether lines that begin with # say nothing.

    Raises
    ------
    LogError
        If the file is no text.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise LogError(f"{path}: expected text in UTF-8: {error.reason}") from error
    lines = list(io.StringIO(text, newline=None))
    if comments:
        lines = ["\n" if line.lstrip().startswith("#") else line for line in lines]
    separator = ";" if ";" in next(filter(str.strip, lines), "") else ","
    rows = csv.reader(lines, delimiter=separator)
    return [(number, [cell.strip() for cell in cells]) for number, cells in enumerate(rows, 1)]
