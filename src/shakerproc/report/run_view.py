"""One run as the report shows it: a line of facts, flags, four drawings, a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.data import FloatArray
from shakerproc.report import analysis_figures, style, svg
from shakerproc.report.drawing import Drawing
from shakerproc.runs import peak_rows, telling, trends
from shakerproc.runs.summary import (
    AnalysisSummary,
    ChannelSummary,
    ControlSummary,
    CurveSummary,
    FlagSummary,
    PeakSummary,
    RunSummary,
)
from shakerproc.runs.tables import heading, shown_cell

STILL: Final = 200
"""Points of a line in a still figure of a run, two for five pixels: 92 runs stay small."""

DECADES: Final = 7
"""Decades below the largest value that a logarithmic axis shows at most."""


@dataclass(frozen=True, slots=True)
class AnalysisView:
    """An analysis that the log asks for, as rows of text and sentences."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    told: Sequence[str]


@dataclass(frozen=True, slots=True)
class RunView:
    """One run, ready for the page."""

    test: str
    anchor: str
    status: str
    title: str
    facts: str
    error: str
    detail: str
    flags: Sequence[FlagSummary]
    figures: Sequence[Drawing]
    channel_columns: Sequence[str]
    channels: Sequence[Sequence[str]]
    peaks_of: str
    peak_columns: Sequence[str]
    peaks: Sequence[Sequence[str]]
    spectrum: str
    withheld: Sequence[str]
    remarks: Sequence[str]
    analyses: Sequence[AnalysisView]
    recording: str
    sha256: str


CHANNEL_COLUMNS: Final = (
    "channel", "role", "rms in band", "largest", "crest factor", "kurtosis", "coherence",
    "peak frequency [Hz]",
)  # fmt: skip

PEAK_COLUMNS: Final = tuple(name.replace("zeta", "ζ") for name in peak_rows.COLUMNS)


def run_view(run: RunSummary, number: int) -> RunView:
    """Return a run as the page shows it; `number` makes its anchor."""
    rows = peak_rows.peak_rows(run)
    return RunView(
        test=run.test,
        anchor=f"run-{number}",
        status=run.status,
        title=_title(run),
        facts=_facts(run),
        error=run.error,
        detail=run.detail,
        flags=run.flags,
        figures=[*figures(run), *(_marked(d, run) for d in analysis_figures.drawings(run))],
        channel_columns=CHANNEL_COLUMNS,
        channels=[_channel_row(c, run) for c in run.channels],
        spectrum=_spectrum_note(run),
        peaks_of=peak_rows.quantity_of(run),
        peak_columns=PEAK_COLUMNS,
        peaks=[[_cell(value) for value in row.cells] for row in rows],
        withheld=tuple(
            filter(None, (peak_rows.unresolved(run, rows), *peak_rows.withheld(rows)))
        ),
        remarks=run.remarks,
        analyses=[_analysis_view(one) for one in run.analyses],
        recording=run.recording,
        sha256=run.sha256,
    )


def _analysis_view(one: AnalysisSummary) -> AnalysisView:
    names = list(one.rows[0]) if one.rows else []
    rows = [[_cell(shown_cell(name, row.get(name))) for name in names] for row in one.rows]
    return AnalysisView(one.title, [heading(name) for name in names], rows, one.told)


def _title(run: RunSummary) -> str:
    names = ("specimen", "joint", "clearance_m", "orientation", "excitation", "level")
    told = (trends.shown(name, run.facts.get(name)) for name in names)
    return ", ".join((f"Test {run.test}", *filter(None, told)))


def _facts(run: RunSummary) -> str:
    parts = []
    if run.duration_s is not None:
        length = f"{run.duration_s:.6g} s"
        if run.promised_s is not None:
            length = f"INCOMPLETE: {run.duration_s:.4g} of {run.promised_s:.4g} s"
        parts.append(f"{length} at {run.sample_rate_hz:.6g} Hz")
    if run.crop_s is not None:
        parts.append(f"processed {run.crop_s[0]:.3f} to {run.crop_s[1]:.3f} s")
    if run.measured_level is not None:
        parts.append(f"measured level {run.measured_level:.4g} {run.level_unit}")
    actual = run.facts.get("actual_clearance_m")
    if actual is not None:
        parts.append(f"actual clearance {trends.shown('actual_clearance_m', actual)}")
    if run.start_time:
        parts.append(f"started {run.start_time}")
    comment = run.facts.get("comment")
    return "; ".join((*parts, *([str(comment)] if comment else [])))


