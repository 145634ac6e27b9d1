"""The report of a comparison or a diagnosis: one page, the tables beside it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

if TYPE_CHECKING:
    from shakerproc.comparison import Comparison, Measured
    from shakerproc.comparison.modes import ComparedModes
    from shakerproc.diagnosis.result import Diagnosis
    from shakerproc.diagnosis.updated import Comparisons
    from shakerproc.models import Model
    from shakerproc.report.evidence.comparison import Models
    from shakerproc.report.evidence.functions import Decays
    from shakerproc.report.page.methods import Methods
    from shakerproc.report.page.sections import ReportSection
    from shakerproc.runs import RunSummary
    from shakerproc.testlog import TestLog


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Comparison and diagnosis beside the runs in a report.

    Attributes
    ----------
    models : Models, optional
        A model compared with the tests, and its successor.
    diagnosis : Diagnosis, optional
        Which effect is missing.
    inputs : sequence of (str, str, str)
        Files that went in: what they are, their names and their SHA-256.
    decays : Decays, optional
        A model compared with free decays, and the one before it.
    modes : ComparedModes, optional
        Modes of a test beside those of the model.
    """

    models: "Models | None" = None
    diagnosis: "Diagnosis | None" = None
    inputs: Sequence[tuple[str, str, str]] = ()
    decays: "Decays | None" = None
    modes: "ComparedModes | None" = None


SCHEMA: Final = "shakerproc-report/1"
"""What a report.json holds."""

NONE: Final = Evidence()


def write_evidence(
    folder: Path, title: str, verdict: str, evidence: Evidence, *, command: str = ""
) -> Path:
    """Write report.html, report.json and the tables of its numbers; return the page.

    `command` is how it was asked for, as one may type it again.
    """
    from shakerproc import __version__, files
    from shakerproc.report.page.page import Report, write_report

    report = Report(
        title,
        [],
        command=command,
        verdict=verdict,
        sections=sections_of(folder, evidence),
        inputs=evidence.inputs,
        methods=methods_of([], evidence),
    )
    write_report(folder / "report.html", report)
    content = {
        "schema": SCHEMA,
        "shakerproc": __version__,
        "title": title,
        "command": report.command,
        "verdict": verdict,
        **document(evidence),
    }
    files.write_json(folder / "report.json", content)
    return folder / "report.html"


def sections_of(folder: Path, evidence: Evidence) -> "Sequence[ReportSection]":
    """Return the sections of the evidence, its tables written beside the page."""
    if evidence is NONE:
        return ()
    from shakerproc import files
    from shakerproc.report.evidence.functions import mode_sections
    from shakerproc.report.evidence.numbers import tables
    from shakerproc.report.evidence.sections import sections

    for name, columns in tables(evidence.models, evidence.diagnosis).items():
        files.write_csv(folder / name, columns)
    report_sections = [
        *sections(evidence.models, evidence.diagnosis),
        *mode_sections(evidence.modes),
    ]
    if evidence.decays is None:
        return report_sections
    from shakerproc.report.evidence.functions import decay_sections

    return [*report_sections, *decay_sections(evidence.decays)]


def methods_of(runs: "Sequence[RunSummary]", evidence: Evidence) -> "Methods":
    """Return the methods, with the references of every effect that plays a part."""
    from shakerproc.report.page import methods

    models, diagnosis = evidence.models, evidence.diagnosis
    kinds = [] if models is None else [
        element.effect.kind for _, _, c in models.each for element in c.model.elements
    ]  # fmt: skip
    if diagnosis is not None:
        kinds += [*(e.kind for e in diagnosis.effects), *diagnosis.indistinguishable]
    return methods.methods_of(
        [run for run in runs if run.status != "discarded"],
        compared=models is not None,
        diagnosed=diagnosis is not None,
        analyses=[] if evidence.decays is None else ["decays"],
        kinds=tuple(dict.fromkeys(kinds)),
    )


Document: TypeAlias = tuple[str, Path, str]
"""A file that is not a recording: what it is, where it is, and the SHA-256 of what was read."""


def inputs_of(
    documents: Sequence[Document], tests: "Sequence[Measured]"
) -> list[tuple[str, str, str]]:
    """Return every file that went in, with the hash of the bytes that were read."""
    from shakerproc.model_files.effect_files import effect_hashes

    rows = [(what, path.name, digest) for what, path, digest in documents]
    rows += [("effects", name, digest) for name, digest in effect_hashes().items()]
    for one in tests:
        path = one.test.require_recording()
        rows.append((f"test {one.name}", f"{path.parent.name}/{path.name}", one.sha256))
    return rows


