"""Small pictures in braille dots, for a terminal: two by four dots in every character."""

import os
import sys
from collections.abc import Sequence
from typing import Final

_BLANK: Final = 0x2800
_DOTS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


def can_be_shown() -> bool:
    """Return whether stdout is a terminal that has such characters."""
    encoding = (getattr(sys.stdout, "encoding", "") or "").lower().replace("-", "")
    return sys.stdout.isatty() and encoding == "utf8" and os.environ.get("TERM") != "dumb"


def curve(x: Sequence[float], y: Sequence[float], columns: int, rows: int) -> str:
    """Return a curve, with the origin in the middle, as lines of characters.

    Parameters
    ----------
    x, y : sequence of float
        Points along the curve, close to each other.
    columns, rows : int
        Size of the picture in characters.
    """
    wide, high = 2 * columns - 1, 4 * rows - 1
    cells = [[0] * columns for _ in range(rows)]
    largest_x = max(map(abs, x)) or 1.0
    largest_y = max(map(abs, y)) or 1.0
    for across, up in zip(x, y, strict=True):
        column = round((across / largest_x + 1.0) / 2.0 * wide)
        row = round((1.0 - up / largest_y) / 2.0 * high)
        cells[row // 4][column // 2] |= _DOTS[row % 4][column % 2]
    return "\n".join("".join(chr(_BLANK + cell) for cell in line) for line in cells)
