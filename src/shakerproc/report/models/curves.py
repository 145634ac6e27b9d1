"""Curves of models: displacement over clearances, responses with folds, panels of studies."""

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.models import Sensor
from shakerproc.models.coordinates import coordinates_of
from shakerproc.numerals import numeral
from shakerproc.planning import (
    AbstractInput,
    AbstractJoint,
    FreeJoint,
    PlannedTest,
    RandomInput,
    ShakerLimits,
    SineInput,
    curve,
    frequencies_of,
)
from shakerproc.report.figures import style
from shakerproc.simulation.harmonic_balance import (
    Backbone,
    Branch,
    Response,
    peaks,
    sensor_harmonics,
    sensors_of_model,
)
from shakerproc.studies.results import StudyImage, StudyLine, StudyPanel, StudyResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


MOST: Final = 14
"""Levels of each kind that are told apart in the legend."""
CLOSE: Final = 1.45
"""Ratio of two plays below which their labels would overlap [-]."""


def plan_figure(
    plans: Sequence[PlannedTest],
    joint: AbstractJoint,
    limits: ShakerLimits,
    title: str,
) -> "Figure":
    """Return the table's displacement, and with a model that of the joint, over frequency.

    Solid: amplitude of sines at one level. Dashed: 3 sigma of what random motion has above a
    frequency. Horizontal: half the play, where a part is met on both sides.
    """
    shaken = [planned.shaken for planned in plans if planned.shaken is not None]
    inputs = [
        *_levels([one for one in shaken if isinstance(one, SineInput)]),
        *_levels([one for one in shaken if isinstance(one, RandomInput)]),
    ]
    of_base = [one for one in inputs if one.quantity == "base acceleration"]
    with_model = not isinstance(joint, FreeJoint)
    rows = int(bool(of_base)) + int(with_model)
    figure, axes = style.figure(7.6, 0.6 + 3.6 * max(rows, 1), max(rows, 1), sharex=True)
    for axis in axes:  # room for the legend
        place = axis.get_position()
        axis.set_position((place.x0, place.y0, 0.83 - place.x0, place.height))
    panels = list(axes)
    if of_base or not with_model:
        axis = panels.pop(0)
        _draw_displacement(axis, of_base, FreeJoint())
        _draw_limits(axis, limits, of_base)
        _draw_plays(axis, _half_plays(plans))
        axis.set_ylabel("displacement of the table [mm]")
        _clearance_legend(axis)
    if with_model:
        axis = panels.pop(0)
        _draw_displacement(axis, inputs, joint)
        _draw_plays(axis, _free_plays(plans))
        axis.set_ylabel("relative displacement of the joint [mm]")
        _clearance_legend(axis)
    axes[0].set_title(title)
    axes[-1].set_xlabel("frequency [Hz]")
    return figure


def _levels(inputs: Sequence[AbstractInput]) -> list[AbstractInput]:
    """Return one input for each level, over all of its bands, lowest level first."""
    merged: dict[tuple[str, float], AbstractInput] = {}
    for one in inputs:
        key = one.quantity, float(f"{_size(one):.9g}")
        other = merged.get(key)
        low = min(one.low, other.low) if other else one.low
        high = max(one.high, other.high) if other else one.high
        merged[key] = type(one)(_size(one), low, high, one.quantity)  # type: ignore[call-arg]
    return [merged[key] for key in sorted(merged)]


def _size(one: AbstractInput) -> float:
    return one.amplitude if isinstance(one, SineInput) else one.density  # type: ignore[attr-defined]


