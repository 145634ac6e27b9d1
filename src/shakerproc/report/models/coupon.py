"""Coupons drawn: modes as maps, frequencies over the clamp, and tensile runs of joints."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from shakerproc.exchange.tensile import JointStiffness, TensileRun
from shakerproc.finite_elements.annular_meshes import NamedMode
from shakerproc.finite_elements.annular_plate import mindlin_modes
from shakerproc.finite_elements.coupon import Coupon
from shakerproc.report.figures import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ACROSS = 3
"""Modes in a row."""


def name_of(diameters: int, circles: int) -> str:
    """Return how a mode is called."""
    lines = f"{diameters} nodal diameter{'s' if diameters != 1 else ''}"
    return f"{lines}, {circles} circle{'s' if circles != 1 else ''}"


def mode_shapes(coupon: Coupon, modes: Sequence[NamedMode], title: str) -> "Figure":
    """Return a map of the deflection of each mode; nodal lines black, the clamp hatched."""
    from matplotlib.figure import Figure

    rows = -(-len(modes) // ACROSS)
    height = 0.95 + 2.55 * rows
    figure = Figure(figsize=(7.4, height))
    grid = {"left": 0.02, "right": 0.98, "top": 1.0 - 0.62 / height, "bottom": 0.42 / height}
    axes = figure.subplots(rows, ACROSS, squeeze=False, gridspec_kw=grid | {"hspace": 0.22})
    figure.text(0.02, 1.0 - 0.2 / height, title, fontsize=10)
    for axis in axes.flat:
        axis.set_axis_off()
    for axis, mode in zip(axes.flat, modes, strict=False):
        _draw(axis, coupon, mode)
    figure.text(
        0.02,
        0.12 / height,
        "deflection out of plane, largest = 1: red towards the eye, blue away; "
        "nodal lines black; hatched: clamped",
        fontsize=8,
    )
    return figure


def _draw(axis: "Axes", coupon: Coupon, mode: NamedMode) -> None:
    from matplotlib.patches import Circle

    solved = mindlin_modes(coupon, mode.diameters, mode.circles + 1)
    radius, angle = 1e3 * solved.radius[::2], np.linspace(0.0, 2.0 * np.pi, 181)
    shape = solved.shapes[mode.circles, ::2]
    deflection = np.outer(shape, np.cos(mode.diameters * angle))
    x, y = np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle))
    axis.contourf(x, y, deflection, levels=np.linspace(-1.0, 1.0, 21), cmap="RdBu_r")
    for number in range(2 * mode.diameters):
        across = (number + 0.5) * np.pi / mode.diameters
        ends = radius[[0, -1]]
        axis.plot(ends * np.cos(across), ends * np.sin(across), "k", lw=1.4)
    for crossing in np.flatnonzero(np.diff(np.sign(shape[1:]))) + 1:
        place = np.interp(0.0, *_rising(shape[crossing : crossing + 2], radius[crossing:]))
        axis.plot(place * np.cos(angle), place * np.sin(angle), "k", lw=1.4)
    held = Circle((0.0, 0.0), radius[0], fc="white", ec="#555555", hatch="////", lw=0.8)
    axis.add_patch(held)
    axis.add_patch(Circle((0.0, 0.0), radius[-1], fill=False, ec="#555555", lw=0.8))
    axis.set_aspect("equal")
    frequency = mode.frequencies["Mindlin"]
    axis.set_title(
        f"{frequency:.0f} Hz\n{name_of(mode.diameters, mode.circles)}", fontsize=8.5, loc="left"
    )


def _rising(
    values: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]",
    places: "np.ndarray[tuple[int, ...], np.dtype[np.float64]]",
) -> tuple[list[float], list[float]]:
    pairs = sorted(zip(values.tolist(), places[:2].tolist(), strict=True))
    return [a for a, _ in pairs], [b for _, b in pairs]


def frequencies_over_clamp(
    radii: Sequence[float],
    frequencies: Mapping[tuple[int, int], Sequence[float]],
    assumed: tuple[float, float | None],
    published: Mapping[tuple[int, int], float],
    title: str,
) -> "Figure":
    """Return how the frequencies depend on the clamped radius that nobody wrote down.

    Parameters
    ----------
    radii : sequence of float
        Clamped radii [m].
    frequencies : mapping of (diameters, circles) to sequence of float
        At those radii [Hz].
    assumed : tuple of float
        The radius of the coupon file, and the one that the documents state or None [m].
    published : mapping of (diameters, circles) to float
        To compare with [Hz].
    title : str
        What the figure shows.
    """
    figure, (axis,) = style.figure(7.0, 3.8)
    millimetres = 1e3 * np.asarray(radii)
    for number, (mode, values) in enumerate(frequencies.items()):
        line = style.line(number % 6)
        axis.plot(millimetres, values, label=name_of(*mode), **line)
        if mode in published:
            axis.axhline(published[mode], color=line["color"], lw=0.8, ls=(0, (1, 2)))
            axis.plot(1e3 * assumed[0], published[mode], "o", color=line["color"], ms=5)
    axis.axvline(1e3 * assumed[0], color="#000000", lw=0.9)
    if assumed[1] is not None:
        axis.axvline(1e3 * assumed[1], color="#767676", lw=0.9, ls=(0, (5, 3)))
    axis.set_xlabel("clamped radius [mm] (black: assumed; dashed grey: stated)")
    axis.set_ylabel("natural frequency [Hz]")
    axis.set_title(title)
    axis.legend(loc="upper left", ncols=3, frameon=True, framealpha=1.0, edgecolor="white")
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.25 * (high - low))
    return figure


def all_runs(runs: Sequence[TensileRun], stiffness: JointStiffness) -> "Figure":
    """Return every run of a specimen, as the thesis' figure 5.8."""
    title = f"{stiffness.specimen}: all {len(runs)} runs"
    return _draw_runs(runs, range(len(runs)), title)


def last_runs(runs: Sequence[TensileRun], stiffness: JointStiffness, last: int) -> "Figure":
    """Return the runs that count and their mean slope, as the thesis' figure 5.9."""
    counted = range(len(runs) - last, len(runs))
    title = (
        f"{stiffness.specimen}: last {last} runs, k = {stiffness.thesis / 1e3:.0f} N/mm "
        f"(secant), {stiffness.slope.value / 1e3:.0f} N/mm (slope)"
    )
    figure = _draw_runs(runs, counted, title)
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


def _draw_runs(runs: Sequence[TensileRun], which: Sequence[int], title: str) -> "Figure":
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
