"""``shakerproc demo``."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from shakerproc.cli import output

if TYPE_CHECKING:
    from shakerproc.comparison import Comparison
    from shakerproc.testlog import TestLog
    from shakerproc.workflows.evidence import Evidence


def demo(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="Folder for the results.", file_okay=False)
    ] = Path("demo_output"),
    figures: Annotated[bool, typer.Option(help="Draw figures as PNG files.")] = True,
    json: output.JsonOption = None,
) -> None:
    """Process sample recordings, then find a hidden gap."""
    from shakerproc.cli.messages import announce, compiled_ahead

    with compiled_ahead() as wait_for_compiler:
        announce()
        everyday = _everyday(folder / "everyday", figures=figures)
        output.data("\n2. The loop: a gap hidden in a simulated campaign")
        wait_for_compiler()
        with ExitStack() as drawings:
            loop = _loop(folder / "hidden_gap", drawings, figures=figures)
    output.write_json(
        {
            "schema": "shakerproc-demo/1",
            "everyday": None if everyday is None else everyday["counts"],
            "loop": loop,
        },
        json,
    )


def _everyday(root: Path, *, figures: bool) -> dict[str, Any] | None:
    """Process the sample recordings, if they are there."""
    from shakerproc.testlog import read_testlog

    sample = sample_log()
    if sample is None:
        output.message("no sample_data beside the program: going on to the simulated campaign")
        return None
    output.data("1. The everyday job: from recordings and a log to trends")
    _say("batch", sample, "--out", root)
    return _processed(read_testlog(sample), root, figures=figures)


def sample_log() -> Path | None:
    """Return the log of the sample data: beside a checkout, or packed into the wheel."""
    import shakerproc

    package = Path(shakerproc.__file__).resolve().parent
    logs = (root / "sample_data" / "testlog.yaml" for root in (package.parents[1], package))
    return next((log for log in logs if log.is_file()), None)


def _processed(
    log: "TestLog",
    root: Path,
    *,
    figures: bool,
    evidence: "Evidence | None" = None,
    verdict: str = "",
) -> dict[str, Any]:
    """Run `shakerproc batch`, with the evidence in the report."""
    from shakerproc.campaign.jobs import Products
    from shakerproc.campaign.result_folder import locked
    from shakerproc.cli.batch_output import tell, work_through_log
    from shakerproc.workflows.arguments import Machines
    from shakerproc.workflows.campaign import TrendWish, write_up
    from shakerproc.workflows.evidence import NONE

    with locked(root):
        campaign = work_through_log(log, root, Products(figures=figures), Machines())
        document = write_up(
            log.title,
            campaign,
            root,
            TrendWish(figures=figures, command=output.command()),
            evidence=evidence or NONE,
            verdict=verdict,
        )
    if evidence is None:
        tell(campaign, document, root)
    return document


def _loop(folder: Path, drawings: ExitStack, *, figures: bool) -> dict[str, Any]:
    """Compare, diagnose, add, compare again; end with the ladder, the report and a sentence."""
    from shakerproc.cli.commands.add import add as add_effect
    from shakerproc.cli.commands.diagnose import show
    from shakerproc.comparison import compare, scored_alike, sentence
    from shakerproc.diagnosis import diagnose_tests
    from shakerproc.diagnosis.data.from_files import tests_of
    from shakerproc.diagnosis.headline import headline
    from shakerproc.model_files import read_model
    from shakerproc.recordings import sha256
    from shakerproc.report.evidence.comparison import Models
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows import draft
    from shakerproc.workflows.evidence import Evidence, inputs_of, name_of_new

    log_path, model_path = draft.write_example(folder)
    log, model = read_testlog(log_path), read_model(model_path)
    _say("compare", model_path, log_path)
    with output.progress("compare", len(log.tests)) as advance:
        before = compare(model, log, tell=advance)
    if figures:
        drawings.enter_context(_drawn(model_path, log_path, folder / "compare_before"))
    output.data(sentence(before))
    _say("diagnose", model_path, log_path)
    with output.progress("diagnose", 8) as advance:
        diagnosis = diagnose_tests(model, log, tests_of(log, model), progress=advance)
    diagnosis_headline = headline(diagnosis, log.active)
    show(diagnosis, diagnosis_headline, output.Once())
    if not diagnosis.effects:
        output.finish(1)
    kind = diagnosis.effects[0].kind
    new = folder / f"model-with-{kind}.yaml"
    _say("add", kind, model_path, log_path, "-o", new)
    add_effect(kind, model_path, log_path, new)
    _say("compare", new, log_path)
    if figures:
        drawings.enter_context(_drawn(new, log_path, folder / "compare_after"))
    with output.progress("compare", len(log.tests)) as advance:
        after = compare(read_model(new), log, tell=advance)
        before, after = scored_alike(before, after, tell=advance)
    verdict = _verdict(before, after, diagnosis_headline)
    models = Models(before, after, new=name_of_new(diagnosis))
    files = (("model", model_path), ("model", new), ("test log", log_path))
    documents = [(what, path, sha256(path)) for what, path in files]
    inputs = inputs_of(documents, [test.measured for test in before.tests])
    evidence = Evidence(models, diagnosis, inputs)
    _processed(log, folder / "results", figures=figures, evidence=evidence, verdict=verdict)
    drawings.close()
    _tell(before, after)
    output.data(f"\nreport: {folder / 'results' / 'report.html'}")
    output.data(verdict)
    return {
        "verdict": verdict,
        "held_out_before": before.held_out,
        "held_out_after": after.held_out,
        "diagnosis": diagnosis.as_json(),
    }


def _say(*words: object) -> None:
    """Print the command of the next step."""
    output.data(f"\n$ shakerproc {' '.join(map(str, words))}")


@contextmanager
def _drawn(model: Path, log: Path, folder: Path) -> Iterator[None]:
    """Compare a model with a log and draw the figures, in a process of its own.

    It takes the core that is idle while this process diagnoses: a tenth of the demo's time.
    """
    words = ("compare", str(model), str(log), "--out", str(folder))
    with subprocess.Popen(  # noqa: S603 - this program itself
        [sys.executable, "-m", "shakerproc", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as child:
        try:
            yield
        except BaseException:
            child.terminate()
            raise
        if child.wait() != 0:
            output.message(f"no figures in {folder}: see shakerproc {' '.join(words)}")


def _verdict(before: "Comparison", after: "Comparison", left_out: str) -> str:
    was, now = before.held_out or before.error, after.held_out or after.error
    return (
        f"The model left out a {left_out} With it, what it does not explain of the test kept "
        f"aside falls from {was:.0%} to {now:.1%}."
    )


def _tell(before: "Comparison", after: "Comparison") -> None:
    """Print the errors before and after."""
    output.print_table(
        ("test", "level", "held out", "error before", "error after", "noise"),
        [
            (
                old.measured.name,
                old.measured.test.level_text,
                "yes" if old.measured.test.hold_out else "",
                old.error,
                new.error,
                new.noise,
            )
            for old, new in zip(before.tests, after.tests, strict=True)
        ],
        title="Errors before and after: residual rms over measured rms",
    )
