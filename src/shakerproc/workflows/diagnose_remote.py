"""A diagnosis, here or on a cluster."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import TypeAdapter

from shakerproc.campaign.remote import at_hand
from shakerproc.comparison import Usable
from shakerproc.diagnosis import diagnose_tests
from shakerproc.diagnosis.compared import Comparisons
from shakerproc.diagnosis.data.from_files import tests_of
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.errors import DiagnosisError
from shakerproc.executors import Task
from shakerproc.models import Model
from shakerproc.testlog import TestLog
from shakerproc.workflows.machines import Machines


@dataclass(frozen=True, slots=True, eq=False)
class DiagnosisCase:
    """Model and tests of a diagnosis, for a worker elsewhere.

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


def diagnose_remotely(case: DiagnosisCase) -> Mapping[str, Any]:
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
    task = Task("diagnosis", DiagnosisCase(model, log, seed, machines.source(log)))
    (outcome,) = machines.executor().run(diagnose_remotely, [task])
    if outcome.cause:
        raise DiagnosisError(outcome.error)
    if outcome.value["sha256"] != hashes_of(usable):
        raise DiagnosisError(
            f"{log.path.name}: the worker read other recordings than this machine (another "
            "SHA-256); give all machines the same recordings."
        )
    return TypeAdapter(Diagnosis).validate_json(outcome.value["diagnosis"])
