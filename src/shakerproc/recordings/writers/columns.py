"""Write columns: CSV and Parquet, with time first and the unit in every header."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np

from shakerproc import files
from shakerproc.data import FloatArray, Recording
from shakerproc.errors import RecordingError
from shakerproc.late import without_parquet
from shakerproc.recordings.parquet import RATE_KEY
from shakerproc.recordings.writers.shown_units import BLOCK, blocks_in_file_units, headers

TIME: Final = "time [s]"


def write_csv(path: Path, recording: Recording) -> None:
    """Write a recording as CSV, whole or not at all; every number with all its digits."""
    line = io.StringIO()
    titles = [TIME, *headers(recording.channels)]
    csv.writer(line, lineterminator="\n").writerow([files.csv_cell(title) for title in titles])
    write_block = _with_python if without_parquet() else _with_arrow
    with files.atomic_path(path) as temporary, temporary.open("wb") as sink:
        sink.write(line.getvalue().encode("utf-8"))
        for columns in _columns(recording):
            write_block(columns, sink)


def _with_arrow(columns: list[FloatArray], sink: BinaryIO) -> None:
    """Write rows of numbers, each in the fewest digits that give it back."""
    import pyarrow as pa
    from pyarrow import csv as arrow_csv

    names = [str(number) for number in range(len(columns))]
    batch = pa.record_batch([pa.array(column) for column in columns], names=names)
    arrow_csv.write_csv(batch, sink, arrow_csv.WriteOptions(include_header=False))


def _with_python(columns: list[FloatArray], sink: BinaryIO) -> None:
    """Write the same numbers without pyarrow, in some five times the time."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    sink.write("".join(",".join(map(repr, row)) + "\n" for row in rows).encode("ascii"))


def write_parquet(path: Path, recording: Recording) -> None:
    """Write a recording as Parquet, whole or not at all.

    Raises
    ------
    RecordingError
        If pyarrow is not installed.
    """
    if lacks := without_parquet():
        raise RecordingError(f"{path}: {lacks}")
    from pyarrow import parquet

    with files.atomic_path(path) as temporary:
        batches = _batches(recording)
        first = next(batches)
        rate = repr(float(recording.sample_rate)).encode("ascii")
        schema = first.schema.with_metadata({RATE_KEY: rate})
        with parquet.ParquetWriter(temporary, schema) as writer:
            writer.write_batch(first.replace_schema_metadata(schema.metadata))
            for batch in batches:
                writer.write_batch(batch.replace_schema_metadata(schema.metadata))


def _batches(recording: Recording) -> Iterator[Any]:
    """Yield the table in pieces."""
    import pyarrow as pa

    titles = [TIME, *headers(recording.channels)]
    for columns in _columns(recording):
        yield pa.record_batch([pa.array(column) for column in columns], names=titles)


def _columns(recording: Recording) -> Iterator[list[FloatArray]]:
    """Yield time [s] and channels in pieces."""
    for number, block in enumerate(blocks_in_file_units(recording)):
        at = np.arange(number * BLOCK, number * BLOCK + block.shape[1])
        yield [at / recording.sample_rate, *block]
