"""Read XLSX: each sheet is read as the table of text that it would be exported as."""

import csv
import io
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import datetime, time
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc.data import ArraySource
from shakerproc.errors import RecordingError
from shakerproc.late import without_xlsx
from shakerproc.recordings.csv import table_of
from shakerproc.recordings.guard import foreign, shown
from shakerproc.recordings.raw import RawFile, RawGroup
from shakerproc.recordings.text_format import looked_at

LARGEST: Final = 1 << 30
"""Bytes of a workbook once it is unpacked; a row of five cells takes some 300."""

_OLD: Final = b"\xd0\xcf\x11\xe0"
"""How workbooks begin that are encrypted, and those of before 2007."""


def read_xlsx(path: Path, run: str) -> RawFile:
    """Return the sheets of a workbook that hold a table of numbers, a group each.

    Raises
    ------
    RecordingError
        If none does, it is encrypted, or openpyxl is not installed.
    """
    if lacks := without_xlsx():
        raise RecordingError(f"{run}: {lacks}")
    with path.open("rb") as file:
        if file.read(4) == _OLD:
            raise RecordingError(
                f"{run}: is encrypted, or a workbook of before 2007. Save it as .xlsx without "
                "a password."
            )
    found: dict[str, RawFile] = {}
    problems: dict[str, RecordingError] = {}
    for name, content in _sheets(path, run):
        try:
            found[name] = table_of(*looked_at(io.BytesIO(content), run), run)
        except RecordingError as error:
            problems[name] = error
    if not found:
        told = "; ".join(str(one) for one in list(problems.values())[:4])
        raise RecordingError(told or f"{run}: the workbook is empty.")
    notes = tuple(f"Sheet {shown(name)} holds no table of numbers." for name in problems)
    if len(found) == 1:
        (raw,) = found.values()
        return replace(raw, notes=(*raw.notes, *notes))
    return _joined(found, notes, run)


def _joined(found: dict[str, RawFile], notes: tuple[str, ...], run: str) -> RawFile:
    """Return several sheets as one file.

    Raises
    ------
    RecordingError
        If one has lines that are no rows.
    """
    groups: list[RawGroup] = []
    values: list[Any] = []
    for name, raw in found.items():
        if raw.skipped is not None:
            raise RecordingError(f"{run}: sheet {shown(name)}: {raw.refusal}")
        channels = raw.groups[0].channels
        groups.append(
            RawGroup(name, tuple(replace(c, row=c.row + len(values)) for c in channels))
        )
        if isinstance(raw.source, ArraySource):
            values += list(raw.source.samples)
        notes += tuple(f"{name}: {note}" for note in raw.notes)
    joined = np.full((len(values), max(row.size for row in values)), np.nan)
    for number, row in enumerate(values):
        joined[number, : row.size] = row
    return RawFile(tuple(groups), ArraySource(joined), notes)


def _sheets(path: Path, run: str) -> Iterator[tuple[str, bytes]]:
    """Yield name and text of each sheet that is not empty.

    Raises
    ------
    RecordingError
        If it is no workbook, or too large.
    """
    import openpyxl

    with foreign(run, "opening the workbook"):
        with zipfile.ZipFile(path) as archive:
            unpacked = sum(entry.file_size for entry in archive.infolist())
        if unpacked > LARGEST:
            raise RecordingError(
                f"{run}: {unpacked >> 20} MB once unpacked are too many to hold in memory. "
                "Export the recording as CSV or TDMS instead."
            )
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
    try:
        for sheet in book.worksheets:
            with foreign(run, f"reading sheet {shown(sheet.title)}"):
                content = _text(sheet.iter_rows(values_only=True))
            if content.strip(b",\r\n"):
                yield sheet.title, content
    finally:
        book.close()


def _text(rows: Any) -> bytes:
    """Return rows as a table of text, without empty ones at the end."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    empty = 0
    for row in rows:
        cells = [_cell(cell) for cell in row]
        while cells and not cells[-1]:
            cells.pop()
        if not cells:
            empty += 1
            continue
        text.write("\n" * empty)
        writer.writerow(cells)
        empty = 0
    return text.getvalue().encode()


def _cell(cell: Any) -> str:
    """Return a cell as text; numbers with all their digits."""
    if cell is None:
        return ""
    if isinstance(cell, datetime):
        return cell.isoformat(" ")
    return cell.isoformat() if isinstance(cell, time) else str(cell)