def _spectrum_note(run: RunSummary) -> str:
    s = run.spectrum
    if s is None:
        return ""
    bounds = (
        f": 95 % bounds of a PSD value × {s.low_factor:.2f} to × {s.high_factor:.2f}"
        if s.low_factor is not None and s.high_factor is not None
        else ""
    )
    return (
        f"Spectra: {s.segment} samples {s.window}, overlap {s.overlap}, "
        f"{s.n_segments} segments, "
        f"bins {s.bin_width_hz:.4g} Hz apart (noise bandwidth {s.resolution_hz:.4g} Hz), "
        f"{s.degrees_of_freedom:.0f} degrees of freedom{bounds}. "
        f"Excited band {s.band_hz[0]:g} to {s.band_hz[1]:g} Hz.{_finer_note(run)}"
    )


def _finer_note(run: RunSummary) -> str:
    """Return which dampings come from finer bins than the other numbers."""
    told = [
        f"{row.channel.name} at {row.peak.frequency_hz:.4g} Hz from bins of "
        f"{row.peak.damping_bin_hz:.3g} Hz"
        for row in peak_rows.peak_rows(run)
        if row.peak.damping_ratio is not None
        and row.peak.damping_bin_hz is not None
        and run.spectrum is not None
        and row.peak.damping_bin_hz < 0.99 * run.spectrum.bin_width_hz
    ]
    return f" Damping of {', '.join(told)}." if told else ""


def number(value: float | None, form: str = ".4g") -> str:
    """Return a number for people, nothing for None."""
    return "" if value is None else format(value, form)


def _channel_row(channel: ChannelSummary, run: RunSummary) -> list[str]:
    is_control = channel.role == "control"
    peak = None if is_control else trends.omega_e(run, channel.name)
    largest = max(
        (abs(v) for v in (channel.minimum, channel.maximum) if v is not None), default=None
    )
    return [
        channel.name,
        channel.role,
        f"{number(channel.band_rms)} {channel.unit}",
        f"{number(largest)} {channel.unit}",
        number(channel.crest_factor, ".3g"),
        number(channel.kurtosis, ".3g"),
        number(channel.coherence, ".3f"),
        number(peak.frequency_hz, ".1f") if peak else "",
    ]


def _cell(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value or "")


def curves_of(run: RunSummary, kind: str) -> list[CurveSummary]:
    """Return the curves of one figure."""
    return [curve for curve in run.curves if curve.kind == kind]


def _array(values: Sequence[float | None]) -> FloatArray:
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def figures(run: RunSummary) -> list[Drawing]:
    """Return the drawings of a run: time with crop, densities, response, coherence."""
    if not run.channels:
        return []
    roles = [c.role for c in run.channels]
    chosen = dict(zip((c.name for c in run.channels), style.styles(roles), strict=True))
    drawn = {
        "time": _time(run, chosen),
        "psd": _psd(run, chosen),
        "gain": _gain(run, chosen),
        "sweep": _sweep(run, chosen),
        "level": _level(run, chosen),
        "coherence": _coherence(run, chosen),
        "notch": _notch(run, chosen),
    }
    return [
        replace(_marked(drawing, run), kind=kind)
        for kind, drawing in drawn.items()
        if drawing is not None
    ]


def _marked(drawing: Drawing, run: RunSummary) -> Drawing:
    """Return a drawing that says so where the recording was cut short."""
    if not run.incomplete:
        return drawing
    told = run.told_status.replace("incomplete,", "INCOMPLETE:")
    return replace(drawing, caption=f"{drawing.caption} {told}.")


