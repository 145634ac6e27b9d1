"""The tables of many runs, tidy and with units in their headers, as files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from shakerproc import files
from shakerproc.campaign.trend import Trend
from shakerproc.late import without_parquet
from shakerproc.runs.levels import density_unit
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary, Value
from shakerproc.runs.tables import Columns, columns_of, gain_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pyarrow import Array


def _run_cells(run: RunSummary) -> dict[str, Value]:
    return {
        "test": run.test,
        **run.facts,
        "incomplete": run.incomplete,
        "present_s": run.duration_s,
        "promised_s": run.promised_s or run.duration_s,
        "flags": "; ".join(dict.fromkeys(flag.kind for flag in run.flags)),
    }


def peak_columns(runs: Sequence[RunSummary]) -> Columns:
    """Return one row for each peak: of density and |H1|; rank 1 is the peak frequency.

    Of response functions over forces, it is one row for each resonance.
    """
    rows = [
        {
            **_run_cells(run),
            **_channel_cells(channel),
            **_peak_cells(run, quantity, rank, peak),
            "height_unit": density_unit(channel.unit).replace("²", "^2")
            if quantity == "psd"
            else gain_unit(run, channel) or "1",
        }
        for run in runs
        for channel in run.channels
        for quantity, peaks in (("psd", channel.psd_peaks), ("h1", channel.response_peaks))
        for rank, peak in enumerate(peaks, 1)
    ]
    rows += [
        {
            **_run_cells(run),
            **_channel_cells(channel),
            "quantity": f"sweep {peak.direction}",
            "rank": 1,
            "frequency_hz": peak.frequency_hz,
            "height": peak.gain,
            "height_unit": gain_unit(run, channel) or "1",
            "height_steady": peak.steady_gain,
            "steady_hz": peak.steady_hz,
            "natural_frequency_hz": peak.natural_frequency_hz,
            "damping_ratio": peak.damping_ratio,
            "damping_low": peak.damping_low,
            "damping_high": peak.damping_high,
            "quality": None if peak.damping_ratio is None else 0.5 / peak.damping_ratio,
        }
        for run in runs
        for channel in run.channels
        for peak in channel.swept_peaks
    ]
    rows += _resonance_rows(runs)
    return columns_of(rows) or {name: [] for name in ("test", "channel", "quantity")}


def _resonance_rows(runs: Sequence[RunSummary]) -> list[dict[str, Value]]:
    """Return one row for each resonance of a response function over a force."""
    rows: list[dict[str, Value]] = []
    for run in runs:
        by_name = {channel.name: channel for channel in run.channels}
        resonances = [
            row for one in run.analyses if one.kind == "resonances" for row in one.rows
        ]
        for function in dict.fromkeys(str(row["function"]) for row in resonances):
            output = by_name.get(function.partition(" / ")[0])
            function_rows = [row for row in resonances if row["function"] == function]
            function_rows.sort(key=lambda row: -float(row["height"] or 0.0))
            for rank, row in enumerate(function_rows, 1):
                rows.append({
                    **_run_cells(run),
                    **({} if output is None else _channel_cells(output)),
                    "quantity": f"h1 {function}",
                    "rank": rank,
                    **_of_resonance(row),
                })
    return rows


def _of_resonance(row: Mapping[str, Value]) -> dict[str, Value]:
    """Return the cells of a resonance, damping as a ratio."""
    ratios = {
        name: None if row.get(percent) is None else 0.01 * float(row[percent] or 0.0)
        for name, percent in (
            ("damping_ratio", "damping_percent"),
            ("damping_low", "low_percent"),
            ("damping_high", "high_percent"),
        )
    }
    ratio = ratios["damping_ratio"]
    return {
        "frequency_hz": row["peak_hz"],
        "height": row["height"],
        "height_unit": row["unit"],
        "natural_frequency_hz": row["natural_frequency_hz"],
        **ratios,
        "quality": 0.5 / ratio if ratio else None,
        "damping_withheld": row["withheld"] or None,
        "coherence": row["coherence"],
    }


def _channel_cells(channel: ChannelSummary) -> dict[str, Value]:
    return {"channel": channel.name, "role": channel.role, "at": channel.at}


def _peak_cells(
    run: RunSummary, quantity: str, rank: int, peak: PeakSummary
) -> dict[str, Value]:
    return {
        "quantity": quantity,
        "rank": rank,
        "frequency_hz": peak.frequency_hz,
        "bin_hz": peak.bin_hz,
        "bin_width_hz": run.spectrum.bin_width_hz if run.spectrum else None,
        "height": peak.height,
        "height_resolved": peak.resolved,
        "height_fitted": peak.fitted_height,
        "natural_frequency_hz": peak.natural_frequency_hz,
        "damping_ratio": peak.damping_ratio,
        "damping_low": peak.damping_low,
        "damping_high": peak.damping_high,
        "quality": peak.quality,
        "damping_bin_width_hz": peak.damping_bin_hz,
        "damping_withheld": peak.why_not,
        "coherence": peak.coherence,
    }


def statistics_columns(runs: Sequence[RunSummary]) -> Columns:
    """Return one row for each channel of each run."""
    return columns_of([
        {
            **_run_cells(run),
            **_channel_cells(c),
            "unit": c.unit,
            "mean": c.mean,
            "rms": c.rms,
            "minimum": c.minimum,
            "maximum": c.maximum,
            "crest_factor": c.crest_factor,
            "kurtosis": c.kurtosis,
            "band_low_hz": run.spectrum.band_hz[0] if run.spectrum else None,
            "band_high_hz": run.spectrum.band_hz[1] if run.spectrum else None,
            "band_rms": c.band_rms,
            "mean_coherence": c.coherence,
        }
        for run in runs
        for c in run.channels
    ])


def run_columns(runs: Sequence[RunSummary]) -> Columns:
    """Return one row for each test: its line of the log, its status, its measurements."""
    return columns_of([
        {
            "test": run.test,
            "status": run.status,
            **run.facts,
            "measured_level": run.measured_level,
            "measured_level_unit": run.level_unit,
            "sample_rate_hz": run.sample_rate_hz,
            "crop_start_s": run.crop_s[0] if run.crop_s else None,
            "crop_stop_s": run.crop_s[1] if run.crop_s else None,
            **{k: v for k, v in _run_cells(run).items() if k not in {"test", *run.facts}},
            "error": run.error,
            "recording": run.recording,
            "sha256": run.sha256,
        }
        for run in runs
    ])


def trend_columns(trend: Trend, channel: str) -> Columns:
    """Return one row for each point of a trend."""
    return columns_of([
        {
            "series": name,
            trend.x_label: point.x,
            "test": point.test,
            "channel": channel,
            "peak_frequency_hz": point.frequency_hz,
            "bin_width_hz": point.bin_width_hz,
            "incomplete": point.incomplete,
            "present_s": point.present_s,
            "promised_s": point.promised_s,
        }
        for name, points in trend.series.items()
        for point in points
    ])


def analysis_columns(runs: Sequence[RunSummary], kind: str) -> Columns:
    """Return the rows of one kind of analysis of every run; empty where none has it."""
    return columns_of([
        {**_run_cells(run), **row}
        for run in runs
        for one in run.analyses
        if one.kind == kind
        for row in one.rows
    ])


def kinds_of_analysis(runs: Sequence[RunSummary]) -> list[str]:
    """Return the kinds of analysis that have rows, in the order of the runs."""
    return list(dict.fromkeys(one.kind for run in runs for one in run.analyses if one.rows))


def write_tables(
    runs: Sequence[RunSummary], trends: Sequence[Trend], channel: str, root: Path
) -> list[Path]:
    """Write runs, peaks, statistics, analyses and trends as CSV, the peaks as Parquet too.

    Parquet only where pyarrow is installed, which the extra `parquet` brings.
    """
    done = [run for run in runs if run.status == "done"]
    content = {
        "runs.csv": run_columns(runs),
        "peaks.csv": peak_columns(done),
        "statistics.csv": statistics_columns(done),
        **{f"{kind}.csv": analysis_columns(done, kind) for kind in kinds_of_analysis(done)},
        **{f"trends/{t.name}.csv": trend_columns(t, channel) for t in trends},
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
