"""The figures of a run on the page."""

from dataclasses import replace
from typing import Final

from markupsafe import Markup

from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Figure, Plot
from shakerproc.report.page.drawing import Drawing
from shakerproc.report.runs.curves import STILL, kept
from shakerproc.report.runs.figures import FIGURES, ON_PAGE
from shakerproc.runs.summary import RunSummary

MOST: Final = 230
"""Height of a figure at most [px]."""

TOGETHER: Final = 250
"""Height of figures above each other, all together, where they have room in it [px]."""

LEAST: Final = 60
"""Height of one of them at least [px]."""

LABEL: Final = 28
"""Height of the numbers and the label of the lowest [px]."""


def figures(run: RunSummary) -> list[Drawing]:
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


def marked(drawing: Drawing, run: RunSummary) -> Drawing:
    """Return a drawing that says so where the recording was cut short."""
    if not run.incomplete:
        return drawing
    told = run.told_status.replace("incomplete,", "INCOMPLETE:")
    return replace(drawing, caption=f"{drawing.caption} {told}.")


def _drawings(figure: Figure, test: str) -> list[Drawing]:
    """Return a drawing for each plot of a figure, or one of all above each other."""
    if not figure.together:
        return [_titled(plot, _drawn(plot, test)) for plot in figure.plots]
    *above, last = figure.plots
    tall = max(LEAST, TOGETHER // len(figure.plots))
    still = 2 * STILL // len(figure.plots)  # of a shared figure each has its part
    parts = [_drawn(_without_label(plot), test, (tall, still), keys=False) for plot in above]
    names = to_svg.legend([item for plot in figure.plots for item in plot.items])
    drawn = Markup("").join((
        *parts,
        _drawn(last, test, (tall + LABEL, still), keys=False),
        names,
    ))
    return [_titled(figure.plots[0], drawn)]


def _titled(plot: Plot, drawn: Markup) -> Drawing:
    return Drawing(f"{plot.title}.", plot.caption, drawn, kind=plot.kind)


def _drawn(
    plot: Plot, test: str, most: tuple[int, int] = (MOST, STILL), *, keys: bool = True
) -> Markup:
    """Return a drawing; `most` are its height [px] and the points of a line that it has."""
    tall, points = most
    height = min(tall, round(58 + 80 * plot.height))
    title = f"{plot.title or plot.channel} of test {test}"
    return to_svg.plot(plot, most=points, title=title, height=height, keys=keys)


def _without_label(plot: Plot) -> Plot:
    return replace(plot, x=Axis("", plot.x.low, plot.x.high))
