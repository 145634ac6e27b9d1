"""Tables of a run, tidy and with units in their headers, and those of the thesis' scripts."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeAlias, final

import numpy as np

from shakerproc import files
from shakerproc.data import STANDARD_GRAVITY, Channel, ComplexArray, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.levels import density_unit
from shakerproc.runs.result import RunResult, shown_ratio, shown_unit
from shakerproc.runs.roles import without_tachometers
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary, Value
from shakerproc.spectra import ThesisSettings, ThesisTables, cumulative_rms, thesis_tables
from shakerproc.testlog import ThresholdCrop

Columns: TypeAlias = dict[str, Any]
"""Columns of equal length by header: arrays and sequences."""

_SPELLED: Final = {
    "g": "g", "1": "", "m/s^2": "m_per_s2", "m/s": "m_per_s", "µm/m": "um_per_m",
    "rad/s^2": "rad_per_s2", "rad/s": "rad_per_s", "N m": "Nm",
}  # fmt: skip

FORMER: Final[Mapping[str, str]] = MappingProxyType({
    "omega_e": "peak_frequency",
    "omega_e_hz": "peak_frequency_hz",
    "omega_e_over_omega_n": "peak_over_natural_frequency",
})
"""Present name by the former one; omega is [rad/s], and these are frequencies."""


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
        columns[f"psd_{channel.name}{ending}"] = result.averages.psd[i] * factor**2
        if result.averages.bounds is not None:
            columns[f"psd_low_{channel.name}{ending}"] = (
                result.averages.bounds.low[i] * factor**2
            )
            columns[f"psd_high_{channel.name}{ending}"] = (
                result.averages.bounds.high[i] * factor**2
            )
        columns[f"cumulative_rms_{channel.name}{spelled(unit)}"] = running[i] * factor
    if result.averages.against is not None:
        columns |= _response_columns(result)
    if result.over_time.notch is not None:
        columns |= _notched_columns(result, result.over_time.notch.psd)
    return marked(columns, result)


def marked(columns: Columns, result: RunResult) -> Columns:
    """Return columns with one more where the recording was cut short: how much is there."""
    if not result.recorded.incomplete or not columns:
        return columns
    return columns | {
        "incomplete": [result.recorded.length_text] * len(next(iter(columns.values())))
    }


def _notched_columns(result: RunResult, density: FloatArray) -> Columns:
    columns: Columns = {}
    for row, i in enumerate(result.responses):
        unit, factor = shown_unit(result.channels[i].unit)
        name = f"psd_notched_{result.channels[i].name}{spelled(unit, power=2)}"
        columns[name] = density[row] * factor**2
    return columns


def _response_columns(result: RunResult) -> Columns:
    against = result.averages.against
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
    if result.over_time.notch is None:
        return {}
    columns: Columns = {"time_s": result.over_time.notch.time}
    for row, i in enumerate(result.responses):
        unit, factor = shown_unit(result.channels[i].unit)
        name = f"{result.channels[i].name}{spelled(unit)}"
        columns[f"before_{name}"] = result.over_time.notch.before[row] * factor
        columns[f"after_{name}"] = result.over_time.notch.after[row] * factor
    return marked(columns, result)


def sweep_columns(result: RunResult) -> Columns:
    """Return the fundamental and harmonics along the sweeps; empty without a sweep."""
    sweeps = result.over_time.tracking.sweeps
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
    for tone in result.over_time.tracking.tones:
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


def present_name(name: str) -> str:
    """Return the present name of a quantity or column."""
    return FORMER.get(name, name)


def former_note(name: str, where: str) -> str:
    """Return the note on a former name that somebody used; empty for a present one."""
    if name not in FORMER:
        return ""
    return (
        f"{where}: {name} is called {FORMER[name]} now; the former name is taken in this "
        "version and not in the next"
    )


def thesis_tables_of(result: RunResult, recording: Recording) -> ThesisTables:
    """Return the thesis' tables of a processed run.

    Controls, responses and the crop are the run's; segments, window and mean are those of its
    processing (the thesis' own by default), and the filter takes out the tone that the log
    names, else 50 Hz.

    Parameters
    ----------
    result : RunResult
        The run.
    recording : Recording
        Its recording, open.

    Raises
    ------
    SpectrumError
        If a control is no acceleration, there is none, or no response is one.
    """
    test, channels = result.test, result.channels
    forces = [channels[i].name for i in result.controls if channels[i].unit != "m/s^2"]
    if forces:
        raise SpectrumError(
            f"{result.recorded.run}: --thesis divides accelerations by accelerations, and the "
            f"control {forces[0]} is not one; leave --thesis out"
        )
    rows = _rows(result)
    welch = test.processing.welch
    settings = ThesisSettings(
        segment=welch.segment,
        overlap=welch.overlap,
        window=welch.window,
        n_fft=welch.n_fft,
        detrend=test.processing.detrend,
        notch_frequency=test.notch_hz or ThesisSettings().notch_frequency,
    )
    try:
        return thesis_tables(
            without_tachometers(recording).select(rows).samples(),
            result.recorded.sample_rate,
            crop=result.crop,
            n_controls=len(result.controls),
            names=thesis_names([channels[i] for i in rows], len(result.controls)),
            settings=settings,
        )
    except SpectrumError as error:
        raise SpectrumError(f"{result.recorded.run}: --thesis: {error}") from error


def _rows(result: RunResult) -> list[int]:
    """Return the controls, then the responses that are accelerations."""
    responses = [i for i in result.responses if result.channels[i].unit == "m/s^2"]
    return [*result.controls, *responses]


def thesis_names(channels: Sequence[Channel], n_controls: int) -> list[str]:
    """Return names for channels, the controls first: the log's, else the thesis' numbers.

    The thesis calls its controls ch1 and ch2 and its responses ch3 and on. Where the log gives
    such a name to another channel, the one without keeps its name in the recording.
    """
    shift = max(0, 2 - n_controls)
    numbers = [f"ch{i + 1 + (shift if i >= n_controls else 0)}" for i in range(len(channels))]
    given = {c.name for c in channels if c.name != c.source_name}
    return [
        number if c.name == c.source_name and number not in given else c.name
        for c, number in zip(channels, numbers, strict=True)
    ]


def write_thesis_tables(result: RunResult, recording: Recording, folder: Path) -> list[Path]:
    """Write the tables of the thesis' scripts, and return the files."""
    thesis = thesis_tables_of(result, recording)
    names = list(thesis.tables["psd"].columns)
    written = []
    for name, table in thesis.tables.items():
        written.append(folder / f"{name}.csv")
        files.write_csv(written[-1], {table.index_name: table.index, **table.columns})
    written.append(folder / "peaks.csv")
    files.write_csv(written[-1], _peak_columns(thesis))
    written.append(folder / "crop.json")
    files.write_json(written[-1], {**thesis.crop, **_said(result, names), "mode": thesis.mode})
    return written


def _peak_columns(tables: ThesisTables) -> dict[str, list[Any]]:
    return {
        "quantity": [p.quantity for p in tables.peaks],
        "channel": [p.channel for p in tables.peaks],
        "used_by_thesis": [p.used_by_thesis for p in tables.peaks],
        "rank_by_location": [p.rank_by_location for p in tables.peaks],
        "frequency_hz": [p.frequency for p in tables.peaks],
        "value": [p.value for p in tables.peaks],
        "deleted": [p.deleted for p in tables.peaks],
    }


def _said(result: RunResult, names: Sequence[str]) -> dict[str, object]:
    """Return where the crop comes from, and which channel of the file each column is."""
    crop, channels = result.test.processing.crop, result.channels
    threshold = crop.threshold if isinstance(crop, ThresholdCrop) else None
    row = result.crop_channel
    rows = _rows(result)
    return {
        "threshold": None if threshold is None else threshold / STANDARD_GRAVITY,
        "crop_channel": None if row is None else channels[row].source_name,
        "channels": {
            name: channels[i].source_name for name, i in zip(names, rows, strict=True)
        },
        "left_out": [c.source_name for i, c in enumerate(channels) if i not in rows],
    }


COLUMNS: Final = (
    "channel",
    "peak [Hz]",
    "height",
    "by fit",
    "f_n [Hz]",
    "Q",
    "zeta, 95 % [%]",
    "coherence",
)
"""Headers of `PeakRow.cells`."""


@final
@dataclass(frozen=True, slots=True)
class PeakRow:
    """One peak of a response.

    Attributes
    ----------
    channel : ChannelSummary
        Whose it is.
    peak : PeakSummary
        What is known of it.
    unit : str
        Of its height; empty where the channel has the unit of the control.
    """

    channel: ChannelSummary
    peak: PeakSummary
    unit: str = ""

    @property
    def cells(self) -> tuple[object, ...]:
        """Cells under `COLUMNS`; None for an empty cell."""
        peak = self.peak
        least = f"{numeral(peak.height)} {self.unit}".strip()
        interval = None
        if peak.damping_low is not None and peak.damping_high is not None:
            interval = (
                f"{numeral(100.0 * peak.damping_low)} to {numeral(100.0 * peak.damping_high)}"
            )
        return (
            self.channel.name,
            peak.frequency_hz,
            in_unit(peak.height, self.unit) if peak.resolved else f"> {least}",
            in_unit(peak.fitted_height, self.unit),
            peak.natural_frequency_hz,
            peak.quality,
            interval,
            peak.coherence,
        )


SWEPT_COLUMNS: Final = (
    "channel", "sweep", "peak [Hz]", "gain", "steady [Hz]", "steady gain", "Q",
)  # fmt: skip
"""Headers of `swept_rows`."""


def swept_rows(run: RunSummary) -> list[tuple[object, ...]]:
    """Return the tallest point of each swept response, and the correction of a slow sweep."""
    return [
        (
            channel.name,
            peak.direction,
            peak.frequency_hz,
            in_unit(peak.gain, gain_unit(run, channel)),
            peak.steady_hz,
            in_unit(peak.steady_gain, gain_unit(run, channel)),
            None if peak.damping_ratio is None else 0.5 / peak.damping_ratio,
        )
        for channel in run.channels
        for peak in channel.swept_peaks
    ]


def steady_withheld(run: RunSummary) -> str:
    """Return of which swept responses no steady gain is known; empty where there are none."""
    of = [
        f"{channel.name} {peak.direction}"
        for channel in run.channels
        for peak in channel.swept_peaks
        if peak.steady_gain is None
    ]
    return (
        f"steady gain withheld ({', '.join(of)}): no linear mode fits. The joint is nonlinear, "
        "or the sweep is too fast and the gain that it shows too low: sweep slower to tell"
        if of
        else ""
    )


def quantity_of(run: RunSummary) -> str:
    """Return the quantity of the peaks: ``|H1|``, or ``PSD`` where there is no control."""
    return "|H1|" if any(c.role == "control" for c in run.channels) else "PSD"


def gain_unit(run: RunSummary, channel: ChannelSummary) -> str:
    """Return the unit of a response of a channel over the controls; empty of an own one."""
    over = next((c.unit for c in run.channels if c.role == "control"), channel.unit)
    return "" if over == channel.unit else f"{channel.unit}/{over}"


def in_unit(value: float | None, unit: str) -> object:
    """Return a value with its unit for people; the number itself where it has none.

    `value` may be in any unit.
    """
    return value if value is None or not unit else f"{numeral(value, 4)} {unit}"


def peak_rows(run: RunSummary) -> tuple[PeakRow, ...]:
    """Return every resolved peak of every response, by channel and frequency."""
    of_response = quantity_of(run) == "|H1|"
    return tuple(
        PeakRow(
            channel,
            peak,
            gain_unit(run, channel) if of_response else density_unit(channel.unit),
        )
        for channel in run.channels
        if channel.role != "control"
        for peak in sorted(
            channel.response_peaks if of_response else channel.psd_peaks,
            key=lambda found: found.frequency_hz,
        )
    )


def unresolved(run: RunSummary, rows: tuple[PeakRow, ...]) -> str:
    """Return the meaning of ``>`` beside a height; empty where the bins resolve every peak."""
    if run.spectrum is None or all(row.peak.resolved for row in rows):
        return ""
    return (
        f"> bins of {numeral(run.spectrum.bin_width_hz)} Hz are too coarse for these peaks: "
        "their height is at least this; the fit allows for the bins"
    )


def withheld(rows: tuple[PeakRow, ...]) -> Iterator[str]:
    """Yield each reason why a damping is withheld, once, with the peaks that it concerns."""
    reasons: dict[str, dict[str, list[str]]] = {}
    for row in rows:
        if row.peak.why_not:
            places = reasons.setdefault(row.peak.why_not, {})
            places.setdefault(numeral(row.peak.frequency_hz, 4), []).append(row.channel.name)
    for reason, places in reasons.items():
        where = "; ".join(f"{', '.join(names)} at {hz} Hz" for hz, names in places.items())
        yield f"Q withheld ({where}): {reason}"
