"""The plane of a drawing: axes and grid, and values over it in colours or as numbers."""

import base64
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.report.figures.figure import Axis, Image
from shakerproc.runs.summary import SURFACE_STEPS

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

    def written(match: re.Match[str]) -> str:
        axes = match[0]
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
    values = _multiples(step, axis)
    if len(values) < 2:  # one number alone says no scale
        finer = (_multiples(m * power, axis) for m in (5, 4, 2, 1))
        return next((many for many in finer if len(many) > 1), values)
    return values


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


COLOURS: Final = (
    "#440154", "#470d60", "#48186a", "#482374", "#472e7c", "#453882", "#424186", "#3e4a89",
    "#3a548c", "#365d8d", "#32658e", "#2e6d8e", "#2b758e", "#287d8e", "#25848e", "#228c8d",
    "#1f948c", "#1e9c89", "#20a386", "#25ab82", "#2eb37c", "#3aba76", "#48c16e", "#58c765",
    "#6ccd5a", "#7fd34e", "#93d741", "#a8db34", "#c0df25", "#d5e21a", "#eae51a", "#fde725",
)  # fmt: skip
"""Colour of each step, from little to much: those of matplotlib's viridis."""

_TICKS: Final = 5


def picture(image: Image, box: Box) -> Markup:
    """Return the values as a picture that fills the axes, low values of y below."""
    share = (image.values - image.low) / (image.high - image.low)
    steps = np.rint(np.clip(share, 0.0, 1.0) * (SURFACE_STEPS - 1)).astype(np.uint8)
    return _drawn(steps[::-1], box.left, box.top, box.width, box.height)


def scale(image: Image) -> Markup:
    """Return a bar of all colours with the values that they stand for."""
    values = np.linspace(image.low, image.high, _TICKS)
    texts = (f"{value:.0f}".replace("-", "−") for value in values)
    return Markup(
        '<div class="scale"><svg viewBox="0 0 {} {}" preserveAspectRatio="none">'
        '<g class="axes">{}</g></svg><p>{}</p></div>'  # written once in a page: `shared`
    ).format(
        SURFACE_STEPS * UNIT,
        UNIT,
        _drawn(np.arange(SURFACE_STEPS, dtype=np.uint8)[np.newaxis], 0, 0, SURFACE_STEPS, 1),
        Markup("").join(Markup("<span>{}</span>").format(text) for text in texts),
    )


def _drawn(
    steps: NDArray[np.uint8], left: float, top: float, wide: float, high: float
) -> Markup:
    return Markup(
        '<image x="{}" y="{}" width="{}" height="{}" preserveAspectRatio="none" '
        'href="data:image/png;base64,{}"/>'
    ).format(
        left * UNIT,
        top * UNIT,
        wide * UNIT,
        high * UNIT,
        base64.b64encode(_png(steps)).decode(),
    )


def _png(steps: NDArray[np.uint8]) -> bytes:
    from PIL import Image as Pictures

    image = Pictures.fromarray(np.ascontiguousarray(steps))
    image.putpalette(bytes.fromhex("".join(COLOURS).replace("#", "")))
    file = io.BytesIO()
    image.save(file, "PNG", optimize=True)
    return file.getvalue()


LEAST, MOST = 1e-3, 1.0
"""Values that are white and that are darkest [-]."""

WHITE_FROM: Final = 6
"""Shade from which the numbers are white, so that every one can be read."""

_SHADES: Final = 8
_TOP, _ROW, _BELOW = 4, 24, 34  # [px]
_WIDTH: Final = 1120


def heat_map(
    labels: Sequence[str],
    edges: FloatArray,
    values: FloatArray,
    bold: NDArray[np.bool_],
    *,
    title: str,
    x_label: str = "frequency [Hz]",
) -> Markup:
    """Return rows of cells with their values in per cent.

    Parameters
    ----------
    labels : sequence of str
        Of the rows.
    edges : (n_columns + 1,) array
        Limits of the columns, on a logarithmic axis [unit of the axis].
    values : (n_rows, n_columns) array
        Shares; not a number leaves a cell empty [-] [-].
    bold : (n_rows, n_columns) array of bool
        Which are printed bold.
    title : str
        Read out in place of the picture.
    x_label : str
        Below the axis.
    """
    axis = Axis(x_label, float(edges[0]), float(edges[-1]), logarithmic=True)
    left = room_for(labels)
    width = _WIDTH - left - 12
    places = (left + axis.share(edges) * width) * UNIT
    height = _TOP + len(labels) * _ROW + _BELOW
    parts = []
    for i, label in enumerate(labels):
        top = (_TOP + i * _ROW) * UNIT
        parts.append(
            Markup('<text class="end" x="{}" y="{}">{}</text>').format(
                (left - 6) * UNIT, top + 16 * UNIT, label
            )
        )
        for j, value in enumerate(values[i]):
            if np.isfinite(value):
                parts.append(
                    _cell(places[j], places[j + 1], top, float(value), bold=bool(bold[i, j]))
                )
    below = (_TOP + len(labels) * _ROW + 13) * UNIT
    for value in fine_ticks(axis):
        x = (left + float(axis.share(np.array([value]))[0]) * width) * UNIT
        parts.append(Markup('<text x="{:.0f}" y="{}">{:g}</text>').format(x, below, value))
    parts.append(
        Markup('<text x="{:.0f}" y="{}">{}</text>').format(
            (left + width / 2) * UNIT, below + 16 * UNIT, axis.label
        )
    )
    return Markup(
        '<svg viewBox="0 0 {} {}" class="plot heat" role="img"><title>{}</title>{}</svg>'
    ).format(_WIDTH * UNIT, height * UNIT, title, Markup("").join(parts))


def room_for(labels: Sequence[str]) -> int:
    """Return the width of the longest label, at most a third of the figure [px]."""
    return min(10 + round(5.9 * max(map(len, labels), default=0)), _WIDTH // 3)


def shade(value: float) -> int:
    """Return how dark a value is, from 0 to 7, in steps of equal ratio.

    `value` is a share [-].
    """
    share = np.log(max(value, LEAST) / LEAST) / np.log(MOST / LEAST)
    return int(np.clip(share * _SHADES, 0, _SHADES - 1))


def _cell(left: float, right: float, top: float, value: float, *, bold: bool) -> Markup:
    text = f"{100.0 * value:.1f}" if value < 0.0095 else f"{100.0 * value:.0f}"
    dark = shade(value)
    return Markup(
        '<rect class="s{}" x="{:.0f}" y="{}" width="{:.0f}" height="{}"/>'
        '<text class="t{}{}" x="{:.0f}" y="{}">{}</text>'
    ).format(
        dark,
        left,
        top,
        right - left,
        (_ROW - 2) * UNIT,
        1 if dark >= WHITE_FROM else 0,
        " bold" if bold else "",
        (left + right) / 2,
        top + 15 * UNIT,
        text,
    )
