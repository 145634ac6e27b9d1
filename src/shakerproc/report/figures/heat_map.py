"""Values over a plane: a small picture of few colours, or numbers in cells over frequency."""

import base64
import io
from collections.abc import Sequence
from typing import Final

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.report.figures.axes import UNIT, Box, fine_ticks
from shakerproc.report.figures.figure import Axis, Image
from shakerproc.runs.summary import SURFACE_STEPS

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
        '<g class="axes">{}</g></svg><p>{}</p></div>'  # written once in a page: `axes.shared`
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

    found = Pictures.fromarray(np.ascontiguousarray(steps))
    found.putpalette(bytes.fromhex("".join(COLOURS).replace("#", "")))
    file = io.BytesIO()
    found.save(file, "PNG", optimize=True)
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
