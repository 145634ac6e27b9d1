"""The cells of a CSV file, as a spreadsheet of any country writes it."""

import csv
import io
from pathlib import Path

from shakerproc.errors import LogError


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
