"""Which effect a model lacks, here or on a cluster: the workflow of `shakerproc diagnose`."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, final

from pydantic import TypeAdapter

from shakerproc.campaign.jobs import at_hand
from shakerproc.comparison import Usable
from shakerproc.diagnosis import diagnose_tests
from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.diagnosis.estimate import ESTIMATE_COLUMNS
from shakerproc.diagnosis.headline import probability_text
from shakerproc.diagnosis.progress import TIME_LIMIT_S, Progress
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.diagnosis.updated import Comparisons
from shakerproc.errors import DiagnosisError
from shakerproc.executors import Task
from shakerproc.models import Model
from shakerproc.testlog import TestLog
from shakerproc.workflows.arguments import Machines, log_of, model_of, positive_of, whole_of
from shakerproc.workflows.shown import Shown, frame_of_errors, frame_of_rows, html

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@dataclass(frozen=True, slots=True, eq=False)
class DiagnosisCase:
    """Model and tests of a diagnosis, for a worker elsewhere.

    Attributes
    ----------
    model : Model
        The model.
    log : TestLog
        The log.
    seed, time_limit_s : int, float
        As for `diagnose` [-], [s].
    source : str
        Folder or URL of the recordings, as the worker sees it.
    """

    model: Model
    log: TestLog
    seed: int
    time_limit_s: float
    source: str


def diagnose_remotely(case: DiagnosisCase) -> Mapping[str, Any]:
    """Return a diagnosis as text, every number to the last digit, and its inputs."""
    with at_hand(case.log, case.source) as log:
        usable = tests_of(log, case.model)
        limited = Progress(limit_s=case.time_limit_s)
        diagnosis = diagnose_tests(case.model, log, usable, seed=case.seed, progress=limited)
    return {"diagnosis": json.dumps(asdict(diagnosis)), "sha256": hashes_of(usable)}


def hashes_of(usable: Usable) -> dict[str, str]:
    """Return the hash of the recording of each test, as it was read."""
    return {test.name: test.sha256 for test in usable.tests}


def judged(
    model: Model,
    log: TestLog,
    usable: Usable,
    machines: Machines,
    *,
    seed: int,
    progress: Progress,
    comparisons: Comparisons | None = None,
) -> Diagnosis:
    """Return a diagnosis; on a cluster it is one task, for its steps are too short to send.

    Raises
    ------
    DiagnosisError
        If the task fails on the cluster, or was made of other recordings than are seen here.
    """
    if machines.scheduler is None:
        return diagnose_tests(
            model, log, usable, seed=seed, progress=progress, comparisons=comparisons
        )
    task = Task(
        "diagnosis", DiagnosisCase(model, log, seed, progress.limit_s, machines.source(log))
    )
    (outcome,) = machines.executor().run(diagnose_remotely, [task])
    if outcome.cause:
        raise DiagnosisError(outcome.error)
    if outcome.value["sha256"] != hashes_of(usable):
        raise DiagnosisError(
            f"{log.path.name}: the worker read other recordings than this machine (another "
            "SHA-256); give all machines the same recordings."
        )
    return TypeAdapter(Diagnosis).validate_json(outcome.value["diagnosis"])


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ShownDiagnosis(Shown):
    """Which effect a model lacks, how surely, and which test would settle it.

    Attributes
    ----------
    found : shakerproc.diagnosis.Diagnosis
        The whole of it, typed.
    """

    found: Diagnosis

    @property
    def verdict(self) -> str:
        """Verdict, such as ``effect found`` or ``nothing missing``."""
        return self.found.verdict

    @property
    def sentence(self) -> str:
        """The verdict in a sentence."""
        return self.found.sentence

    @property
    def confidence(self) -> float | None:
        """The probability that verdict, kinds and joints are exactly right [-]."""
        return self.found.confidence

    @property
    def effects(self) -> "DataFrame":
        """The effects that were found: their numbers in SI units, with 95 % intervals."""
        rows = [
            (effect.kind, " - ".join(effect.between), name, *p.row)
            for effect in self.found.effects
            for name, p in effect.parameters.items()
        ]
        names = ("effect", "between", "parameter", *ESTIMATE_COLUMNS)
        return frame_of_rows(names, rows)

    @property
    def errors(self) -> "DataFrame":
        """The free-run errors before and after, and the noise floor [-]."""
        return frame_of_errors(self.found.errors)

    def to_pandas(self) -> "DataFrame":
        """Return every hypothesis that was tried, best first, with its errors [-]."""
        rows = [
            (one.kind, " - ".join(one.between), one.fitted_error, one.held_out_error)
            for one in self.found.candidates
        ]
        return frame_of_rows(("candidate", "between", "fitted_error", "held_out_error"), rows)

    def as_json(self) -> dict[str, Any]:
        """Return the diagnosis as diagnosis.json holds it."""
        return self.found.as_json()

    def plot(self) -> "Figure":
        """Return the errors of all hypotheses beside the model as it was and the noise."""
        from shakerproc.report.evidence.numbers import candidate_errors

        return candidate_errors(self.found)

    def _repr_html_(self) -> str:
        sentences = [
            self.sentence,
            *filter(None, [probability_text(self.found)]),
            *self.found.notes,
        ]
        return html(self.verdict, sentences, self.errors, self.effects, self.to_pandas())


def diagnose(
    model: Any, log: TestLog, *, seed: int = 0, time_limit_s: float = TIME_LIMIT_S
) -> ShownDiagnosis:
    """Return which effect a model lacks, how surely, and which test would settle it.

    Parameters
    ----------
    model : ModelFile or Model
        What `read_model` returned, or a model made in Python.
    log : TestLog
        What `read_log` returned; tests with ``hold_out: true`` are only scored.
    seed : int
        Of the tests that are proposed.
    time_limit_s : float
        About how long it may take; what was not tried for want of time is noted [s].

    Raises
    ------
    ArgumentError
        If an argument is of another kind.
    DiagnosisError
        If the tests and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    known, tests = model_of(model).model, log_of(log)
    number = whole_of("seed", seed, 0)
    limited = Progress(limit_s=positive_of("time_limit_s", time_limit_s))
    usable = tests_of(tests, known)
    return ShownDiagnosis(diagnose_tests(known, tests, usable, seed=number, progress=limited))
