"""The figure of a study: its panels, side by side or one above the other."""

from itertools import groupby
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from shakerproc.report.figures import style
from shakerproc.studies.results import StudyImage, StudyLine, StudyPanel, StudyResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOOKS: Final = {"line": "-", "dashed": (0, (4, 2)), "dotted": ":", "marked": "-", "points": ""}
SIGNS: Final = ("o", "s", "^", "D", "v", "P", "X", "*")
ACROSS: Final = 3
"""Square panels in a row."""
DECIBELS: Final = 60.0
"""Range of a spectrogram below its tallest value [dB]."""


def study_figure(result: StudyResult) -> "Figure":
    """Return every panel of a study: wide ones below each other, square ones in rows."""
    from matplotlib.figure import Figure

    rows: list[list[StudyPanel]] = []
    for square, group in groupby(result.panels, key=lambda panel: panel.square):
        panels, across = list(group), ACROSS if square else 1
        rows += [panels[i : i + across] for i in range(0, len(panels), across)]
    heights = [3.0 if row[0].square else 2.6 for row in rows]
    figure = Figure(figsize=(7.0, sum(heights) + 0.5), layout="constrained")
    for sub, row in zip(_stripes(figure, heights), rows, strict=True):
        width = ACROSS if row[0].square and len(row) > 1 else len(row)
        axes = sub.subplots(1, width, squeeze=False)[0]
        for axis, panel in zip(axes, row, strict=False):
            _draw(axis, panel)
        for axis in axes[len(row) :]:
            axis.set_visible(False)
    named = f"{result.title} (figure {result.figure})" if result.figure else result.title
    figure.suptitle(named, fontsize=10.0, x=0.01, ha="left")
    return figure


def _stripes(figure: "Figure", heights: list[float]) -> list[Any]:
    found = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)
    return [row[0] for row in found]


def _draw(axis: "Axes", panel: StudyPanel) -> None:
    if panel.image is not None:
        _draw_image(axis, panel.image)
    for line in panel.lines:
        axis.plot(line.x, line.y, **_arguments(line))
    axis.set_xscale("log" if panel.log_x else "linear")
    axis.set_yscale("log" if panel.log_y else "linear")
    if panel.log_y and panel.lines:
        _limit_decades(axis, panel)
    if panel.square:
        axis.locator_params(axis="x", nbins=3)  # labels of small panels would overlap
        axis.tick_params(axis="x", labelsize=7.0)
    axis.set_xlabel(panel.x_label)
    axis.set_ylabel(panel.y_label)
    if panel.title:
        axis.set_title(panel.title)
    named = [line for line in panel.lines if line.label]
    if named:
        axis.legend(ncols=1 + len(named) // 9)


def _arguments(line: StudyLine) -> dict[str, Any]:
    """Return matplotlib's arguments for a line."""
    colour = style.COLOURS[line.style % len(style.COLOURS)]
    if line.look == "points":
        return {
            "color": colour,
            "linestyle": "none",
            "marker": ".",
            "ms": 1.6 if line.x.size > 500 else 3.0,
            "mew": 0.0,
            "label": line.label or None,
            "rasterized": True,
        }
    sign = SIGNS[line.style % len(SIGNS)] if line.look == "marked" else None
    return {
        "color": colour,
        "linestyle": LOOKS[line.look],
        "linewidth": 1.2,
        "marker": sign,
        "ms": 4.0,
        "label": line.label or None,
    }


def _limit_decades(axis: "Axes", panel: StudyPanel) -> None:
    """Show at most ten decades below the top: what is smaller is rounding."""
    top = max(float(np.max(line.y)) for line in panel.lines if line.y.size)
    low = min(float(np.min(line.y[line.y > 0.0])) for line in panel.lines if np.any(line.y > 0))
    axis.set_ylim(max(0.5 * low, 1e-10 * top), 3.0 * top)


def _draw_image(axis: "Axes", image: StudyImage) -> None:
    top = float(np.max(image.values))
    decibels = 10.0 * np.log10(np.maximum(image.values, 1e-30 * max(top, 1e-300)))
    mesh = axis.pcolormesh(
        image.x,
        image.y,
        decibels,
        vmin=10.0 * np.log10(top) - DECIBELS,
        vmax=10.0 * np.log10(top),
        cmap="cividis",
        shading="nearest",
        rasterized=True,
    )
    axis.grid(visible=False)
    axis.figure.colorbar(mesh, ax=axis, label="density [dB]")
