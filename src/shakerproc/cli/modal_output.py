"""Terminal output of a modal analysis, and the folder that it is written to."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from shakerproc.campaign.mode_trends import told_of_modes
from shakerproc.cli import output
from shakerproc.data import FloatArray
from shakerproc.modal.analysis import ModalAnalysis, TestModes
from shakerproc.modal.from_log import analyse_log
from shakerproc.modal.gathering import SINGLE_FREQUENCIES
from shakerproc.modal.scatter import scatter_text
from shakerproc.numerals import numeral
from shakerproc.testlog import TestLog
from shakerproc.workflows.modal_files import write_modes
from shakerproc.workflows.modal_tables import (
    document_of,
    reciprocity_columns,
    track_columns,
    track_rows,
)


def write_folder(
    folder: Path,
    analysis: ModalAnalysis,
    document: dict[str, Any],
    logs: Sequence[Path],
    *,
    figures: bool,
) -> None:
    """Write what a modal analysis leaves, into a folder that is marked as its results."""
    with output.results(folder, "modal"):
        write_modes(folder, analysis, document, logs, command=output.command(), figures=figures)


def modes_of_batch(
    log: TestLog, root: Path, json: str | None, *, figures: bool
) -> ModalAnalysis:
    """Return the modes of the tests of a batch that reach more than single frequencies.

    They are written to root/modal and told.
    """
    tests = [test for test in log.active if test.excitation not in SINGLE_FREQUENCIES]
    with output.progress("modes", len(tests)) as advance:
        analysis = analyse_log(log, tests, log.modal, progress=advance)
    print_analysis(analysis, json)
    document = document_of(analysis, log.path)
    write_folder(root / "modal", analysis, document, [log.path], figures=figures)
    output.message(f"modes: {root / 'modal' / 'report.html'}")
    return analysis


def print_analysis(analysis: ModalAnalysis, json: str | None) -> None:
    """Print the modes of every test, then each mode through the tests."""
    for one in analysis.tests:
        _print_test(one, json)
    rows = track_rows(analysis)
    if len(analysis.tests) > 1 and rows:
        columns = list(track_columns(analysis))
        output.print_table(
            columns,
            rows,
            title="modes over the tests:",
            json_target=json,
            elsewhere="tracks.csv",
        )
    if analysis.reciprocals:
        pairs = reciprocity_columns(analysis)
        output.print_table(
            list(pairs),
            list(zip(*pairs.values(), strict=True)),
            title="reciprocity:",
            json_target=json,
            elsewhere="reciprocity.csv",
        )
    for sentence in told_of_modes(analysis):
        output.data(sentence, json_target=json)
    for note in analysis.notes:
        output.data(f"note: {note}", json_target=json)
    for name, reason in analysis.failed:
        output.warning(f"test {name} left out: {reason}")


def _modes(count: int) -> str:
    return f"{count} mode{'' if count == 1 else 's'}"


def _span(shares: FloatArray) -> str:
    """Return the smallest and largest of some shares, once where they read alike."""
    low, high = f"{shares.min():.2%}", f"{shares.max():.2%}"
    return low if low == high else f"{low} to {high}"


def _print_test(one: TestModes, json: str | None) -> None:
    modes = one.modes
    said = ", ".join(word for word in (one.test.excitation, one.test.level_text) if word)
    title = (
        f"test {one.name}{f' ({said})' if said else ''}: {_modes(modes.poles.size)} from "
        f"{numeral(one.band[0], 4)} to {numeral(one.band[1], 4)} Hz, {len(one.sensors)} "
        f"sensors, input {', '.join(one.inputs) or 'not measured'}"
    )
    rows = [
        (
            i + 1,
            f"{modes.frequency[i]:.6g}",
            numeral(100.0 * modes.frequency_error[i] * 1.96, 2),
            numeral(100.0 * modes.damping[i], 4),
            _interval(modes.damping_bounds[:, i]),
            f"{modes.collinearity[i]:.3f}",
            _orders(one, i),
            *scatter_text(modes, i),
        )
        for i in range(modes.poles.size)
    ]
    if rows:
        columns = (
            "mode", "f_n [Hz]", "+- 95 % [%]", "zeta [%]", "95 % [%]", "collinearity", "orders",
            *(() if modes.scatter is None else ("f scatter [%]", "zeta scatter [%]")),
        )  # fmt: skip
        output.print_table(columns, rows, title=title, json_target=json)
    else:
        output.data(title, json_target=json)
    if modes.model is not None:
        left = one.unexplained
        output.data(
            f"residual rms {_span(left)} of the responses; intervals: {modes.interval_from}",
            json_target=json,
        )
    else:
        output.data(f"intervals: {modes.interval_from}", json_target=json)
    for note in one.notes:
        output.data(f"note: {note}", json_target=json)


def _interval(bounds: "np.ndarray[Any, Any]") -> str:
    return f"{numeral(100.0 * bounds[0], 4)} to {numeral(100.0 * bounds[1], 4)}"


def _orders(one: TestModes, mode: int) -> int:
    """Return at how many orders of the diagram a stable pole is near a mode."""
    diagram, pole = one.modes.diagram, one.modes.poles[mode]
    near = np.abs(diagram.poles - pole) < max(-pole.real, 0.002 * abs(pole))
    return int(np.unique(diagram.order[near & diagram.stable]).size)
