"""Force over displacement of tensile runs: all of them, and the last that count."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from shakerproc.exchange.tensile import JointStiffness, TensileRun
from shakerproc.report.figures import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def all_runs(runs: Sequence[TensileRun], stiffness: JointStiffness) -> "Figure":
    """Return every run of a specimen, as the thesis' figure 5.8."""
    title = f"{stiffness.specimen}: all {len(runs)} runs"
    return _draw(runs, range(len(runs)), title)


def last_runs(runs: Sequence[TensileRun], stiffness: JointStiffness, last: int) -> "Figure":
    """Return the runs that count and their mean slope, as the thesis' figure 5.9."""
    counted = range(len(runs) - last, len(runs))
    title = (
        f"{stiffness.specimen}: last {last} runs, k = {stiffness.thesis / 1e3:.0f} N/mm "
        f"(secant), {stiffness.slope.value / 1e3:.0f} N/mm (slope)"
    )
    figure = _draw(runs, counted, title)
    axis = figure.axes[0]
    middle = runs[-1]
    half = 0.5 * float(np.max(middle.force))
    place = float(np.interp(half, middle.force, middle.displacement))
    reach = 0.4 * float(np.max(middle.force)) / stiffness.slope.value
    x = np.array([place - reach, place + reach])
    y = half + stiffness.slope.value * (x - place)
    axis.plot(1e3 * x, y, color="black", lw=1.0, ls=(0, (5, 3)), label="mean slope")
    axis.legend(loc="lower right")
    return figure


def _draw(runs: Sequence[TensileRun], which: Sequence[int], title: str) -> "Figure":
    figure, (axis,) = style.figure(6.0, 3.9)
    for number in which:
        run = runs[number]
        axis.plot(
            1e3 * run.displacement, run.force, label=f"run {number + 1}", **style.line(number)
        )
    axis.set_xlabel("displacement [mm]")
    axis.set_ylabel("force [N]")
    axis.set_title(title)
    axis.set_ylim(0.0, 1.2 * max(float(run.force[-1]) for run in runs))
    axis.set_xlim(0.0, 1.07e3 * max(float(np.max(run.displacement)) for run in runs))
    axis.legend(loc="lower right")
    return figure