def _time(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    curves = curves_of(run, "time")
    if not curves or run.duration_s is None:
        return None
    fills = [
        svg.Filling(c.channel, _array(c.x), _array(c.low), _array(c.y), chosen[c.channel])
        for c in reversed(curves)
    ]
    largest = max(float(np.nanmax(np.abs([f.low, f.high]))) for f in fills) or 1.0
    end = run.promised_s or run.duration_s
    spans: list[svg.Span] = []
    marks = [svg.Mark(time, note) for time, note in run.events if time <= end]
    if run.crop_s is not None:
        spans = [svg.Span(0.0, run.crop_s[0]), svg.Span(run.crop_s[1], end)]
    if run.incomplete:
        marks += [svg.Mark(run.duration_s, f"cut off at {run.duration_s:.3g} s")]
    unit = next(c.unit for c in run.channels if c.name == curves[0].channel)
    return Drawing(
        "Time.",
        "Extremes of each slice. Grey is cropped away: the run should fill what is white.",
        svg.plot(
            fills,
            svg.Axis("time [s]", 0.0, end),
            svg.Axis(f"[{unit}]", -1.05 * largest, 1.05 * largest),
            most=STILL,
            title=f"Time series of test {run.test}",
            marks=marks,
            spans=spans,
        ),
    )


def _frequency_axis(curves: Sequence[CurveSummary]) -> svg.Axis:
    return svg.Axis("frequency [Hz]", 0.0, max(max(c.x) for c in curves))


def _outside(run: RunSummary, axis: svg.Axis) -> list[svg.Span]:
    if run.spectrum is None or run.facts.get("excitation") in trends.SINGLE_FREQUENCY:
        return []
    low, high = run.spectrum.band_hz
    return [svg.Span(axis.low, low), svg.Span(min(high, axis.high), axis.high)]


def _lines(curves: Sequence[CurveSummary], chosen: Mapping[str, int]) -> list[svg.Curve]:
    return [
        svg.Curve(f"{c.channel} {c.part}".strip(), _array(c.x), _array(c.y), chosen[c.channel])
        for c in curves
    ]


def logarithmic_axis(
    label: str, curves: Sequence[svg.Curve], decades: int = DECADES
) -> svg.Axis:
    """Return a logarithmic axis of whole decades around the curves.

    Lines leave it below where they reach further down than so many decades; points do not.
    """
    values = _above_zero([c.y for c in curves])
    if not values.size:
        return svg.Axis(label, 0.1, 1.0, logarithmic=True)
    high = np.ceil(np.log10(values.max()) + 1e-9)
    low = max(np.floor(np.log10(values.min()) - 1e-9), high - decades)
    points = _above_zero([c.y for c in curves if c.points])
    if points.size:
        low = min(low, np.floor(np.log10(points.min()) - 1e-9))
    return svg.Axis(label, 10.0**low, 10.0 ** max(high, low + 1.0), logarithmic=True)


def _above_zero(rows: Sequence[FloatArray]) -> FloatArray:
    values = np.concatenate([*rows, np.zeros(0)])
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])


