import time

import pytest
from tests.campaign.bad_work import work

from shakerproc.executors import Limits, ProcessExecutor, Task, ThreadExecutor

LIMITS = Limits(time=3.0, memory=1e9)
CAUSES = {
    "raise": ("error", "no luck"),
    "unpicklable": ("error", "cannot cross"),
    "killed": ("killed", "SIGKILL"),
    "hang": ("time limit", "--time-limit"),
    "memory": ("memory limit", "--memory-limit"),
    "exit": ("error", "SystemExit"),
    "not json": ("error", "not JSON serializable"),
}


def outcomes(tasks, n_workers=2):
    ended = list(ProcessExecutor(n_workers, LIMITS).run(work, tasks))
    assert len(ended) == len(tasks)
    return {outcome.name: outcome for outcome in ended}


@pytest.mark.slow
def test_one_bad_task_of_each_kind_leaves_all_others_done():
    kinds = ["good"] * 12
    for place, kind in enumerate(CAUSES):
        kinds.insert(2 * place, kind)
    tasks = [Task(f"{i}", {"kind": kind, "number": i}) for i, kind in enumerate(kinds)]
    ended = outcomes(tasks)
    for i, kind in enumerate(kinds):
        outcome = ended[f"{i}"]
        if kind == "good":
            assert outcome.cause == "", outcome
            assert outcome.value == {"kind": "good", "number": i**2}
        else:
            cause, words = CAUSES[kind]
            assert outcome.cause == cause, outcome
            assert words in outcome.error


@pytest.mark.slow
def test_a_task_whose_process_was_killed_once_gets_a_second_chance(tmp_path):
    tasks = [
        Task("innocent", {"kind": "killed once", "number": 3, "marker": str(tmp_path / "x")}),
        Task("other", {"kind": "good", "number": 2}),
    ]
    ended = outcomes(tasks, n_workers=1)
    assert ended["innocent"].value["number"] == 9
    assert ended["other"].value["number"] == 4


def test_no_tasks_are_done_at_once():
    assert outcomes([]) == {}


@pytest.mark.slow
def test_leaving_early_kills_the_processes_at_once():
    tasks = [Task("quick", {"kind": "good", "number": 1}), Task("h", {"kind": "hang"})]
    running = ProcessExecutor(2, Limits(time=600.0)).run(work, tasks)
    next(running)
    start = time.monotonic()
    running.close()
    assert time.monotonic() - start < 60.0  # the task itself would hang for ten minutes


@pytest.mark.parametrize("name", ["time", "memory"])
def test_limits_must_be_positive(name):
    with pytest.raises(ValueError, match=f"{name} limit must be above 0"):
        Limits(**{name: 0.0})


@pytest.mark.parametrize("kind", [ProcessExecutor, ThreadExecutor])
def test_there_must_be_a_worker(kind):
    with pytest.raises(ValueError, match="n_workers must be above 0"):
        kind(0)
