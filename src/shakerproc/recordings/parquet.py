"""Read Parquet: columns of numbers with names such as ``ch3 [g]``, a piece at a time.

A page that claims 2 GB is given 2 GB before anything is found wrong with it [1]_.

References
----------
.. [1] Apache Parquet, "File format" (PageHeader in parquet.thrift); Apache Thrift, "Thrift
   compact protocol encoding".
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, BinaryIO, Final, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.recordings.columns import Columns, file_of_columns
from shakerproc.recordings.guard import AGAIN, foreign, kept_open, shown
from shakerproc.recordings.raw import RawFile, TimeAxis, TimesInFile
from shakerproc.recordings.si import split_header
from shakerproc.recordings.times import SECONDS, is_time, time_columns

WINDOW: Final = 1 << 12
"""Bytes in which a page header is looked for; it has some 20, and more with statistics."""

UNCOMPRESSED, COMPRESSED = 2, 3
"""Fields of a page header: sizes of the page [byte]."""

DEEPEST: Final = 8
"""How far structures may stand in each other; those of a page header do three times."""

_BOOLEANS: Final = frozenset({1, 2})
_NUMBERS: Final = frozenset({4, 5, 6})
_FIXED: Final = {1: 1, 2: 1, 3: 1, 7: 8}
"""Bytes of what has a fixed length, in lists."""
_BINARY, _LIST, _SET, _STRUCT = 8, 9, 10, 12


def check_pages(path: Path, metadata: Any, run: str) -> None:
    """Pass a file whose pages are no larger than the columns that they are pieces of.

    A header that cannot be understood is left to the reader, which refuses it.

    Parameters
    ----------
    path : Path
        The file.
    metadata : pyarrow.parquet.FileMetaData
        What its footer says.
    run : str
        Opens the message.

    Raises
    ------
    RecordingError
        If a page promises more than its column holds in all.
    """
    with path.open("rb") as file:
        for group in range(metadata.num_row_groups):
            for number in range(metadata.num_columns):
                column = metadata.row_group(group).column(number)
                problem = _problem(file, column)
                if problem:
                    raise RecordingError(
                        f"{run}: a page of column {shown(column.path_in_schema)} says it holds "
                        f"{problem}. {AGAIN}"
                    )


def _problem(file: BinaryIO, column: Any) -> str:
    """Return how a page of a column contradicts its content; empty where it does not."""
    place, whole = column.data_page_offset, column.total_uncompressed_size
    if column.has_dictionary_page and column.dictionary_page_offset:
        place = min(place, column.dictionary_page_offset)
    end = place + column.total_compressed_size
    while 0 <= place < end:
        file.seek(place)
        try:
            fields, length = _page_header(file.read(WINDOW))
        except IndexError:
            return ""
        place += length
        size, compressed = fields.get(UNCOMPRESSED, 0), fields.get(COMPRESSED, -1)
        if size > whole:
            return f"{size} bytes, but the whole column of this group has {whole}"
        if compressed > end - place:
            return f"{compressed} bytes, but {end - place} are left of the column"
        if compressed < 0:
            return ""
        place += compressed
    return ""


def _page_header(data: bytes) -> tuple[dict[int, int], int]:
    """Return the whole numbers of the structure that data begin with, and its length.

    Raises
    ------
    IndexError
        If the data end before it does, or it nests too deep.
    """
    reader = _Compact(data)
    fields = reader.structure(depth=0)
    return fields, reader.place


class _Compact:
    """Thrift's compact protocol, as far as a page header needs it."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.place = 0

    def structure(self, *, depth: int) -> dict[int, int]:
        """Return the whole numbers of a structure by the number of their field.

        Raises
        ------
        IndexError
            If it does not end, or nests too deep.
        """
        if depth > DEEPEST:
            raise IndexError
        numbers: dict[int, int] = {}
        field = 0
        while kind := (head := self._byte()) & 15:
            field = field + (head >> 4) if head >> 4 else self._whole()
            if kind in _NUMBERS:
                numbers[field] = self._whole()
            elif kind not in _BOOLEANS:
                self._skip(kind, depth)
        return numbers

    def _byte(self) -> int:
        self.place += 1
        return self._data[self.place - 1]

    def _varint(self) -> int:
        value = 0
        for shift in range(0, 70, 7):
            byte = self._byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
        raise IndexError

    def _whole(self) -> int:
        value = self._varint() & 0xFFFFFFFF  # sizes have 32 bits; readers drop the others
        return (value >> 1) ^ -(value & 1)

    def _skip(self, kind: int, depth: int) -> None:
        if kind == _STRUCT:
            self.structure(depth=depth + 1)
        elif kind in _NUMBERS:
            self._varint()
        elif kind == _BINARY:
            length = self._varint()
            self.place += length
        elif kind in {_LIST, _SET}:
            head = self._byte()
            for _ in range(head >> 4 if head >> 4 < 15 else self._varint()):
                self._skip(head & 15, depth + 1)
        elif kind in _FIXED:
            self.place += _FIXED[kind]
        else:
            raise IndexError


