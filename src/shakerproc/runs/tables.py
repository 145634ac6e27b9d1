"""The tables of a run, tidy and with units in their headers."""

from collections.abc import Mapping, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.runs.result import RunResult, shown_ratio, shown_unit
from shakerproc.runs.summary import Value
from shakerproc.spectra import cumulative_rms

Columns: TypeAlias = dict[str, Any]
"""Columns of equal length by header: arrays and sequences."""

_SPELLED: Final = {
    "g": "g", "1": "", "m/s^2": "m_per_s2", "m/s": "m_per_s", "µm/m": "um_per_m",
    "rad/s^2": "rad_per_s2", "rad/s": "rad_per_s", "N m": "Nm",
}  # fmt: skip


def spelled(unit: str, *, power: int = 1) -> str:
    """Return how a header ends for a unit: ``_g``, ``_m2_per_s2_per_hz`` for a density."""
    name = _SPELLED.get(unit, unit)
    if power == 2:
        return f"_{name.replace('_per_', '2_per_')}2_per_hz" if name else "_per_hz"
    return f"_{name}" if name else ""


def spelled_ratio(output: str, over: str) -> str:
    """Return how a header ends for one SI unit over another: ``_g_per_N``, or nothing."""
    if output == over:
        return ""
    return f"{spelled(shown_unit(output)[0])}_per{spelled(shown_unit(over)[0])}"


def spectra_columns(result: RunResult) -> Columns:
    """Return densities, response functions and coherences against frequency."""
    columns: Columns = {"frequency_hz": result.spectra.frequency}
    running = cumulative_rms(result.spectra, result.band)
    for i, channel in enumerate(result.channels):
        unit, factor = shown_unit(channel.unit)
        ending = spelled(unit, power=2)
        columns[f"psd_{channel.name}{ending}"] = result.psd[i] * factor**2
        if result.bounds is not None:
            columns[f"psd_low_{channel.name}{ending}"] = result.bounds.low[i] * factor**2
            columns[f"psd_high_{channel.name}{ending}"] = result.bounds.high[i] * factor**2
        columns[f"cumulative_rms_{channel.name}{spelled(unit)}"] = running[i] * factor
    if result.against is not None:
        columns |= _response_columns(result)
    if result.notch is not None:
        columns |= _notched_columns(result, result.notch.psd)
    return marked(columns, result)


def marked(columns: Columns, result: RunResult) -> Columns:
    """Return columns with one more where the recording was cut short: how much is there."""
    if not result.incomplete or not columns:
        return columns
    return columns | {"incomplete": [result.told_length] * len(next(iter(columns.values())))}


def _notched_columns(result: RunResult, density: FloatArray) -> Columns:
    columns: Columns = {}
    for row, i in enumerate(result.responses):
        unit, factor = shown_unit(result.channels[i].unit)
        name = f"psd_notched_{result.channels[i].name}{spelled(unit, power=2)}"
        columns[name] = density[row] * factor**2
    return columns


def _response_columns(result: RunResult) -> Columns:
    against = result.against
    assert against is not None  # noqa: S101 - asked by the caller
    columns: Columns = {"excited": against.valid}
    for row, i in enumerate(result.responses):
        name, units = result.channels[i].name, result.units_of_response(i)
        factor, ending = shown_ratio(*units)[1], spelled_ratio(*units)
        for kind, values in (("h1", against.h1), ("h2", against.h2), ("hv", against.hv)):
            columns[f"{kind}_{name}_magnitude{ending}"] = np.abs(values[row]) * factor
            columns[f"{kind}_{name}_phase_deg"] = np.degrees(np.angle(values[row]))
        columns[f"psd_ratio_{name}"] = against.psd_ratio[row] * factor**2
        columns[f"coherence_{name}"] = against.coherence[row]
        columns[f"multiple_coherence_{name}"] = against.multiple_coherence[row]
    return columns


def notch_columns(result: RunResult) -> Columns:
    """Return two periods before and after the tone was taken out; empty without a notch."""
    if result.notch is None:
        return {}
    columns: Columns = {"time_s": result.notch.time}
    for row, i in enumerate(result.responses):
        unit, factor = shown_unit(result.channels[i].unit)
        name = f"{result.channels[i].name}{spelled(unit)}"
        columns[f"before_{name}"] = result.notch.before[row] * factor
        columns[f"after_{name}"] = result.notch.after[row] * factor
    return marked(columns, result)


