"""The content of the figures of a run: numbers, curves and sentences in the units asked for."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.campaign import trends
from shakerproc.campaign.trend import Trend, TrendPoint
from shakerproc.data import FloatArray
from shakerproc.report.figures import style
from shakerproc.report.figures.figure import Axis, Curve, Span
from shakerproc.report.figures.units import ShownUnits
from shakerproc.runs.panels import Panel, PanelScale
from shakerproc.runs.summarising import RunCurve, RunSurface
from shakerproc.runs.summary import (
    SURFACE_STEPS,
    AnalysisSummary,
    ChannelSummary,
    CurveKind,
    CurveSummary,
    LineSummary,
    PanelSummary,
    PeakSummary,
    RunSummary,
    SurfaceSummary,
    SweptPeak,
    Value,
)
from shakerproc.runs.tables import IN_UNIT, heading

STILL: Final = 200
"""Points of a line in a still figure of a run, two for five pixels: 92 runs stay small."""

DECADES: Final = 9
"""Decades below the largest value that a logarithmic axis shows at most."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class RunContent:
    """A run as its figures show it.

    Attributes
    ----------
    run : RunSummary
        Its numbers.
    curves : sequence of RunCurve
        Every curve for a file, those that a summary keeps for the page.
    surface : RunSurface, optional
        Its spectrogram.
    """

    run: RunSummary
    curves: Sequence[RunCurve]
    surface: RunSurface | None = None

    @property
    def styles(self) -> Mapping[str, int]:
        """Colour and dash of each channel."""
        channels = self.run.channels
        chosen = style.styles([c.role for c in channels])
        return dict(zip((c.name for c in channels), chosen, strict=True))

    @property
    def units(self) -> list[str]:
        """Units of the channels, each once."""
        return list(dict.fromkeys(c.unit for c in self.run.channels))

    @property
    def control_unit(self) -> str:
        """Unit of the control; empty without one."""
        return next((c.unit for c in self.run.channels if c.role == "control"), "")

    def unit_of(self, channel: str) -> str:
        """Return the unit of a channel."""
        return next((c.unit for c in self.run.channels if c.name == channel), "")

    def of(self, kind: str, unit: str | None = None) -> list[RunCurve]:
        """Return the curves of a kind, those of channels of one unit if it is given."""
        curves = [curve for curve in self.curves if curve.kind == kind]
        return [c for c in curves if unit is None or self.unit_of(c.channel) == unit]

    def lines(self, kind: str, unit: str | None = None) -> list[Curve]:
        """Return the curves of a kind as lines, each in the style of its channel."""
        styles = self.styles
        return [
            Curve(f"{c.channel} {c.part}".strip(), c.x, c.y, styles[c.channel])
            for c in self.of(kind, unit)
        ]


def content_of_summary(run: RunSummary) -> RunContent:
    """Return the content of a run's figures from its summary."""
    surface = None if run.surface is None else _run_surface(run.surface)
    return RunContent(run, [_run_curve(curve) for curve in run.curves], surface)


def _run_surface(kept: SurfaceSummary) -> RunSurface:
    steps = np.array([np.frombuffer(row.encode(), np.uint8) for row in kept.rows]) - ord("A")
    return RunSurface(
        kept.channel,
        kept.unit,
        np.linspace(*kept.time_s, steps.shape[1]),
        np.linspace(*kept.frequency_hz, steps.shape[0]),
        kept.low_db + (kept.high_db - kept.low_db) * steps / (SURFACE_STEPS - 1),
    )


def _run_curve(curve: CurveSummary) -> RunCurve:
    low = values_of(curve.low) if curve.low else None
    return RunCurve(
        curve.kind, curve.channel, values_of(curve.x), values_of(curve.y), low, curve.part
    )


def values_of(values: Sequence[float | None]) -> FloatArray:
    """Return stored values as an array, NaN for None. They are in any unit."""
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def thin(lines: Sequence[Curve]) -> list[Curve]:
    """Return lines as thin ones without a name, beside others of the same colours."""
    return [replace(line, label="", thin=True) for line in lines]


def unnamed(lines: Sequence[Curve]) -> list[Curve]:
    """Return lines without names, below others of the same colours that have them."""
    return [replace(line, label="") for line in lines]


def frequency_axis(curves: Sequence[RunCurve | Curve]) -> Axis:
    """Return the axis from 0 to the highest frequency of the curves [Hz]."""
    return Axis("frequency [Hz]", 0.0, max(float(c.x.max()) for c in curves))


def swept_axis(curves: Sequence[Curve]) -> Axis:
    """Return the axis around the frequencies that sweeps pass [Hz]."""
    low, high = min(c.x.min() for c in curves), max(c.x.max() for c in curves)
    return Axis("frequency [Hz]", 0.98 * float(low), 1.02 * float(high))


