"""Modes of a test beside those of a model: table, MAC, shapes that move."""

from collections.abc import Iterator
from typing import Final

from shakerproc.comparison.document import mode_rows
from shakerproc.comparison.modes import ComparedModes, ModePair
from shakerproc.numerals import numeral
from shakerproc.report.modal.sections import MOST_MODES
from shakerproc.report.modal.shapes import matrix, moving_shape
from shakerproc.report.page.sections import PageFigure, ReportSection, filled

_TOLD: Final = (
    "The shape of the test is expanded to all points of the model (O'Callahan, Avitabile and "
    "Riemer, System equivalent reduction expansion process, 7th International Modal Analysis "
    "Conference, 29-37, 1989) by the modes nearest in frequency: as many as predict a sensor "
    "that is left out best (Allen, Technometrics 16, 125-127, 1974)."
)
_SHOWN: Final = (
    "measured [Hz]", "model [Hz]", "difference [%]", "ζ measured", "ζ model", "MAC",
    "sensors missed [-]", "sensor left out [-]",
)  # fmt: skip


def mode_sections(modes: ComparedModes | None) -> list[ReportSection]:
    """Return the modes of a test and of a model, side by side; nothing where there are none."""
    if modes is None or not modes.pairs:
        return []
    rows = [
        tuple("" if value is None else f"{value:.4g}" for value in row)
        for row in mode_rows(modes)
    ]
    table = filled(
        f"Modes of test {modes.test} and of the linear part of the model", _SHOWN, rows
    )
    told = [modes.sentence]
    if modes.shapes is not None:
        told += [modes.shapes.sentence, _TOLD]
    figures = [*_shapes(modes), *_macs(modes)]
    return [ReportSection("Modes", "modes", told, [table], figures)]


def _macs(modes: ComparedModes) -> Iterator[PageFigure]:
    """Yield the MAC of every mode of the test with every mode of the model near its band."""
    n_test, n_model = modes.macs.shape
    if len(modes.sensors) < 2 or not 0 < max(n_test, n_model) <= MOST_MODES or not n_model:
        return
    labels = [
        {p.rows[side]: numeral(hz, 4) for p, hz in _by_side(modes, side)} for side in (0, 1)
    ]
    names = [[labels[k].get(i, "") for i in range(n)] for k, n in ((0, n_test), (1, n_model))]
    caption = "Rows: test; columns: model [Hz], without a number where it lies beside the band."
    yield PageFigure("MAC", caption, matrix(names[0], names[1], modes.macs, "MAC"))


def _by_side(modes: ComparedModes, side: int) -> Iterator[tuple[ModePair, float]]:
    for pair in modes.pairs:
        hz = (pair.measured_hz, pair.model_hz)[side]
        if hz is not None:
            yield pair, hz


def _shapes(modes: ComparedModes) -> Iterator[PageFigure]:
    """Yield the shapes of each pair side by side, then those without a partner."""
    found = modes.shapes
    if found is None or len(found.points) < 2:
        return
    for pair in sorted(modes.pairs, key=lambda pair: None in pair.rows)[:MOST_MODES]:
        alike = "" if pair.mac is None else f"MAC {pair.mac:.3f} at the sensors"
        for whose, hz, shape in zip(
            ("Test", "Model"),
            (pair.measured_hz, pair.model_hz),
            found.of_pair(pair),
            strict=True,
        ):
            if hz is None or shape is None:
                continue
            title = f"{whose}: {hz:.5g} Hz"
            drawing = moving_shape(found.geometry, shape, found.points, f"Shape, {title}")
            yield PageFigure(title, alike or "No partner.", drawing)
