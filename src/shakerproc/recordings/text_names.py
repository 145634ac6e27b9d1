"""Which lines above a table of numbers name its columns and their units."""

import re
from collections.abc import Sequence
from typing import Final

from shakerproc.recordings.si import parse_unit
from shakerproc.recordings.text_meta import uncommented
from shakerproc.recordings.times import SECONDS

_WHOLE: Final = re.compile(r"\d{1,6}")
_BRACKETS: Final = re.compile(r"^(?:\[([^][]*)\]|\(([^()]*)\))$")
"""A cell that is one pair of brackets, as around a unit."""


def cells_in_use(row: Sequence[str]) -> Sequence[str]:
    """Return the cells of a row up to the last one that holds something."""
    there = [i for i, cell in enumerate(row) if cell]
    return row[: there[-1] + 1] if there else []


def fitted(row: list[str], used: int, width: int) -> list[str]:
    """Return a row of names at the width of the numbers: either may end in a delimiter."""
    filled = cells_in_use(row)
    return [*filled, *[""] * (width - used)] if len(filled) == used else row


def title_rows(
    above: Sequence[list[str]], numbers: Sequence[int], width: int, comments: Sequence[bool]
) -> list[int]:
    """Return which lines are headers: the last that fits, and one before it.

    A comment is one only where no other line is, or where it holds the units of such a line.
    """
    fitting = [
        i
        for i, row in enumerate(above)
        if len(row) == width and any(row) and _may_be_title(row, numbers[i], comments[i])
    ]
    plain = [i for i in fitting if not comments[i]]
    below = plain[-1] + 1 if plain else 0
    if below in fitting and _are_units(["" if comments[below] else "?", *above[below][1:]]):
        plain.append(below)
    titles = plain or fitting
    if not titles:
        return []
    last = titles[-1]
    if numbers[last] and last - 1 in titles and not numbers[last - 1]:
        last -= 1  # a row that holds numbers, below names: the first of the table
    return [last - 1, last] if last - 1 in titles else [last]


def _may_be_title(row: Sequence[str], numbers: int, comment: bool) -> bool:  # noqa: FBT001
    """Return whether a row may hold names: numbers among them are short and whole."""
    whole = sum(_WHOLE.fullmatch(cell) is not None for cell in row)
    if numbers and comment:
        return False
    return numbers == whole and numbers < sum(map(bool, row))


def column_names(
    rows: Sequence[list[str]], titles: Sequence[int], width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the lines above the numbers."""
    if not titles:
        return numbered(width), ()
    units = tuple(_BRACKETS.sub(r"\1\2", cell) for cell in _names(rows[titles[-1]]))
    if len(titles) == 2 and _are_units(units):
        return _names(rows[titles[0]]), units
    return _names(rows[titles[-1]]), ()


def numbered(width: int) -> tuple[str, ...]:
    """Return what columns are called that nothing names."""
    return tuple(f"column {i + 1}" for i in range(width))


def _names(row: Sequence[str]) -> tuple[str, ...]:
    """Return the names in a row, which may be written as a comment."""
    return (uncommented(row[0]), *row[1:])


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a row holds units rather than names: most of its words are units."""
    words = [cell for cell in cells if cell]
    known = sum(word.casefold() in SECONDS or parse_unit(word) is not None for word in words)
    return 2 * known > len(words)