def check_same(first: "Sequence[Measured]", second: "Sequence[Measured]") -> None:
    """Pass tests that were read twice, if their recordings were the same both times.

    Raises
    ------
    DiagnosisError
        If one changed in between.
    """
    _check_hashes({one.name: one.sha256 for one in first}, second)


def _check_hashes(known: Mapping[str, str], tests: "Sequence[Measured]") -> None:
    from shakerproc.errors import DiagnosisError

    for one in tests:
        if one.sha256 != known.get(one.name, one.sha256):
            raise DiagnosisError(
                f"{one.run}: the recording changed since it was read before (another SHA-256). "
                "Wait until nothing changes it any more, then call again."
            )


def judged(
    model: "Model",
    diagnosis: "Diagnosis",
    comparisons: "Comparisons",
    warn: Callable[[str], None],
) -> "Models | None":
    """Return a model and the one that a diagnosis leads to, run free against the same tests.

    None where nothing drives them: a whole test cannot be predicted then.
    """
    from shakerproc.diagnosis.updated import updated_model
    from shakerproc.errors import SimulationError
    from shakerproc.report.evidence.comparison import Models

    if model.excitation.role is None:
        return None
    before = comparisons.of(model)
    new = updated_model(model, diagnosis)
    after: Comparison | None = None
    if new is not None:
        try:
            before, after = comparisons.alike(model, new)
        except SimulationError as error:
            warn(f"the new model is not shown: {error}")
    return Models(before, after, new=name_of_new(diagnosis))


def decays_judged(
    model: "Model",
    diagnosis: "Diagnosis",
    measured: "Sequence[Measured]",
    warn: Callable[[str], None],
) -> "Decays | None":
    """Return decays of a model and of the one that a diagnosis leads to, beside those measured.

    None where something drives the tests: `judged` compares whole tests with them.
    """
    from shakerproc.comparison.decays import DecayComparison, decays_of
    from shakerproc.diagnosis.updated import updated_model
    from shakerproc.errors import ShakerprocError
    from shakerproc.report.evidence.functions import Decays

    if model.excitation.role is not None:
        return None
    new = updated_model(model, diagnosis)
    models = [model] if new is None else [new, model]
    try:
        comparisons = [
            DecayComparison(one, tuple(decays_of(one, test) for test in measured))
            for one in models
        ]
    except ShakerprocError as error:
        warn(f"decays of the model are not shown: {error}")
        return None
    return Decays(*comparisons)


def name_of_new(diagnosis: "Diagnosis") -> str:
    """Return the name of the new model in figures."""
    from shakerproc.models import EFFECTS

    kinds = [e.kind.replace("_", " ") for e in diagnosis.effects if e.kind in EFFECTS]
    return f"with {' and '.join(kinds)}" if kinds else "numbers fitted"


def document(evidence: Evidence) -> dict[str, Any]:
    """Return the evidence as the part of a JSON document."""
    if evidence is NONE:
        return {}
    from shakerproc.comparison import document_of

    models, diagnosis = evidence.models, evidence.diagnosis
    inputs = [{"what": a, "file": b, "sha256": c} for a, b, c in evidence.inputs]
    out: dict[str, Any] = {"inputs": inputs}
    if models is not None:
        out["compare"] = {text: document_of(c) for text, _, c in models.each}
    if diagnosis is not None:
        out["diagnosis"] = diagnosis.as_json()
    return out


def held_against(
    model: Path,
    log: "TestLog",
    log_path: Path,
    runs: "Sequence[RunSummary]",
    *,
    tell: Callable[[str], None],
    warn: Callable[[str], None],
) -> Evidence:
    """Return the evidence for a model: compared, diagnosed, compared with the effect.

    Its recordings are those of which the runs were made.
    """
    from shakerproc.diagnosis import diagnose_tests
    from shakerproc.diagnosis.data.from_files import tests_of
    from shakerproc.diagnosis.progress import TIME_LIMIT_S, Progress
    from shakerproc.diagnosis.updated import Comparisons
    from shakerproc.model_files import read_model
    from shakerproc.recordings import read_hashed, sha256

    known, digest = read_hashed(read_model, model)
    usable = tests_of(log, known)
    usable.tell(warn)
    _check_hashes({run.test: run.sha256 for run in runs if run.sha256}, usable.tests)
    comparisons = Comparisons(usable.tests, tell)
    limited = Progress(tell, TIME_LIMIT_S)
    diagnosis = diagnose_tests(known, log, usable, progress=limited, comparisons=comparisons)
    models = judged(known, diagnosis, comparisons, warn)
    documents = [("model", model, digest), ("test log", log_path, sha256(log_path))]
    decays = decays_judged(known, diagnosis, usable.tests, warn)
    return Evidence(models, diagnosis, inputs_of(documents, ()), decays)
