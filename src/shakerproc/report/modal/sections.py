"""A modal analysis as a report: sections with tables, diagrams and moving shapes."""

import importlib.metadata
import platform
from typing import Final

import numpy as np

from shakerproc.campaign.trends import mode_shifts, trends_of_modes
from shakerproc.data import FloatArray
from shakerproc.modal.analysis import ModalAnalysis, Reciprocal, TestModes, mac_over
from shakerproc.modal.identification import scatter_text
from shakerproc.modal.shapes import mac
from shakerproc.modal.stabilisation import frequency_of
from shakerproc.numerals import numeral
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis, Curve, Mark, Plot
from shakerproc.report.figures.units import read_ratio
from shakerproc.report.modal.figures import indicator, matrix, moving_shape, swings
from shakerproc.report.page.methods import Methods
from shakerproc.report.page.page import Report
from shakerproc.report.page.sections import PageFigure, ReportSection, ReportTable
from shakerproc.report.trends import page_figures

MOST_MODES: Final = 20
"""Modes of a matrix that is drawn."""


def modal_report(
    analysis: ModalAnalysis, command: str, inputs: tuple[tuple[str, str, str], ...]
) -> Report:
    """Return the report of a modal analysis.

    Parameters
    ----------
    analysis : ModalAnalysis
        What was found.
    command : str
        How it was made.
    inputs : tuple of (str, str, str)
        Files that went in: what they are, their names and their SHA-256.
    """
    sections = [_test_section(one, i) for i, one in enumerate(analysis.tests, 1)]
    if analysis.reciprocals:
        sections.append(_reciprocity(analysis))
    over = _over_tests(analysis)
    if over is not None:
        sections.insert(0, over)
    if not sections:
        sections = [ReportSection("Modes", "modes", ["No test could be analysed."])]
    return Report(
        title=f"{analysis.title}: modes",
        runs=(),
        command=command,
        verdict=_verdict(analysis),
        sections=sections,
        inputs=inputs,
        methods=methods_of(analysis),
    )


def section_of_modes(analysis: ModalAnalysis) -> ReportSection:
    """Return the section on the modes of its tests for the report of a batch.

    Parameters
    ----------
    analysis : ModalAnalysis
        What was found; its own page, in ``modal``, has diagrams and response functions too.
    """
    sentences = [_verdict(analysis), "Diagrams and response functions: modal/report.html."]
    tables = [
        _mode_table(one, f"Test {one.name}") for one in analysis.tests if one.modes.poles.size
    ]
    shapes = [drawing for one in analysis.tests[:1] for drawing in _shapes(one)]
    over = _over_tests(analysis)
    return ReportSection(
        "Modes", "modes", sentences, tables, shapes, [] if over is None else [over]
    )


def _verdict(analysis: ModalAnalysis) -> str:
    sentences = [
        f"test {one.name}: {one.modes.poles.size} modes" for one in analysis.tests[:12]
    ]
    failed = [f"test {name} left out: {reason}" for name, reason in analysis.failed]
    return ". ".join([", ".join(sentences), *failed]).strip(". ") + "."


def _test_section(one: TestModes, number: int) -> ReportSection:
    modes = one.modes
    said = [one.test.excitation or "", one.test.level_text, one.test.joint, one.test.specimen]
    heading = ", ".join([f"Test {one.name}", *(word for word in said if word)])
    opening = [
        f"{modes.poles.size} modes from {numeral(one.band[0], 4)} to "
        f"{numeral(one.band[1], 4)} Hz; input: "
        f"{', '.join(one.inputs) or 'not measured'}; {len(one.sensors)} sensors. Intervals: "
        f"{modes.interval_from}.",
        *(f"{note[0].upper()}{note[1:].removesuffix('.')}." for note in one.notes),
    ]
    figures = [_stabilisation(one), *_synthesis(one)]
    parts = []
    if len(one.sensors) > 1 and modes.poles.size:
        parts.append(
            ReportSection("Mode shapes", "shapes", figures=[*_shapes(one), *_auto_mac(one)])
        )
    table = [_mode_table(one, "Modes")] if modes.poles.size else []
    return ReportSection(heading, f"test-{number}", opening, table, figures, parts)


