"""The spectra of a run in other programs' formats, in the units of its tables."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

import numpy as np

from shakerproc import files
from shakerproc.campaign.tables import write_parquet
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.recordings.writers import (
    COHERENCE,
    DENSITY,
    FREQUENCY,
    NONE,
    QUANTITIES,
    RESPONSE,
    End,
    RecordAxis,
    RecordHead,
    direction_of,
    write_function,
)
from shakerproc.runs import RunResult
from shakerproc.runs.pairs import ChannelPair, functions_of
from shakerproc.runs.result import shown_ratio, shown_unit
from shakerproc.runs.roles import uses_of_channels
from shakerproc.runs.tables import spectra_columns

_MAT_HEADER: Final = b"MATLAB 5.0 MAT-file, written by shakerproc"
_MAT_HEADER_SIZE: Final = 116
_UFF_GENERAL: Final = 1

_XLSX_ROWS: Final = 1_048_575
"""Rows of a sheet below its headers; what is longer goes on in another."""

_XLSX_DATE: Final = datetime(2000, 1, 1, tzinfo=UTC).replace(tzinfo=None)
"""Date in a workbook, so that the same run gives the same cells and properties."""


def export_parquet(result: RunResult, path: Path) -> None:
    """Write the columns of spectra.csv, and of the curves of every analysis, as Parquet."""
    write_parquet(path, spectra_columns(result))
    for one in result.analyses:
        if one.columns:
            write_parquet(path.with_name(f"{one.kind}_curves.parquet"), dict(one.columns))


def export_mat(result: RunResult, path: Path) -> None:
    """Write arrays for MATLAB: frequency, densities, response functions, names and units."""
    from scipy.io import savemat

    units = [shown_unit(channel.unit) for channel in result.channels]
    content: dict[str, Any] = {
        "frequency_hz": result.spectra.frequency,
        "channels": _texts([c.name for c in result.channels]),
        "units": _texts([unit for unit, _ in units]),
        "psd": result.averages.psd * np.array([[factor**2] for _, factor in units]),
        "psd_units": _texts([f"({unit})^2/Hz" for unit, _ in units]),
        "sample_rate_hz": result.recorded.sample_rate,
        "band_hz": result.band,
        "segment": result.spectra.segment,
        "overlap": result.spectra.overlap,
        "window": result.spectra.window_name,
        "degrees_of_freedom": result.spectra.degrees_of_freedom,
    }
    if result.recorded.incomplete:
        content["incomplete"] = result.recorded.length_text
    if result.averages.against is not None:
        content |= _against_controls(result)
    pairs = functions_of(result)
    if pairs:
        content["response_functions"] = _functions(result, pairs)
    with files.atomic_path(path) as temporary:
        savemat(temporary, content, long_field_names=True)
        with temporary.open("rb+") as file:  # scipy writes the time of day there
            file.write(_MAT_HEADER.ljust(_MAT_HEADER_SIZE))


def _texts(words: Sequence[str]) -> Any:
    return np.array(words, dtype=object)


def _against_controls(result: RunResult) -> dict[str, Any]:
    """Return the response functions against the controls, for MATLAB."""
    against = result.averages.against
    assert against is not None  # noqa: S101 - asked by the caller
    ratios = [shown_ratio(*result.units_of_response(i)) for i in result.responses]
    factors = np.array([[factor] for _, factor in ratios])
    return {
        "responses": np.array([i + 1 for i in result.responses]),
        "h1": against.h1 * factors,
        "h2": against.h2 * factors,
        "hv": against.hv * factors,
        "h1_units": _texts([unit or "1" for unit, _ in ratios]),
        "psd_ratio": against.psd_ratio * factors**2,
        "psd_ratio_units": _texts([f"({unit})^2" if unit else "1" for unit, _ in ratios]),
        "coherence": against.coherence,
        "multiple_coherence": against.multiple_coherence,
        "excited": against.valid,
    }


def _functions(result: RunResult, pairs: Sequence[ChannelPair]) -> dict[str, Any]:
    """Return the functions over forces, or those that the log asks for, for MATLAB."""
    arrays = ("h1", "h2", "hv", "low", "high", "coherence", "excited")
    return {
        "names": _texts([pair.label for pair in pairs]),
        "inputs": _texts([_named(result, pair.inputs) for pair in pairs]),
        "outputs": _texts([pair.output for pair in pairs]),
        "units": _texts([pair.unit for pair in pairs]),
        **{name: np.array([getattr(pair, name) for pair in pairs]) for name in arrays},
    }


def _named(result: RunResult, rows: Sequence[int]) -> str:
    return " + ".join(result.channels[row].name for row in rows)


def export_uff(result: RunResult, path: Path) -> None:
    """Write one data set 58 for each density, response function and coherence."""
    with files.atomic_path(path) as temporary, temporary.open("wb") as file:
        for curve in _curves(result):
            if not np.isnan(curve.values).all():  # a coherence of one average
                head = _head(result, curve)
                write_function(file, head, np.nan_to_num(curve.values), binary=True)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """One dataset: `row` is the channel of its response, `inputs` those of its reference."""

    kind: int
    name: str
    values: FloatArray | ComplexArray
    row: int
    unit: str
    inputs: tuple[int, ...] = ()


def _curves(result: RunResult) -> Iterator[_Curve]:
    """Yield the densities, then functions over the controls, then over the forces."""
    for i, channel in enumerate(result.channels):
        unit, factor = shown_unit(channel.unit)
        yield _Curve(
            DENSITY,
            f"PSD {channel.name}",
            result.averages.psd[i] * factor**2,
            i,
            f"{unit}^2/Hz",
        )
    if result.averages.against is not None:
        for row, i in enumerate(result.responses):
            factor = shown_ratio(*result.units_of_response(i))[1]
            name, h1 = result.channels[i].name, result.averages.against.h1[row] * factor
            unit, over = shown_unit(result.channels[i].unit)[0], result.controls
            yield _Curve(RESPONSE, f"H1 {name}", h1, i, unit, over)
            share = result.averages.against.coherence[row]
            yield _Curve(COHERENCE, f"coherence {name}", share, i, "1", over)
    for pair in functions_of(result):
        unit = shown_unit(result.channels[pair.row].unit)[0]
        yield _Curve(RESPONSE, f"H1 {pair.label}", pair.h1, pair.row, unit, pair.inputs)
        yield _Curve(
            COHERENCE,
            f"coherence {pair.label}",
            pair.coherence,
            pair.row,
            "1",
            pair.inputs,
        )


def _head(result: RunResult, curve: _Curve) -> RecordHead:
    start = (
        ""
        if result.recorded.start_time is None
        else f"{result.recorded.start_time:%d-%b-%y %H:%M:%S}"
    )
    spectra = result.spectra
    cut = f", INCOMPLETE {result.recorded.length_text}" if result.recorded.incomplete else ""
    is_ratio = curve.kind == RESPONSE
    over = [_axis(result, curve.inputs[0])] if is_ratio else [NONE]
    return RecordHead(
        curve.kind,
        (
            curve.name,
            result.recorded.run,
            start,
            f"{spectra.n_segments} segments of {spectra.segment} samples",
            f"sample rate {float(result.recorded.sample_rate)!r} Hz{cut}",
        ),
        _end(result, (curve.row,)),
        _end(result, curve.inputs) if curve.inputs else End(),
        0.0,
        float(spectra.bin_width),
        FREQUENCY,
        RecordAxis(_quantity(result, curve.row, curve.unit), "NONE", curve.unit),
        *over,
    )


def _axis(result: RunResult, row: int) -> RecordAxis:
    unit = shown_unit(result.channels[row].unit)[0]
    return RecordAxis(_quantity(result, row, unit), "NONE", unit)


def _end(result: RunResult, rows: Sequence[int]) -> End:
    uses = uses_of_channels(result.channels, result.test)
    direction = direction_of(uses[rows[0]].direction) if uses else 0
    return End(_entity(result, rows), rows[0] + 1, direction)


def _entity(result: RunResult, rows: Sequence[int]) -> str:
    """Return the name of a channel, cut to the format's length; of several, their kind."""
    name = result.channels[rows[0]].name if len(rows) == 1 else "controls"
    return files.printable(name)[:10].strip() or "NONE"


