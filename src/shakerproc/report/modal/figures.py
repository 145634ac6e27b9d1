"""Modal analysis as figures: stabilisation, synthesis, shapes that move, MAC, trends."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from shakerproc.campaign.trends import trends_of_modes
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.analysis import ModalAnalysis, Reciprocal, TestModes, Track, file_name
from shakerproc.modal.geometry import Geometry
from shakerproc.modal.shapes import mac
from shakerproc.modal.stabilisation import frequency_of
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.axes import UNIT, WHITE_FROM
from shakerproc.report.figures.to_png import save
from shakerproc.report.figures.units import read_ratio
from shakerproc.report.trends import draw_trends
from shakerproc.runs.summarising import unbroken_phase

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


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


PANELS: Final = 8
"""Responses whose functions are drawn at most."""

ACROSS: Final = 3
"""Shapes in a row."""


LETTER: Final = (0.022, 0.043)
"""Width and height of letters of 6 pt on a drawing of 2.2 in, as shares of it [-]."""


def draw_modal(analysis: ModalAnalysis, folder: Path) -> list[Path]:
    """Draw every figure of an analysis, and return the files."""
    with style.look():
        written = [
            save(draw(), folder / f"{name}.png") for name, draw in figures_of(analysis).items()
        ]
        against = [one for row in trends_of_modes(analysis).values() for one in row]
        return written + draw_trends(against, folder / "trends")


def figures_of(analysis: ModalAnalysis) -> "dict[str, Callable[[], Figure]]":
    """Return the function that draws each figure of an analysis, by name."""
    drawings: dict[str, Callable[[], Figure]] = {}
    for one in analysis.tests:
        name = file_name(one.name)
        kinds = {"stabilisation": stabilisation_figure}
        shaped = len(one.sensors) > 1
        if one.functions is not None:
            kinds["synthesis"] = synthesis_figure
        if shaped and one.modes.poles.size:
            kinds["shapes"] = shapes_figure
        if shaped and one.modes.poles.size > 1:
            kinds["mac"] = mac_figure
        drawings |= {f"{name}_{kind}": partial(draw, one) for kind, draw in kinds.items()}
    for number, pair in enumerate(analysis.reciprocals[:PANELS], 1):
        drawings[f"reciprocity_{number}"] = partial(reciprocity_figure, pair)
    if _tracked(analysis):
        drawings["modes_over_tests"] = partial(trend_figure, analysis)
    return drawings


def _tracked(analysis: ModalAnalysis) -> list[Track]:
    """Return the modes that several tests have."""
    if len(analysis.tests) < 2:
        return []
    return [track for track in analysis.tracks if len(track.sightings) > 1]


def _title(one: TestModes) -> str:
    said = [one.test.excitation or "", one.test.level_text, one.test.specimen]
    return ", ".join([f"test {one.name}", *(word for word in said if word)])


def stabilisation_figure(one: TestModes) -> "Figure":
    """Return the stabilisation diagram over the mean density or response function."""
    diagram, modes = one.modes.diagram, one.modes
    figure, (axis,) = style.figure(7.4, 3.8, left=0.62)
    behind = axis.twinx()
    frequency, level = indicator(one)
    behind.plot(frequency, level, color="#b0b0b0", lw=0.8)
    behind.set_yscale("log")
    peak = float(np.nanmax(level))
    behind.set_ylim(max(float(np.nanmin(level)), 1e-5 * peak) / 2.0, 3.0 * peak)
    behind.set_yticks([])
    behind.minorticks_off()
    behind.spines["right"].set_visible(False)
    axis.set_zorder(behind.get_zorder() + 1)
    axis.patch.set_visible(False)
    places = frequency_of(diagram.poles)
    kinds: tuple[tuple[str, NDArray[np.bool_], dict[str, Any]], ...] = (
        ("not stable", ~diagram.stable, {"marker": ".", "ms": 2.5, "color": "#a0a0a0"}),
        (
            "stable",
            diagram.stable & (diagram.cluster < 0),
            {"marker": "o", "ms": 3.2, "mfc": "none", "color": style.COLOURS[0]},
        ),
        (
            "stable, in a cluster",
            diagram.cluster >= 0,
            {"marker": "o", "ms": 3.2, "color": style.COLOURS[0]},
        ),
    )
    for kind, chosen, arguments in kinds:
        axis.plot(places[chosen], diagram.order[chosen], ls="none", label=kind, **arguments)
    for number, value in enumerate(modes.frequency, 1):
        axis.axvline(value, color=style.COLOURS[1], lw=0.9, zorder=0)
        axis.annotate(
            f"{number}", (value, 1.0), xycoords=("data", "axes fraction"), fontsize=7,
            xytext=(1.5, -7 - 7 * ((number - 1) % 2)), textcoords="offset points",
            color="#a04000",
        )  # fmt: skip
    axis.set_xlim(*one.band)
    axis.set_ylim(0, diagram.order.max(initial=2) + 6)
    axis.set_xlabel("frequency [Hz]")
    axis.set_ylabel("order")
    grey = "mean |H1|" if one.functions is not None else "mean density"
    style.head(axis, f"{_title(one)}: stabilisation", f"vertical: modes kept; grey: {grey}")
    style.legend(axis)
    return figure


def indicator(one: TestModes) -> tuple[np.ndarray, np.ndarray]:
    """Return frequency and the mean of all response functions, or of all densities."""
    if one.functions is not None:
        values = np.abs(one.functions.measured).reshape(-1, one.functions.frequency.size)
        return one.functions.frequency, np.sqrt(np.mean(values**2, axis=0))
    return one.density[0], np.mean(one.density[1:], axis=0)


def synthesis_figure(one: TestModes) -> "Figure":
    """Return measured and synthesised response functions of the sensors, first input."""
    functions = one.functions
    assert functions is not None  # noqa: S101 - figures_of asks for it where there are any
    shown = min(PANELS, len(one.sensors))
    columns = 1 if shown == 1 else 2
    rows = -(-shown // columns)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 0.75 + 1.75 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True)
    for axis in axes.flat[shown:]:
        axis.set_visible(False)
    for i, axis in zip(range(shown), axes.flat, strict=False):
        ratio, factor = read_ratio(one.sensors[i].unit, one.input_units[0])
        measured, model = (
            factor * np.abs(h[i, 0]) for h in (functions.measured, functions.synthesis)
        )
        axis.semilogy(functions.frequency, measured, color="#9a9a9a", lw=2.2, label="measured")
        axis.semilogy(
            functions.frequency, model, color=style.COLOURS[1], lw=0.9, label="modal model"
        )
        axis.set_xlim(*one.band)
        top, low = np.nanmax(measured), np.nanmin(measured[measured > 0.0])
        axis.set_ylim(max(low, 1e-5 * top) / 1.5, 2.0 * top)
        name, left = one.sensors[i].name, one.unexplained[i]
        axis.set_title(f"{name} (residual {left:.1%} rms)", fontsize=8.5)
        axis.set_ylabel(f"|H1| [{ratio or '-'}]")
    for axis in axes[-1]:
        axis.set_xlabel("frequency [Hz]")
    axes[0, 0].legend(loc="best", ncols=2, fontsize=7)
    figure.suptitle(
        f"{_title(one)}: response to {one.inputs[0]}, both through one window",
        fontsize=10, x=0.01, ha="left",
    )  # fmt: skip
    return figure


def shapes_figure(one: TestModes) -> "Figure":
    """Return every mode shape: at rest grey, at its largest in colour."""
    modes = one.modes
    from matplotlib.figure import Figure

    drawn = one.geometry
    rows = -(-modes.poles.size // ACROSS)
    figure = Figure(figsize=(7.6, 0.6 + 1.75 * rows), layout="constrained")
    axes = figure.subplots(rows, ACROSS, squeeze=False)
    for axis in axes.flat:
        axis.set_axis_off()
    for number, axis in zip(range(modes.poles.size), axes.flat, strict=False):
        draw_shape(axis, drawn, modes.shapes[number], one.sensor_names)
        axis.set_title(
            f"{number + 1}: {numeral(modes.frequency[number], 4)} Hz, "
            f"{modes.damping[number]:.2%}\n"
            f"collinearity {modes.collinearity[number]:.2f}",
            fontsize=8,
        )
    figure.suptitle(f"{_title(one)}: mode shapes", fontsize=10, x=0.01, ha="left")
    return figure


def draw_shape(
    axis: "Axes", drawn: Geometry, shape: ComplexArray, names: Sequence[str]
) -> None:
    """Draw a mode shape: at rest grey; at its largest in colour."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    rest, moved, seats = drawn.rest, drawn.moved(shape, 0.0), drawn.measured
    colour = style.COLOURS[0]
    grey = [rest[[a, b]] for a, b in (*drawn.still, *drawn.edges)]
    axis.add_collection(LineCollection(grey, colors="#b8b8b8", linewidths=1.0))
    faces = [Outline(moved[[*f, f[0]]], closed=True) for f in drawn.upright_faces]
    if faces:
        whole = Outline.make_compound_path(*faces)
        axis.add_patch(PathPatch(whole, facecolor=colour, alpha=0.13, linewidth=0.0))
    lines = [moved[[a, b]] for a, b in drawn.edges]
    axis.add_collection(LineCollection(lines, colors=colour, linewidths=1.5))
    ways = [np.stack([rest[i], moved[i]]) for i in seats]
    axis.add_collection(LineCollection(ways, colors=colour, linewidths=0.5, alpha=0.6))
    axis.plot(*rest[seats].T, "o", color="#b8b8b8", ms=2.5)
    axis.plot(*moved[seats].T, "o", color=colour, ms=3.5)
    for place, name in drawn.fitting(drawn.labels(names), LETTER).items():
        axis.annotate(
            name, rest[place], (0, -4), textcoords="offset points", ha="center", va="top",
            fontsize=6,
        )  # fmt: skip
    low, high = drawn.bounds
    axis.set_xlim(low[0], high[0])
    axis.set_ylim(low[1], high[1])
    if np.ptp(rest[:, 1]) > 0.02:  # a line across may be stretched upwards
        axis.set_aspect("equal")