def outside(run: RunSummary, axis: Axis) -> list[Span]:
    """Return the spans of a frequency axis outside the excited band."""
    if run.spectrum is None or run.facts.get("excitation") in trends.SINGLE_FREQUENCY:
        return []
    low, high = run.spectrum.band_hz
    return [Span(axis.low, low), Span(min(high, axis.high), axis.high)]


def logarithmic_axis(label: str, curves: Sequence[Curve], decades: int = DECADES) -> Axis:
    """Return a logarithmic axis of whole decades around the curves.

    Lines leave it below where they reach further down than so many decades; points do not.
    """
    values = _above_zero([c.y for c in curves])
    if not values.size:
        return Axis(label, 0.1, 1.0, logarithmic=True)
    high = np.ceil(np.log10(values.max()) + 1e-9)
    low = max(np.floor(np.log10(values.min()) - 1e-9), high - decades)
    points = _above_zero([c.y for c in curves if c.points])
    if points.size:
        low = min(low, np.floor(np.log10(points.min()) - 1e-9))
    return Axis(label, 10.0**low, 10.0 ** max(high, low + 1.0), logarithmic=True)


def even_axis(label: str, rows: Sequence[FloatArray]) -> Axis:
    """Return a linear axis around values, in the unit of its label, with a little room."""
    values = np.concatenate([*rows, np.zeros(0)])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    return Axis(label, low - room, high + room)


def _above_zero(rows: Sequence[FloatArray]) -> FloatArray:
    values = np.concatenate([*rows, np.zeros(0)])
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])


_Number: TypeAlias = float | None

OVER_CONTROL: Final = frozenset({"gain", "gain_root", "sweep"})
"""Kinds of curves in units of the channel over those of the control."""

DENSITIES: Final = frozenset({"psd", "notch_psd"})
"""Kinds in squares of those of the channel."""

PLAIN: Final = frozenset({
    "coherence", "multiple_coherence", "phase", "psd_ratio", "sweep_phase", "sweep_harmonic",
})  # fmt: skip
"""Kinds that have a unit of their own."""


def run_in(run: RunSummary, units: ShownUnits) -> RunSummary:
    """Return a run as the report shows it."""
    kept = words_of(run)
    level_unit, level = units.unit(run.level_unit)
    control = run.control and replace(run.control, demanded=run.control.demanded * level)
    return replace(
        run,
        facts=_facts(run.facts, units),
        measured_level=_times(run.measured_level, level),
        level_unit=level_unit,
        alarm=run.alarm and (run.alarm[0] * level, run.alarm[1] * level),
        control=control,
        channels=tuple(_channel(c, run, units) for c in run.channels),
        curves=tuple(_curve(c, run, units) for c in run.curves),
        flags=tuple(replace(f, message=units.text(f.message, kept)) for f in run.flags),
        notes=tuple(units.text(note, kept) for note in run.notes),
        analyses=tuple(_analysis(one, units, kept) for one in run.analyses),
        surface=run.surface and _surface(run.surface, units),
    )


def words_of(run: RunSummary) -> list[str]:
    """Return the words of the log that stand in sentences about a run."""
    said = (run.facts.get(name) for name in ("comment", "specimen", "joint"))
    return [*(c.name for c in run.channels), *(str(word) for word in said if word)]


def trend_in(trend: Trend, units: ShownUnits) -> Trend:
    """Return a trend as the report shows it."""
    label, factor = units.label(trend.x_label)
    return replace(
        trend,
        title=units.text(trend.title),
        caption=units.text(trend.caption, [trend.channel]),
        x_label=label,
        series={
            units.text(name): tuple(_point(p, factor) for p in points)
            for name, points in trend.series.items()
        },
    )


def _point(point: TrendPoint, factor: float) -> TrendPoint:
    return replace(point, x=point.x * factor) if isinstance(point.x, float) else point


def _facts(facts: Mapping[str, Value], units: ShownUnits) -> dict[str, Value]:
    level = facts.get("level")
    other = {"level": units.text(level)} if isinstance(level, str) else {}
    return {**facts, **other}


def _times(value: _Number, factor: float) -> _Number:
    return None if value is None else value * factor


def _all(values: tuple[_Number, ...], factor: float) -> tuple[_Number, ...]:
    return tuple(_times(value, factor) for value in values)


def _gain(channel: ChannelSummary, run: RunSummary, units: ShownUnits) -> float:
    """Return the factor of a response function of a channel over the controls."""
    over = next((c.unit for c in run.channels if c.role == "control"), channel.unit)
    return units.unit(channel.unit)[1] / units.unit(over)[1]


def _channel(channel: ChannelSummary, run: RunSummary, units: ShownUnits) -> ChannelSummary:
    unit, factor = units.unit(channel.unit)
    gain = _gain(channel, run, units)
    return replace(
        channel,
        unit=unit,
        mean=_times(channel.mean, factor),
        rms=_times(channel.rms, factor),
        minimum=_times(channel.minimum, factor),
        maximum=_times(channel.maximum, factor),
        band_rms=_times(channel.band_rms, factor),
        psd_peaks=tuple(_peak(p, factor**2) for p in channel.psd_peaks),
        response_peaks=tuple(_peak(p, gain) for p in channel.response_peaks),
        swept_peaks=tuple(_swept(p, gain) for p in channel.swept_peaks),
    )


