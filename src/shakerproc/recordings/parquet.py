"""Read Parquet: columns of numbers with names such as ``ch3 [g]``, a piece at a time."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import Columns, file_of_columns
from shakerproc.recordings.guard import foreign, shown
from shakerproc.recordings.parquet_pages import check_pages
from shakerproc.recordings.rates import agreed_rate
from shakerproc.recordings.raw import RawFile
from shakerproc.recordings.times import rate_of_times, time_columns
from shakerproc.recordings.trial import check_survived

RATE_KEY: Final = b"sample_rate_hz"
LARGEST: Final = 1 << 40
"""Bytes of numbers that a recording may hold; they are read in pieces."""

PIECE: Final = 1 << 16
"""Rows that are decoded at a time."""

HEAD: Final = 1 << 10
"""Rows at the start by which a column is judged to be a time."""

JUDGED: Final = 1 << 20
"""Rows of a time column that are judged at a time."""

CURSORS: Final = 4
"""Places of the file that are kept, each for its own columns."""


def read_parquet(path: Path, run: str) -> RawFile:
    """Return the columns of a Parquet file as channels; what is text is named in a note.

    pyarrow ends the process at some damaged files. A process of its own opens the file first,
    and reads the first piece of each row group: a third of a second for each file.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    check_survived(path, run, "shakerproc.recordings.parquet:try_parquet")
    return _opened(path, run)


def try_parquet(path: Path) -> None:
    """Open a file and read the first piece of each row group; the process may die of it."""
    raw = _opened(path, path.name)
    if isinstance(raw.source, ParquetSource):
        raw.source.read_beginnings()


def _opened(path: Path, run: str) -> RawFile:
    from pyarrow import parquet

    with foreign(run, "opening the table"):
        file = parquet.ParquetFile(path, pre_buffer=False, buffer_size=1 << 16)
    try:
        with foreign(run, "reading the table"):
            check_pages(path, file.metadata, run)
            return _read(file, run)
    except BaseException:
        file.close()
        raise


def _read(file: Any, run: str) -> RawFile:
    import pyarrow as pa

    n_rows, n_columns = file.metadata.num_rows, file.metadata.num_columns
    if n_rows < 0 or 8 * n_rows * n_columns > LARGEST:
        raise RecordingError(
            f"{run}: the file says that it holds {n_rows} rows of {n_columns} columns, more "
            "than any recording. Export it again."
        )
    schema = file.schema_arrow
    are_numbers = (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal)
    names = [f.name for f in schema if any(is_kind(f.type) for is_kind in are_numbers)]
    others = [f"{shown(f.name, 40)} ({f.type})" for f in schema if f.name not in names]
    notes = []
    if others:
        notes.append(f"Columns that hold no numbers are not used: {', '.join(others[:20])}.")
    double = sorted({name for name in names if names.count(name) > 1})
    if double:
        raise RecordingError(
            f"{run}: several columns are called {shown(double[0])}. Give each a name of its "
            "own."
        )
    source = ParquetSource(run, file, tuple(names), n_rows)
    head = source.read(range(len(names)), 0, min(n_rows, HEAD))
    axes = time_columns(names)
    if len(axes) > 1:
        listed = ", ".join(shown(names[row]) for row, _ in axes)
        raise RecordingError(
            f"{run}: several time columns: {listed}. Save what has a rate of its own in a file "
            "of its own."
        )
    said = _said(schema.metadata or {})
    problem = ""
    if axes and n_rows > 1:
        rate, problem = _rate_of_times(source, *axes[0], n_rows)
        said |= {} if rate is None else {f"column {shown(names[axes[0][0]])}": rate}
    agreed, contradiction = agreed_rate(said)
    return file_of_columns(
        Columns(names, head),
        sample_rate=None if problem else agreed,
        rate_problem=problem or contradiction,
        lengths=[n_rows] * len(names),
        source=source,
        notes=notes,
    )


def _said(metadata: "dict[bytes, bytes]") -> dict[str, float]:
    """Return the sample rate [Hz] in the metadata; not a number where it is none."""
    if RATE_KEY not in metadata:
        return {}
    text = metadata[RATE_KEY].decode("ascii", errors="replace")
    try:
        return {RATE_KEY.decode(): float(text)}
    except ValueError:
        return {RATE_KEY.decode(): math.nan}


