"""Trials in processes of their own."""

import multiprocessing
import time

import pytest
from tests.blind.works import by_class

from blind import runner

pytestmark = pytest.mark.slow


def test_one_that_hangs_or_dies_costs_itself_only():
    tasks = [(seed, "none") for seed in (1, 2, 3, 4)]
    trials = {trial.seed: trial for trial in runner.run(tasks, by_class, jobs=1, limit=0.5)}
    assert set(trials) == {1, 2, 3, 4}
    assert trials[1].problem == trials[4].problem == ""
    assert trials[2].problem == "timeout: more than 0.5 s of processor time"
    assert trials[3].problem == "died: exit code 7"


def test_whoever_stops_listening_ends_the_processes():
    running = runner.run([(1, "none"), (2, "none")], by_class, jobs=1, limit=1000.0)
    next(running)
    start = time.perf_counter()
    running.close()
    assert time.perf_counter() - start < 5.0
    assert not multiprocessing.active_children()
