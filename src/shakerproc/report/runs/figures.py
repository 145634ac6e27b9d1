"""Figures of a run, each described once, drawn as PNG and on the page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from shakerproc import files
from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.figure import (
    Axis,
    Curve,
    Figure,
    Filling,
    Image,
    Mark,
    Plot,
    Span,
)
from shakerproc.report.figures.style import RESPONSE_STYLES
from shakerproc.report.runs.in_units import (
    RunContent,
    even_axis,
    frequency_axis,
    logarithmic_axis,
    outside,
    swept_axis,
    thin,
    unnamed,
)
from shakerproc.runs.levels import control_text as told_of_control
from shakerproc.runs.levels import density_unit
from shakerproc.runs.summarising import RANGE_DB, RunCurve
from shakerproc.runs.summary import ControlSummary, PeakSummary, RunSummary
from shakerproc.runs.tables import gain_unit

DECADES: Final = 6
"""Decades of a response function, a swept response or harmonics that are shown at most."""

MOST_TOLD: Final = 4
"""Sweeps whose ends are told one by one."""


def phase_axis(label: str) -> Axis:
    """Return the axis of a phase from -270 to 90 degrees."""
    return Axis(f"{label} [°]", -275.0, 95.0, degrees=True)


def response(content: RunContent) -> Figure | None:
    """Return |H1| and root of the PSD ratio, two axes for each unit, and the phase of H1."""
    plots = [_gain(content, unit) for unit in content.units if content.of("gain", unit)]
    phases = unnamed(content.lines("phase"))
    if not plots:
        return None
    if phases:
        axis, run = frequency_axis(phases), content.run
        turns = Plot(phases, axis, phase_axis("phase of H1"), spans=outside(run, axis))
        plots.append(turns)
    return Figure("response", plots, "H1; thin: root of the PSD ratio; marks: peaks")


def _gain(content: RunContent, unit: str) -> Plot:
    """Return response functions of one unit, with a mark at every peak of the table."""
    run, over = content.run, content.control_unit
    lines = content.lines("gain", unit)
    roots = thin(content.lines("gain_root", unit))
    modes = {c.name: c.response_peaks for c in run.channels if c.response_peaks}
    peaks = [_peaks(line, modes[line.label]) for line in lines if line.label in modes]
    axis, same = frequency_axis(lines), unit == over
    low = "1 at low frequency if sensor and table move together; " if same else ""
    caption = f"{low}a peak is a resonance."
    if peaks:
        caption += " Marks: the peaks of the table."
    label = f"|H1| [{'-' if same else f'{unit}/{over}'}]"
    return Plot(
        [*lines, *roots, *peaks],
        axis,
        logarithmic_axis(label, [*lines, *roots], DECADES),
        spans=outside(run, axis),
        title="Response over control, |H1|",
        caption=caption[0].upper() + caption[1:],
        kind="gain",
    )


def _peaks(line: Curve, modes: tuple[PeakSummary, ...]) -> Curve:
    """Return a mark at each mode of a line."""
    x, y = (np.array([p.frequency_hz for p in modes]), np.array([p.height for p in modes]))
    return Curve("", x, y, line.style, points=True)


def coherence(content: RunContent) -> Figure | None:
    """Return the coherence of every response, multiple coherence thin."""
    lines = content.lines("coherence")
    if not lines:
        return None
    axis = frequency_axis(lines)
    multiple = thin(content.lines("multiple_coherence"))
    plot = Plot(
        [*lines, *multiple],
        axis,
        Axis("coherence [-]", 0.0, 1.05),
        spans=outside(content.run, axis),
        title="Coherence with the control",
        caption="Near 1 where the response follows linearly; "
        "a drop means nonlinearity or noise.",
        kind="coherence",
    )
    also = "; thin: multiple, with all controls" if multiple else ""
    return Figure("coherence", [plot], f"coherence with the mean control{also}")


def psd_ratio_plot(content: RunContent) -> Plot | None:
    """Return the density of each response in the control's unit over that of the control."""
    lines = unnamed(content.lines("psd_ratio", content.control_unit))
    if not lines:
        return None
    axis = frequency_axis(lines)
    label = logarithmic_axis("PSD ratio [-]", lines)
    return Plot(lines, axis, label, spans=outside(content.run, axis), title="PSD ratio")


