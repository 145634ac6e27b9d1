"""``shakerproc compare``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import messages, options, output
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from shakerproc.comparison import Comparison, Refit
    from shakerproc.comparison.modes import ComparedModes
    from shakerproc.models import Model
    from shakerproc.testlog import TestLog
    from shakerproc.workflows.evidence import Document, Evidence

_SHOWN = (
    "test", "level", "sensor", "error", "noise", "PSD", "H1", "FRAC", "peak [Hz]", "model [Hz]",
    "gain", "model gain",
)  # fmt: skip

_DECAY_KEYS = (
    "test", "mode", "sensor", "measured_hz", "model_hz",
    "frequency_difference_at_largest_percent", "frequency_difference_at_smallest_percent",
    "damping_difference_at_largest_percent", "damping_difference_at_smallest_percent",
    "outside_percent",
)  # fmt: skip
_DECAY_SHOWN = (
    "test", "mode", "sensor", "line [Hz]", "model [Hz]", "f, large [%]", "f, small [%]",
    "zeta, large [% of critical]", "zeta, small", "outside [%]",
)  # fmt: skip


def compare(
    model: Annotated[
        Path, typer.Argument(metavar="MODEL", help="Model (YAML).", exists=True, dir_okay=False)
    ],
    log: options.LogOrFunctions,
    fit: Annotated[
        bool,
        typer.Option("--fit", help="Fit the model's numbers first, with 95 % intervals."),
    ] = False,
    before: Annotated[
        Path | None,
        typer.Option(
            "--before",
            metavar="OLD",
            help="An earlier model, shown beside it.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(
            "--at",
            metavar="NAME=PLACE",
            help="Sensor or place of the model that a name in FUNCTIONS stands for; may be "
            "repeated.",
        ),
    ] = None,
    figures: options.FiguresOption = True,
    pdf: options.PdfOption = False,
    out: output.OutOption = None,
    effects: options.EffectsOption = None,
    json: output.JsonOption = None,
) -> None:
    """Show where, and by how much, a model fails in each test.

    The model is driven by the measured control signal (the mean of the controls, or the
    measured force) and its sensors are compared with the channels of the same name. Where
    nothing drives it, frequency and damping over amplitude are compared with free decays.
    Response functions that an analyser has exported are compared with those of the model's
    linear part, without a log.
    """
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.comparison import explained, sentence
    from shakerproc.model_files import read_model
    from shakerproc.recordings import read_hashed
    from shakerproc.recordings.response_functions import holds_functions
    from shakerproc.report.evidence.comparison import Models
    from shakerproc.testlog import read_testlog
    from shakerproc.workflows.comparison import compare_models, structure_sentences
    from shakerproc.workflows.evidence import Evidence, inputs_of

    folder = Path(f"{model.stem}_compare") if out is None else out
    if holds_functions(log):
        _functions(folder, (model, log), at, alone=not fit and not before, json=json, pdf=pdf)
        return
    if at:
        raise typer.BadParameter("--at is for response functions; a log names its channels")
    options.check_order(model, log)
    messages.announce()
    check_result_folder(folder, "compare")
    campaign, log_hash = read_hashed(read_testlog, log)
    shaken, model_hash = read_hashed(read_model, model)
    documents = [("model", model, model_hash), ("test log", log, log_hash)]
    older = None
    if before is not None:
        older, older_hash = read_hashed(read_model, before)
        documents.insert(0, ("model", before, older_hash))
    if shaken.excitation.role is None:
        three = (shaken, older, campaign)
        _decays(folder, three, documents, fit=fit, figures=figures, json=json, pdf=pdf)
        return
    once = output.Once()
    output.messages(structure_sentences(shaken))
    with output.progress("compare", len(campaign.tests)) as advance:
        compared = compare_models(
            shaken, campaign, before=older, fit=fit, tell=advance, warn=once.warning
        )
    comparison, measured = compared.found, [test.measured for test in compared.found.tests]
    models = Models(comparison, old=shaken.title)
    if compared.before is not None:
        names = _names((older or shaken).title, shaken.title, fit=fit)
        models = Models(compared.before, comparison, *names)
    document = {
        **_provenance(documents[-2:]), **options.effects_of(effects), **compared.as_json()
    }  # fmt: skip
    evidence = Evidence(models, None, inputs_of(documents, measured), modes=compared.modes)
    with output.results(folder, "compare"):
        page = _write(folder, comparison, document, campaign.title, evidence, figures=figures)
        _write_modes(folder, compared.modes)
    output.write_json(document, json)
    _print(comparison, folder, once)
    _print_modes(compared.modes, folder)
    output.data(sentence(comparison))
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)
    messages.after_comparing(model, log, explained=explained(comparison))


def _functions(
    folder: Path,
    given: tuple[Path, Path],
    at: list[str] | None,
    *,
    alone: bool,
    json: str | None,
    pdf: bool,
) -> None:
    """Compare the linear part of a model with response functions of a file."""
    from shakerproc.campaign.result_folder import check_result_folder
    from shakerproc.comparison.document import mode_rows
    from shakerproc.model_files import read_model
    from shakerproc.models.validation import check_unscaled
    from shakerproc.recordings import read_hashed
    from shakerproc.workflows.comparison import FUNCTION_COLUMNS, compare_file

    if not alone:
        raise typer.BadParameter("--fit and --before are for test logs")
    check_result_folder(folder, "compare")
    model, model_hash = read_hashed(read_model, given[0])
    check_unscaled(model, "a comparison with response functions")
    compared = compare_file(model, given[1], at or [])
    comparison = compared.found
    inputs = [
        ("model", given[0].name, model_hash),
        ("response functions", given[1].name, comparison.measured.sha256),
    ]
    with output.results(folder, "compare"):
        page = compared.write(folder, output.command(), inputs)
    output.write_json(compared.as_json(), json)
    output.print_table(
        FUNCTION_COLUMNS,
        compared.rows,
        title="Response functions, measured and of the model",
        elsewhere=str(folder / "functions.csv"),
    )
    if comparison.modes is not None and mode_rows(comparison.modes):
        _print_modes(comparison.modes, folder)
    for note in comparison.notes:
        output.message(f"note: {note}")
    output.data(comparison.sentence)
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)


def _decays(
    folder: Path,
    asked: "tuple[Model, Model | None, TestLog]",
    documents: "Sequence[Document]",
    *,
    fit: bool,
    figures: bool,
    json: str | None,
    pdf: bool,
) -> None:
    """Compare a model that nothing drives with free decays."""
    from shakerproc import files
    from shakerproc.workflows.comparison import compare_free_decays
    from shakerproc.workflows.evidence import inputs_of

    model, older, campaign = asked
    with output.progress("compare", len(campaign.tests)) as advance:
        compared = compare_free_decays(
            model, campaign, before=older, fit=fit, tell=advance, warn=output.warning
        )
    document = {**_provenance(documents[-2:]), **compared.as_json()}
    inputs = inputs_of(documents, compared.measured)
    with output.results(folder, "compare"):
        files.write_json(folder / "compare.json", document)
        page = compared.write(folder, campaign.title, output.command(), inputs, figures=figures)
    output.write_json(document, json)
    output.print_table(
        _DECAY_SHOWN,
        [tuple(row[key] for key in _DECAY_KEYS) for row in compared.rows],
        title="Free decays, measured less model",
        elsewhere=str(folder / "decay_differences.csv"),
    )
    for text in compared.sentences:
        output.data(f"{text[0].upper()}{text[1:]}")
    output.message(f"results in {folder}, report: {page}")
    output.print_if(pdf, page)


def _write(
    folder: Path,
    comparison: "Comparison",
    document: "Mapping[str, object]",
    title: str,
    evidence: "Evidence",
    *,
    figures: bool,
) -> Path:
    """Write tables, figures and report of a comparison; return the report."""
    from shakerproc import files
    from shakerproc.comparison import COLUMNS, rows_of, sentence
    from shakerproc.workflows.evidence import write_evidence

    files.write_json(folder / "compare.json", document)
    rows = rows_of(comparison)
    table = {name: [row[i] for row in rows] for i, name in enumerate(COLUMNS)}
    files.write_text(folder / "errors.csv", files.csv_text(table))
    if figures:
        from shakerproc.report.evidence.comparison import draw_comparison

        draw_comparison(comparison, folder)
    verdict = f"{sentence(comparison).split('. ')[0].removesuffix('.')}.".replace("^2", "²")
    return write_evidence(folder, title, verdict, evidence, command=output.command())


def _write_modes(folder: Path, modes: "ComparedModes | None") -> None:
    """Write the tables of modes of test and model, if there are any."""
    from shakerproc import files
    from shakerproc.comparison.document import mode_tables

    for name, columns in mode_tables(modes).items():
        files.write_csv(folder / name, columns)


def _print_modes(modes: "ComparedModes | None", folder: Path) -> None:
    """Print the modes of test and model, and how far they are apart."""
    from shakerproc.comparison.document import mode_rows

    if modes is None:
        return
    output.print_table(
        ("measured [Hz]", "model [Hz]", "difference [%]", "zeta measured", "zeta model", "MAC"),
        [row[:6] for row in mode_rows(modes)],
        title=f"Modes of test {modes.test} and of the linear part of the model",
        elsewhere=str(folder / "modes.csv"),
    )
    output.data(modes.sentence)
    if modes.shapes is not None:
        output.data(modes.shapes.sentence)


def _names(old: str, new: str, *, fit: bool) -> tuple[str, str]:
    """Return the names of the two models, distinct."""
    new = f"{new}, fitted" if fit else new
    return (old, new) if old != new else ("old model", "new model")


def _provenance(documents: "Sequence[Document]") -> dict[str, object]:
    from shakerproc import __version__

    (_, model, model_hash), (_, log, log_hash) = documents
    return {
        "version": __version__,
        "model_file": model.name,
        "model_sha256": model_hash,
        "log_file": log.name,
        "log_sha256": log_hash,
    }


def _print(comparison: "Comparison", folder: Path, once: output.Once) -> None:
    """Print the errors of every test, and the notes that were not printed yet."""
    from shakerproc.runs.summary import by_tests

    rows = []
    for test in comparison.tests:
        for i, (name, e) in enumerate(zip(test.measured.sensors, test.errors, strict=True)):
            kept = " (held out)" if test.measured.test.hold_out else ""
            rows.append((
                test.measured.name + kept, test.measured.test.level_text, name, e.error,
                float(test.floor.share[i]), e.psd, e.h1, e.frac, e.peak_hz, e.peak_model_hz,
                e.peak_gain, e.peak_model_gain,
            ))  # fmt: skip
    output.print_table(
        _SHOWN,
        rows,
        title="Errors: residual rms over measured rms",
        spare=("model gain", "gain", "level"),
        elsewhere=str(folder / "errors.csv"),
    )
    if comparison.refit is not None:
        _print_fit(comparison.refit)
    output.messages(by_tests((t.measured.name, t.measured.remarks) for t in comparison.tests))
    for text in (*comparison.left_out, *comparison.warnings):
        once.warning(text)
    for test in comparison.tests:
        for note in test.measured.notes:
            once.warning(note)
        output.messages(test.notes)
        if not test.prediction.predictable:
            output.warning(
                f"test {test.measured.name}: a disturbance of the model's motion grows too "
                f"much for a whole test. The error is taken in windows of "
                f"{numeral(test.prediction.horizon_s)} s, each with its start fitted"
            )


def _print_fit(fitted: "Refit") -> None:
    output.print_table(
        ("element", "between", "number", "before", "fitted", "low", "high", "unit"),
        [
            (p.kind, " and ".join(p.between), p.name, p.before, p.value, p.low, p.high, p.unit)
            for p in fitted.parameters
        ],
        title=f"Fitted to test {', '.join(fitted.tests)}, 95 % intervals",
    )
    for p in fitted.parameters:
        if p.at_bound:
            output.warning(
                f"{p.name} of the {p.kind} between {' and '.join(p.between)} ran against its "
                f"bound; the value means little"
            )
    if not fitted.converged:
        output.warning("the fit has not settled; the numbers may still move")