def _quantity(result: RunResult, row: int, unit: str) -> int:
    """Return the number of a quantity in the format; 0 of a number without a unit."""
    return 0 if unit == "1" else QUANTITIES.get(result.channels[row].unit, _UFF_GENERAL)


def export_xlsx(result: RunResult, path: Path) -> None:
    """Write the columns of spectra.csv, and of the curves of every analysis, as sheets."""
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    tables = {"spectra": spectra_columns(result)}
    tables |= {one.kind: dict(one.columns) for one in result.analyses if one.columns}
    for name, columns in tables.items():
        longest = max(len(values) for values in columns.values())
        for number, first in enumerate(range(0, longest, _XLSX_ROWS), 1):
            sheet = book.create_sheet(name if number == 1 else f"{name} {number}")
            sheet.append([files.csv_cell(title) for title in columns])
            parts = (values[first : first + _XLSX_ROWS] for values in columns.values())
            for row in zip(*parts, strict=True):
                sheet.append([_cell(value) for value in row])
    book.properties.created = book.properties.modified = _XLSX_DATE
    with files.atomic_path(path) as temporary:
        book.save(temporary)


def _cell(value: Any) -> Any:
    """Return a value as a cell; one that is not finite is empty."""
    plain = value.item() if isinstance(value, np.generic) else value
    if isinstance(plain, str):
        return files.csv_cell(plain)
    return None if isinstance(plain, float) and not np.isfinite(plain) else plain


EXPORTS: Mapping[str, Callable[[RunResult, Path], None]] = MappingProxyType({
    "mat": export_mat,
    "parquet": export_parquet,
    "uff": export_uff,
    "xlsx": export_xlsx,
})
