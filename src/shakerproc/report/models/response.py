"""Response curves: stable solid, unstable dashed, folds marked, backbone dotted."""

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.models import Sensor
from shakerproc.models.coordinates import coordinates_of
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.simulation.harmonic_balance import (
    Backbone,
    Branch,
    Response,
    peaks,
    sensor_harmonics,
    sensors_of_model,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    found = [np.exp(PchipInterpolator(length, log)(fine)) for log in logs]
    return found[0], found[1]


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
    found = np.abs(sensor_harmonics(response.model, response.level, branch, sensor))
    orders = branch.balance.harmonics / branch.balance.order
    shown = np.flatnonzero(orders > 0.0)[:HARMONICS]
    for style_number, column in enumerate(shown):
        if np.any(found[:, column] > 0.0):
            axis.semilogy(
                branch.frequency,
                np.where(found[:, column] > 0.0, found[:, column], np.nan),
                label=f"{orders[column]:g}",
                **style.line(style_number),
            )
    top = float(np.max(found[:, shown]))
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
