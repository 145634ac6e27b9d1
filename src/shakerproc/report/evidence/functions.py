"""Response functions of a file beside a model's, as a page."""

import importlib.metadata
import platform
from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.comparison.response_functions import ComparedFunction, FunctionComparison
from shakerproc.numerals import numeral
from shakerproc.report.evidence.modes import mode_sections
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Plot
from shakerproc.report.figures.units import read_ratio
from shakerproc.report.modal.sections import magnitude_axis
from shakerproc.report.page.methods import Methods
from shakerproc.report.page.page import Report
from shakerproc.report.page.sections import PageFigure, ReportSection, filled

MOST_DRAWN: Final = 60
"""Functions that are drawn, the worst first."""

_METHOD: Final = (
    "The response functions of the file are compared with those of the linear part of the "
    "model, line by line. The error is the rms of their difference over the rms measured, "
    "lines weighted by the coherence where the file holds it; FRAC is the frequency response "
    "assurance criterion (Heylen and Lammens, 1996). What was measured keeps window and "
    "leakage of the analyser."
)
_REFERENCE: Final = (
    "W. Heylen and S. Lammens, FRAC: a consistent way of comparing frequency response "
    "functions, International Conference on Identification in Engineering, 48-57, 1996."
)


def function_report(
    found: FunctionComparison, command: str, inputs: Sequence[tuple[str, str, str]]
) -> Report:
    """Return the page of a comparison of response functions."""
    packages = ", ".join(f"{n} {importlib.metadata.version(n)}" for n in ("numpy", "scipy"))
    return Report(
        f"{found.measured.name}: response functions and {found.model.title}",
        [],
        command=command,
        verdict=found.sentence,
        sections=[_functions(found), *mode_sections(found.modes)],
        inputs=inputs,
        methods=Methods(
            [_METHOD], [_REFERENCE],
            f"{packages}, Python {platform.python_version()} on {platform.system()}",
        ),
    )  # fmt: skip


def _functions(found: FunctionComparison) -> ReportSection:
    columns = ("response", "input", "error [%]", "FRAC", "peak [Hz]", "model [Hz]", "coherence")
    rows = [
        (
            one.response, one.input, numeral(100.0 * one.error), f"{one.frac:.3f}",
            f"{found.peak(one.measured):.5g}", f"{found.peak(one.model):.5g}",
            "" if one.coherence is None else f"{np.mean(one.coherence):.3f}",
        )
        for one in found.functions
    ]  # fmt: skip
    worst = sorted(found.functions, key=lambda one: -one.error)[:MOST_DRAWN]
    told = [found.sentence, *(f"{note.removesuffix('.')}." for note in found.notes)]
    if len(worst) < len(found.functions):
        told.append(f"The {MOST_DRAWN} with the largest errors are drawn.")
    figures = [_figure(found, one) for one in worst]
    table = filled("Response functions, measured and of the model", columns, rows)
    return ReportSection("Response functions", "functions", told, [table], figures)


def _figure(found: FunctionComparison, one: ComparedFunction) -> PageFigure:
    ratio, factor = read_ratio(*one.units)
    measured, model = factor * np.abs(one.measured), factor * np.abs(one.model)
    name = f"{one.response} over {one.input}"
    drawing = to_svg.plot(
        Plot(
            [
                Curve("measured", found.frequency, measured, 7, wide=True),
                Curve("model", found.frequency, model, 1),
            ],
            Axis("frequency [Hz]", float(found.frequency[0]), float(found.frequency[-1])),
            magnitude_axis(measured, ratio),
        ),
        title=f"Response function of {name}",
    )
    return PageFigure(name, f"Error {one.error:.1%}, FRAC {one.frac:.3f}.", drawing)
