"""Tensile runs: displacement and force from a CSV file or a testing machine's text export."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError

_DISPLACEMENT = (
    "displacement",
    "extension",
    "elongation",
    "weg",
    "dehnung",
    "travel",
    "stroke",
)
_FORCE = ("force", "load", "kraft", "standardkraft")
_TO_METRE = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "in": 0.0254}
_TO_NEWTON = {"n": 1.0, "kn": 1e3, "mn": 1e6, "lbf": 4.4482216152605, "kip": 4448.2216152605}


@final
@dataclass(frozen=True, slots=True, eq=False)
class TensileRun:
    """One pull of a specimen.

    Attributes
    ----------
    name : str
        Name of the run, from its file.
    specimen : str
        Name of the folder that holds the file.
    displacement : (n_samples,) array
        [m].
    force : (n_samples,) array
        [N].
    """

    name: str
    specimen: str
    displacement: FloatArray
    force: FloatArray


def read_tensile(path: Path) -> TensileRun:
    """Return the run in a CSV file or text export with a heading that names its units.

    Semicolons, tabs and commas part the columns; a decimal comma is understood where columns
    are not parted by commas; lines before the heading and a row of units below it may stand.

    Raises
    ------
    ExchangeError
        If a column, its unit or a number is missing; file and line are named.
    """
    lines = _lines(path)
    heading = next((i for i, line in enumerate(lines) if _is_heading(line)), None)
    if heading is None:
        raise ExchangeError(
            f"{path.name}: no line names a displacement and a force; write a heading such as "
            f"displacement_mm,force_n above the numbers"
        )
    separator = max(";\t,", key=lines[heading].count)
    titles = [title.strip(' "') for title in lines[heading].split(separator)]
    first = heading + 1
    units = [""] * len(titles)
    if first < len(lines) and not re.search(r"\d", lines[first]):
        units = [unit.strip(' "[]()') for unit in lines[first].split(separator)]
        first += 1
    where = f"{path.name}:{heading + 1}"
    columns = [
        _column(where, titles, units, quantity)
        for quantity in ((_DISPLACEMENT, _TO_METRE), (_FORCE, _TO_NEWTON))
    ]
    rows = [
        [_number(path, i, line.split(separator), column, separator) for column, _ in columns]
        for i, line in enumerate(lines[first:], first + 1)
        if line.strip(f" {separator}")
    ]
    if len(rows) < 2:
        raise ExchangeError(f"{path.name}: {len(rows)} rows of numbers, at least 2 are needed")
    values = np.array(rows).T
    return TensileRun(
        name=path.stem,
        specimen=path.resolve().parent.name,
        displacement=values[0] * columns[0][1],
        force=values[1] * columns[1][1],
    )


def _lines(path: Path) -> list[str]:
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ExchangeError(f"{path.name}: cannot be read: {error.strerror}") from error
    if b"\0" in raw[:4096]:
        raise ExchangeError(f"{path.name}: not a text file; export the run as text or CSV")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return raw.decode(encoding).splitlines()
        except UnicodeDecodeError:
            continue
    raise ExchangeError(f"{path.name}: neither UTF-8 nor Windows text; export it as UTF-8")


def _is_heading(line: str) -> bool:
    low = line.lower()
    return any(w in low for w in _DISPLACEMENT) and any(w in low for w in _FORCE)


def _column(
    where: str,
    titles: list[str],
    units: list[str],
    quantity: tuple[tuple[str, ...], dict[str, float]],
) -> tuple[int, float]:
    words, factors = quantity
    column = next(i for i, t in enumerate(titles) if any(w in t.lower() for w in words))
    title = titles[column]
    written = units[column] if column < len(units) and units[column] else ""
    if not written:
        found = re.search(r"[\[(_ ,]\s*([A-Za-zµ]+)\s*[\])]?\s*$", title)
        written = found.group(1) if found else ""
    if written.lower() not in factors:
        raise ExchangeError(
            f"{where}: column {title!r} has no unit that is known here"
            f"{f' ({written!r})' if written else ''}; write one of {', '.join(factors)} into "
            f"the heading, such as {words[0]}_{next(iter(factors))}"
        )
    return column, factors[written.lower()]


def _number(path: Path, line: int, cells: list[str], column: int, separator: str) -> float:
    text = cells[column].strip(' "') if column < len(cells) else ""
    if separator != ",":
        text = text.replace(",", ".")
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ExchangeError(
            f"{path.name}:{line}: column {column + 1} holds {text!r}, a number was wanted; "
            f"delete the line or repair the export"
        )
    return value
