"""What a modal analysis leaves in a folder, of its own or of a batch."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from shakerproc import files
from shakerproc.cli import output
from shakerproc.cli.modal_tables import (
    document_of,
    mode_columns,
    print_analysis,
    reciprocity_columns,
    shape_columns,
    track_columns,
    trend_columns,
)
from shakerproc.modal.analysis import ModalAnalysis
from shakerproc.modal.choosing import SINGLE_FREQUENCIES
from shakerproc.modal.from_log import analyse_log
from shakerproc.report.modal import modal_report
from shakerproc.report.page import write_report
from shakerproc.testlog import TestLog


def write_folder(
    folder: Path,
    analysis: ModalAnalysis,
    document: dict[str, Any],
    logs: Sequence[Path],
    *,
    figures: bool,
) -> None:
    """Write tables, JSON, figures and the page of a modal analysis."""
    with output.results(folder, "modal"):
        files.write_csv(folder / "modes.csv", mode_columns(analysis))
        files.write_csv(folder / "shapes.csv", shape_columns(analysis))
        files.write_csv(folder / "tracks.csv", track_columns(analysis))
        points = trend_columns(analysis)
        if points["mode"]:
            files.write_csv(folder / "mode_trends.csv", points)
        if analysis.reciprocals:
            files.write_csv(folder / "reciprocity.csv", reciprocity_columns(analysis))
        files.write_json(folder / "report.json", document)
        if figures:
            from shakerproc.report.modal_figures import draw_modal

            draw_modal(analysis, folder)
        inputs = [
            ("log", log.name, hashlib.sha256(log.read_bytes()).hexdigest()) for log in logs
        ]
        inputs += [
            (f"test {one.name}", one.test.require_recording().name, one.sha256)
            for one in analysis.tests
        ]
        page = modal_report(analysis, output.command(), tuple(inputs))
        write_report(folder / "report.html", page)


def modes_of_batch(log: TestLog, root: Path, json: str | None, *, figures: bool) -> None:
    """Analyse the tests of a batch that reach more than single frequencies, in root/modal."""
    tests = [test for test in log.active if test.excitation not in SINGLE_FREQUENCIES]
    with output.progress("modes", len(tests)) as advance:
        analysis = analyse_log(log, tests, log.modal, progress=advance)
    print_analysis(analysis, json)
    document = document_of(analysis, log)
    write_folder(root / "modal", analysis, document, [log.path], figures=figures)
    output.message(f"modes: {root / 'modal' / 'report.html'}")
