"""Breakpoints of a profile as a CSV file holds them."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias, final

from shakerproc.errors import LogError
from shakerproc.testlog.csv_cells import csv_cells
from shakerproc.units import quoted

MOST_BYTES: Final = 1_000_000
"""Largest file of a profile that is read [byte]."""

SLOPE: Final = re.compile(
    r"^\s*([+-]?(?:\d+\.?\d*|\.\d+))\s*dB\s*/\s*oct(?:ave)?\s*$", re.IGNORECASE
)
"""A slope that stands where a level may, such as ``-3 dB/oct``."""

_HEADER: Final = re.compile(r"^(?P<name>[^\[(]*)[\[(](?P<unit>[^\])]*)[\])]\s*$")
_WANTED: Final = '"frequency [Hz],demand [g^2/Hz]" and, if need be, "alarm [dB],abort [dB]"'

Raise: TypeAlias = Callable[[int, str], Exception]
"""From the number of a breakpoint and what is wrong with it to the error with its place."""


@final
@dataclass(frozen=True, slots=True)
class Written:
    """A breakpoint as text: quantities with units, a slope where a level may stand."""

    frequency: str
    level: str
    alarm: str = ""
    abort: str = ""


def read_breakpoints(path: Path) -> tuple[list[Written], Raise]:
    """Return the breakpoints of a CSV file, and how errors about them say where they are.

    Raises
    ------
    LogError
        If it is no table of breakpoints.
    """
    lines = _lines(path)
    number, header = lines[0]
    columns = _columns(f"{path}:{number}", header)

    def place(row: int, message: str) -> Exception:
        at = lines[min(row + 1, len(lines) - 1)][0]
        return LogError(f"{path}:{at}: {message}")

    written = []
    for i, (_, cells) in enumerate(lines[1:]):
        if len(cells) != len(header):
            raise LogError(
                f"{path}:{lines[i + 1][0]}: expected {len(header)} cells, got {len(cells)}"
            )
        cell = {name: _cell(cells[at], unit) for name, (at, unit) in columns.items()}
        written.append(
            Written(
                cell["frequency"], cell["demand"], cell.get("alarm", ""), cell.get("abort", "")
            )
        )
    return written, place


def _lines(path: Path) -> list[tuple[int, list[str]]]:
    """Return the number and the cells of every line that holds something.

    Raises
    ------
    LogError
        If the file is no text, empty, or larger than any profile.
    """
    with path.open("rb") as file:
        raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise LogError(
            f"{path}: expected breakpoints, got more than 1 MB; name the profile's file"
        )
    lines = [row for row in csv_cells(raw, path, comments=True) if any(row[1])]
    if not lines:
        raise LogError(f"{path}: expected a header {_WANTED}, got an empty file")
    return lines


def _columns(place: str, header: Sequence[str]) -> dict[str, tuple[int, str]]:
    """Return position and unit of each column: frequency, demand, alarm, abort.

    Raises
    ------
    LogError
        If a column has no unit, is not known, stands twice or is missing.
    """
    found: dict[str, tuple[int, str]] = {}
    for i, cell in enumerate(header):
        match = _HEADER.match(cell)
        name = match["name"].strip().lower() if match else ""
        if match is None or name not in {"frequency", "demand", "alarm", "abort"}:
            raise LogError(f"{place}: expected a header {_WANTED}, got {quoted(cell)}")
        if name in found:
            raise LogError(f"{place}: expected one column {name}, got two")
        found[name] = (i, match["unit"].strip())
    if not {"frequency", "demand"} <= found.keys():
        raise LogError(f"{place}: expected a header {_WANTED}, got {', '.join(header)}")
    return found


def _cell(text: str, unit: str) -> str:
    """Return a cell with its unit; a slope says its own, and an empty one nothing."""
    return text if not text or SLOPE.match(text) else f"{text} {unit}"