def sweep_columns(result: RunResult) -> Columns:
    """Return the fundamental and harmonics along the sweeps; empty without a sweep."""
    sweeps = result.tracking.sweeps
    if not sweeps:
        return {}
    factor = shown_unit(result.channels[result.controls[0]].unit)[1]
    columns: Columns = {
        "direction": [sweep.direction for sweep in sweeps for _ in sweep.frequency],
        "time_s": _joined([sweep.time for sweep in sweeps]),
        "frequency_hz": _joined([sweep.frequency for sweep in sweeps]),
        f"control{spelled(shown_unit(result.channels[result.controls[0]].unit)[0])}": _joined([
            sweep.control * factor for sweep in sweeps
        ]),
        "purity": _joined([sweep.purity for sweep in sweeps]),
    }
    for i in result.responses:
        name, units = result.channels[i].name, result.units_of_response(i)
        gains, ratio = [sweep.gain[i] for sweep in sweeps], shown_ratio(*units)[1]
        columns[f"gain_{name}_magnitude{spelled_ratio(*units)}"] = _joined([
            np.abs(g) * ratio for g in gains
        ])
        columns[f"gain_{name}_phase_deg"] = _joined([np.degrees(np.angle(g)) for g in gains])
        for k in range(1, sweeps[0].harmonics.shape[1]):
            ratios = [_over_fundamental(s.harmonics[i], k) for s in sweeps]
            columns[f"harmonic_{k + 1}_{name}_ratio"] = _joined([np.abs(r) for r in ratios])
            columns[f"harmonic_{k + 1}_{name}_phase_deg"] = _joined([
                np.degrees(np.angle(r)) for r in ratios
            ])
    return marked(columns, result)


def _joined(parts: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate(parts)


def _over_fundamental(harmonics: ComplexArray, k: int) -> ComplexArray:
    """Return a harmonic over the size of the first; no number where there is no first one."""
    first = np.abs(harmonics[0])
    ratio = np.full(first.shape, np.nan, dtype=np.complex128)
    np.divide(harmonics[k], first, out=ratio, where=first > 0.0)
    return ratio


def tone_columns(result: RunResult) -> Columns:
    """Return one row for each tone, channel and harmonic; empty without a tone."""
    rows: list[Mapping[str, Value]] = []
    for tone in result.tracking.tones:
        for i, channel in enumerate(result.channels):
            unit, factor = shown_unit(channel.unit)
            for k, value in enumerate(tone.harmonics[i], 1):
                rows.append({
                    "frequency_hz": tone.frequency,
                    "channel": channel.name,
                    "harmonic": k,
                    f"amplitude{spelled(unit)}": float(np.abs(value)) * factor,
                    "phase_deg": float(np.degrees(np.angle(value))),
                    f"residual_rms{spelled(unit)}": float(tone.residual[i]) * factor,
                })
    return marked(columns_of(rows), result)


def columns_of(rows: Sequence[Mapping[str, Value]]) -> Columns:
    """Return rows as columns; a cell that a row does not have is None."""
    names: list[str] = []
    for row in rows:
        place = 0
        for name in row:  # what only some rows have stands where those rows have it
            if name not in names:
                names.insert(place, name)
            place = names.index(name) + 1
    return {name: [row.get(name) for row in rows] for name in names}


_UNITS: Final = {
    "_db": "dB", "_hz": "Hz", "_s": "s", "_g": "g", "_m_per_s2": "m/s²", "_m_per_s": "m/s",
    "_mm_per_s": "mm/s", "_mm": "mm", "_n": "N", "_m": "m", "_share": "%",
    "_ms": "ms", "_percent": "%", "_deg": "°", "_rev_per_min": "rev/min",
}  # fmt: skip


IN_UNIT: Final = {
    "unit": (
        "rms", "rms_there", "largest", "standard_deviation", "demand_rms", "measured_rms",
        "height", "gain_first", "gain_last", "amplitude", "amplitude_error",
        "demanded_amplitude", "least_in_parts", "largest_in_parts", "value", "expanded",
    ),
    "damage_unit": ("damage",),
}  # fmt: skip
"""Columns of the summaries of analyses whose unit stands in a column of its own."""


def heading(name: str) -> str:
    """Return a header of a table for people: ``peak [Hz]`` for ``peak_hz``."""
    for ending in sorted(_UNITS, key=len, reverse=True):
        if name.endswith(ending):
            return f"{name.removesuffix(ending).replace('_', ' ')} [{_UNITS[ending]}]"
    return name.replace("_", " ")


def shown_cell(name: str, value: Value) -> str | float:
    """Return a value of such a column for people: shares in per cent, yes and no in words."""
    if isinstance(value, bool):
        return "yes" if value else "NO"
    if isinstance(value, float):
        return round(100.0 * value, 2) if name.endswith("_share") else value
    return "" if value is None else str(value)
