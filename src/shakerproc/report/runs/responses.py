"""Responses of a run: functions against its control, along a sine, and at its harmonics."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.numerals import numeral
from shakerproc.report.figures.figure import Axis, Curve, Figure, Plot
from shakerproc.report.figures.style import RESPONSE_STYLES
from shakerproc.report.runs.in_units import (
    RunContent,
    frequency_axis,
    logarithmic_axis,
    outside,
    swept_axis,
    thin,
    unnamed,
)
from shakerproc.runs.summary import PeakSummary, RunSummary
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
    found, parts = [], list(dict.fromkeys(c.part for c in content.of("sweep_harmonic")))
    named: set[str] = set()
    for c in content.of("sweep_harmonic"):
        label = "" if c.part in named else c.part
        named.add(c.part)
        found.append(Curve(label, c.x, c.y, parts.index(c.part) % len(RESPONSE_STYLES)))
    return found


def _spans(content: RunContent) -> str:
    """Return from where to where each sweep goes, in words."""
    first = content.of("sweep")[0].channel
    own = [c for c in content.of("sweep") if c.channel == first]
    told = [f"{c.part} {numeral(c.x.min(), 4)} to {numeral(c.x.max(), 4)} Hz" for c in own]
    return f": {', '.join(told)}" if len(told) <= MOST_TOLD else f", {len(told)} sweeps"


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
    apart = 0.4 * tone / len(lines)
    points = [
        replace(line, x=line.x + apart * (i - (len(lines) - 1) / 2.0), points=True)
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
