"""Figures drawn with matplotlib and written as PNG."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from shakerproc import files
from shakerproc.data import FloatArray
from shakerproc.report.figures import style
from shakerproc.report.figures.figure import (
    Axis,
    Curve,
    Figure,
    Filling,
    Image,
    Mark,
    Plot,
    unwrapped,
)
from shakerproc.report.figures.style import write_legibly

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as MatplotlibFigure

DOTS_PER_INCH: Final = 130

LEFT: Final = 0.8
"""Left margin [in]."""

MARKERS: Final = ("o", "s", "^", "D", "v", "P", "_", "|")
"""Mark of each style, as on the page."""


def save(picture: "MatplotlibFigure", path: Path) -> Path:
    """Write a figure as PNG, whole or not at all, the same bytes for the same figure.

    It is opaque: its colours without transparency are packed in two thirds of the time.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image as Pixels
    from PIL.PngImagePlugin import PngInfo

    write_legibly(picture)
    picture.set_dpi(DOTS_PER_INCH)
    canvas = FigureCanvasAgg(picture)
    canvas.draw()  # type: ignore[no-untyped-call]
    pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    written_by = PngInfo()
    written_by.add_text("Software", "shakerproc")
    resolution = (DOTS_PER_INCH, DOTS_PER_INCH)
    with files.atomic_path(path) as temporary:
        Pixels.fromarray(np.ascontiguousarray(pixels[..., :3])).save(
            temporary, "PNG", dpi=resolution, pnginfo=written_by, compress_level=2
        )
    return path


def matplotlib_figure(figure: Figure, title: str, alarm: str = "") -> "MatplotlibFigure":
    """Return a figure drawn with matplotlib.

    Parameters
    ----------
    figure : Figure
        What it shows.
    title : str
        Headline.
    alarm : str
        What the line below the headline begins with, in red.
    """
    plots = figure.plots
    tall = 0.5 + sum(plot.height for plot in plots)
    shared = all(_ends(plot.x) == _ends(plots[0].x) for plot in plots)
    keys = any(item.label for plot in plots for item in plot.items) and not figure.together
    with style.look():
        picture, axes = style.figure(
            7.0, tall, len(plots), sharex=shared, left=LEFT, legend=keys
        )
        named: list[str] = []
        for axis, plot in zip(axes, plots, strict=True):
            _draw(axis, plot, last=axis is axes[-1] or not shared)
            above, named = named, [item.label for item in plot.items if item.label]
            if keys and named != above:
                style.legend(axis)
        note = ", ".join(filter(None, (alarm, figure.note)))
        style.head(axes[0], title, note, alarming=bool(alarm), legend=keys)
    return picture


def _ends(axis: Axis) -> tuple[str, float, float]:
    return axis.label, axis.low, axis.high


def _draw(axis: "Axes", plot: Plot, *, last: bool) -> None:
    """Draw one plot; only the last of several along the same axis names it."""
    if plot.image is not None:
        _image(axis, plot.image)
    for item in (unwrapped(item, plot.y) for item in plot.items):
        if isinstance(item, Filling):
            colour = style.COLOURS[item.style % len(style.COLOURS)]
            axis.fill_between(item.x, item.low, item.high, color=colour, lw=0.3)
        else:
            _curve(axis, item, plot.y)
    for span in plot.spans:
        axis.axvspan(span.low, span.high, color="#888888", alpha=0.16, lw=0.0)
    for mark in plot.marks:
        _mark(axis, mark, plot)
    _scale(axis, plot)
    if last:
        axis.set_xlabel(plot.x.label)
    axis.set_ylabel(plot.y.label)
    if plot.channel:
        style.name(axis, plot.channel)


def _scale(axis: "Axes", plot: Plot) -> None:
    """Set ends and ticks of both axes."""
    if plot.x.logarithmic:
        style.plain_logarithmic(axis, "x")
    axis.set_xlim(plot.x.low, plot.x.high)
    if plot.names:
        axis.set_xticks(list(plot.names), list(plot.names.values()))
    if plot.y.logarithmic:
        style.logarithmic(axis, plot.y.low, plot.y.high)
    else:
        axis.set_ylim(plot.y.low, plot.y.high)
    if plot.y.degrees:
        axis.set_yticks([v for v in range(-360, 361, 90) if plot.y.low <= v <= plot.y.high])


def _curve(axis: "Axes", curve: Curve, scale: Axis) -> None:
    y = drawable(curve.y, logarithmic=scale.logarithmic)
    how: dict[str, Any] = style.line(curve.style)
    if curve.points:
        how |= {
            "linestyle": "none",
            "marker": MARKERS[curve.style % len(MARKERS)],
            "markersize": 5.0,
        }
    elif curve.thin:
        how["linewidth"] = 0.7
    axis.plot(curve.x, y, label=curve.label or "_", **how)
    if curve.spread is not None:
        low, high = (y * factor for factor in curve.spread)
        axis.fill_between(curve.x, low, high, color=how["color"], alpha=0.18, lw=0.0)


def drawable(y: FloatArray, *, logarithmic: bool) -> FloatArray:
    """Return values in any unit; NaN where a logarithmic axis cannot show them."""
    return np.where(y > 0.0, y, np.nan) if logarithmic else y


def _mark(axis: "Axes", mark: Mark, plot: Plot) -> None:
    """Draw a vertical line, its word on the side where there is room, below a name."""
    axis.axvline(mark.x, color="#222222", lw=0.8, ls=(0, (4, 3)))
    if not mark.label:
        return
    late = float(plot.x.share(np.array([mark.x]))[0]) > 0.6
    low = bool(plot.channel)
    axis.annotate(
        mark.label,
        (mark.x, 0.0 if low else 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(-3 if late else 3, 2 if low else -2),
        textcoords="offset points",
        ha="right" if late else "left",
        va="bottom" if low else "top",
        fontsize=8.0,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
    )


def _image(axis: "Axes", image: Image) -> None:
    """Draw values in colours, with a bar of their scale."""
    shown = axis.imshow(
        image.values,
        origin="lower",
        aspect="auto",
        extent=(image.x[0], image.x[-1], image.y[0], image.y[-1]),
        vmin=image.low,
        vmax=image.high,
        cmap="viridis",
        interpolation="nearest",
    )
    axis.grid(visible=False)
    bar = axis.figure.colorbar(shown, ax=axis, pad=0.02)
    bar.set_label(image.label)