def _draw_displacement(
    axis: "Axes", inputs: Sequence[AbstractInput], joint: AbstractJoint
) -> None:
    from matplotlib import colormaps

    for kind in (SineInput, RandomInput):
        alike = [one for one in inputs if isinstance(one, kind)]
        for i, one in enumerate(alike):
            frequency, height = _curve(joint, one)
            axis.loglog(
                frequency,
                1e3 * height,
                color=colormaps["viridis"](0.9 * (1.0 - i / max(len(alike) - 1, 1))),
                linestyle="-" if kind is SineInput else (0, (4, 2)),
                marker="o" if one.low == one.high else None,
                markersize=4.0,
                linewidth=1.3,
                label=_label(one) if i < MOST else None,
            )


def _curve(joint: AbstractJoint, one: AbstractInput) -> tuple[FloatArray, FloatArray]:
    frequency = frequencies_of(joint, one.low, one.high)
    if isinstance(one, RandomInput):
        frequency = frequency[frequency < 0.98 * one.high]
    return frequency, curve(joint, one, frequency)


def _label(one: AbstractInput) -> str:
    of_base = one.quantity == "base acceleration"
    scale, unit = (STANDARD_GRAVITY, "g") if of_base else (1.0, "N")
    if isinstance(one, SineInput):
        return f"{numeral(one.amplitude / scale)} {unit}"
    return f"{numeral(_size(one) / scale**2)} {unit}²/Hz"


def _draw_limits(axis: "Axes", limits: ShakerLimits, inputs: Sequence[AbstractInput]) -> None:
    if not limits.known or not inputs:
        return
    low, high = min(one.low for one in inputs), max(one.high for one in inputs)
    inside = [f for f in limits.crossovers() if low < f < high]
    frequency = np.union1d(np.geomspace(low, 1.001 * high, 50), inside)
    most = 1e3 * limits.largest_acceleration(frequency) / (2.0 * np.pi * frequency) ** 2
    bottom, top = axis.get_ylim()
    axis.fill_between(frequency, most, 1e6, color="#d55e00", alpha=0.10, linewidth=0.0)
    axis.plot(frequency, most, color="#d55e00", linewidth=1.8, label="shaker")
    axis.set_ylim(bottom, max(top, 2.0 * float(np.max(most))))


def _half_plays(plans: Sequence[PlannedTest]) -> list[float]:
    plays = [planned.travel.play for planned in plans if planned.travel is not None]
    return [play.half for play in plays if play is not None and play.total > 0.0]


def _free_plays(plans: Sequence[PlannedTest]) -> list[float]:
    walls = [planned.walls for planned in plans if planned.walls is not None]
    return [side for one in walls for side in (one.positive, one.negative) if np.isfinite(side)]


def _draw_plays(axis: "Axes", heights: Sequence[float]) -> None:
    microns = sorted({round(1e6 * value, 1) for value in heights})
    for height in microns:
        axis.axhline(1e-3 * height, color="black", linewidth=0.9, linestyle=":")
    for group in _close(microns):
        axis.text(
            0.99,
            1e-3 * group[-1],
            f"play ±{', '.join(f'{height:g}' for height in group)} µm",
            transform=axis.get_yaxis_transform(),
            ha="right",
            va="bottom",
            fontsize=7.5,
        )


def _close(heights: Sequence[float]) -> list[list[float]]:
    """Return rising heights in groups whose labels would overlap."""
    groups: list[list[float]] = []
    for height in heights:
        if groups and height < CLOSE * groups[-1][-1]:
            groups[-1].append(height)
        else:
            groups.append([height])
    return groups


def _clearance_legend(axis: "Axes") -> None:
    if axis.get_legend_handles_labels()[0]:
        axis.legend(
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),
            borderaxespad=0.0,
            title="solid: amplitude\ndashed: 3σ of all\nabove a frequency",
            title_fontsize=7.5,
        )


SIGNS: Final = {
    "fold": ("^", "fold"),
    "period doubling": ("s", "period doubling"),
    "branch point": ("o", "symmetry or branch point"),
    "quasi-periodic": ("D", "quasi-periodic"),
}
SHOWN: Final = {
    "acceleration": "acceleration",
    "displacement": "displacement",
    "velocity": "velocity",
    "relative displacement": "displacement against the base",
    "relative velocity": "velocity against the base",
    "force": "force",
}
HARMONICS: Final = 5
"""How many harmonics the lower panel shows."""


