"""Numbers in fixed columns: many lines of a text file at once."""

import numpy as np

from shakerproc.data import FloatArray


def numbers_of(lines: bytes, start: int, width: int, columns: int) -> FloatArray:
    """Return the numbers of lines of one length that stand in columns of one width.

    Parameters
    ----------
    lines : bytes
        Lines that all end in a line feed and have as many characters as the first.
    start, width : int
        Characters before the first column, and of each.
    columns : int
        How many there are.

    Returns
    -------
    (n_lines, columns) array
        As they stand, in the units of the file.

    Raises
    ------
    ValueError
        If lines differ in length, or a column holds no number.
    """
    length = lines.find(b"\n") + 1
    end = start + width * columns
    if length <= end or len(lines) % length:
        raise ValueError("lines differ in length")
    characters = np.frombuffer(lines, np.uint8).reshape(-1, length)
    if np.any(characters[:, -1] != ord("\n")):
        raise ValueError("lines differ in length")
    cells = np.ascontiguousarray(characters[:, start:end]).view(f"S{width}")
    return cells.astype(float)
