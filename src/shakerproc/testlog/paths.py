"""Files beside a log: paths below its folder, on every system, and cells of CSV files."""

import csv
import io
import os
import re
import stat
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Final, final

from shakerproc.errors import LogError
from shakerproc.units import quoted

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
    for found, is_wrong in _WRONG.items():
        if is_wrong(plain):
            raise ValueError(
                f"expected a path below the folder, such as Test_1/Acceleration.tdms, "
                f"got {quoted(text)} with {found}"
            )
    return plain


@final
class Below:
    """A folder, and what lies below it; remembers which of its folders were looked at."""

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
        found = os.lstat(path)
    except (OSError, ValueError):
        return False
    return stat.S_ISLNK(found.st_mode) or getattr(found, "st_reparse_tag", 0) != 0


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