def response_figure(
    response: Response,
    others: tuple[Branch, ...] = (),
    free: Backbone | None = None,
    name: str | None = None,
) -> "Figure":
    """Return the response of one sensor: its peak, and the harmonics of the main curve.

    Parameters
    ----------
    response : Response
        The curve.
    others : tuple of Branch
        Further branches.
    free : Backbone, optional
        Drawn where the sensor measures a displacement against the base.
    name : str, optional
        Which sensor; the first one by default.
    """
    sensors = sensors_of_model(response.model)
    chosen = name or next(iter(sensors))
    sensor = sensors[chosen]
    figure, (upper, lower) = style.figure(7.0, 5.6, 2, sharex=True)
    main = max(response.branches, key=lambda branch: np.ptp(branch.frequency))
    for branch in response.branches:
        _draw_branch(upper, response, branch, sensor, 0)
    for branch in others:
        _draw_branch(upper, response, branch, sensor, _colour(branch))
    if free is not None and sensor.measures == "relative displacement":
        _draw_backbone(upper, response, free, sensor)
    _draw_signs(upper, response, (*response.branches, *others), sensor)
    _draw_harmonics(lower, response, main, sensor)
    quantity = SHOWN[sensor.measures]
    unit = response.model.sensor_unit(sensor).replace("^2", "²")
    upper.set_title(f"{response.model.title}: {chosen}, {_level(response)}")
    upper.set_ylabel(f"peak {quantity} [{unit}]")
    lower.set_ylabel(f"harmonics [{unit}]")
    lower.set_xlabel("frequency of the excitation [Hz]")
    lower.set_xlim(*response.band)
    with_backbone = free is not None and sensor.measures == "relative displacement"
    _legend(upper, others, backbone=with_backbone)
    return figure


def _level(response: Response) -> str:
    unit = response.model.drive_unit
    what = "base" if response.model.excitation.on is None else "force"
    in_g = f" ({numeral(response.level / STANDARD_GRAVITY)} g)" if unit == "m/s^2" else ""
    return f"{what} {numeral(response.level, 4)} {unit.replace('^2', '²')}{in_g}"


def _values(response: Response, branch: Branch, sensor: Sensor) -> FloatArray:
    return peaks(branch, sensor_harmonics(response.model, response.level, branch, sensor))


def _draw_branch(
    axis: "Axes", response: Response, branch: Branch, sensor: Sensor, colour: int
) -> None:
    height = _values(response, branch, sensor)
    for part, stable in _parts(branch.stable):
        x, y = _smooth(branch.frequency[part], height[part])
        axis.semilogy(
            x,
            y,
            color=style.COLOURS[colour],
            linestyle="-" if stable else (0, (3, 2)),
            linewidth=1.5 if stable else 1.1,
        )


def _colour(branch: Branch) -> int:
    return 1 + (branch.balance.order - 1) % 5


def _parts(stable: NDArray[np.bool_]) -> Iterator[tuple[slice, bool]]:
    """Yield stretches of points alike, each with the first point of the next."""
    edges = [0, *(np.flatnonzero(np.diff(stable)) + 1), stable.size]
    for start, stop in pairwise(edges):
        yield slice(int(start), min(int(stop) + 1, stable.size)), bool(stable[start])


