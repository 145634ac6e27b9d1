"""The tables of a whole campaign."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shakerproc import files
from shakerproc.campaign import tables
from shakerproc.campaign.trend import Trend
from shakerproc.late import without_parquet
from shakerproc.runs import RunSummary
from shakerproc.runs.summary import Value
from shakerproc.runs.tables import Columns

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pyarrow import Array


def write_tables(
    runs: Sequence[RunSummary], trends: Sequence[Trend], channel: str, root: Path
) -> list[Path]:
    """Write runs, peaks, statistics, analyses and trends as CSV, the peaks as Parquet too.

    Parquet only where pyarrow is installed, which the extra `parquet` brings.
    """
    done = [run for run in runs if run.status == "done"]
    content = {
        "runs.csv": tables.run_columns(runs),
        "peaks.csv": tables.peak_columns(done),
        "statistics.csv": tables.statistics_columns(done),
        **{
            f"{kind}.csv": tables.analysis_columns(done, kind)
            for kind in tables.kinds_of_analysis(done)
        },
        **{f"trends/{t.name}.csv": tables.trend_columns(t, channel) for t in trends},
    }
    for name, columns in content.items():
        files.write_csv(root / name, columns)
    written = [root / name for name in content]
    if not without_parquet():
        written.append(root / "peaks.parquet")
        write_parquet(written[-1], content["peaks.csv"])
    return written


def write_parquet(path: Path, columns: Columns) -> None:
    """Write columns as Parquet, whole or not at all; a column of mixed kinds becomes text."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = [files.printable(name) for name in columns]
    arrays = [_arrow(values) for values in columns.values()]
    with files.atomic_path(path) as temporary:
        pq.write_table(pa.Table.from_arrays(arrays, names), temporary)


def _arrow(values: "Sequence[Value] | NDArray[Any]") -> "Array[Any]":
    """Return a column as Arrow holds it.

    `pyarrow.array` would load pandas, a fifth of a second, to see that a list is none of its.
    """
    import pyarrow as pa

    if isinstance(values, np.ndarray):
        values = values.tolist()
    kinds = {type(value) for value in values if value is not None}
    if not kinds:
        return pa.nulls(len(values))
    valid = pa.py_buffer(
        np.packbits([value is not None for value in values], bitorder="little")
    )
    if kinds == {bool}:
        bits = pa.py_buffer(np.packbits([value is True for value in values], bitorder="little"))
        return pa.Array.from_buffers(pa.bool_(), len(values), [valid, bits])
    if kinds <= {int, float}:
        whole = kinds == {int}
        numbers = np.array(
            [0 if v is None else v for v in values], np.int64 if whole else np.float64
        )
        kind = pa.int64() if whole else pa.float64()
        return pa.Array.from_buffers(kind, len(values), [valid, pa.py_buffer(numbers)])
    texts = [b"" if value is None else str(value).encode() for value in values]
    ends = np.cumsum([0, *map(len, texts)], dtype=np.int32)
    return pa.Array.from_buffers(
        pa.string(), len(values), [valid, pa.py_buffer(ends), pa.py_buffer(b"".join(texts))]
    )