def sweep(content: RunContent) -> Figure | None:
    """Return the fundamental along each sweep, and the harmonics of the loudest response."""
    gains = _each_way(content, "sweep")
    if not gains:
        return None
    axis = swept_axis(gains)
    plots = [_fundamental(content, unit) for unit in content.units if content.of("sweep", unit)]
    phases = unnamed(_each_way(content, "sweep_phase"))
    if phases:
        turns = phase_axis("phase of the fundamental")
        plots.append(Plot(phases, axis, turns, title="Phase", height=1.8))
    ratios = _harmonics_of_sweep(content)
    if ratios:
        loudest = content.of("sweep_harmonic")[0].channel
        label = logarithmic_axis(f"harmonics of {loudest} [-]", ratios, DECADES)
        plots.append(Plot(ratios, axis, label, title="Harmonics", height=2.2))
    return Figure("sweep", plots, f"swept response{_spans(content)}")


def _fundamental(content: RunContent, unit: str) -> Plot:
    """Return the swept responses of the channels of one unit."""
    gains, over = _each_way(content, "sweep", unit), content.control_unit
    axis = swept_axis(gains)
    label = f"fundamental over control [{'-' if unit == over else f'{unit}/{over}'}]"
    return Plot(
        gains,
        axis,
        logarithmic_axis(label, gains, DECADES),
        spans=outside(content.run, axis),
        title="Swept response",
        caption="The fundamental alone; a sudden drop is a jump of a nonlinear joint. "
        f"Tallest: {_tallest(content.run, unit)}.",
        kind="sweep",
    )


def _each_way(content: RunContent, kind: str, unit: str | None = None) -> list[Curve]:
    """Return lines along the sweeps; each sweep of a channel has a colour of its own."""
    lines, curves = content.lines(kind, unit), content.of(kind, unit)
    channels = list(dict.fromkeys(c.channel for c in curves))
    seen: dict[str, int] = {}
    found = []
    for line, curve in zip(lines, curves, strict=True):
        again = seen.setdefault(curve.channel, 0)
        seen[curve.channel] += 1
        number = (line.style + again * len(channels)) % len(RESPONSE_STYLES)
        found.append(replace(line, style=number))
    return found


def _harmonics_of_sweep(content: RunContent) -> list[Curve]:
    """Return harmonics over their fundamental, each named once whatever the sweeps."""
    curves, parts = [], list(dict.fromkeys(c.part for c in content.of("sweep_harmonic")))
    named: set[str] = set()
    for c in content.of("sweep_harmonic"):
        label = "" if c.part in named else c.part
        named.add(c.part)
        curves.append(Curve(label, c.x, c.y, parts.index(c.part) % len(RESPONSE_STYLES)))
    return curves


def _spans(content: RunContent) -> str:
    """Return from where to where each sweep goes, in words."""
    first = content.of("sweep")[0].channel
    sweeps = [c for c in content.of("sweep") if c.channel == first]
    sentences = [
        f"{c.part} {numeral(c.x.min(), 4)} to {numeral(c.x.max(), 4)} Hz" for c in sweeps
    ]
    return (
        f": {', '.join(sentences)}"
        if len(sentences) <= MOST_TOLD
        else f", {len(sentences)} sweeps"
    )


def _tallest(run: RunSummary, unit: str) -> str:
    """Return the tallest point of the responses of a unit along every sweep, in words."""
    return "; ".join(
        f"{channel.name} {peak.direction} {numeral(peak.gain)}{over} at "
        f"{peak.frequency_hz:.1f} Hz"
        + (
            f" (a slow sweep: {numeral(peak.steady_gain)}{over} at {peak.steady_hz:.1f} Hz)"
            if peak.steady_gain is not None and peak.steady_hz is not None
            else ""
        )
        for channel in run.channels
        if channel.unit == unit
        for over in (f" {gain_unit(run, channel)}".rstrip(),)
        for peak in channel.swept_peaks
    )