def _psd(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    curves = curves_of(run, "psd")
    if not curves:
        return None
    lines, axis = _lines(curves, chosen), _frequency_axis(curves)
    units = {c.unit for c in run.channels}
    unit = units.pop() if len(units) == 1 else "unit"
    best = max(filter(None, _all_omega_e(run)), key=lambda p: p.height, default=None)
    marks = [svg.Mark(best.frequency_hz, f"{best.frequency_hz:.1f} Hz")] if best else []
    caption = "The tallest peak of a response inside the excited band is its peak frequency."
    if run.alarm is not None:
        caption += _control_told(run, "band")
    return Drawing(
        "Power spectral density.",
        caption,
        svg.plot(
            [*lines, *_alarm_lines(run)],
            axis,
            logarithmic_axis(f"[{unit}²/Hz]", lines),
            most=STILL,
            title=f"Power spectral densities of test {run.test}",
            marks=marks,
            spans=_outside(run, axis),
        ),
    )


def _control_told(run: RunSummary, where: str) -> str:
    """Return whether the controls kept the limits that are drawn."""
    if run.control is None:
        return " The controls should stay between the thin lines."
    return f" Mean control (limits: thin lines) {telling.control_told(run.control, where)}."


def _all_omega_e(run: RunSummary) -> list[PeakSummary | None]:
    return [trends.omega_e(run, c.name) for c in run.channels if c.role == "response"]


def _alarm_lines(run: RunSummary) -> list[svg.Curve]:
    """Return the limits of the control density as lines over the band."""
    if run.alarm is None or run.spectrum is None:
        return []
    band = np.array(run.spectrum.band_hz)
    limits = [("alarm limits", run.alarm, style.CONTROL_STYLES[0])]
    if run.control is not None:
        limits = _limits(run.control, 10.0)
    return [
        svg.Curve(label, band, np.full(2, limit), number, thin=True)
        for name, pair, number in limits
        for label, limit in zip((name, ""), pair, strict=True)
    ]


def _limits(
    control: ControlSummary, per_decade: float
) -> list[tuple[str, tuple[float, float], int]]:
    """Return name, values and style of the alarm and abort limits; 10 or 20 dB a decade."""
    found = []
    for name, decibels, number in (
        ("alarm", control.alarm_db, style.CONTROL_STYLES[0]),
        ("abort", control.abort_db, 3),
    ):
        factor = 10.0 ** (decibels / per_decade)
        pair = (control.demanded / factor, control.demanded * factor)
        found.append((f"{name} ±{decibels:g} dB", pair, number))
    return found


def _level(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    """Return the amplitude of the control along a sweep, and its limits."""
    del chosen  # the mean of the controls is no channel
    curves = curves_of(run, "level")
    if not curves or run.control is None:
        return None
    axis = _frequency_axis(curves)
    band = np.array(run.spectrum.band_hz if run.spectrum else (axis.low, axis.high))
    lines = [
        svg.Curve(f"mean control {c.part}".strip(), _array(c.x), _array(c.y), style_of)
        for c, style_of in zip(curves, style.CONTROL_STYLES * len(curves), strict=False)
    ]
    limits = [
        svg.Curve(label, band, np.full(2, limit), number, thin=True)
        for name, pair, number in _limits(run.control, 20.0)
        for label, limit in zip((name, ""), pair, strict=True)
    ]
    top = 1.08 * max(float(np.nanmax(line.y)) for line in (*lines, *limits))
    return Drawing(
        "Level of the control.",
        f"Fundamental along the sweep.{_control_told(run, 'sweep')}",
        svg.plot(
            [*lines, *limits],
            axis,
            svg.Axis(f"[{run.level_unit}]", 0.0, top),
            most=STILL,
            title=f"Level of the control of test {run.test}",
            spans=_outside(run, axis),
        ),
    )


def _logarithmic(
    run: RunSummary, chosen: Mapping[str, int], kind: str, told: tuple[str, str]
) -> Markup | None:
    curves = curves_of(run, kind)
    if not curves:
        return None
    lines, axis = _lines(curves, chosen), _frequency_axis(curves)
    label, title = told
    return svg.plot(
        lines,
        axis,
        logarithmic_axis(label, lines, 5),
        most=STILL,
        title=f"{title} of test {run.test}",
        spans=_outside(run, axis),
    )


def _gain(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    drawing = _logarithmic(run, chosen, "gain", ("|H1| [-]", "Response functions"))
    if drawing is None:
        return None
    return Drawing(
        "Response over control, |H1|.",
        "1 at low frequency if sensor and table move together; a peak is a resonance.",
        drawing,
    )


def _sweep(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    told = ("fundamental over control [-]", "Swept response")
    drawing = _logarithmic(run, chosen, "sweep", told)
    if drawing is None:
        return None
    peaks = "; ".join(
        f"{channel.name} {peak.direction} {peak.gain:.3g} at {peak.frequency_hz:.1f} Hz"
        + (
            f" (a slow sweep: {peak.steady_gain:.3g} at {peak.steady_hz:.1f} Hz)"
            if peak.steady_gain is not None and peak.steady_hz is not None
            else ""
        )
        for channel in run.channels
        for peak in channel.swept_peaks
    )
    return Drawing(
        "Swept response.",
        "The fundamental alone; a sudden drop is a jump of a nonlinear joint. "
        f"Tallest: {peaks}.",
        drawing,
    )


def _coherence(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    curves = curves_of(run, "coherence")
    if not curves:
        return None
    axis = _frequency_axis(curves)
    return Drawing(
        "Coherence with the control.",
        "Near 1 where the response follows linearly; a drop means nonlinearity or noise.",
        svg.plot(
            _lines(curves, chosen),
            axis,
            svg.Axis("coherence [-]", 0.0, 1.0),
            most=STILL,
            title=f"Coherence of test {run.test}",
            spans=_outside(run, axis),
        ),
    )


def _notch(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    del chosen  # before in grey, after in colour
    curves = curves_of(run, "notch")
    if not curves:
        return None
    lines = [
        svg.Curve(c.part, _array(c.x), _array(c.y), style.CONTROL_STYLES[1] if i == 0 else 0)
        for i, c in enumerate(curves)
    ]
    largest = 1.05 * max(float(np.nanmax(np.abs(line.y))) for line in lines) or 1.0
    channel = curves[0].channel
    unit = next(c.unit for c in run.channels if c.name == channel)
    tone = trends.shown("notch_hz", run.facts.get("notch_hz"))
    return Drawing(
        f"Two periods of {channel}, {tone} taken out.",
        "What is left is what the joint adds to the tone: nothing in a linear one.",
        svg.plot(
            lines,
            svg.Axis("time [s]", min(curves[0].x), max(curves[0].x)),
            svg.Axis(f"[{unit}]", -largest, largest),
            most=STILL,
            title=f"Two periods of test {run.test}, before and after",
        ),
    )
