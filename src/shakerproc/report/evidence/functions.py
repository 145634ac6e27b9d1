"""Modes, response functions and free decays of a test beside those of a model, as pages."""

import importlib.metadata
import platform
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from shakerproc.comparison.decays import (
    DecayComparison,
    ModeDecay,
    TestDecays,
    decay_rows,
    sentence_of_decays,
    sentences_of,
    unit_of,
)
from shakerproc.comparison.document import mode_rows
from shakerproc.comparison.modes import ComparedModes, ModePair
from shakerproc.comparison.response_functions import ComparedFunction, FunctionComparison
from shakerproc.numerals import numeral
from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.figures.to_png import save
from shakerproc.report.figures.units import read_ratio, read_unit
from shakerproc.report.modal.figures import matrix, moving_shape
from shakerproc.report.modal.sections import MOST_MODES, magnitude_axis
from shakerproc.report.page import methods
from shakerproc.report.page.methods import Methods
from shakerproc.report.page.page import Report
from shakerproc.report.page.sections import PageFigure, ReportSection, ReportTable, filled
from shakerproc.report.runs.analyses import draw_panel, drawing
from shakerproc.runs.analyses.decays import Amplitude, decay_panels
from shakerproc.runs.analyses.decays import Curve as AmplitudeCurve
from shakerproc.runs.panels import Panel

