"""Batches of the tests work within the process of the tests: none has to start, and import."""

import json
import pickle

import pytest

from shakerproc.executors import AbstractExecutor, TaskOutcome
from shakerproc.executors.processes import _attempt
from shakerproc.workflows.arguments import Machines

BY_PROCESSES = Machines.executor


class WithinExecutor(AbstractExecutor):
    """One task after the other; arguments and results cross as they do to a process."""

    def __init__(self, prepare=None):
        self.prepare = prepare

    def run(self, work, tasks):
        if tasks and self.prepare is not None:
            self.prepare()
        for task in tasks:
            report = _attempt(work, pickle.dumps(task.argument))
            yield TaskOutcome(task.name, **json.loads(report))


def _executor(machines, prepare=None):
    if machines.scheduler is not None:
        return BY_PROCESSES(machines, prepare)
    return WithinExecutor(prepare)


@pytest.fixture(scope="session", autouse=True)
def within():
    """Have no batch start processes, but where `processes` is asked for."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Machines, "executor", _executor)
        yield


@pytest.fixture
def processes(within):
    """Have batches of a test start processes, as they do for a user."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Machines, "executor", BY_PROCESSES)
        yield
