"""A diagnosis, here or on a cluster."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass

from pydantic import TypeAdapter

from shakerproc.batch.elsewhere import at_hand
from shakerproc.cli.machines import Machines
from shakerproc.diagnose import Diagnosis, diagnose
from shakerproc.errors import DiagnosisError
from shakerproc.executors import Task
from shakerproc.models import Model
from shakerproc.testlog import TestLog


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


def judge_elsewhere(case: Case) -> Mapping[str, str]:
    """Return a diagnosis as text, every number to the last digit."""
    with at_hand(case.log, case.source) as log:
        found = diagnose(case.model, log, seed=case.seed)
    return {"diagnosis": json.dumps(asdict(found))}


def judged(
    model: Model,
    log: TestLog,
    machines: Machines,
    *,
    seed: int,
    progress: Callable[[str], None],
) -> Diagnosis:
    """Return a diagnosis; on a cluster it is one task, for its steps are too short to send.

    Raises
    ------
    DiagnosisError
        If the task fails on the cluster.
    """
    if machines.scheduler is None:
        return diagnose(model, log, seed=seed, progress=progress)
    task = Task("diagnosis", Case(model, log, seed, machines.source(log)))
    (outcome,) = machines.executor().run(judge_elsewhere, [task])
    if outcome.cause:
        raise DiagnosisError(outcome.error)
    return TypeAdapter(Diagnosis).validate_json(outcome.value["diagnosis"])
