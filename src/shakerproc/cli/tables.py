"""Tables as text that fit a width: wrapped, then with columns left out; never a number cut."""

import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

BETWEEN: Final = 2
"""Spaces between two columns."""

LONGEST: Final = 14
"""Characters of a word that is never broken: every number is shorter."""


class Picture(str):
    """A cell of several lines that the program has drawn itself."""

    __slots__ = ()


@final
@dataclass(frozen=True, slots=True)
class TableLayout:
    """Which columns of a table are printed, and how wide.

    Attributes
    ----------
    kept : tuple of int
        Columns that are printed.
    widths : tuple of int
        Characters of each of them.
    empty, left_out : tuple of str
        Columns that are not printed: those without a cell, and the others.
    """

    kept: tuple[int, ...]
    widths: tuple[int, ...]
    empty: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()

    def omission_text(self, elsewhere: str) -> str:
        """Return which columns are left out and where they are, nothing where none is."""
        names = [*self.left_out, *(f"{name} (empty)" for name in self.empty)]
        if not names:
            return ""
        return f"columns left out: {', '.join(names)}; widen the terminal or see {elsewhere}"


def fitted(
    columns: Sequence[str],
    cells: Sequence[Sequence[str]],
    numeric: Sequence[bool],
    width: int | None,
    spare: Sequence[str] = (),
) -> TableLayout:
    """Return how to print a table in so many characters.

    Empty columns are left out first; then headers and texts are wrapped between words, and
    within words of more than `LONGEST` characters. Where that is not enough, columns that can
    be spared are left out, in their order, then others from the right; the first one stays.

    Parameters
    ----------
    columns : sequence of str
        Headers.
    cells : sequence of sequence of str
        Rows of texts.
    numeric : sequence of bool
        Which columns hold numbers, which are never broken.
    width : int or None
        Characters of a line; None for as many as the rows take.
    spare : sequence of str
        Columns to leave out first.
    """
    rows = [columns, *cells]
    natural = [max(_width(row[i]) for row in rows) for i in range(len(columns))]
    least = [
        max(
            _narrowest(columns[i]),
            *(_width(row[i]) if numeric[i] else _narrowest(row[i]) for row in cells),
            1,
        )
        for i in range(len(columns))
    ]
    kept = list(range(len(columns)))
    if width is None:
        return TableLayout(tuple(kept), tuple(natural))
    empty = [i for i in kept if not any(row[i] for row in cells)] if cells else []
    named = [columns.index(name) for name in spare if name in columns]
    gone: list[int] = []
    for candidates, needed in ((empty, natural), ((*named, *reversed(kept[1:])), least)):
        for i in candidates:
            if _total([needed[k] for k in kept]) > width and i in kept and len(kept) > 1:
                kept.remove(i)
                gone.append(i)
    of_cells = [max((_width(row[i]) for row in cells), default=0) for i in kept]
    widths = [natural[k] for k in kept]
    for low in (  # headers first: that takes no line more for each row
        [max(least[k], size) for k, size in zip(kept, of_cells, strict=True)],
        [least[k] for k in kept],
    ):
        widths = _shrunk(widths, low, width)
    return TableLayout(
        tuple(kept),
        tuple(widths),
        tuple(columns[i] for i in sorted(gone) if i in empty),
        tuple(columns[i] for i in sorted(gone) if i not in empty),
    )


def _total(widths: Sequence[int]) -> int:
    return sum(widths) + BETWEEN * (len(widths) - 1)


def _shrunk(natural: Sequence[int], least: Sequence[int], width: int) -> list[int]:
    """Return widths that fit, the widest column taken from first."""
    widths = list(natural)
    while _total(widths) > width:
        free = [i for i, (now, low) in enumerate(zip(widths, least, strict=True)) if now > low]
        if not free:
            break
        widths[max(free, key=lambda i: widths[i])] -= 1
    return widths


def lines_of(
    row: Sequence[str], layout: TableLayout, numeric: Sequence[bool], *, bottom: bool = False
) -> list[str]:
    """Return the lines of one row of a table; of a header, the words stand at the bottom."""
    folded = [
        wrapped(row[i], width) for i, width in zip(layout.kept, layout.widths, strict=True)
    ]
    height = max(len(lines) for lines in folded)
    lines = []
    for k in range(height):
        parts = []
        for i, width, texts in zip(layout.kept, layout.widths, folded, strict=True):
            place = k - (height - len(texts)) if bottom else k
            text = texts[place] if 0 <= place < len(texts) else ""
            room = " " * max(0, width - _length(text))
            parts.append(room + text if numeric[i] else text + room)
        lines.append((" " * BETWEEN).join(parts).rstrip())
    return lines


def wrapped(text: str, width: int) -> list[str]:
    """Return a text in lines of at most so many characters, broken between words if it can."""
    if isinstance(text, Picture):
        return text.splitlines() or [""]
    lines = []
    for line in text.splitlines() or [""]:
        now = ""
        for word in _pieces(line, width):
            longer = f"{now} {word}" if now else word
            if now and _length(longer) > width:
                lines.append(now)
                now = word
            else:
                now = longer
        lines.append(now)
    return lines


def _pieces(line: str, width: int) -> list[str]:
    """Return the words of a line, split where they are longer than it."""
    if _length(line) <= width:
        return [line]
    pieces = []
    for word in line.split():
        rest = word
        while _length(rest) > width and len(rest) > 1:
            size = max(k for k in range(1, len(rest)) if k == 1 or _length(rest[:k]) <= width)
            pieces.append(rest[:size])
            rest = rest[size:]
        pieces.append(rest)
    return pieces


def _narrowest(text: str) -> int:
    """Return how narrow a text may be printed: its longest word, or where that is broken."""
    if isinstance(text, Picture):
        return _width(text)
    return max((min(_length(word), LONGEST) for word in text.split()), default=0)


def _width(text: str) -> int:
    return max((_length(line) for line in text.splitlines()), default=0)


def _length(text: str) -> int:
    """Return how many characters of a terminal a text takes."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1
        for c in text
    )