_TOLD: Final = (
    "SEREP expands the shape of the test to all points of the model (O'Callahan, Avitabile and "
    "Riemer, 7th IMAC, 29-37, 1989). It takes the modes nearest in frequency, as many as "
    "predict a sensor that is left out best (Allen, Technometrics 16, 125-127, 1974)."
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
    sentences = [modes.sentence]
    if modes.shapes is not None:
        sentences += [modes.shapes.sentence, _TOLD]
    figures = [*_shapes(modes), *_macs(modes)]
    return [ReportSection("Modes", "modes", sentences, [table], figures)]


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
    shapes = modes.shapes
    if shapes is None or len(shapes.points) < 2:
        return
    for pair in sorted(modes.pairs, key=lambda pair: None in pair.rows)[:MOST_MODES]:
        alike = "" if pair.mac is None else f"MAC {pair.mac:.3f} at the sensors"
        for whose, hz, shape in zip(
            ("Test", "Model"),
            (pair.measured_hz, pair.model_hz),
            shapes.of_pair(pair),
            strict=True,
        ):
            if hz is None or shape is None:
                continue
            title = f"{whose}: {hz:.5g} Hz"
            drawing = moving_shape(shapes.geometry, shape, shapes.points, f"Shape, {title}")
            yield PageFigure(title, alike or "No partner.", drawing)


MOST_DRAWN: Final = 60
"""Functions that are drawn, the worst first."""

_METHOD: Final = (
    "The response functions of the file are compared with those of the linear part of the "
    "model, line by line. The error is the rms of their difference over the rms measured, "
    "lines weighted by the coherence where the file holds it. FRAC is the frequency response "
    "assurance criterion (Heylen and Lammens, 1996). The measured functions keep window and "
    "leakage of the analyser."
)
_REFERENCE: Final = (
    "W. Heylen and S. Lammens, FRAC: a consistent way of comparing frequency response "
    "functions, International Conference on Identification in Engineering, 48-57, 1996."
)


def function_report(
    comparison: FunctionComparison, command: str, inputs: Sequence[tuple[str, str, str]]
) -> Report:
    """Return the page of a comparison of response functions."""
    packages = ", ".join(f"{n} {importlib.metadata.version(n)}" for n in ("numpy", "scipy"))
    return Report(
        f"{comparison.measured.name}: response functions and {comparison.model.title}",
        [],
        command=command,
        verdict=comparison.sentence,
        sections=[_functions(comparison), *mode_sections(comparison.modes)],
        inputs=inputs,
        methods=Methods(
            [_METHOD], [_REFERENCE],
            f"{packages}, Python {platform.python_version()} on {platform.system()}",
        ),
    )  # fmt: skip


def _functions(comparison: FunctionComparison) -> ReportSection:
    columns = ("response", "input", "error [%]", "FRAC", "peak [Hz]", "model [Hz]", "coherence")
    rows = [
        (
            one.response, one.input, numeral(100.0 * one.error), f"{one.frac:.3f}",
            f"{comparison.peak(one.measured):.5g}", f"{comparison.peak(one.model):.5g}",
            "" if one.coherence is None else f"{np.mean(one.coherence):.3f}",
        )
        for one in comparison.functions
    ]  # fmt: skip
    worst = sorted(comparison.functions, key=lambda one: -one.error)[:MOST_DRAWN]
    sentences = [
        comparison.sentence,
        *(f"{note.removesuffix('.')}." for note in comparison.notes),
    ]
    if len(worst) < len(comparison.functions):
        sentences.append(f"The {MOST_DRAWN} with the largest errors are drawn.")
    figures = [_figure(comparison, one) for one in worst]
    table = filled("Response functions, measured and of the model", columns, rows)
    return ReportSection("Response functions", "functions", sentences, [table], figures)


def _figure(comparison: FunctionComparison, one: ComparedFunction) -> PageFigure:
    ratio, factor = read_ratio(*one.units)
    measured, model = factor * np.abs(one.measured), factor * np.abs(one.model)
    name = f"{one.response} over {one.input}"
    drawing = to_svg.plot(
        Plot(
            [
                Curve("measured", comparison.frequency, measured, 7, wide=True),
                Curve("model", comparison.frequency, model, 1),
            ],
            Axis(
                "frequency [Hz]",
                float(comparison.frequency[0]),
                float(comparison.frequency[-1]),
            ),
            magnitude_axis(measured, ratio),
        ),
        title=f"Response function of {name}",
    )
    return PageFigure(name, f"Error {one.error:.1%}, FRAC {one.frac:.3f}.", drawing)


MODEL_STYLES: Final = (3, 2)
"""Styles of the curves of the model and of the older one."""

CAPTION: Final = (
    "Measured by two methods, grey their 95 % limits. The model after a start fitted to "
    "the first periods, read by least squares as the measurement is."
)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Decays:
    """A model compared with free decays, and an older one if there is any.

    Attributes
    ----------
    comparison : DecayComparison
        With the model.
    before : DecayComparison, optional
        With the older one, against the same tests.
    """

    comparison: DecayComparison
    before: DecayComparison | None = None

    @property
    def names(self) -> tuple[str, str]:
        """Names of the model and the older one, distinct."""
        new = self.comparison.model.title
        old = "" if self.before is None else self.before.model.title
        return (new, old) if new != old else ("new model", "old model")


def panels_of(decays: Decays) -> dict[str, tuple[str, Panel]]:
    """Return the test and the panel of every figure, by the name of its file."""
    panels = {}
    for i, test in enumerate(decays.comparison.tests):
        for k, mode in enumerate(test.modes):
            if not mode.measured.fitted:
                continue
            older = None if decays.before is None else decays.before.tests[i].modes[k]
            for panel in _panels(decays, test, mode, older):
                panels[panel.name] = (test.measured.name, panel)
    return panels


def _panels(
    decays: Decays, test: TestDecays, mode: ModeDecay, older: ModeDecay | None
) -> list[Panel]:
    sensor = test.measured.sensors[mode.sensor]
    unit, factor = read_unit(unit_of(decays.comparison, sensor))
    curves: list[AmplitudeCurve] = [
        ("measured, least squares", 0, mode.measured.fitted),
        ("measured, peaks and crossings", 1, mode.measured.charted),
    ]
    for name, one, look in zip(decays.names, (mode, older), MODEL_STYLES, strict=True):
        if one is not None and one.model is not None and one.model.fitted:
            curves.append((name, look, one.model.fitted))
    return decay_panels(
        f"decay_{test.measured.name}_{mode.number}",
        f"mode {mode.number}, {numeral(mode.measured.line.frequency, 4)} Hz",
        CAPTION,
        Amplitude(sensor, unit, factor),
        curves,
        limited=2,
    )


def draw_decays(decays: Decays, folder: Path) -> list[Path]:
    """Draw every figure of a comparison of decays, and return the files."""
    written = []
    for name, (test, panel) in panels_of(decays).items():
        with style.look():
            figure = draw_panel(panel, f"test {test}", {})
        written.append(save(figure, folder / f"{name}.png"))
    return written


def decay_report(
    decays: Decays, title: str, command: str, inputs: Sequence[tuple[str, str, str]]
) -> Report:
    """Return the page of a comparison of decays."""
    return Report(
        title,
        [],
        command=command,
        verdict=sentence_of_decays(decays.comparison),
        sections=decay_sections(decays),
        inputs=inputs,
        methods=methods.methods_of(
            [],
            analyses=["decays"],
            kinds=[element.effect.kind for element in decays.comparison.model.elements],
        ),
    )


def decay_sections(decays: Decays) -> list[ReportSection]:
    """Return a section for each test."""
    return [_section(decays, i) for i in range(len(decays.comparison.tests))]


def _section(decays: Decays, index: int) -> ReportSection:
    test = decays.comparison.tests[index]
    name = test.measured.name
    sentences = [
        f"{text[0].upper()}{text[1:].removesuffix('.')}." for text in sentences_of(test)
    ]
    if decays.before is not None:
        old = decays.names[1]
        sentences += [f"{old}: {text}" for text in sentences_of(decays.before.tests[index])]
    if index == 0:
        sentences += [f"{text.removesuffix('.')}." for text in decays.comparison.left_out]
    sentences += [f"{text.removesuffix('.')}." for text in test.measured.notes]
    rows = [row for row in decay_rows(decays.comparison) if row["test"] == name]
    return ReportSection(
        f"Test {name}: frequency and damping against amplitude",
        f"decay_{index + 1}",
        sentences,
        [_table(rows)],
        [
            drawing(panel, f"{panel.title} of test {owner}", {})
            for owner, panel in panels_of(decays).values()
            if owner == name
        ],
    )


def _table(rows: Sequence[dict[str, Any]]) -> ReportTable:
    shown = {
        "mode": "mode", "sensor": "sensor", "largest_amplitude": "amplitude from",
        "smallest_amplitude": "to", "unit": "unit",
        "frequency_difference_at_largest_percent": "frequency, measured less model [%]",
        "frequency_difference_at_smallest_percent": "at the smallest [%]",
        "damping_difference_at_largest_percent": "damping, measured less model [% of critical]",
        "damping_difference_at_smallest_percent": "at the smallest [% of critical]",
        "outside_percent": "stretches outside [%]",
    }  # fmt: skip
    cells = [[_cell(row[key]) for key in shown] for row in rows]
    return filled("Measured less model at both ends of each curve", list(shown.values()), cells)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return numeral(value, 4) if isinstance(value, float) else str(value)
