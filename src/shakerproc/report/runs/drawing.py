"""Figures of a run as PNG and on the page, and samples of a recording against time."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from markupsafe import Markup

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.report.figures import style, to_png, to_svg
from shakerproc.report.figures.figure import Axis, Figure, Plot
from shakerproc.report.figures.to_png import LEFT
from shakerproc.report.figures.units import USUAL, read_unit
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.runs.figures import FIGURES, IN_FILES, ON_PAGE
from shakerproc.report.runs.in_units import (
    STILL,
    RunContent,
    content_of_summary,
    curve_in,
    run_in,
    surface_in,
)
from shakerproc.runs.panels import Envelope, envelope
from shakerproc.runs.result import RunResult
from shakerproc.runs.summarising import curves_of, numbers_of, surface_of
from shakerproc.runs.summary import RunSummary
from shakerproc.testlog import facts_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as MatplotlibFigure


def draw_run(result: RunResult, title: str, folder: Path) -> list[Path]:
    """Draw every figure that a run has, and return the files."""
    content = _content(result)
    written = []
    for name in IN_FILES:
        picture = _matplotlib_figure(content, name, title)
        if picture is not None:
            written.append(to_png.save(picture, folder / f"{name}.png"))
    return written


def run_figure(result: RunResult, name: str, title: str) -> "MatplotlibFigure | None":
    """Return one figure of a run, None where the run lacks its curves."""
    return _matplotlib_figure(_content(result), name, title)


def _content(result: RunResult) -> RunContent:
    numbers = numbers_of(result, str(result.test.id), facts_of(result.test))
    curves = [curve_in(curve, numbers, USUAL) for curve in curves_of(result)]
    surface = surface_of(result)
    return RunContent(run_in(numbers, USUAL), curves, surface and surface_in(surface, USUAL))


def _matplotlib_figure(content: RunContent, name: str, title: str) -> "MatplotlibFigure | None":
    figure = FIGURES[name](content)
    if figure is None:
        return None
    run = content.run
    alarm = run.status_text.replace("incomplete,", "INCOMPLETE:") if run.incomplete else ""
    return to_png.matplotlib_figure(figure, title, alarm)


MOST: Final = 230
"""Height of a figure at most [px]."""

TOGETHER: Final = 250
"""Height of figures above each other, all together, where they have room in it [px]."""

LEAST: Final = 60
"""Height of one of them at least [px]."""

LABEL: Final = 28
"""Height of the numbers and the label of the lowest [px]."""


def page_figures(run: RunSummary) -> list[PageFigure]:
    """Return the drawings of a run: of the curves that its summary keeps."""
    if not run.channels:
        return []
    content = content_of_summary(run)
    described = (FIGURES[name](content) for name in ON_PAGE)
    return [
        marked(drawing, run)
        for figure in described
        if figure is not None
        for drawing in _drawings(figure, run.test)
    ]


def marked(drawing: PageFigure, run: RunSummary) -> PageFigure:
    """Return a drawing that says so where the recording was cut short."""
    if not run.incomplete:
        return drawing
    text = run.status_text.replace("incomplete,", "INCOMPLETE:")
    return replace(drawing, caption=f"{drawing.caption} {text}.")


def _drawings(figure: Figure, test: str) -> list[PageFigure]:
    """Return a drawing for each plot of a figure, or one of all above each other."""
    if not figure.together:
        return [_titled(plot, _svg(plot, test)) for plot in figure.plots]
    *above, last = figure.plots
    tall = max(LEAST, TOGETHER // len(figure.plots))
    still = 2 * STILL // len(figure.plots)  # of a shared figure each has its part
    parts = [_svg(_without_label(plot), test, (tall, still), keys=False) for plot in above]
    names = to_svg.legend([item for plot in figure.plots for item in plot.items])
    drawn = Markup("").join((
        *parts,
        _svg(last, test, (tall + LABEL, still), keys=False),
        names,
    ))
    return [_titled(figure.plots[0], drawn)]


def _titled(plot: Plot, drawn: Markup) -> PageFigure:
    return PageFigure(f"{plot.title}.", plot.caption, drawn, kind=plot.kind)


def _svg(
    plot: Plot, test: str, most: tuple[int, int] = (MOST, STILL), *, keys: bool = True
) -> Markup:
    """Return a drawing; `most` are its height [px] and the points of a line that it has."""
    tall, points = most
    height = min(tall, round(58 + 80 * plot.height))
    title = f"{plot.title or plot.channel} of test {test}"
    return to_svg.plot(plot, most=points, title=title, height=height, keys=keys)


def _without_label(plot: Plot) -> Plot:
    return replace(plot, x=Axis("", plot.x.low, plot.x.high))


def time_signals(recording: Recording) -> "MatplotlibFigure":
    """Return every channel against time: the extremes of each of some thousand slices."""
    extremes = envelope(recording.blocks(), recording.n_samples, recording.sample_rate)
    named = []
    for channel in recording.channels:
        unit, factor = read_unit(channel.unit)
        named.append((channel.name, unit, factor))
    return _drawn(recording.run, extremes, named, recording.duration)


def signals(
    title: str, time: FloatArray, named: Sequence[tuple[str, str, FloatArray]]
) -> "MatplotlibFigure":
    """Return signals against time, likewise.

    Parameters
    ----------
    title : str
        Headline.
    time : (n,) array
        From 0 in equal steps [s].
    named : sequence of (str, str, (n,) array)
        Name, unit and samples of each.
    """
    rate = (time.size - 1) / float(time[-1]) if time.size > 1 else 1.0
    rows = np.stack([samples for _, _, samples in named])
    extremes = envelope([rows], time.size, rate)
    return _drawn(
        title,
        extremes,
        [(name, *USUAL.unit(unit)) for name, unit, _ in named],
        time.size / rate,
    )


def _drawn(
    title: str, extremes: Envelope, named: Sequence[tuple[str, str, float]], duration: float
) -> "MatplotlibFigure":
    n = len(named)
    with style.look():
        figure, axes = style.figure(
            7.0, 0.5 + 0.85 * n, n, sharex=True, left=LEFT, legend=False
        )
        for i, (axis, (name, unit, factor)) in enumerate(zip(axes, named, strict=True)):
            low, high = extremes.low[i] * factor, extremes.high[i] * factor
            axis.fill_between(extremes.time, low, high, color=style.COLOURS[0], lw=0.5)
            style.name(axis, name)
            axis.set_ylabel(f"[{unit}]")
        style.head(axes[0], title, f"{numeral(duration, 4)} s", legend=False)
        axes[-1].set_xlabel("time [s]")
        axes[-1].set_xlim(0.0, duration)
    return figure
