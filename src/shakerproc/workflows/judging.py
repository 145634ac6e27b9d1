"""A diagnosis, here or on a cluster.

Every command takes `diagnose_tests` and `add_effect` from here: the one place that says which
room judges.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import TypeAdapter

from shakerproc.batch.elsewhere import at_hand
from shakerproc.compare import Usable
from shakerproc.compare.prediction import LINEAR
from shakerproc.diagnose.adding import add as added_by_observer
from shakerproc.diagnose.candidates import sought
from shakerproc.diagnose.from_files import diagnose_tests as by_observer
from shakerproc.diagnose.translate import unknown
from shakerproc.diagnosis.adding import NO_START, Added
from shakerproc.diagnosis.adding import add as added_by_free_runs
from shakerproc.diagnosis.api import diagnose_tests as by_free_runs
from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.errors import DiagnosisError
from shakerproc.executors import Task
from shakerproc.models import Model
from shakerproc.models.identification import Values
from shakerproc.testlog import TestLog
from shakerproc.workflows.machines import Machines

__all__ = ["Case", "add_effect", "diagnose_tests", "hashes_of", "judge_elsewhere", "judged"]


def diagnose_tests(
    model: Model,
    log: TestLog,
    usable: Usable,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from tests that were read from a log.

    A model that is linear is judged by the room `diagnose`, until its successor was scored on
    fresh seeds; what that room does not know, such as an effect that the model has already, by
    `diagnosis`.
    """
    judge = by_free_runs if needs_free_runs(model) else by_observer
    return judge(model, log, usable, seed=seed, progress=progress)


def add_effect(
    kind: str,
    model: Model,
    log: TestLog,
    *,
    between: Sequence[str] | None = None,
    start: Values = NO_START,
    force: bool = False,
    progress: Callable[[str], None] | None = None,
) -> Added:
    """Return a model with one effect more, fitted to the tests of a log.

    By `diagnosis`, where the room `diagnose` does not know the model or the effect.
    """
    add = added_by_free_runs if unknown(model) or kind not in sought() else added_by_observer
    return add(kind, model, log, between=between, start=start, force=force, progress=progress)


def needs_free_runs(model: Model) -> bool:
    """Return whether a model is more than masses, springs and dampers on a base or a force."""
    kinds = {element.effect.kind for element in model.elements}
    return bool(unknown(model)) or not kinds <= LINEAR


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What is to be judged, for a worker elsewhere.

    Attributes
    ----------
    model : Model
        The model.
    log : TestLog
        The log.
    seed : int
        As for `diagnose`.
    source : str
        Folder or URL of the recordings, as the worker sees it.
    """

    model: Model
    log: TestLog
    seed: int
    source: str


def judge_elsewhere(case: Case) -> Mapping[str, Any]:
    """Return a diagnosis as text, every number to the last digit, and what it was made from."""
    with at_hand(case.log, case.source) as log:
        usable = tests_of(log, case.model)
        found = diagnose_tests(case.model, log, usable, seed=case.seed)
    return {"diagnosis": json.dumps(asdict(found)), "sha256": hashes_of(usable)}


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
    progress: Callable[[str], None],
) -> Diagnosis:
    """Return a diagnosis; on a cluster it is one task, for its steps are too short to send.

    Raises
    ------
    DiagnosisError
        If the task fails on the cluster, or was made of other recordings than are seen here.
    """
    if machines.scheduler is None:
        return diagnose_tests(model, log, usable, seed=seed, progress=progress)
    task = Task("diagnosis", Case(model, log, seed, machines.source(log)))
    (outcome,) = machines.executor().run(judge_elsewhere, [task])
    if outcome.cause:
        raise DiagnosisError(outcome.error)
    if outcome.value["sha256"] != hashes_of(usable):
        raise DiagnosisError(
            f"{log.path.name}: the worker read other recordings than this machine (another "
            "SHA-256); give all machines the same recordings."
        )
    return TypeAdapter(Diagnosis).validate_json(outcome.value["diagnosis"])
