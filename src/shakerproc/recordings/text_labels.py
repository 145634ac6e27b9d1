"""Rows above a table that begin with a label: interval, channel names, units."""

import re
from collections.abc import Sequence
from typing import Final

from shakerproc.recordings.si import split_header
from shakerproc.recordings.text_names import cells_in_use
from shakerproc.recordings.times import SECONDS

_NAME: Final = re.compile(
    r"(?:channel|signal)?[ _]?(?:names?|labels?)|channels?", re.IGNORECASE
)
_UNIT: Final = re.compile(r"units?|einheit(?:en)?", re.IGNORECASE)
_INTERVAL: Final = re.compile(
    r"(?:sampl(?:e|ing)[ _]?)?interval|delta[ _]?[tx]|dt|time[ _]?step", re.IGNORECASE
)
_QUANTITY: Final = re.compile(r"\s*(?P<number>[-+0-9.eE,]+)\s*(?P<unit>[^\d\s]*)\s*")

SAME_STEP: Final = 0.01
"""How far the steps of a first column may be from the interval, relative, to be times [-]."""


def unlabelled(
    above: Sequence[list[str]], used: int, decimal: str
) -> tuple[list[list[str]], float | None] | None:
    """Return the rows above a table without their labels, and the interval [s].

    A label stands in front of the columns or over the first of them. None where names and
    units do not both have one.

    Parameters
    ----------
    above : sequence of list of str
        Cells of the rows above the numbers.
    used : int
        How many columns hold numbers.
    decimal : str
        Sign between whole and fraction.
    """
    labels = [split_header(row[0])[0] if row else "" for row in above]
    if not (any(map(_NAME.fullmatch, labels)) and any(map(_UNIT.fullmatch, labels))):
        return None
    rows: list[list[str]] = []
    interval = None
    for label, row in zip(labels, above, strict=True):
        if _INTERVAL.fullmatch(label):
            interval = _seconds(row, decimal)
            rows.append([])
        elif _NAME.fullmatch(label) or _UNIT.fullmatch(label):
            filled = cells_in_use(row)
            rows.append(list(row[1:]) if len(filled) == used + 1 else ["", *row[1:]])
        else:
            rows.append(row)
    return rows, interval


def _seconds(row: Sequence[str], decimal: str) -> float | None:
    """Return the interval of a row that states one [s]; None where it is not to be read."""
    unit = split_header(row[0])[1]
    for cell in row[1:]:
        match = _QUANTITY.fullmatch(cell)
        if match is not None:
            factor = SECONDS.get((match["unit"] or unit or "s").casefold(), 0.0)
            try:
                return float(match["number"].replace(decimal, ".")) * factor or None
            except ValueError:
                return None
    return None


def is_stepped(rows: Sequence[list[str]], interval: float | None, decimal: str) -> bool:
    """Return whether the first column of a table begins with steps of an interval [s]."""
    if interval is None or len(rows) < 2:
        return False
    try:
        first, second = (float(row[0].replace(decimal, ".")) for row in rows[:2])
    except ValueError:
        return False
    return abs((second - first) / interval - 1.0) <= SAME_STEP