def harmonics_plot(content: RunContent) -> Plot | None:
    """Return the amplitude of a steady tone and its harmonics, channels side by side."""
    lines = content.lines("harmonics")
    if not lines:
        return None
    tone = float(lines[0].x[0])
    names = {float(x): f"{round(x / tone)} x {numeral(tone, 4)} Hz" for x in lines[0].x}
    spacing = 0.4 * tone / len(lines)
    points = [
        replace(line, x=line.x + spacing * (i - (len(lines) - 1) / 2.0), points=True)
        for i, line in enumerate(lines)
    ]
    unit = content.units[0] if len(content.units) == 1 else "unit of the channel"
    return Plot(
        points,
        Axis("harmonic", 0.5 * tone, float(lines[0].x[-1]) + 0.5 * tone),
        logarithmic_axis(f"amplitude [{unit}]", lines, DECADES),
        names=names,
        title="Harmonics",
        caption="Amplitude of the tone and of its multiples.",
        kind="harmonics",
    )


def harmonics(content: RunContent) -> Figure | None:
    """Return the harmonics of a steady tone."""
    plot = harmonics_plot(content)
    return None if plot is None else Figure("harmonics", [plot])


def control_verdict(run: RunSummary, where: str) -> str:
    """Return whether the controls kept the limits that are drawn."""
    if run.control is None:
        return " The controls should stay between the thin lines."
    return f" Mean control (limits: thin lines) {told_of_control(run.control, where)}."


def alarm_lines(run: RunSummary) -> list[Curve]:
    """Return the limits of the control density as lines over the band."""
    if run.alarm is None or run.spectrum is None:
        return []
    limits = [("alarm limits", run.alarm, style.ALARM_STYLE)]
    if run.control is not None:
        limits = _limits(run.control, 10.0)
    return _lines(limits, run.spectrum.band_hz)


def _limits(
    control: ControlSummary, per_decade: float
) -> list[tuple[str, tuple[float, float], int]]:
    """Return name, values and style of the alarm and abort limits; 10 or 20 dB a decade."""
    rows = []
    for name, decibels, number in (
        ("alarm", control.alarm_db, style.ALARM_STYLE),
        ("abort", control.abort_db, style.ABORT_STYLE),
    ):
        factor = 10.0 ** (decibels / per_decade)
        pair = (control.demanded / factor, control.demanded * factor)
        rows.append((f"{name} ±{decibels:g} dB", pair, number))
    return rows


def _lines(
    limits: list[tuple[str, tuple[float, float], int]], band: tuple[float, float]
) -> list[Curve]:
    """Return two lines for each pair of limits, of which the first has the name."""
    return [
        Curve(label, np.array(band), np.full(2, limit), number, thin=True)
        for name, pair, number in limits
        for label, limit in zip((name, ""), pair, strict=True)
    ]


def level(content: RunContent) -> Figure | None:
    """Return the amplitude of the control along a sweep, and its limits."""
    curves, run = content.of("level"), content.run
    if not curves or run.control is None:
        return None
    lines = [
        Curve(f"mean control {c.part}".strip(), c.x, c.y, style_of)
        for c, style_of in zip(curves, style.CONTROL_STYLES * len(curves), strict=False)
    ]
    axis = swept_axis(lines)
    band = run.spectrum.band_hz if run.spectrum else (axis.low, axis.high)
    limits = _lines(_limits(run.control, 20.0), band)
    top = 1.08 * max(float(np.nanmax(line.y)) for line in (*lines, *limits))
    plot = Plot(
        [*lines, *limits],
        axis,
        Axis(f"[{run.level_unit}]", 0.0, top),
        spans=outside(run, axis),
        title="Level of the control",
        caption=f"Fundamental along the sweep.{control_verdict(run, 'sweep')}",
        kind="level",
        height=2.9,
    )
    return Figure("level", [plot], "level of the control along the sweep; thin: limits")


