"""Write columns: CSV and Parquet, with time first and the unit in every header."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc import files
from shakerproc.data import Recording
from shakerproc.recordings.parquet import RATE_KEY
from shakerproc.recordings.writers.shown_units import BLOCK, blocks_in_file_units, headers

TIME: Final = "time [s]"


def write_csv(path: Path, recording: Recording) -> None:
    """Write a recording as CSV, whole or not at all; every number with all its digits."""
    from pyarrow import csv as arrow_csv

    line = io.StringIO()
    titles = [TIME, *headers(recording.channels)]
    csv.writer(line, lineterminator="\n").writerow([files.csv_cell(title) for title in titles])
    options = arrow_csv.WriteOptions(include_header=False)
    with files.atomic_path(path) as temporary, temporary.open("wb") as sink:
        sink.write(line.getvalue().encode("utf-8"))
        for batch in _batches(recording):
            arrow_csv.write_csv(batch, sink, options)


def write_parquet(path: Path, recording: Recording) -> None:
    """Write a recording as Parquet, whole or not at all."""
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
    for number, block in enumerate(blocks_in_file_units(recording)):
        at = np.arange(number * BLOCK, number * BLOCK + block.shape[1])
        columns = [pa.array(row) for row in (at / recording.sample_rate, *block)]
        yield pa.record_batch(columns, names=titles)
