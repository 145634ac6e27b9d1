"""Responses of a run against its control: functions, phases, coherence."""

from typing import Final

import numpy as np

from shakerproc.report.figures.figure import Axis, Curve, Figure, Plot
from shakerproc.report.runs.curves import (
    RunContent,
    frequency_axis,
    logarithmic_axis,
    outside,
    thin,
    unnamed,
)
from shakerproc.runs.summary import PeakSummary

DECADES: Final = 6
"""Decades of a response function that are shown at most."""


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
