"""The tables of a whole campaign."""

from collections.abc import Sequence
from pathlib import Path

from shakerproc import files
from shakerproc.campaign import tables
from shakerproc.campaign.trend import Trend
from shakerproc.runs import RunSummary
from shakerproc.runs.tables import Columns


def write_tables(
    runs: Sequence[RunSummary], trends: Sequence[Trend], channel: str, root: Path
) -> list[Path]:
    """Write runs, peaks, statistics, analyses and trends as CSV, the peaks as Parquet too."""
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
    write_parquet(root / "peaks.parquet", content["peaks.csv"])
    return [*(root / name for name in content), root / "peaks.parquet"]


def write_parquet(path: Path, columns: Columns) -> None:
    """Write columns as Parquet, whole or not at all; a column of mixed kinds becomes text."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays = {}
    for name, values in columns.items():
        try:
            arrays[files.printable(name)] = pa.array(values)
        except (pa.ArrowInvalid, pa.ArrowTypeError):
            texts = [None if v is None else str(v) for v in values]
            arrays[files.printable(name)] = pa.array(texts)
    with files.atomic_path(path) as temporary:
        pq.write_table(pa.table(arrays), temporary)
