"""Axes of a drawing: where they are marked, what stands there, and the grid."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup, escape

from shakerproc.report.figures.figure import Axis

UNIT: Final = 4
"""Steps of the drawing in one pixel: paths are whole numbers of quarter pixels."""


STEPS: Final = 6
"""Steps between the numbers of an axis, about."""

LINE: Final = 22
"""Room of a number along an upright axis: twice the height of its letters [px]."""


@dataclass(frozen=True, slots=True)
class Box:
    """The part of a figure inside the axes [px]."""

    left: int
    top: int
    width: int
    height: int


def grid(
    x_axis: Axis, y_axis: Axis, box: Box, height: int, names: Mapping[float, str]
) -> Markup:
    """Return the lines of the grid with their numbers, and the labels of both axes.

    An axis along x without a label has no numbers either: those of the figure below are its.
    `height` is of the whole figure [px]; `names` are texts for values in the unit of the axis.
    """
    lines, texts = [], []
    for value in names or fine_ticks(x_axis):
        x = (box.left + float(x_axis.share(np.array([value]))[0]) * box.width) * UNIT
        lines.append(f"M{x:.0f} {box.top * UNIT}v{box.height * UNIT}")
        below = (box.top + box.height + 14) * UNIT
        if x_axis.label:
            number = names.get(value) or shown(value, x_axis)
            texts.append(Markup('<text x="{:.0f}" y="{}">{}</text>').format(x, below, number))
    for value in ticks(y_axis, min(STEPS, max(2, box.height // LINE))):
        y = (box.top + (1.0 - float(y_axis.share(np.array([value]))[0])) * box.height) * UNIT
        lines.append(f"M{box.left * UNIT} {y:.0f}h{box.width * UNIT}")
        texts.append(
            Markup('<text class="end" x="{}" y="{:.0f}">{}</text>').format(
                (box.left - 5) * UNIT, y + 14, shown(value, y_axis)
            )
        )
    if x_axis.label:
        middle = (box.left + box.width / 2) * UNIT
        texts.append(
            Markup('<text x="{:.0f}" y="{}">{}</text>').format(
                middle, (height - 4) * UNIT, x_axis.label
            )
        )
    y_middle = (box.top + box.height / 2) * UNIT
    return (
        Markup('<g class="axes"><path class="grid" d="{}"/>').format("".join(lines))
        + Markup("").join(texts)
        + Markup('<text transform="translate(48 {:.0f})rotate(-90)">{}</text></g>').format(
            y_middle, y_axis.label
        )
    )


def shared(page: str) -> str:
    """Return a page in which axes that stand in several figures are written once."""
    known: dict[str, int] = {}

    def written(found: re.Match[str]) -> str:
        axes = found[0]
        if axes in known:
            return f'<use href="#axes-{known[axes]}"/>'
        known[axes] = len(known)
        return axes.replace('class="axes"', f'class="axes" id="axes-{known[axes]}"', 1)

    return re.sub(r'<g class="axes">.*?</g>', written, page, flags=re.DOTALL)


def ticks(axis: Axis, steps: int = STEPS) -> list[float]:
    """Return round numbers along an axis, with about so many steps between them at most."""
    if axis.logarithmic:
        low, high = math.ceil(math.log10(axis.low)), math.floor(math.log10(axis.high))
        every = max(1, math.ceil((high - low + 1) / (steps + 1)))
        powers = [10.0**power for power in range(low, high + 1) if power % every == 0]
        if len(powers) > 1:
            return powers
        return fine_ticks(axis)
    if axis.degrees:
        return [float(v) for v in range(-360, 361, 90) if axis.low <= v <= axis.high]
    raw = (axis.high - axis.low) / steps
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= raw)
    found = _multiples(step, axis)
    if len(found) < 2:  # one number alone says no scale
        finer = (_multiples(m * power, axis) for m in (5, 4, 2, 1))
        return next((many for many in finer if len(many) > 1), found)
    return found


def _multiples(step: float, axis: Axis) -> list[float]:
    """Return every multiple of a step along an axis. `step` is in the unit of the axis."""
    first, last = math.ceil(axis.low / step - 1e-9), math.floor(axis.high / step + 1e-9)
    return [i * step for i in range(first, last + 1)]


def fine_ticks(axis: Axis) -> list[float]:
    """Return the ticks of an axis; on up to two logarithmic decades 1, 2, 5 of each."""
    if not axis.logarithmic or axis.high / axis.low > 300.0:
        return ticks(axis)
    powers = range(math.floor(math.log10(axis.low)), math.ceil(math.log10(axis.high)) + 1)
    finer = [m * 10.0**power for power in powers for m in (1, 2, 5)]
    return [value for value in finer if axis.low <= value <= axis.high]


def shown(value: float, axis: Axis) -> str | Markup:
    """Return the number at a tick. `value` is in the unit of the axis."""
    return _power(value) if axis.logarithmic else _tick(value)


def _tick(value: float) -> str:
    return f"{value:.10g}" if abs(value) < 1e5 else f"{value:.3g}"


def _power(value: float) -> Markup:
    power = round(math.log10(value))
    if -2 <= power <= 3 or abs(10.0**power / value - 1.0) > 1e-6:
        return escape(f"{value:g}")
    return Markup('10<tspan class="up" dy="-20">{}</tspan>').format(
        f"{power}".replace("-", "−")
    )
