"""Displacement against frequency with the clearances (figure 5.14), for the tests of a log."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
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
        _draw(axis, of_base, FreeJoint())
        _draw_limits(axis, limits, of_base)
        _draw_plays(axis, _half_plays(plans))
        axis.set_ylabel("displacement of the table [mm]")
        _legend(axis)
    if with_model:
        axis = panels.pop(0)
        _draw(axis, inputs, joint)
        _draw_plays(axis, _free_plays(plans))
        axis.set_ylabel("relative displacement of the joint [mm]")
        _legend(axis)
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


def _draw(axis: "Axes", inputs: Sequence[AbstractInput], joint: AbstractJoint) -> None:
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


def _legend(axis: "Axes") -> None:
    if axis.get_legend_handles_labels()[0]:
        axis.legend(
            loc="upper left",
            bbox_to_anchor=(1.01, 1.0),
            borderaxespad=0.0,
            title="solid: amplitude\ndashed: 3σ of all\nabove a frequency",
            title_fontsize=7.5,
        )
