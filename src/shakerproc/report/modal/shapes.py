"""Mode shapes that move, and matrices of MAC, as SVG in the report."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final, TypeAlias

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

MOST_MOVING: Final = 2000
"""Lines and surfaces that swing: more make a page of many modes too heavy for a browser."""

Pixels: TypeAlias = Sequence[tuple[int, int]]
"""Places in a drawing [px/10]."""

_LETTER, _LINE = 24, 50  # width and height of letters [px/10]
_WIDTH, _HEIGHT, _MARGIN = 360, 190, 34  # of a shape [px]
_CELL, _LEFT, _BELOW = 44, 70, 22  # of a matrix [px]
_SHADES: Final = 8


def swings(geometry: Geometry) -> bool:
    """Return whether shapes on a geometry move on the page."""
    return len(geometry.edges) + len(geometry.faces) <= MOST_MOVING


def moving_shape(
    geometry: Geometry, shape: ComplexArray, names: Sequence[str], title: str
) -> Markup:
    """Return a mode shape: at rest grey; moved in colour, swinging where the page is shown.

    The motion is part of the drawing (SMIL) and needs no script. On paper, and where the reader
    wants no motion, the page shows the largest instead.

    `shape` may be in any unit; `names` are those of the sensors, at their places at rest.
    """
    low, high = geometry.bounds
    scale = min(
        (_WIDTH - 2 * _MARGIN) / (high[0] - low[0]), (_HEIGHT - 16) / (high[1] - low[1])
    )

    def at(places: FloatArray) -> list[tuple[int, int]]:
        across, up = (scale * (places - (low + high) / 2.0)).T
        x_y = np.column_stack([_WIDTH / 2 + across, _HEIGHT / 2 - up])
        pixels = np.rint(x_y * UNIT).astype(int)
        return [(int(x), int(y)) for x, y in pixels]

    def lines(pixels: Pixels, edges: Sequence[tuple[int, int]]) -> str:
        return "".join("M{} {}L{} {}".format(*pixels[a], *pixels[b]) for a, b in edges)

    def faces(pixels: Pixels) -> str:
        around = (" ".join("{} {}".format(*pixels[i]) for i in one) for one in upright)
        return "".join(f"M{one}Z" for one in around)

    def dots(pixels: Pixels) -> str:
        return "".join("M{} {}h0".format(*pixels[i]) for i in geometry.measured)

    rest, labels = at(geometry.rest), geometry.labels(names)
    letter = (_LETTER / (scale * UNIT), _LINE / (scale * UNIT))
    upright = geometry.upright_faces
    swinging = swings(geometry)
    count = FRAMES if swinging else 1
    frames = [at(geometry.moved(shape, 2.0 * np.pi * i / count)) for i in range(count + 1)]
    kinds = [("face", faces)] * bool(upright)
    kinds += [("c0", lambda pixels: lines(pixels, geometry.edges)), ("d0", dots)]
    moved = [(css, [draw(frame) for frame in frames]) for css, draw in kinds]
    still = Markup("").join(
        Markup('<path class="{}" d="{}"/>').format(css, paths[0]) for css, paths in moved
    )
    parts = [
        Markup('<path class="rest" d="{}"/>').format(
            lines(rest, [*geometry.still, *geometry.edges])
        ),
        *(
            [
                Markup('<g class="moving">'),
                *(_moving(css, paths) for css, paths in moved),
                Markup('</g><g class="still">{}</g>').format(still),
            ]
            if swinging
            else [still]
        ),
        *_texts(rest, labels, geometry.fitting(labels, letter)),
    ]
    return Markup(
        '<svg viewBox="0 0 {} {}" class="plot" role="img"><title>{}</title>{}</svg>'
    ).format(_WIDTH * UNIT, _HEIGHT * UNIT, title, Markup("").join(parts))


def _texts(
    rest: Pixels, labels: Mapping[int, str], fitting: Mapping[int, str]
) -> Iterator[Markup]:
    """Yield the names of the sensors that find room, and those of all where one points at."""
    for place, text in labels.items():
        x, y = rest[place]
        yield Markup(
            '<circle class="hit" cx="{}" cy="{}" r="60"><title>{}</title></circle>'
        ).format(x, y, text)
        if place in fitting:
            yield Markup('<text x="{}" y="{}">{}</text>').format(x, y + 64, text)


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
