"""The figures of the analyses that a log asks for, as files and on the page."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot, unwrapped_line
from shakerproc.report.figures.to_png import LEFT, drawable, save
from shakerproc.report.figures.units import USUAL
from shakerproc.report.page.sections import PageFigure
from shakerproc.report.runs.in_units import panel_in
from shakerproc.runs.panels import Look, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult
from shakerproc.runs.summary import LineSummary, PanelSummary, RunSummary

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STILL: Final = 240
"""Points of a line in a still figure of the page."""

DECADES: Final = 7
"""Decades below the largest value that a logarithmic axis shows at most."""

PAGE_BOX: Final = (484, 188)
"""Width and height of the axes of a figure of the page [px]."""

PRINTED: Final[Mapping[str, str]] = {
    "shock": "shock", "sine": "dwell", "sine on random": "tones", "multisine": "multisine",
    "free decay": "decays", "hammer": "resonances",
}  # fmt: skip
"""The analysis that a test is made for, by its excitation: paper has no room for every one."""

NAME_ROOM: Final = (0.1, 0.035)
"""Room of a name in letters of 6.5 pt in a figure of 7 by 4 in, as shares of the axes [-]."""

LIMITS: Final[Mapping[Look, tuple[str, str, float]]] = {
    "demand": ("#000000", "--", 1.2),
    "alarm": ("#e69f00", "-", 1.0),
    "abort": ("#a62b00", "-", 1.0),
    "paper": ("#cccccc", "-", 0.5),
}
"""Colour, dash and width [pt] of what is no measurement."""

PAGE_STYLES: Final[Mapping[Look, int]] = {
    "demand": 7, "alarm": style.ALARM_STYLE, "abort": style.ABORT_STYLE, "paper": 7,
}  # fmt: skip
"""Colour of the same on the page."""


def draw_analyses(result: RunResult, title: str, folder: Path) -> list[Path]:
    """Draw every figure of the analyses of a run, and return the files."""
    roles = [c.role or "response" for c in result.channels]
    chosen = _chosen([c.name for c in result.channels], roles)
    written = []
    for panel in (panel for one in result.analyses for panel in one.panels):
        with style.look():
            figure = draw_panel(panel_in(panel, USUAL), title, chosen)
        written.append(save(figure, folder / f"{panel.name}.png"))
    return written


def _chosen(names: Sequence[str], roles: Sequence[str]) -> dict[str, int]:
    return dict(zip(names, style.styles(roles), strict=True))


def draw_panel(panel: Panel, title: str, chosen: Mapping[str, int]) -> "Figure":
    """Return one figure; call it inside `style.look`."""
    figure, (axis,) = style.figure(7.0, 4.0, left=LEFT)
    for line in panel.lines:
        how = _how(line, chosen)
        label = line.label if line.label and line.look != "paper" else "_"
        drawn = unwrapped_line(_curve(line, chosen), _y_axis(panel.y, 0.0, 1.0))
        axis.plot(
            drawn.x, drawable(drawn.y, logarithmic=panel.y.logarithmic), label=label, **how
        )
    x_low, x_high = _ends([line.x for line in panel.lines], panel.x)
    y_low, y_high = limits(panel.lines, panel.y)
    if panel.equal:
        axis.set_aspect("equal", adjustable="datalim")
    else:
        axis.set_xlim(x_low, x_high)
        axis.set_ylim(y_low, y_high)
    if panel.x.logarithmic:
        _logarithmic_x(axis)
    if panel.y.logarithmic:
        style.logarithmic(axis, y_low, y_high)
    named: list[tuple[float, float]] = []
    for line in panel.lines:
        if line.look == "paper" and line.label:
            _name_on_paper(axis, line, (x_low, x_high), (y_low, y_high), named)
    axis.set_xlabel(panel.x.label)
    axis.set_ylabel(panel.y.label)
    style.head(axis, title, panel.title)
    style.legend(axis)
    return figure


def _how(line: PanelLine, chosen: Mapping[str, int]) -> dict[str, Any]:
    if line.look == "curve":
        return {**style.line(chosen.get(line.channel, line.style)), "zorder": 2.5}
    colour, dash, width = LIMITS[line.look]
    return {"color": colour, "linestyle": dash, "linewidth": width}


def _logarithmic_x(axis: "Axes") -> None:
    """Make the horizontal axis logarithmic with plain numbers, 1, 2 and 5 of a decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    axis.set_xscale("log")
    low, high = axis.get_xlim()
    subs = (1.0, 2.0, 5.0) if high / low <= 2e4 else (1.0,)
    axis.xaxis.set_major_locator(LogLocator(subs=subs, numticks=20))
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.xaxis.set_minor_locator(NullLocator())


