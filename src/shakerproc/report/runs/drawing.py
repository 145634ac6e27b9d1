"""The figures of one run, drawn from one description: as PNG files and as SVG on the page."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from markupsafe import Markup

from shakerproc.report.figures import to_png, to_svg
from shakerproc.report.figures.figure import Axis, Figure, Plot
from shakerproc.report.figures.units import USUAL
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.runs.curves import STILL, RunContent, kept
from shakerproc.report.runs.figures import FIGURES, IN_FILES, ON_PAGE
from shakerproc.report.runs.in_units import curve_in, run_in, surface_in
from shakerproc.runs.curves import curves_of, surface_of
from shakerproc.runs.result import RunResult
from shakerproc.runs.summarising import numbers_of
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
    """Return one figure of a run, None where the run has not got what is drawn there."""
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
    alarm = run.told_status.replace("incomplete,", "INCOMPLETE:") if run.incomplete else ""
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
    content = kept(run)
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
    told = run.told_status.replace("incomplete,", "INCOMPLETE:")
    return replace(drawing, caption=f"{drawing.caption} {told}.")


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
