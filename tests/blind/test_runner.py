"""Trials in processes of their own."""

import multiprocessing
import time

import pytest
from blind.__main__ import arguments, trials_of
from tests.blind.works import by_class

from blind import runner

pytestmark = pytest.mark.slow


@pytest.mark.long
def test_one_that_hangs_or_dies_costs_itself_only(monkeypatch, tmp_path):
    monkeypatch.setenv("BLIND_CACHE", str(tmp_path))  # who hung is drawn once
    monkeypatch.setattr(runner, "WALL_OVER_PROCESSOR", 40.0)  # 20 s, to import in as well
    tasks = [(seed, "none") for seed in (1, 2, 3, 4)]
    trials = {trial.seed: trial for trial in runner.run(tasks, by_class, jobs=1, limit=0.5)}
    assert set(trials) == {1, 2, 3, 4}
    assert trials[1].problem == trials[4].problem == ""
    assert trials[2].problem == "timeout: more than 0.5 s of processor time"
    assert trials[3].problem == "died: exit code 7"


def test_what_the_command_does_can_be_handed_over(monkeypatch, tmp_path):
    """A process of its own cannot see what `__main__` defines."""
    handed = []
    monkeypatch.setattr(runner, "run", lambda _, work, *__: handed.append(work) or iter(()))
    trials_of(arguments([]), [(1, "none")])
    trials_of(arguments(["--next-test", str(tmp_path / "none.json")]), [(1, "none")])
    assert [getattr(work, "func", work) for work in handed] == [runner.first, runner.retest]


def test_whoever_stops_listening_ends_the_processes():
    running = runner.run([(1, "none"), (2, "none")], by_class, jobs=1, limit=1000.0)
    next(running)
    start = time.perf_counter()
    running.close()
    assert time.perf_counter() - start < 5.0
    assert not multiprocessing.active_children()
