"""The figures of one run as files: time with crop, densities, responses, coherence, notch."""

from pathlib import Path
from typing import TYPE_CHECKING

from shakerproc.report.figures import to_png
from shakerproc.report.figures.units import USUAL
from shakerproc.report.runs.curves import RunContent
from shakerproc.report.runs.figures import FIGURES, IN_FILES
from shakerproc.report.runs.in_units import curve_in, run_in, surface_in
from shakerproc.runs.curves import curves_of, surface_of
from shakerproc.runs.result import RunResult
from shakerproc.runs.summarising import numbers_of
from shakerproc.testlog import facts_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def draw_run(result: RunResult, title: str, folder: Path) -> list[Path]:
    """Draw every figure that a run has, and return the files."""
    content = _content(result)
    written = []
    for name in IN_FILES:
        picture = _drawn(content, name, title)
        if picture is not None:
            written.append(to_png.save(picture, folder / f"{name}.png"))
    return written


def run_figure(result: RunResult, name: str, title: str) -> "Figure | None":
    """Return one figure of a run, None where the run has not got what is drawn there."""
    return _drawn(_content(result), name, title)


def _content(result: RunResult) -> RunContent:
    numbers = numbers_of(result, str(result.test.id), facts_of(result.test))
    curves = [curve_in(curve, numbers, USUAL) for curve in curves_of(result)]
    surface = surface_of(result)
    return RunContent(run_in(numbers, USUAL), curves, surface and surface_in(surface, USUAL))


def _drawn(content: RunContent, name: str, title: str) -> "Figure | None":
    figure = FIGURES[name](content)
    if figure is None:
        return None
    run = content.run
    alarm = run.told_status.replace("incomplete,", "INCOMPLETE:") if run.incomplete else ""
    return to_png.drawn(figure, title, alarm)
