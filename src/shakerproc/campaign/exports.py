"""The spectra of a run in other programs' formats."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from shakerproc import files
from shakerproc.campaign.collecting import write_parquet
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.runs import RunResult
from shakerproc.runs.result import shown_unit
from shakerproc.runs.tables import spectra_columns

_MAT_HEADER: Final = b"MATLAB 5.0 MAT-file, written by shakerproc"
_MAT_HEADER_SIZE: Final = 116
_UFF_DENSITY, _UFF_RESPONSE, _UFF_COHERENCE = 9, 4, 6


def export_parquet(result: RunResult, path: Path) -> None:
    """Write the columns of spectra.csv as Parquet."""
    write_parquet(path, spectra_columns(result))


def export_mat(result: RunResult, path: Path) -> None:
    """Write arrays for MATLAB: frequency, densities, response functions, names and units."""
    from scipy.io import savemat

    units = [shown_unit(channel.unit) for channel in result.channels]
    content: dict[str, Any] = {
        "frequency_hz": result.spectra.frequency,
        "channels": np.array([c.name for c in result.channels], dtype=object),
        "units": np.array([unit for unit, _ in units], dtype=object),
        "psd": result.psd * np.array([[factor**2] for _, factor in units]),
        "sample_rate_hz": result.sample_rate,
        "band_hz": result.band,
        "segment": result.spectra.segment,
        "overlap": result.spectra.overlap,
        "window": result.spectra.window_name,
        "degrees_of_freedom": result.spectra.degrees_of_freedom,
    }
    if result.incomplete:
        content["incomplete"] = result.told_length
    if result.against is not None:
        content |= {
            "responses": np.array([i + 1 for i in result.responses]),
            "h1": result.against.h1,
            "h2": result.against.h2,
            "psd_ratio": result.against.psd_ratio,
            "coherence": result.against.coherence,
            "excited": result.against.valid,
        }
    with files.atomic_path(path) as temporary:
        savemat(temporary, content, long_field_names=True)
        with temporary.open("rb+") as file:  # scipy writes the time of day there
            file.write(_MAT_HEADER.ljust(_MAT_HEADER_SIZE))


def export_uff(result: RunResult, path: Path) -> None:
    """Write one dataset 58 for each density, response function and coherence."""
    import pyuff

    with files.atomic_path(path) as temporary:
        temporary.touch()
        target = pyuff.UFF(str(temporary))
        for dataset in _datasets(result):
            target.write_sets(_common(result) | dataset, "add")


def _common(result: RunResult) -> dict[str, Any]:
    """Return every field of a dataset; pyuff puts None where one is missing."""
    start = "NONE" if result.start_time is None else f"{result.start_time:%d-%b-%y %H:%M:%S}"
    return {
        "type": 58,
        "binary": 1,
        "id2": files.printable(result.run)[:80] or "NONE",
        "id3": start,
        "id4": f"{result.spectra.n_segments} segments of {result.spectra.segment} samples",
        "id5": f"sample rate {float(result.sample_rate)!r} Hz{_cut(result)}",
        "rsp_ent_name": "NONE",
        "rsp_dir": 0,
        "ref_ent_name": "NONE",
        "ref_node": 0,
        "ref_dir": 0,
        "abscissa_spacing": 1,
        "abscissa_min": 0.0,
        "abscissa_inc": float(result.spectra.bin_width),
        "abscissa_spec_data_type": 18,
        "abscissa_axis_lab": "frequency",
        "abscissa_axis_units_lab": "Hz",
        "ordinate_spec_data_type": 0,
        "orddenom_spec_data_type": 0,
        "z_axis_spec_data_type": 0,
        "ordinate_axis_lab": "NONE",
        "x": result.spectra.frequency[:2],
    }


def _cut(result: RunResult) -> str:
    return f", INCOMPLETE {result.told_length}" if result.incomplete else ""


def _datasets(result: RunResult) -> list[dict[str, Any]]:
    found = []
    for i, channel in enumerate(result.channels):
        unit, factor = shown_unit(channel.unit)
        values = result.psd[i] * factor**2
        found.append(_dataset(_UFF_DENSITY, i, f"PSD {channel.name}", values, f"{unit}^2/Hz"))
    if result.against is not None:
        for row, i in enumerate(result.responses):
            name = result.channels[i].name
            response, coherence = result.against.h1[row], result.against.coherence[row]
            found.append(_dataset(_UFF_RESPONSE, i, f"H1 {name}", response, "1"))
            found.append(_dataset(_UFF_COHERENCE, i, f"coherence {name}", coherence, "1"))
    return found


def _dataset(
    kind: int, row: int, name: str, values: FloatArray | ComplexArray, unit: str
) -> dict[str, Any]:
    return {
        "func_type": kind,
        "id1": files.printable(name)[:80],
        "rsp_node": row + 1,
        "ordinate_axis_units_lab": unit[:20],
        "data": np.nan_to_num(values),
    }


EXPORTS: Mapping[str, Callable[[RunResult, Path], None]] = MappingProxyType({
    "mat": export_mat,
    "parquet": export_parquet,
    "uff": export_uff,
})