def _mode_table(one: TestModes, caption: str) -> ReportTable:
    modes = one.modes
    rows = [
        (
            str(i + 1),
            f"{modes.frequency[i]:.6g}",
            f"{modes.frequency_bounds[0, i]:.6g} to {modes.frequency_bounds[1, i]:.6g}",
            numeral(100 * modes.damping[i], 4),
            f"{numeral(100 * modes.damping_bounds[0, i], 4)} to "
            f"{numeral(100 * modes.damping_bounds[1, i], 4)}",
            f"{modes.collinearity[i]:.3f}",
            *scatter_text(modes, i),
        )
        for i in range(modes.poles.size)
    ]
    columns = (
        "mode", "f_n [Hz]", "95 % [Hz]", "ζ [%]", "95 % [%]", "phase collinearity",
        *(() if modes.scatter is None else ("scatter of f_n [%]", "scatter of ζ [%]")),
    )  # fmt: skip
    return ReportTable(caption, columns, rows)


def _stabilisation(one: TestModes) -> PageFigure:
    diagram = one.modes.diagram
    frequency, level = indicator(one)
    top = float(diagram.order.max(initial=2)) + 4.0
    logs = np.log10(np.maximum(level, 1e-5 * float(np.nanmax(level))))
    scaled = top * (0.05 + 0.9 * (logs - logs.min()) / max(float(np.ptp(logs)), 1e-9))
    places = frequency_of(diagram.poles)
    order = diagram.order.astype(float)
    kept, loose = diagram.cluster >= 0, ~diagram.stable
    other = diagram.stable & ~kept
    shown = "mean |H1|" if one.functions is not None else "mean density"
    drawing = to_svg.plot(
        Plot(
            [
                Curve(f"{shown}, logarithmic, no scale", frequency, scaled, 7, thin=True),
                Curve("not stable", places[loose], order[loose], 7, dots=True),
                Curve("stable", places[other], order[other], 5, points=True),
                Curve("stable, in a cluster", places[kept], order[kept], 0, points=True),
            ],
            Axis("frequency [Hz]", *one.band),
            Axis("order", 0.0, top),
            marks=[Mark(float(f), f"{i}") for i, f in enumerate(one.modes.frequency, 1)],
        ),
        title=f"Stabilisation diagram of test {one.name}",
        width=1120,
        height=330,
    )
    caption = "Poles of every order; dashed lines: the modes that were kept."
    return PageFigure("Stabilisation diagram", caption, drawing, broad=True)


def _synthesis(one: TestModes) -> list[PageFigure]:
    functions = one.functions
    if functions is None:
        return []
    figures = []
    for k, sensor in enumerate(one.sensors):
        for j, name in enumerate(one.inputs):
            ratio, factor = read_ratio(sensor.unit, one.input_units[j])
            measured = factor * np.abs(functions.measured[k, j])
            model = factor * np.abs(functions.synthesis[k, j])
            top = float(np.nanmax(measured))
            if not top > 0.0:
                continue
            drawing = to_svg.plot(
                Plot(
                    [
                        Curve("measured", functions.frequency, measured, 7, wide=True),
                        Curve("modal model", functions.frequency, model, 1),
                    ],
                    Axis("frequency [Hz]", *one.band),
                    magnitude_axis(measured, ratio),
                ),
                title=f"Response function of {sensor.name} over {name}",
            )
            caption = f"Residual rms: {one.unexplained[k]:.2%} of the response."
            figures.append(PageFigure(f"{sensor.name} over {name}", caption, drawing))
    return figures