def _rate_of_times(
    source: "ParquetSource", row: int, seconds: float, n_rows: int
) -> tuple[float | None, str]:
    """Return the sample rate [Hz] of a time column, judged in pieces that overlap by a row."""
    if n_rows <= JUDGED:
        return rate_of_times(source.read([row], 0, n_rows)[0] * seconds)
    ends = [source.read([row], at, at + 1)[0, 0] * seconds for at in (0, n_rows - 1)]
    rate, problem = rate_of_times(np.array(ends))
    if rate is None:
        return None, problem
    rate *= n_rows - 1
    for first in range(0, n_rows - 1, JUDGED):
        last = min(first + JUDGED, n_rows - 1)
        piece, problem = rate_of_times(source.read([row], first, last + 1)[0] * seconds)
        if piece is None:
            return None, f"{problem} (counted from sample {first})"
        if abs(piece / rate - 1.0) * (last - first) > 1.0:
            return None, (
                f"the time column does not advance evenly: {piece:.9g} Hz from sample {first} "
                f"to {last}, {rate:.9g} Hz on the whole"
            )
    whole = round(rate)
    return (float(whole) if whole and abs(rate / whole - 1.0) * n_rows < 0.5 else rate), ""


@final
class ParquetSource(SampleSource):
    """Columns of a Parquet file, decoded a piece at a time as they are asked for, in order.

    Parameters
    ----------
    run : str
        Name of the run, for messages.
    file : object
        The open file.
    names : tuple of str
        Columns, one a row.
    n_rows : int
        Values of each.
    """

    def __init__(self, run: str, file: Any, names: tuple[str, ...], n_rows: int) -> None:
        self._run = run
        self._file = file
        self._names = names
        self._n_rows = n_rows
        sizes = [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)]
        self._starts = np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
        self._cursors: dict[tuple[int, ...], _Cursor] = {}

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        columns = tuple(rows)
        out = np.empty((len(columns), max(0, stop - start)))
        if not out.size:
            return out
        with foreign(self._run, "reading the samples"):
            cursor = self._cursors.pop(columns, None)
            if cursor is None or not cursor.first <= start:
                cursor = self._cursor(columns, start)
            self._cursors[columns] = cursor
            if len(self._cursors) > CURSORS:
                del self._cursors[next(iter(self._cursors))]
            cursor.fill(out, start)
        return out

    def read_beginnings(self) -> None:
        """Decode the first piece of each row group, and keep none."""
        for start, stop in pairwise(self._starts):
            self.read(range(len(self._names)), int(start), min(int(stop), int(start) + PIECE))

    def _cursor(self, columns: tuple[int, ...], start: int) -> "_Cursor":
        group = int(np.searchsorted(self._starts, start, side="right")) - 1
        pieces = self._file.iter_batches(
            batch_size=PIECE,
            row_groups=list(range(max(group, 0), self._file.num_row_groups)),
            columns=[self._names[column] for column in columns],
            use_threads=False,
        )
        names = [self._names[column] for column in columns]
        return _Cursor(pieces, names, int(self._starts[max(group, 0)]))

    def close(self) -> None:
        """Close the file."""
        self._cursors.clear()
        self._file.close()


@final
class _Cursor:
    """A place in some columns, from which it goes on."""

    def __init__(self, pieces: Iterator[Any], names: Sequence[str], first: int) -> None:
        self._pieces = pieces
        self._names = names
        self._piece = np.empty((len(names), 0))
        self.first = first

    def fill(self, out: FloatArray, start: int) -> None:
        """Write the samples from `start` on.

        Raises
        ------
        EOFError
            If the file ends before.
        """
        done = 0
        while done < out.shape[1]:
            at = start + done - self.first
            there = self._piece[:, at : at + out.shape[1] - done]
            out[:, done : done + there.shape[1]] = there
            done += there.shape[1]
            if done < out.shape[1]:
                self._next()

    def _next(self) -> None:
        self.first += self._piece.shape[1]
        batch = next(self._pieces, None)
        if batch is None:
            raise EOFError(f"the columns end after {self.first} rows")
        self._piece = np.stack([_numbers(batch.column(name)) for name in self._names])


def _numbers(column: Any) -> FloatArray:
    """Return a column as numbers; not a number where it holds none."""
    import pyarrow as pa

    if pa.types.is_decimal(column.type):
        column = column.cast(pa.float64())
    values: FloatArray = column.to_numpy(zero_copy_only=False).astype(np.float64)
    return values
