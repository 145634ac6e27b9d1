"""Files of a modal analysis in a folder, of its own or of a batch."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from shakerproc import files
from shakerproc.modal.analysis import ModalAnalysis, file_name
from shakerproc.report.modal.sections import modal_report
from shakerproc.report.page.page import write_report
from shakerproc.workflows.modal_tables import (
    mode_columns,
    reciprocity_columns,
    shape_columns,
    track_columns,
    trend_columns,
)
from shakerproc.workflows.modal_universal import write_universal


def write_modes(
    folder: Path,
    analysis: ModalAnalysis,
    document: dict[str, Any],
    logs: Sequence[Path],
    *,
    command: str,
    figures: bool,
) -> None:
    """Write tables, JSON, figures and the page of a modal analysis."""
    files.write_csv(folder / "modes.csv", mode_columns(analysis))
    files.write_csv(folder / "shapes.csv", shape_columns(analysis))
    files.write_csv(folder / "tracks.csv", track_columns(analysis))
    points = trend_columns(analysis)
    if points["mode"]:
        files.write_csv(folder / "mode_trends.csv", points)
    if analysis.reciprocals:
        files.write_csv(folder / "reciprocity.csv", reciprocity_columns(analysis))
    for one in analysis.tests:
        if one.modes.poles.size:
            write_universal(folder / f"{file_name(one.name)}.uff", one, analysis.title)
    files.write_json(folder / "report.json", document)
    if figures:
        from shakerproc.report.modal.figures import draw_modal

        draw_modal(analysis, folder)
    inputs = [("log", log.name, hashlib.sha256(log.read_bytes()).hexdigest()) for log in logs]
    inputs += [
        (f"test {test}", name, sha256)
        for one in analysis.tests
        for test, name, sha256 in one.recordings
    ]
    page = modal_report(analysis, command, tuple(inputs))
    write_report(folder / "report.html", page)
