"""``shakerproc diagnose``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import messages, options, output
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.diagnosis.result import Diagnosis, Errors, Tried


def diagnose(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model file (YAML).", exists=True)
    ],
    testlog: options.LogArgument,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.")] = 0,
    scheduler: options.SchedulerOption = None,
    recordings: options.RecordingsOption = None,
    pdf: options.PdfOption = False,
    out: output.OutOption = None,
    effects: options.EffectsOption = None,
    time_limit_s: Annotated[
        float | None,
        typer.Option(
            "--time-limit",
            help="About how long it may take; a note says what was left out [s].",
            min=1.0,
            callback=options.positive,
            show_default="300",
        ),
    ] = None,
    json: output.JsonOption = None,
) -> None:
    """Name the missing effect, how surely, and the next test."""
    from shakerproc import files
    from shakerproc.campaign.jobs import at_hand
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.cli.messages import announce
    from shakerproc.diagnosis.data.from_files import tests_of
    from shakerproc.diagnosis.headline import headline
    from shakerproc.diagnosis.progress import TIME_LIMIT_S, Progress
    from shakerproc.diagnosis.updated import Comparisons
    from shakerproc.model_files import read_model
    from shakerproc.recordings import read_hashed
    from shakerproc.runs.summary import by_tests
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows import evidence
    from shakerproc.workflows.arguments import LONG, MUCH, Machines
    from shakerproc.workflows.diagnosis import judged

    options.check_order(model, testlog)
    announce()
    folder = Path(f"{model.stem}_diagnosis") if out is None else out
    check_result_folder(folder, "diagnose")
    log, log_hash = read_hashed(read_testlog, testlog)
    known, model_hash = read_hashed(read_model, model)
    machines = Machines(None, LONG, MUCH, scheduler, recordings)
    once = output.Once()
    with (
        output.progress("diagnose", 8 + 2 * len(log.tests)) as advance,
        at_hand(log, recordings) as seen,
    ):
        given = seen if scheduler is None else log
        usable = tests_of(seen, known)
        usable.tell(once.warning)
        measured = usable.tests
        comparisons = Comparisons(measured, advance)
        result = judged(
            known, given, usable, machines, seed=seed,
            progress=Progress(advance, time_limit_s or TIME_LIMIT_S), comparisons=comparisons,
        )  # fmt: skip
        models = evidence.judged(known, result, comparisons, once.warning)
    documents = [("model", model, model_hash), ("test log", testlog, log_hash)]
    inputs = evidence.inputs_of(documents, measured)
    show(result, headline(result, log.active), once)
    output.messages(by_tests((test.name, test.remarks) for test in measured))
    for text in models.before.warnings if models is not None else ():
        once.warning(text)
    document = {**result.as_json(), **options.effects_of(effects)}
    output.write_json(document, json)
    decays = evidence.decays_judged(known, result, measured, once.warning)
    shown = evidence.Evidence(models, result, inputs, decays)
    with output.results(folder, "diagnose"):
        files.write_json(folder / "diagnosis.json", document)
        page = evidence.write_evidence(
            folder,
            log.title,
            f"{headline(result, log.active)} {result.sentence}".strip(),
            shown,
            command=output.command(),
        )
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)
    messages.after_diagnosis(result, model, testlog)


def show(result: "Diagnosis", numbers: str, once: output.Once) -> None:
    """Print verdict, errors before and after, and candidates; `numbers` as `headline` says.

    Notes that were said `once` before are not printed again.
    """
    from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS
    from shakerproc.diagnosis.headline import probability_text

    output.data(f"verdict: {result.verdict}")
    if numbers:
        output.data(numbers)
    output.data(result.sentence)
    if surely := probability_text(result):
        output.data(surely)
    errors = result.errors
    alone = [["numbers fitted", None, errors.without]] if errors.without is not None else []
    output.print_table(
        ["error", "fitted", "held_out"],
        [
            ["before", errors.fitted.before, errors.held_out.before],
            *alone,
            ["after", errors.fitted.after, errors.held_out.after],
            ["noise floor", None, errors.as_json()["noise_floor"]],
        ],
        title="Share of the response that is not explained",
    )
    rows = [
        [effect.kind, " - ".join(effect.between), name, *p.row]
        for effect in result.effects
        for name, p in effect.parameters.items()
    ]
    if rows:
        output.print_table(
            ["found", "between", "parameter", *ESTIMATE_COLUMNS],
            rows,
            title="Found, with 95 % intervals",
        )
    output.print_table(
        ["candidate", "between", "held_out_error"],
        [
            [
                _label(c),
                " - ".join(c.between),
                _not_fitted(c) if c.held_out_error is None else c.held_out_error,
            ]
            for c in result.candidates
        ],
        title=_title(errors.among),
    )
    for test in result.next_test:
        like = f", like {test.like}" if test.like else ""
        low, high = test.band_hz
        output.data(
            f"next test: {test.excitation} at {test.level}, {numeral(low, 4)} to "
            f"{numeral(high, 4)} Hz{like}: {test.reason}"
        )
    for note in result.notes:
        once.message(note)


def _not_fitted(candidate: "Tried") -> str:
    """Return the line of an effect that was not fitted, with its residual along the motion."""
    if candidate.screened is None:
        return "not fitted: others explain more"
    times = numeral(candidate.screened, 3)
    return f"not fitted: leaves {times} times the noise along the measured motion"


def _title(errors: "Errors") -> str:
    """Return the title of the errors of candidates, which `errors` are compared as."""
    how = f", predicted {numeral(errors.ahead_s[0], 2)} s ahead" if errors.ahead_s else ""
    return f"Candidates, best first{how}"


def _label(candidate: "Tried") -> str:
    """Return the kind of a candidate, with its side where it has one."""
    side = candidate.parameters.get("side")
    return candidate.kind if side is None else f"{candidate.kind} ({side.value})"