def time(content: RunContent) -> Figure | None:
    """Return channels over the whole recording, the part outside the crop shaded."""
    curves, run = content.of("time"), content.run
    if not curves or run.duration_s is None:
        return None
    axis, spans, notes = Axis("time [s]", 0.0, run.promised_s or run.duration_s), [], []
    caption = "Extremes of each slice."
    if run.crop_s is not None:
        spans = [Span(0.0, run.crop_s[0]), Span(run.crop_s[1], axis.high)]
        caption += " Grey is cropped away: the run should fill what is white."
        notes.append(f"processed {run.crop_s[0]:.2f} to {run.crop_s[1]:.2f} s")
    if content.of("threshold"):
        caption += " Thin: threshold of the crop."
        notes.append("thin: threshold of the crop")
    marks = _happened(run, axis.high)
    plots = [replace(_channel(content, c, axis), spans=spans, marks=marks) for c in curves]
    below = [replace(plot, marks=[Mark(m.x, "") for m in marks]) for plot in plots[1:]]
    first = replace(plots[0], title="Time", caption=caption)
    return Figure("time", [first, *below], ", ".join(notes), together=True)


def _channel(content: RunContent, curve: RunCurve, axis: Axis) -> Plot:
    """Return one channel against time, with the threshold that it is compared with."""
    limits = [c for c in content.of("threshold") if c.channel == curve.channel]
    lines = [Curve("", c.x, c.y, style.ABORT_STYLE, thin=True) for c in limits]
    low = curve.y if curve.low is None else curve.low
    area = Filling(curve.channel, curve.x, low, curve.y, content.styles[curve.channel])
    label = f"[{content.unit_of(curve.channel)}]"
    return Plot(
        [area, *lines],
        axis,
        even_axis(label, [low, curve.y, *(line.y for line in lines)]),
        kind="time",
        channel=curve.channel,
        height=0.85,
    )


def _happened(run: RunSummary, end: float) -> list[Mark]:
    """Return the events of the log, a doubtful start, and where the recording is cut off."""
    marks = [Mark(at, files.printable(note)) for at, note in run.events if at <= end]
    if run.crop_s is not None and any(flag.kind == "crop" for flag in run.flags):
        marks.append(Mark(run.crop_s[0], "stands alone: a spike?"))
    if run.incomplete and run.duration_s is not None:
        marks.append(Mark(run.duration_s, f"cut off at {numeral(run.duration_s)} s"))
    return marks


def psd(content: RunContent) -> Figure | None:
    """Return the density of every channel, two axes for each unit."""
    plots = [_density(content, unit) for unit in content.units if content.of("psd", unit)]
    height = 3.0 if len(plots) == 1 else 2.2
    resized = [replace(plot, height=height) for plot in plots]
    return Figure("psd", resized, _worth(content.run)) if resized else None


def _worth(run: RunSummary) -> str:
    s = run.spectrum
    return (
        ""
        if s is None
        else f"bins {numeral(s.bin_width_hz)} Hz, {s.degrees_of_freedom:.0f} DOF"
    )


def _density(content: RunContent, unit: str) -> Plot:
    """Return the densities of the channels of one unit, limits of the control among them."""
    run, lines = content.run, content.lines("psd", unit)
    axis, spread = frequency_axis(lines), _spread(run)
    lines = [replace(line, spread=spread) for line in lines]
    best = max(filter(None, _main_peaks(run, unit)), key=lambda p: p.height, default=None)
    marks, caption = [], ""
    if best is not None:
        marks = [Mark(best.frequency_hz, f"peak {best.frequency_hz:.1f} Hz")]
        caption = (
            "The tallest peak of a response inside the excited band is its peak frequency."
        )
    limits = alarm_lines(run) if unit == content.control_unit else []
    if limits:
        caption += control_verdict(run, "band")
    return Plot(
        [*lines, *limits],
        axis,
        logarithmic_axis(f"PSD [{density_unit(unit)}]", lines),
        marks,
        outside(run, axis),
        title="Power spectral density",
        caption=caption,
        kind="psd",
    )


def _spread(run: RunSummary) -> tuple[float, float] | None:
    """Return the 95 % bounds of a density as multiples of it, None of blows."""
    s = run.spectrum
    if s is None or s.low_factor is None or s.high_factor is None:
        return None
    return s.low_factor, s.high_factor


def _main_peaks(run: RunSummary, unit: str) -> list[PeakSummary | None]:
    return [
        trends.main_peak(run, c.name)
        for c in run.channels
        if c.role != "control" and c.unit == unit
    ]