def mac_figure(one: TestModes) -> "Figure":
    """Return the MAC of every pair of modes of a test."""
    modes = one.modes
    size = max(3.4, 1.3 + 0.36 * modes.poles.size)
    figure, (axis,) = style.figure(size + 0.6, size)
    draw_mac(axis, mac(modes.shapes, modes.shapes))
    labels = [numeral(value, 4) for value in modes.frequency]
    axis.set_xticks(range(len(labels)), labels, rotation=90)
    axis.set_yticks(range(len(labels)), labels)
    axis.set_xlabel("mode [Hz]")
    axis.set_ylabel("mode [Hz]")
    axis.set_title(f"test {one.name}: MAC of its modes")
    return figure


def draw_mac(axis: "Axes", values: np.ndarray) -> None:
    """Draw a matrix of MAC values, the numbers in the cells."""
    axis.imshow(values, vmin=0.0, vmax=1.0, cmap="Blues")
    axis.grid(visible=False)
    for (row, column), value in np.ndenumerate(values):
        axis.text(
            column, row, f"{value:.2f}", ha="center", va="center", fontsize=6.5,
            color="white" if value > 0.6 else "black",
        )  # fmt: skip


def reciprocity_figure(pair: Reciprocal) -> "Figure":
    """Return two functions between the same places overlaid, size and phase."""
    figure, (upper, lower) = style.figure(7.4, 4.6, 2, sharex=True)
    ratio, factor = read_ratio(*pair.units)
    for name, values, how in zip(pair.names, pair.functions, (0, 1), strict=True):
        upper.semilogy(pair.frequency, factor * np.abs(values), **style.line(how), label=name)
        lower.plot(pair.frequency, unbroken_phase(values), **style.line(how))
    upper.set_ylabel(f"|H1| [{ratio or '-'}]")
    lower.set_ylabel("phase [°]")
    lower.set_yticks([-180, -90, 0, 90, 180])
    lower.set_xlabel("frequency [Hz]")
    upper.set_title(
        f"reciprocity: correlation {pair.correlation:.3f}, size {numeral(pair.ratio)}",
        fontsize=9,
    )
    upper.legend(loc="best", fontsize=7)
    return figure