def _shapes(one: TestModes) -> list[PageFigure]:
    """Return the moving shapes; none of a single sensor."""
    if len(one.sensors) < 2:
        return []
    geometry, modes = one.geometry, one.modes
    still = "" if swings(geometry) else ", at its largest: too many lines to move"
    return [
        PageFigure(
            f"Mode {i + 1}: {modes.frequency[i]:.5g} Hz",
            f"damping {modes.damping[i]:.3%}, phase collinearity {modes.collinearity[i]:.2f}"
            + still,
            moving_shape(geometry, modes.shapes[i], one.sensor_names, f"Shape of mode {i + 1}"),
        )
        for i in range(modes.poles.size)
    ]


def _auto_mac(one: TestModes) -> list[PageFigure]:
    labels = [numeral(f, 4) for f in one.modes.frequency]
    if not 1 < len(labels) <= MOST_MODES:
        return []
    drawing = matrix(labels, labels, mac(one.modes.shapes, one.modes.shapes), "MAC")
    caption = "Of every pair of modes [Hz]. Off the diagonal large: too few sensors to tell."
    return [PageFigure("MAC", caption, drawing)]


def _reciprocity(analysis: ModalAnalysis) -> ReportSection:
    """Return functions between the same two places overlaid."""
    rows = [
        (
            *pair.names,
            f"{pair.correlation:.3f}",
            numeral(pair.ratio),
            pair.problem or "agree",
        )
        for pair in analysis.reciprocals
    ]
    columns = ("function", "reciprocal", "correlation", "size ratio", "")
    text = (
        "A linear structure answers alike where force and motion change places: correlation "
        "over the band and ratio of the sizes are 1."
    )
    figures = [_reciprocal(pair) for pair in analysis.reciprocals[:MOST_MODES]]
    return ReportSection(
        "Reciprocity", "reciprocity", [text], [ReportTable("", columns, rows)], figures
    )


def _reciprocal(pair: Reciprocal) -> PageFigure:
    ratio, factor = read_ratio(*pair.units)
    drawing = to_svg.plot(
        Plot(
            [
                Curve(name, pair.frequency, factor * np.abs(values), look)
                for name, values, look in zip(pair.names, pair.functions, (0, 1), strict=True)
            ],
            Axis("frequency [Hz]", pair.frequency[0], pair.frequency[-1]),
            magnitude_axis(factor * np.abs(pair.functions), ratio),
        ),
        title=f"Reciprocity of {pair.names[0]}",
    )
    caption = f"Correlation {pair.correlation:.3f}, size ratio {numeral(pair.ratio)}."
    return PageFigure(f"{pair.names[0]} and back", caption, drawing)


def magnitude_axis(values: FloatArray, ratio: str) -> Axis:
    """Return the logarithmic axis of magnitudes [ratio], five decades at most."""
    top = float(np.nanmax(values, initial=1e-300))
    low = max(float(np.nanmin(values[values > 0.0], initial=top)), 1e-5 * top)
    return Axis(f"|H1| [{ratio or '-'}]", low / 1.5, 2.0 * top, logarithmic=True)