def psd_and_response(content: RunContent) -> Figure | None:
    """Return the thesis' two-in-one figure: densities above, PSD ratio below.

    At a single frequency a ratio of densities says nothing: the harmonics stand there instead.
    """
    below = psd_ratio_plot(content) or harmonics_plot(content)
    if below is None:
        return None
    unit = content.control_unit or content.unit_of(content.of("psd")[0].channel)
    above = replace(_density(content, unit), height=2.85)
    plots = [above, replace(below, height=2.85)]
    return Figure("psd_and_response", plots, _worth(content.run))


def notch(content: RunContent) -> Figure | None:
    """Return two periods before and after the tone was taken out (figures 5.41 to 5.44)."""
    curves = content.of("notch")
    if not curves:
        return None
    tone = _tone(content.run)
    plots = [
        Plot(
            lines,
            Axis("time [s]", float(lines[0].x[0]), float(lines[0].x[-1])),
            even_axis(f"[{content.unit_of(name)}]", [line.y for line in lines]),
            title=f"Two periods of {name}, {tone} taken out",
            caption="What is left is what the joint adds to the tone: nothing in a linear one.",
            kind="notch",
            channel=name,
            height=1.2,
        )
        for name, lines in _before_and_after(content, curves).items()
    ]
    return Figure("notch", plots, f"two periods, {tone} taken out")


def notch_psd(content: RunContent) -> Figure | None:
    """Return the density of each response with and without the tone (figures 5.43 and 5.44)."""
    curves = content.of("notch_psd")
    if not curves:
        return None
    axis, tone = frequency_axis(curves), _tone(content.run)
    plots = [
        Plot(
            lines,
            axis,
            logarithmic_axis(f"[{density_unit(content.unit_of(name))}]", lines),
            spans=outside(content.run, axis),
            title=f"Power spectral density of {name}, {tone} taken out",
            kind="notch_psd",
            channel=name,
            height=1.8,
        )
        for name, lines in _before_and_after(content, curves).items()
    ]
    return Figure("notch_psd", plots, f"PSD, {tone} taken out")


def _tone(run: RunSummary) -> str:
    return trends.shown("notch_hz", run.facts.get("notch_hz"))


def _before_and_after(
    content: RunContent, curves: Sequence[RunCurve]
) -> dict[str, list[Curve]]:
    """Return the curves of each channel: before in grey, after in its colour."""
    columns: dict[str, list[Curve]] = {}
    for c in curves:
        before = c.part == "before"
        number = style.CONTROL_STYLES[1] if before else content.styles[c.channel]
        columns.setdefault(c.channel, []).append(Curve(c.part, c.x, c.y, number))
    return columns


def spectrogram(content: RunContent) -> Figure | None:
    """Return the density of one channel against time and frequency."""
    surface = content.surface
    if surface is None:
        return None
    top = float(surface.level.max())
    image = Image(
        surface.time,
        surface.frequency,
        surface.level,
        top - RANGE_DB,
        top,
        f"dB re 1 {surface.unit}",
    )
    plot = Plot(
        [],
        Axis("time [s]", float(surface.time[0]), float(surface.time[-1])),
        Axis("frequency [Hz]", 0.0, float(surface.frequency[-1])),
        title="Spectrogram",
        caption=f"Density of {surface.channel} in dB re 1 {surface.unit}; of neighbouring "
        "cells the largest.",
        image=image,
        height=3.1,
    )
    return Figure("spectrogram", [plot], f"spectrogram of {surface.channel}")


FIGURES: Final[Mapping[str, Callable[[RunContent], Figure | None]]] = MappingProxyType({
    "time": time,
    "psd": psd,
    "response": response,
    "sweep": sweep,
    "level": level,
    "coherence": coherence,
    "psd_and_response": psd_and_response,
    "harmonics": harmonics,
    "notch": notch,
    "notch_psd": notch_psd,
    "spectrogram": spectrogram,
})
"""Every figure of a run by its name, in the order of the page."""

IN_FILES: Final = tuple(name for name in FIGURES if name != "harmonics")
"""Those that are files; harmonics stand below the densities there."""

ON_PAGE: Final = tuple(name for name in FIGURES if name != "psd_and_response")
"""Those of the page, where densities and ratios are figures of their own."""