def trend_figure(analysis: ModalAnalysis) -> "Figure":
    """Return frequency and damping of every mode over the tests, with 95 % bars."""
    tests, tracks = analysis.tests, _tracked(analysis)
    figure, axes = style.figure(7.4, 5.4, 3, sharex=True)
    for number, track in enumerate(tracks):
        places = [s.test for s in track.sightings]
        sets = [(tests[s.test].modes, s.mode) for s in track.sightings]
        colour = style.COLOURS[number % 6]
        first = float(sets[0][0].frequency[sets[0][1]])
        for axis, values, bounds in (
            (
                axes[0],
                [100.0 * (float(m.frequency[i]) / first - 1.0) for m, i in sets],
                [100.0 * (m.frequency_bounds[:, i] / first - 1.0) for m, i in sets],
            ),
            (
                axes[1],
                [100.0 * float(m.damping[i]) for m, i in sets],
                [100.0 * m.damping_bounds[:, i] for m, i in sets],
            ),
        ):
            reach = np.abs(np.array(bounds).T - np.array(values))
            axis.errorbar(
                places, values, yerr=reach, color=colour, marker="o", ms=3.5, lw=1.1,
                capsize=2, label=f"{numeral(first, 4)} Hz",
            )  # fmt: skip
        axes[2].plot(
            places, [np.nan if s.mac is None else s.mac for s in track.sightings],
            color=colour, marker="o", ms=3.5, lw=1.1,
        )  # fmt: skip
    axes[0].set_ylabel("frequency, shift [%]")
    axes[1].set_ylabel("damping [%]")
    style.plain_logarithmic(axes[1], "y")
    axes[2].set_ylabel("MAC with the first")
    axes[2].set_ylim(0.0, 1.05)
    names = [f"{t.name}\n{t.test.level_text}".strip() for t in tests]
    axes[2].set_xticks(range(len(tests)), names, fontsize=7.5)
    axes[2].set_xlabel("test")
    axes[2].set_xlim(-0.5, len(tests) - 0.5)
    figure.suptitle("modes over the tests, 95 % intervals", fontsize=10, x=0.01, ha="left")
    axes[0].legend(ncols=7, fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return figure
