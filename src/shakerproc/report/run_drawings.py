"""The drawings of a run: time with crop, densities, responses, coherence."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from markupsafe import Markup

from shakerproc.campaign import trends
from shakerproc.report import style, svg
from shakerproc.report.control_drawings import alarm_lines, control_told, level
from shakerproc.report.drawing import Drawing
from shakerproc.report.run_curves import (
    STILL,
    curves_of,
    frequency_axis,
    lines_of,
    logarithmic_axis,
    outside,
    values_of,
)
from shakerproc.runs.summary import CurveSummary, PeakSummary, RunSummary


def figures(run: RunSummary) -> list[Drawing]:
    """Return the drawings of a run: time with crop, densities, response, coherence."""
    if not run.channels:
        return []
    roles = [c.role for c in run.channels]
    chosen = dict(zip((c.name for c in run.channels), style.styles(roles), strict=True))
    units = list(dict.fromkeys(c.unit for c in run.channels))
    drawn = [
        ("time", _time(run, chosen)),
        *(("psd", _psd(run, chosen, unit)) for unit in units),
        *(("gain", _gain(run, chosen, unit)) for unit in units),
        ("sweep", _sweep(run, chosen)),
        ("level", level(run, chosen)),
        ("coherence", _coherence(run, chosen)),
        ("notch", _notch(run, chosen)),
    ]
    return [
        replace(marked(drawing, run), kind=kind)
        for kind, drawing in drawn
        if drawing is not None
    ]


def _in_unit(run: RunSummary, kind: str, unit: str) -> list[CurveSummary]:
    """Return the curves of one figure whose channels have a unit."""
    names = {c.name for c in run.channels if c.unit == unit}
    return [curve for curve in curves_of(run, kind) if curve.channel in names]


def _control_unit(run: RunSummary) -> str:
    return next((c.unit for c in run.channels if c.role == "control"), "")


def marked(drawing: Drawing, run: RunSummary) -> Drawing:
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
        svg.Filling(
            c.channel, values_of(c.x), values_of(c.low), values_of(c.y), chosen[c.channel]
        )
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


def _psd(run: RunSummary, chosen: Mapping[str, int], unit: str) -> Drawing | None:
    curves = _in_unit(run, "psd", unit)
    if not curves:
        return None
    lines, axis = lines_of(curves, chosen), frequency_axis(curves)
    best = max(filter(None, _all_main_peaks(run, unit)), key=lambda p: p.height, default=None)
    marks = [svg.Mark(best.frequency_hz, f"{best.frequency_hz:.1f} Hz")] if best else []
    caption = ""
    if best:
        caption = (
            "The tallest peak of a response inside the excited band is its peak frequency."
        )
    limits = alarm_lines(run) if unit == _control_unit(run) else []
    if limits:
        caption += control_told(run, "band")
    return Drawing(
        "Power spectral density.",
        caption,
        svg.plot(
            [*lines, *limits],
            axis,
            logarithmic_axis(f"[{style.density_unit(unit)}]", lines),
            most=STILL,
            title=f"Power spectral densities of test {run.test}",
            marks=marks,
            spans=outside(run, axis),
        ),
    )


def _all_main_peaks(run: RunSummary, unit: str) -> list[PeakSummary | None]:
    return [
        trends.main_peak(run, c.name)
        for c in run.channels
        if c.role != "control" and c.unit == unit
    ]


def _logarithmic(
    run: RunSummary,
    chosen: Mapping[str, int],
    curves: Sequence[CurveSummary],
    told: tuple[str, str],
    modes: Mapping[str, Sequence[PeakSummary]] | None = None,
) -> Markup | None:
    """Return curves over a logarithmic axis, with a mark at every mode of a channel."""
    if not curves:
        return None
    lines, axis = lines_of(curves, chosen), frequency_axis(curves)
    label, title = told
    drawn = [one for line in lines for one in (line, *_marked(line, modes or {}))]
    return svg.plot(
        drawn,
        axis,
        logarithmic_axis(label, lines, 5),
        most=STILL,
        title=f"{title} of test {run.test}",
        spans=outside(run, axis),
    )


def _marked(line: svg.Curve, modes: Mapping[str, Sequence[PeakSummary]]) -> Iterator[svg.Curve]:
    """Yield marks at the modes of a line, where it has some."""
    peaks = modes.get(line.label, ())
    if peaks:
        x, y = (np.array([p.frequency_hz for p in peaks]), np.array([p.height for p in peaks]))
        yield svg.Curve("", x, y, line.style, points=True)


def _gain(run: RunSummary, chosen: Mapping[str, int], unit: str) -> Drawing | None:
    same = unit == _control_unit(run)
    over = "-" if same else f"{unit}/{_control_unit(run)}"
    told = (f"|H1| [{over}]", "Response functions")
    modes = {c.name: c.response_peaks for c in run.channels if c.unit == unit}
    drawing = _logarithmic(run, chosen, _in_unit(run, "gain", unit), told, modes)
    if drawing is None:
        return None
    low = "1 at low frequency if sensor and table move together; " if same else ""
    caption = f"{low}a peak is a resonance."
    if any(modes.values()):
        caption += " Marks: the peaks of the table."
    return Drawing("Response over control, |H1|.", caption[0].upper() + caption[1:], drawing)


def _sweep(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    told = ("fundamental over control [-]", "Swept response")
    drawing = _logarithmic(run, chosen, curves_of(run, "sweep"), told)
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
    axis = frequency_axis(curves)
    return Drawing(
        "Coherence with the control.",
        "Near 1 where the response follows linearly; a drop means nonlinearity or noise.",
        svg.plot(
            lines_of(curves, chosen),
            axis,
            svg.Axis("coherence [-]", 0.0, 1.0),
            most=STILL,
            title=f"Coherence of test {run.test}",
            spans=outside(run, axis),
        ),
    )


def _notch(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    del chosen  # before in grey, after in colour
    curves = curves_of(run, "notch")
    if not curves:
        return None
    lines = [
        svg.Curve(
            c.part, values_of(c.x), values_of(c.y), style.CONTROL_STYLES[1] if i == 0 else 0
        )
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