def _name_on_paper(
    axis: "Axes",
    line: PanelLine,
    x_ends: tuple[float, float],
    y_ends: tuple[float, float],
    named: list[tuple[float, float]],
) -> None:
    """Write the name of a line of the paper along it, beside those that are `named` already."""
    inside = (line.x >= x_ends[0]) & (line.x <= x_ends[1])
    inside &= (line.y >= y_ends[0] * 1.1) & (line.y <= y_ends[1] / 1.3)
    if not inside.any():
        return
    shares = np.array([
        np.log(values / low) / np.log(high / low)
        for values, (low, high) in ((line.x[inside], x_ends), (line.y[inside], y_ends))
    ]).T
    free = [
        all(np.any(np.abs(place - other) > NAME_ROOM) for other in named) for place in shares
    ]
    if not any(free):
        return
    last = int(np.flatnonzero(free)[-1])
    named.append(tuple(shares[last]))
    i = int(np.flatnonzero(inside)[last])
    axis.annotate(
        line.label,
        (line.x[i], line.y[i]),
        xytext=(-2, 2),
        textcoords="offset points",
        ha="right",
        fontsize=6.5,
        color="#777777",
    )


def _ends(rows: Sequence[FloatArray], scale: PanelScale) -> tuple[float, float]:
    values = np.concatenate([*rows, np.zeros(0)])
    values = values[np.isfinite(values) & ((values > 0.0) | (not scale.logarithmic))]
    if not values.size:
        return (0.1, 1.0)
    low, high = float(values.min()), float(values.max())
    if low < high:
        return low, high
    half = 0.5 * abs(low) or 1.0  # a flat line, or a point, in the middle
    return (0.5 * low, 2.0 * low) if scale.logarithmic else (low - half, low + half)


def limits(lines: Sequence[PanelLine], scale: PanelScale) -> tuple[float, float]:
    """Return the ends of the vertical axis: those that are fixed, whole decades, or room."""
    if scale.ends is not None:
        return scale.ends
    low, high = _ends([line.y for line in lines if line.look != "paper"], scale)
    if not scale.logarithmic:
        room = 0.05 * (high - low)
        return low - room, high + room
    top = np.ceil(np.log10(high) - 1e-9)
    bottom = max(np.floor(np.log10(low) + 1e-9), top - DECADES)
    return float(10.0**bottom), float(10.0 ** max(top, bottom + 1.0))


def is_printed(kind: str, run: RunSummary) -> bool:
    """Return whether an analysis is printed: its test was made for it, or is judged by it."""
    return kind == "profile" or kind == PRINTED.get(str(run.facts.get("excitation")))


def page_figures(run: RunSummary) -> list[PageFigure]:
    """Return the figures of the analyses of a run for the page."""
    chosen = _chosen([c.name for c in run.channels], [c.role for c in run.channels])
    return [
        replace(
            drawing(_panel(panel), f"{panel.title} of test {run.test}", chosen),
            paper=is_printed(one.kind, run),
        )
        for one in run.analyses
        for panel in one.panels
    ]


def drawing(panel: Panel, title: str, chosen: Mapping[str, int]) -> PageFigure:
    """Return a figure for the page; `title` is for who cannot see it."""
    lines = panel.lines
    x_low, x_high = _ends([line.x for line in lines], panel.x)
    y_low, y_high = limits(lines, panel.y)
    if panel.equal:
        (x_low, x_high), (y_low, y_high) = _equal((x_low, x_high), (y_low, y_high))
    return PageFigure(
        f"{panel.title}.",
        panel.caption,
        to_svg.plot(
            Plot(
                [_curve(line, chosen) for line in lines],
                Axis(panel.x.label, x_low, x_high, logarithmic=panel.x.logarithmic),
                _y_axis(panel.y, y_low, y_high),
            ),
            most=STILL,
            title=title,
        ),
    )


def _y_axis(scale: PanelScale, low: float, high: float) -> Axis:
    degrees = scale.label.endswith("[°]")
    return Axis(scale.label, low, high, logarithmic=scale.logarithmic, degrees=degrees)


def _equal(
    x: tuple[float, float], y: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return wider ends of two axes, so that a unit is as long along both on the page."""
    scale = max((x[1] - x[0]) / PAGE_BOX[0], (y[1] - y[0]) / PAGE_BOX[1])
    middles = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]))
    wide, high = (
        (middle - 0.52 * scale * size, middle + 0.52 * scale * size)
        for middle, size in zip(middles, PAGE_BOX, strict=True)
    )
    return wide, high


def _panel(panel: PanelSummary) -> Panel:
    lines = tuple(_line(line) for line in panel.lines)
    return Panel("", panel.title, panel.caption, panel.x, panel.y, lines, equal=panel.equal)


def _line(line: LineSummary) -> PanelLine:
    y = np.array([np.nan if v is None else v for v in line.y], dtype=float)
    return PanelLine(
        line.label, np.array(line.x, dtype=float), y, line.channel, line.look, line.style
    )


def _curve(line: PanelLine, chosen: Mapping[str, int]) -> Curve:
    if line.look == "curve":
        return Curve(line.label, line.x, line.y, chosen.get(line.channel, line.style))
    label = "" if line.look == "paper" else line.label
    return Curve(label, line.x, line.y, PAGE_STYLES[line.look], thin=True)
