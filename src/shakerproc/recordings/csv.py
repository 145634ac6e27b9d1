"""Read CSV: delimiter, decimal sign, headers, units and time column are found by looking."""

from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from shakerproc.recordings.columns import Columns, file_of_columns
from shakerproc.recordings.raw import RawFile
from shakerproc.recordings.skipped import refusal, without_bad_rows
from shakerproc.recordings.text_format import find_format, open_text
from shakerproc.recordings.text_rows import read_table
from shakerproc.recordings.text_stamps import StampedFile, stamps_of
from shakerproc.recordings.times import time_columns


def read_csv(path: Path, run: str) -> RawFile:
    """Return the columns of a text file as channels.

    Raises
    ------
    RecordingError
        If it holds no table of numbers.
    """
    return table_of(*open_text(path, run), run)


def table_of(file: BinaryIO, encoding: str, lines: list[str], run: str) -> RawFile:
    """Return the columns of an open text as channels; arguments as `open_text` returns them.

    Raises
    ------
    RecordingError
        If it holds no table of numbers.
    """
    stamps = stamps_of(lines)
    with file:
        if stamps is None:
            found = find_format(lines, encoding, run)
            table = read_table(file, found, run)
        else:
            plain = [stamps.replaced(line.encode()).decode() for line in lines]
            found = find_format(plain, encoding, run)
            units = tuple("" if at == stamps.column else u for at, u in enumerate(found.units))
            found = replace(found, headers=stamps.named(found.headers), units=units)
            table = read_table(StampedFile(file, stamps), found, run)
    axes = time_columns(found.headers, found.units)
    times = table.values[axes[0]] if axes else None
    values, skipped = without_bad_rows(table.values, table.bad, times)
    raw = file_of_columns(
        Columns(found.headers, values, found.units),
        axes=found.axes,
        start_time=None if stamps is None else stamps.start,
        cut=table.torn,
    )
    notes = (*([found.note] if found.note else []), *raw.notes)
    if table.unended:
        notes += ("The file does not end with a line end: its last number may be cut.",)
    if skipped is None:
        return replace(raw, notes=notes)
    return replace(
        raw,
        notes=(skipped.message, *notes),
        skipped=skipped,
        refusal=refusal(table.bad, len(found.headers)),
    )