def _over_tests(analysis: ModalAnalysis) -> ReportSection | None:
    """Return each mode through the tests; None where there is one test only."""
    if len(analysis.tests) < 2:
        return None
    rows = []
    for number, track in enumerate(analysis.tracks, 1):
        for sighting in track.sightings:
            one = analysis.tests[sighting.test]
            modes, i = one.modes, sighting.mode
            seen = analysis.tests[track.sightings[0].test].modes
            shift = modes.frequency[i] / seen.frequency[track.sightings[0].mode] - 1.0
            rows.append((
                str(number), one.name, one.test.level_text, f"{modes.frequency[i]:.6g}",
                f"{shift:+.2%}", numeral(100 * modes.damping[i], 4),
                "" if sighting.mac is None else f"{sighting.mac:.3f}",
            ))  # fmt: skip
    columns = ("mode", "test", "level", "f_n [Hz]", "shift", "ζ [%]", "MAC with the first")
    figures = []
    first = analysis.tests[0]
    for one in analysis.tests[1:]:
        names = (first.sensor_names, one.sensor_names)
        values = mac_over(first.modes.shapes, one.modes.shapes, names)
        if values is None or not values.size or max(values.shape) > MOST_MODES:
            continue
        labels = [[numeral(f, 4) for f in t.modes.frequency] for t in (first, one)]
        figures.append(
            PageFigure(
                f"MAC of test {first.name} and test {one.name}",
                f"Rows: test {first.name}; columns: test {one.name} [Hz].",
                matrix(labels[0], labels[1], values, "MAC"),
            )
        )
    notes = [*mode_shifts(analysis), *(f"{n[0].upper()}{n[1:]}." for n in analysis.notes)]
    figures += page_figures([
        trend for row in trends_of_modes(analysis).values() for trend in row
    ])
    return ReportSection(
        "Modes over the tests", "over-tests", notes, [ReportTable("", columns, rows)], figures
    )


_WITH_INPUT: Final = (
    "Candidates are the poles that stay in place over the orders of a least-squares complex "
    "frequency fit (Peeters et al., 2004). It fits the discrete Fourier transforms of inputs "
    "and responses over the whole record. The transient has terms of its own, so that no "
    "window smears the peaks. Modes are those that Schwarz' criterion needs; poles, residues, "
    "transients and residual terms are refined by maximum likelihood. Their 95 % intervals "
    "come from the scatter of the lines about the model (White). They hold for noise that is "
    "coloured or shared by the sensors. Drift from test to test is in the scatter over tests."
)
_EXPORTED: Final = (
    "Response functions that a file holds are fitted as they are, without samples. Window and "
    "leakage of the analyser stay in them. A damping that their lines do not resolve comes "
    "out too large."
)
_OUTPUT_ONLY: Final = (
    "Where no input was measured, poles come from covariance-driven stochastic subspace "
    "identification (Peeters and De Roeck, 1999) over orders. Intervals come from leaving out "
    "one of twelve blocks at a time. Their scatter also tells how much of the imaginary parts "
    "of a shape is chance. They are shrunk by that share (Efron and Morris, 1973). The "
    "excitation is taken for broadband."
)
_REFERENCES: Final = (
    "B. Peeters, H. Van der Auweraer, P. Guillaume and J. Leuridan, The PolyMAX "
    "frequency-domain method, Shock and Vibration 11, 395-409, 2004.",
    "M. El-Kafafy, P. Guillaume and B. Peeters, Modal parameter estimation by combining "
    "stochastic and deterministic frequency-domain approaches, Mechanical Systems and Signal "
    "Processing 35, 52-68, 2013.",
    "R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, 2nd "
    "ed., Wiley, 2012.",
    "B. Peeters and G. De Roeck, Reference-based stochastic subspace identification for "
    "output-only modal analysis, Mechanical Systems and Signal Processing 13, 855-878, 1999.",
    "B. Efron and C. Morris, Stein's estimation rule and its competitors: an empirical Bayes "
    "approach, Journal of the American Statistical Association 68, 117-130, 1973.",
    "R. J. Allemang, The modal assurance criterion, Sound and Vibration 37, 14-23, 2003.",
)


def methods_of(analysis: ModalAnalysis) -> Methods:
    """Return the methods of an analysis, those that it took."""
    output_only = any(one.modes.model is None for one in analysis.tests)
    exported = any(one.modes.method == "response functions" for one in analysis.tests)
    with_input = any(one.modes.model is not None for one in analysis.tests)
    names = ("numpy", "scipy")
    packages = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    return Methods(
        [
            *([_WITH_INPUT] if with_input else []),
            *([_EXPORTED] if exported else []),
            *([_OUTPUT_ONLY] if output_only else []),
        ],
        _REFERENCES,
        f"{packages}, Python {platform.python_version()} on {platform.system()}",
    )
