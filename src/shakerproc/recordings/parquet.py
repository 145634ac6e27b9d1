"""Read Parquet: columns of numbers with names such as ``ch3 [g]``."""

from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST
from shakerproc.recordings.columns import Columns, file_of_columns
from shakerproc.recordings.guard import foreign
from shakerproc.recordings.raw import RawFile

RATE_KEY: Final = b"sample_rate_hz"


def read_parquet(path: Path, run: str) -> RawFile:
    """Return the columns of a Parquet file as channels.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    import pyarrow as pa
    from pyarrow import parquet

    with foreign(run, "reading the table"), parquet.ParquetFile(path) as file:
        metadata = file.metadata
        if metadata.num_rows * metadata.num_columns * 8 > LARGEST:
            raise RecordingError(
                f"{run}: {metadata.num_rows} rows of {metadata.num_columns} columns are too "
                "many to hold in memory. Export the recording as TDMS instead."
            )
        schema = file.schema_arrow
        names = [
            field.name
            for field in schema
            if pa.types.is_floating(field.type) or pa.types.is_integer(field.type)
        ]
        table = file.read(columns=names)
        values = np.array([table.column(n).to_numpy().astype(np.float64) for n in names])
        text = (schema.metadata or {}).get(RATE_KEY, b"").decode("ascii")
        rate = float(text) if text else None
    return file_of_columns(Columns(names, values), sample_rate=rate)