def _peak(peak: PeakSummary, factor: float) -> PeakSummary:
    fitted = _times(peak.fitted_height, factor)
    return replace(peak, height=peak.height * factor, fitted_height=fitted)


def _swept(peak: SweptPeak, factor: float) -> SweptPeak:
    steady = _times(peak.steady_gain, factor)
    return replace(peak, gain=peak.gain * factor, steady_gain=steady)


def _factor(kind: CurveKind, channel: str, run: RunSummary, units: ShownUnits) -> float:
    """Return the factor of the curves of a kind of a channel."""
    if kind == "level":
        return units.unit(run.level_unit)[1]
    of = next((c for c in run.channels if c.name == channel), None)
    if of is None or kind in PLAIN:
        return 1.0
    factor = units.unit(of.unit)[1]
    if kind in OVER_CONTROL:
        return _gain(of, run, units)
    return factor**2 if kind in DENSITIES else factor


def _curve(curve: CurveSummary, run: RunSummary, units: ShownUnits) -> CurveSummary:
    factor = _factor(curve.kind, curve.channel, run, units)
    if factor == 1.0:
        return curve
    return replace(curve, y=_all(curve.y, factor), low=_all(curve.low, factor))


def curve_in(curve: RunCurve, run: RunSummary, units: ShownUnits) -> RunCurve:
    """Return a curve with all of its points in these units.

    `run` is the run as its tables say it.
    """
    factor = _factor(curve.kind, curve.channel, run, units)
    low = None if curve.low is None else curve.low * factor
    return replace(curve, y=curve.y * factor, low=low)


def surface_in(surface: RunSurface, units: ShownUnits) -> RunSurface:
    """Return a spectrogram with all of its cells in these units."""
    unit, factor = units.unit(surface.unit)
    return replace(surface, unit=unit, level=surface.level + 10.0 * math.log10(factor))


def _surface(surface: SurfaceSummary, units: ShownUnits) -> SurfaceSummary:
    unit, factor = units.unit(surface.unit)
    low, high = (
        level + 10.0 * math.log10(factor) for level in (surface.low_db, surface.high_db)
    )
    return replace(surface, unit=unit, low_db=low, high_db=high)


def _analysis(one: AnalysisSummary, units: ShownUnits, kept: list[str]) -> AnalysisSummary:
    return replace(
        one,
        rows=tuple(_row(row, units) for row in one.rows),
        told=tuple(units.text(text, kept) for text in one.told),
        panels=tuple(_panel(panel, units, kept) for panel in one.panels),
    )


def _row(row: Mapping[str, Value], units: ShownUnits) -> dict[str, Value]:
    """Return a row of a summary; a header whose unit is another is one for people."""
    values: dict[str, Value] = {}
    factors = {
        name: units.unit(str(row[column]))[1]
        for column, names in IN_UNIT.items()
        for name in names
        if column in row
    }
    for name, value in row.items():
        if name in IN_UNIT:
            values[name] = units.unit(str(value))[0]
            continue
        label, factor = units.label(heading(name))
        factor *= factors.get(name, 1.0)
        scaled = value * factor if isinstance(value, float) else value
        values[label if label != heading(name) else name] = scaled
    return values


def _panel(panel: PanelSummary, units: ShownUnits, kept: list[str]) -> PanelSummary:
    x, along = _scale(panel.x, units)
    y, across = _scale(panel.y, units)
    return replace(
        panel,
        caption=units.text(panel.caption, kept),
        x=x,
        y=y,
        lines=tuple(_line(line, along, across, units) for line in panel.lines),
    )


def panel_in(panel: Panel, units: ShownUnits) -> Panel:
    """Return a figure of an analysis with all of its points in these units."""
    x, along = _scale(panel.x, units)
    y, across = _scale(panel.y, units)
    lines = tuple(replace(one, x=one.x * along, y=one.y * across) for one in panel.lines)
    return replace(panel, caption=units.text(panel.caption), x=x, y=y, lines=lines)


def _scale(scale: PanelScale, units: ShownUnits) -> tuple[PanelScale, float]:
    label, factor = units.label(scale.label)
    ends = scale.ends and (scale.ends[0] * factor, scale.ends[1] * factor)
    return replace(scale, label=label, ends=ends), factor


def _line(line: LineSummary, along: float, across: float, units: ShownUnits) -> LineSummary:
    label = units.text(line.label) if line.look == "paper" else line.label
    x = tuple(v * along for v in line.x)
    return replace(line, label=label, x=x, y=_all(line.y, across))
