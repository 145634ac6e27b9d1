"""One test in a worker process: process it, write tables, draw."""

from pathlib import Path
from typing import Any

from shakerproc import files
from shakerproc.campaign.exports import EXPORTS
from shakerproc.campaign.jobs import SUMMARY, Job, Products, check_recording
from shakerproc.campaign.result_folder import hashes
from shakerproc.campaign.trends import shown
from shakerproc.data import Recording
from shakerproc.late import loaded
from shakerproc.runs import (
    RunResult,
    open_path,
    process_recording,
    summary_of,
    tables,
    write_summary,
)
from shakerproc.runs.tables import write_thesis_tables
from shakerproc.testlog import Test, facts_of


def work_through(job: Job) -> dict[str, Any]:
    """Process one test; return the hash of every file written and read."""
    test = job.test
    with files.staged(job.folder) as folder:
        with open_path(test.require_recording(), test, seen=job.seen) as recording:
            if recording.file is not None:
                check_recording(job, recording.file)
            result = process_recording(recording, test, pictured=job.products.figures)
            write_products(result, recording, folder, job.products)
            digest = recording.sha256()
        summary = summary_of(result, str(test.id), facts_of(test), job.recording, digest)
        write_summary(folder / SUMMARY, summary)
        outputs = hashes(job.root, files.move_into(job.folder, folder))
    return {"outputs": outputs, "sha256": digest}


def write_products(
    result: RunResult, recording: Recording, folder: Path, products: Products
) -> None:
    """Write tables, figures and exports of a run."""
    files.write_csv(folder / "spectra.csv", tables.spectra_columns(result))
    for name, columns in (
        ("notch.csv", tables.notch_columns(result)),
        ("sweep.csv", tables.sweep_columns(result)),
        ("tones.csv", tables.tone_columns(result)),
    ):
        if columns:
            files.write_csv(folder / name, columns)
    for one in result.analyses:
        if one.columns:
            files.write_csv(folder / f"{one.kind}_curves.csv", one.columns)
    for kind in products.exports:
        EXPORTS[kind](result, folder / f"spectra.{kind}")
    if products.thesis:
        write_thesis_tables(result, recording, folder / "thesis")
    if products.figures:
        title = title_of(result.test, result.recorded.run)
        for draw in ("drawing:draw_run", "analyses:draw_analyses"):
            loaded(f"shakerproc.report.runs.{draw}")(result, title, folder)


def title_of(test: Test, run: str) -> str:
    """Return the headline of the figures of a run."""
    facts = facts_of(test)
    named = f"Test {test.id}" if test.recording is not None else run
    told = (
        shown(name, facts.get(name))
        for name in ("joint", "clearance_m", "orientation", "excitation", "level")
    )
    return ", ".join(files.printable(text) for text in (named, *told) if text)


def prepare() -> None:
    """Import slow packages before the clock of the first test runs."""
    import matplotlib.figure  # noqa: F401
