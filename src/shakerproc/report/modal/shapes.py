"""Mode shapes that move, and matrices of MAC, as SVG in the report."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.geometry import Geometry
from shakerproc.report.figures.axes import UNIT
from shakerproc.report.figures.heat_map import WHITE_FROM

FRAMES: Final = 16
"""Pictures of one period of the motion."""

SECONDS: Final = 1.6
"""Length of that period on the screen [s]."""

_WIDTH, _HEIGHT, _MARGIN = 360, 190, 34  # of a shape [px]
_CELL, _LEFT, _BELOW = 44, 70, 22  # of a matrix [px]
_SHADES: Final = 8


def moving_shape(
    geometry: Geometry, shape: ComplexArray, names: Sequence[str], title: str
) -> Markup:
    """Return a mode shape: at rest grey; moved in colour, swinging where the page is shown.

    The motion is part of the drawing (SMIL) and needs no script. On paper, and where the reader
    wants no motion, the page shows the largest instead.

    `shape` may be in any unit; `names` are those of the sensors, at their places at rest.
    """
    low, high = geometry.rest.min(axis=0) - 0.27, geometry.rest.max(axis=0) + 0.27
    scale = min(
        (_WIDTH - 2 * _MARGIN) / (high[0] - low[0]), (_HEIGHT - 16) / (high[1] - low[1])
    )

    def at(places: FloatArray) -> tuple[FloatArray, FloatArray]:
        middle = places - (low + high) / 2.0
        x = (_WIDTH / 2 + scale * middle[:, 0]) * UNIT
        return x, (_HEIGHT / 2 - scale * middle[:, 1]) * UNIT

    def path(places: FloatArray) -> str:
        x, y = at(places)
        return "".join(
            f"M{x[a]:.0f} {y[a]:.0f}L{x[b]:.0f} {y[b]:.0f}" for a, b in geometry.edges
        )

    def dots(places: FloatArray) -> str:
        x, y = at(places)
        return "".join(f"M{a:.0f} {b:.0f}h0" for a, b in zip(x, y, strict=True))

    frames = [geometry.moved(shape, 2.0 * np.pi * i / FRAMES) for i in range(FRAMES + 1)]
    parts = [
        Markup('<path class="c7 thin" d="{}"/>').format(path(geometry.rest)),
        Markup('<g class="moving">'),
        _moving("c0", [path(frame) for frame in frames]),
        _moving("d0", [dots(frame) for frame in frames]),
        Markup(
            '</g><g class="still"><path class="c0" d="{}"/><path class="d0" d="{}"/></g>'
        ).format(path(frames[0]), dots(frames[0])),
        *(
            Markup('<text x="{:.0f}" y="{:.0f}">{}</text>').format(x, y + 64, ", ".join(here))
            for (x, y), here in _named(geometry.rest, names, at).items()
        ),
    ]
    return Markup(
        '<svg viewBox="0 0 {} {}" class="plot" role="img"><title>{}</title>{}</svg>'
    ).format(_WIDTH * UNIT, _HEIGHT * UNIT, title, Markup("").join(parts))


def _named(
    rest: FloatArray,
    names: Sequence[str],
    at: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
) -> dict[tuple[float, float], list[str]]:
    """Return the names of the sensors by their place in the drawing."""
    found: dict[tuple[float, float], list[str]] = {}
    for x, y, name in zip(*at(rest), names, strict=True):
        found.setdefault((float(np.rint(x)), float(np.rint(y))), []).append(name)
    return found


def _moving(css: str, paths: Sequence[str]) -> Markup:
    return Markup(
        '<path class="{}" d="{}"><animate attributeName="d" dur="{}s" '
        'repeatCount="indefinite" values="{}"/></path>'
    ).format(css, paths[0], SECONDS, ";".join(paths))


def matrix(
    rows: Sequence[str], columns: Sequence[str], values: FloatArray, title: str
) -> Markup:
    """Return a matrix of numbers from 0 to 1, dark where they are large.

    Parameters
    ----------
    rows, columns : sequence of str
        Labels.
    values : (n_rows, n_columns) array
        From 0 to 1 [-].
    title : str
        Read out in place of the picture.
    """
    width = max(_LEFT + _CELL * len(columns) + 8, 360)
    height = 6 + 22 * len(rows) + _BELOW
    parts = []
    for i, row in enumerate(rows):
        parts.append(
            Markup('<text class="end" x="{}" y="{}">{}</text>').format(
                (_LEFT - 6) * UNIT, (6 + 22 * i + 15) * UNIT, row
            )
        )
        for j in range(len(columns)):
            value = float(values[i, j])
            shade = int(np.clip(value * _SHADES, 0, _SHADES - 1))
            parts.append(
                Markup(
                    '<rect class="s{}" x="{}" y="{}" width="{}" height="{}"/>'
                    '<text class="t{}" x="{}" y="{}">{:.2f}</text>'
                ).format(
                    shade,
                    (_LEFT + _CELL * j) * UNIT,
                    (6 + 22 * i) * UNIT,
                    (_CELL - 2) * UNIT,
                    20 * UNIT,
                    int(shade >= WHITE_FROM),
                    (_LEFT + _CELL * j + _CELL / 2 - 1) * UNIT,
                    (6 + 22 * i + 14) * UNIT,
                    value,
                )
            )
    for j, column in enumerate(columns):
        parts.append(
            Markup('<text x="{}" y="{}">{}</text>').format(
                (_LEFT + _CELL * j + _CELL / 2 - 1) * UNIT,
                (6 + 22 * len(rows) + 14) * UNIT,
                column,
            )
        )
    return Markup(
        '<svg viewBox="0 0 {} {}" class="plot heat" role="img"><title>{}</title>{}</svg>'
    ).format(width * UNIT, height * UNIT, title, Markup("").join(parts))
