"""The control against its limits: lines, a sentence, the level of a sweep."""

import numpy as np

from shakerproc.report.figures import style
from shakerproc.report.figures.figure import Axis, Curve, Figure, Plot
from shakerproc.report.runs.curves import RunContent, outside, swept_axis
from shakerproc.runs.levels import control_told as told_of_control
from shakerproc.runs.summary import ControlSummary, RunSummary


def control_told(run: RunSummary, where: str) -> str:
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
    found = []
    for name, decibels, number in (
        ("alarm", control.alarm_db, style.ALARM_STYLE),
        ("abort", control.abort_db, style.ABORT_STYLE),
    ):
        factor = 10.0 ** (decibels / per_decade)
        pair = (control.demanded / factor, control.demanded * factor)
        found.append((f"{name} ±{decibels:g} dB", pair, number))
    return found


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
        caption=f"Fundamental along the sweep.{control_told(run, 'sweep')}",
        kind="level",
        height=2.9,
    )
    return Figure("level", [plot], "level of the control along the sweep; thin: limits")
