"""What the control did against its limits: lines, a sentence, the level of a sweep."""

from collections.abc import Mapping

import numpy as np

from shakerproc.report import style, svg
from shakerproc.report.drawing import Drawing
from shakerproc.report.run_curves import STILL, curves_of, frequency_axis, outside, values_of
from shakerproc.runs.control import control_told as told_of_control
from shakerproc.runs.summary import ControlSummary, RunSummary


def control_told(run: RunSummary, where: str) -> str:
    """Return whether the controls kept the limits that are drawn."""
    if run.control is None:
        return " The controls should stay between the thin lines."
    return f" Mean control (limits: thin lines) {told_of_control(run.control, where)}."


def alarm_lines(run: RunSummary) -> list[svg.Curve]:
    """Return the limits of the control density as lines over the band."""
    if run.alarm is None or run.spectrum is None:
        return []
    band = np.array(run.spectrum.band_hz)
    limits = [("alarm limits", run.alarm, style.ALARM_STYLE)]
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
        ("alarm", control.alarm_db, style.ALARM_STYLE),
        ("abort", control.abort_db, style.ABORT_STYLE),
    ):
        factor = 10.0 ** (decibels / per_decade)
        pair = (control.demanded / factor, control.demanded * factor)
        found.append((f"{name} ±{decibels:g} dB", pair, number))
    return found


def level(run: RunSummary, chosen: Mapping[str, int]) -> Drawing | None:
    """Return the amplitude of the control along a sweep, and its limits."""
    del chosen  # the mean of the controls is no channel
    curves = curves_of(run, "level")
    if not curves or run.control is None:
        return None
    axis = frequency_axis(curves)
    band = np.array(run.spectrum.band_hz if run.spectrum else (axis.low, axis.high))
    lines = [
        svg.Curve(f"mean control {c.part}".strip(), values_of(c.x), values_of(c.y), style_of)
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
        f"Fundamental along the sweep.{control_told(run, 'sweep')}",
        svg.plot(
            [*lines, *limits],
            axis,
            svg.Axis(f"[{run.level_unit}]", 0.0, top),
            most=STILL,
            title=f"Level of the control of test {run.test}",
            spans=outside(run, axis),
        ),
    )