def _smooth(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a curve through points in order, drawn fine by its length on log paper."""
    if x.size < 3:
        return x, y
    logs = np.log(x), np.log(np.maximum(y, 1e-300))
    steps = np.hypot(*(np.diff(log) for log in logs))
    length = np.concatenate([[0.0], np.cumsum(np.maximum(steps, 1e-12))])
    fine = np.interp(
        np.linspace(0.0, x.size - 1.0, 8 * (x.size - 1) + 1), np.arange(x.size), length
    )
    smooth = [np.exp(PchipInterpolator(length, log)(fine)) for log in logs]
    return smooth[0], smooth[1]


def _draw_backbone(axis: "Axes", response: Response, free: Backbone, sensor: Sensor) -> None:
    moved = np.tensordot(
        free.coefficients, coordinates_of(response.model).at(sensor.at), axes=(1, 0)
    )
    size = np.sum(np.abs(moved), axis=-1)
    inside = (free.frequency > response.band[0]) & (free.frequency < response.band[1])
    low, high = axis.get_ylim()
    axis.semilogy(free.frequency[inside], size[inside], color="#767676", ls=":", lw=1.3)
    axis.set_ylim(low, high)


def _draw_signs(
    axis: "Axes", response: Response, branches: tuple[Branch, ...], sensor: Sensor
) -> None:
    for kind, (sign, _) in SIGNS.items():
        x: list[float] = []
        y: list[float] = []
        for branch in branches:
            height = _values(response, branch, sensor)
            marks = [mark for mark in branch.marks if mark.kind == kind]
            x += [mark.frequency for mark in marks]
            y += [float(height[mark.index]) for mark in marks]
        if x:
            axis.semilogy(x, y, sign, ms=4.5, mfc="white", mec="black", mew=0.9, ls="none")


def _draw_harmonics(axis: "Axes", response: Response, branch: Branch, sensor: Sensor) -> None:
    amplitudes = np.abs(sensor_harmonics(response.model, response.level, branch, sensor))
    orders = branch.balance.harmonics / branch.balance.order
    shown = np.flatnonzero(orders > 0.0)[:HARMONICS]
    for style_number, column in enumerate(shown):
        if np.any(amplitudes[:, column] > 0.0):
            axis.semilogy(
                branch.frequency,
                np.where(amplitudes[:, column] > 0.0, amplitudes[:, column], np.nan),
                label=f"{orders[column]:g}",
                **style.line(style_number),
            )
    top = float(np.max(amplitudes[:, shown]))
    axis.set_ylim(1e-4 * top, 2.0 * top)
    axis.legend(title="harmonic", ncols=HARMONICS, loc="upper right")


def _legend(axis: "Axes", others: tuple[Branch, ...], *, backbone: bool) -> None:
    from matplotlib.lines import Line2D

    lines = [
        Line2D([], [], color=style.COLOURS[0], lw=1.5, label="stable"),
        Line2D([], [], color=style.COLOURS[0], lw=1.1, ls=(0, (3, 2)), label="unstable"),
    ]
    for order in sorted({branch.balance.order for branch in others}):
        label = f"1/{order} subharmonic" if order > 1 else "asymmetric"
        colour = next(_colour(branch) for branch in others if branch.balance.order == order)
        lines.append(Line2D([], [], color=style.COLOURS[colour], lw=1.5, label=label))
    if backbone:
        lines.append(Line2D([], [], color="#767676", ls=":", label="backbone"))
    lines += [
        Line2D([], [], marker=sign, mfc="white", mec="black", ms=4.5, ls="none", label=label)
        for sign, label in SIGNS.values()
    ]
    axis.legend(handles=lines, ncols=2, loc="best")


LOOKS: Final = {"line": "-", "dashed": (0, (4, 2)), "dotted": ":", "marked": "-", "points": ""}
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X", "*")
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
    subfigures = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)
    return [row[0] for row in subfigures]


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
    sign = MARKERS[line.style % len(SIGNS)] if line.look == "marked" else None
    return {
        "color": colour,
        "linestyle": LOOKS[line.look],
        "linewidth": 1.2,
        "marker": sign,
        "ms": 4.0,
        "label": line.label or None,
    }


def _limit_decades(axis: "Axes", panel: StudyPanel) -> None:
    """Limit an axis to ten decades below its top: smaller values are rounding."""
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
