"""Terminal output of a batch and of a modal analysis: progress and results."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from shakerproc.campaign import trends
from shakerproc.campaign.batch import BatchListener, CampaignResult
from shakerproc.campaign.jobs import Products
from shakerproc.campaign.trends import mode_shifts
from shakerproc.cli import output
from shakerproc.data import FloatArray
from shakerproc.modal.analysis import ModalAnalysis, TestModes
from shakerproc.modal.from_measurements import analyse_log
from shakerproc.modal.gathering import SINGLE_FREQUENCIES
from shakerproc.modal.identification import scatter_text
from shakerproc.numerals import numeral
from shakerproc.runs import RunSummary
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.summary import by_tests
from shakerproc.testlog import TestLog
from shakerproc.workflows.arguments import Machines
from shakerproc.workflows.campaign import run_log
from shakerproc.workflows.modal_tables import (
    document_of,
    reciprocity_columns,
    track_columns,
    track_rows,
    write_modes,
)


def work_through_log(
    log: TestLog,
    root: Path,
    products: Products,
    machines: Machines,
    *,
    accept_changed: bool = False,
) -> CampaignResult:
    """Process the tests of a log, with a progress bar."""
    with ExitStack() as stack:
        advance = [lambda _text: None]

        def start(to_do: int, kept: int) -> None:
            if kept:
                tests = "test" if kept == 1 else "tests"
                output.message(f"{kept} {tests} reused from an earlier batch")
            if to_do:
                advance[0] = stack.enter_context(output.progress("tests", to_do))

        try:
            return run_log(
                log,
                root,
                products,
                machines,
                accept_changed=accept_changed,
                progress=BatchListener(
                    start, tell_outdated, lambda test: advance[0](f"(test {test} ended)")
                ),
            )
        except KeyboardInterrupt as stopped:
            raise KeyboardInterrupt(output.GO_ON) from stopped


def tell_outdated(count: int, why: str) -> None:
    """Say how many tests are computed again though their recordings are the same, and why."""
    output.message(f"{count} test{'s' if count > 1 else ''} computed again: {why}")


def tell(campaign: CampaignResult, document: dict[str, Any], root: Path) -> None:
    """Print the results of a batch."""
    channel = document["trend_channel"]
    rows = [_row(run, channel) for run in campaign.runs if run.status != "discarded"]
    output.print_table(
        (
            "test",
            "status",
            "joint",
            "clearance",
            "orientation",
            "excitation",
            "level",
            "peak frequency [Hz]",
            "Q",
            "coherence",
            "flags",
        ),
        rows,
        spare=("orientation", "excitation", "joint", "coherence", "Q"),
        elsewhere=f"{root / 'runs.csv'} and peaks.csv",
    )
    for run in campaign.runs:
        if run.status == "failed":
            output.message(f"test {run.test} failed: {run.error}")
        if run.left_out:
            output.warning(run.left_out)
    runs = [run for run in campaign.runs if run.status == "done"]
    expired = [[f.message for f in run.flags if f.kind == EXPIRED] for run in runs]
    messages = ((r.test, (*r.remarks, *more)) for r, more in zip(runs, expired, strict=True))
    output.messages(by_tests(messages))
    number = document["counts"]
    parts = [f"{n} {name}" for name, n in number.items() if n or name == "processed"]
    whose = f" (peak frequency of {channel})" if channel else ""
    output.data(f"{', '.join(parts)}{whose}")
    if document["verdict"]:
        output.data(document["verdict"])
    output.data(f"report: {root / 'report.html'}")


def _row(run: RunSummary, channel: str) -> tuple[object, ...]:
    peak = trends.main_peak(run, channel)
    seen = next((c for c in run.channels if c.name == channel), None)
    response = seen.response_peaks[0] if seen and seen.response_peaks else None
    return (
        run.test,
        run.status_text,
        run.facts.get("joint"),
        trends.shown("clearance_m", run.facts.get("clearance_m")),
        run.facts.get("orientation"),
        run.facts.get("excitation"),
        trends.shown("level", run.facts.get("level")),
        peak.frequency_hz if peak else None,
        response.quality if response else None,
        seen.coherence if seen else None,
        ", ".join(dict.fromkeys(flag.kind for flag in run.flags)),
    )


def write_folder(
    folder: Path,
    analysis: ModalAnalysis,
    document: dict[str, Any],
    logs: Sequence[Path],
    *,
    figures: bool,
) -> None:
    """Write the results of a modal analysis into a folder that is marked as such."""
    with output.results(folder, "modal"):
        write_modes(folder, analysis, document, logs, command=output.command(), figures=figures)


def modes_of_batch(log: TestLog, root: Path, *, figures: bool) -> ModalAnalysis:
    """Return the modes of the tests of a batch that reach more than single frequencies.

    They are written to root/modal and told.
    """
    tests = [test for test in log.active if test.excitation not in SINGLE_FREQUENCIES]
    with output.progress("modes", len(tests)) as advance:
        analysis = analyse_log(log, tests, log.modal, progress=advance)
    print_analysis(analysis)
    document = document_of(analysis, log.path)
    write_folder(root / "modal", analysis, document, [log.path], figures=figures)
    output.message(f"modes: {root / 'modal' / 'report.html'}")
    return analysis


def print_analysis(analysis: ModalAnalysis) -> None:
    """Print the modes of every test, then each mode through the tests."""
    for one in analysis.tests:
        _print_test(one)
    rows = track_rows(analysis)
    if len(analysis.tests) > 1 and rows:
        columns = list(track_columns(analysis))
        output.print_table(
            columns,
            rows,
            title="modes over the tests:",
            elsewhere="tracks.csv",
        )
    if analysis.reciprocals:
        pairs = reciprocity_columns(analysis)
        output.print_table(
            list(pairs),
            list(zip(*pairs.values(), strict=True)),
            title="reciprocity:",
            elsewhere="reciprocity.csv",
        )
    for sentence in mode_shifts(analysis):
        output.data(sentence)
    for note in analysis.notes:
        output.data(f"note: {note}")
    for name, reason in analysis.failed:
        output.warning(f"test {name} left out: {reason}")


def _modes(count: int) -> str:
    return f"{count} mode{'' if count == 1 else 's'}"


def _span(shares: FloatArray) -> str:
    """Return the smallest and largest of some shares, once where they read alike."""
    low, high = f"{shares.min():.2%}", f"{shares.max():.2%}"
    return low if low == high else f"{low} to {high}"


def _print_test(one: TestModes) -> None:
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
        output.print_table(columns, rows, title=title)
    else:
        output.data(title)
    if modes.model is not None:
        unexplained = one.unexplained
        output.data(
            f"residual rms {_span(unexplained)} of the responses; "
            f"intervals: {modes.interval_from}"
        )
    else:
        output.data(f"intervals: {modes.interval_from}")
    for note in one.notes:
        output.data(f"note: {note}")


def _interval(bounds: "np.ndarray[Any, Any]") -> str:
    return f"{numeral(100.0 * bounds[0], 4)} to {numeral(100.0 * bounds[1], 4)}"


def _orders(one: TestModes, mode: int) -> int:
    """Return at how many orders of the diagram a stable pole is near a mode."""
    diagram, pole = one.modes.diagram, one.modes.poles[mode]
    near = np.abs(diagram.poles - pole) < max(-pole.real, 0.002 * abs(pole))
    return int(np.unique(diagram.order[near & diagram.stable]).size)