RATE_KEY: Final = b"sample_rate_hz"
LARGEST: Final = 1 << 40
"""Bytes of numbers that a recording may hold; they are read in pieces."""

PIECE: Final = 1 << 16
"""Rows that are decoded at a time."""

HEAD: Final = 1 << 10
"""Rows at the start by which a column is judged to be a time."""

CURSORS: Final = 4
"""Places of the file that are kept, each for its own columns."""


def read_parquet(path: Path, run: str) -> RawFile:
    """Return the columns of a Parquet file as channels; columns of text are named in a note.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    from pyarrow import parquet

    with foreign(run, "opening the table"):
        file = parquet.ParquetFile(path, pre_buffer=False, buffer_size=1 << 16)
    with foreign(run, "reading the table"):
        return kept_open(file, lambda file: _read(file, path, run))


def _read(file: Any, path: Path, run: str) -> RawFile:
    check_pages(path, file.metadata, run)
    return file_of_table(_Groups(file), run)


@final
class _Groups:
    """A Parquet file, with the rows of its groups in a list."""

    def __init__(self, file: Any) -> None:
        groups = range(file.num_row_groups)
        self.sizes = [file.metadata.row_group(i).num_rows for i in groups]
        self.n_rows: int = file.metadata.num_rows
        self.num_row_groups: int = file.num_row_groups
        self.schema_arrow, self.iter_batches = file.schema_arrow, file.iter_batches
        self.close = file.close


def file_of_table(file: Any, run: str) -> RawFile:
    """Return the columns of an open table, of Parquet or Arrow, as channels.

    Raises
    ------
    RecordingError
        If it has too many rows, several columns of one name or several times.
    """
    import pyarrow as pa

    n_rows, n_columns = file.n_rows, len(file.schema_arrow.names)
    if n_rows < 0 or 8 * n_rows * n_columns > LARGEST:
        raise RecordingError(
            f"{run}: the file says that it holds {n_rows} rows of {n_columns} columns, more "
            "than any recording. Export it again."
        )
    schema = file.schema_arrow
    are_numbers = (pa.types.is_floating, pa.types.is_integer, pa.types.is_decimal)
    are_times = (pa.types.is_timestamp, pa.types.is_time, pa.types.is_duration)
    stamped = {f.name: f.type for f in schema if any(is_kind(f.type) for is_kind in are_times)}
    names = [
        f.name
        for f in schema
        if f.name in stamped or any(is_kind(f.type) for is_kind in are_numbers)
    ]
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
    zeros = {name: _first(file, name) for name in stamped}
    source = ParquetSource(run, file, tuple(names), n_rows, zeros)
    head = source.read(range(len(names)), 0, min(n_rows, HEAD))
    headers = [_header(n, stamped[n]) if n in stamped else n for n in names]
    axes = time_columns(headers)
    if len(axes) > 1:
        listed = ", ".join(shown(names[row]) for row in axes)
        raise RecordingError(
            f"{run}: several time columns: {listed}. Save what has a rate of its own in a file "
            "of its own."
        )
    return file_of_columns(
        Columns(headers, head),
        start_time=next((_date(kind, zeros[n]) for n, kind in stamped.items()), None),
        axes=_said(schema.metadata or {}),
        times={row: TimesInFile(source, row, n_rows) for row in axes},
        lengths=[n_rows] * len(names),
        source=source,
        notes=notes,
    )


def _first(file: Any, name: str) -> int:
    """Return the first date or time of a column, in its own unit; 0 where it has none."""
    import pyarrow as pa

    for batch in file.iter_batches(batch_size=1, columns=[name], use_threads=False):
        column = batch.column(0)
        plain = column.cast(pa.int32() if column.type.bit_width == 32 else pa.int64())
        return int(plain[0].as_py() or 0)
    return 0


def _header(name: str, kind: Any) -> str:
    """Return the header of a column of times, with the unit that it counts in."""
    plain = split_header(name)[0]
    return f"{plain if is_time(plain) else 'time'} [{kind.unit}]"


def _date(kind: Any, zero: int) -> datetime | None:
    """Return when a column of dates counts from; None of times without a day."""
    import pyarrow as pa

    if not pa.types.is_timestamp(kind):
        return None
    try:
        return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(seconds=zero * SECONDS[kind.unit])
    except OverflowError:
        return None


def _said(metadata: "dict[bytes, bytes]") -> tuple[TimeAxis, ...]:
    """Return the sample rate in the metadata; not a number where it is none."""
    if RATE_KEY not in metadata:
        return ()
    text = metadata[RATE_KEY].decode("ascii", errors="replace")
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    return (TimeAxis(RATE_KEY.decode(), rate=rate),)


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
    zeros : mapping
        First value of each column of dates or times, which is taken from the others [units of
        the column].
    """

    def __init__(
        self,
        run: str,
        file: Any,
        names: tuple[str, ...],
        n_rows: int,
        zeros: Mapping[str, int],
    ) -> None:
        self._run = run
        self._zeros = zeros
        self._file = file
        self._names = names
        self._n_rows = n_rows
        self._starts = np.concatenate([[0], np.cumsum(file.sizes, dtype=np.int64)])
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

    def _cursor(self, columns: tuple[int, ...], start: int) -> "_Cursor":
        group = int(np.searchsorted(self._starts, start, side="right")) - 1
        pieces = self._file.iter_batches(
            batch_size=PIECE,
            row_groups=list(range(max(group, 0), self._file.num_row_groups)),
            columns=[self._names[column] for column in columns],
            use_threads=False,
        )
        names = [self._names[column] for column in columns]
        zeros = [self._zeros.get(name, 0) for name in names]
        return _Cursor(pieces, names, int(self._starts[max(group, 0)]), zeros)

    def close(self) -> None:
        """Close the file."""
        self._cursors.clear()
        self._file.close()


@final
class _Cursor:
    """A place in some columns, from which it goes on."""

    def __init__(
        self, pieces: Iterator[Any], names: Sequence[str], first: int, zeros: Sequence[int]
    ) -> None:
        self._pieces = pieces
        self._zeros = zeros
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
        self._piece = np.stack([
            _numbers(batch.column(name), zero)
            for name, zero in zip(self._names, self._zeros, strict=True)
        ])


def _numbers(column: Any, zero: int = 0) -> FloatArray:
    """Return a column as numbers, of dates and times less `zero`; NaN where it holds none."""
    import pyarrow as pa

    if pa.types.is_temporal(column.type):
        whole = column.cast(pa.int32() if column.type.bit_width == 32 else pa.int64())
        there = column.is_valid().to_numpy(zero_copy_only=False)
        since = whole.fill_null(zero).to_numpy(zero_copy_only=False).astype(np.int64) - zero
        return np.where(there, since.astype(np.float64), np.nan)
    if pa.types.is_decimal(column.type):
        column = column.cast(pa.float64())
    values: FloatArray = column.to_numpy(zero_copy_only=False).astype(np.float64)
    return values
