"""A share of ``make fuzz``, drawn with a fixed seed: nothing hangs, blows up or lies."""

import itertools
import subprocess
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from tests.fuzz.judge import GOOD, Judge, compared
from tests.fuzz.mutants import Mutant, mutants
from tests.fuzz.recorder_seeds import CORE, EXTRAS
from tests.fuzz.seeds import make_seeds
from tests.fuzz.time_seeds import make_time_seeds

from shakerproc.data import Channel, SkippedRows, recording_of_arrays

resource = pytest.importorskip("resource", reason="no memory figures on this system")
SHARES = ((397, 17), pytest.param(79, 11, marks=pytest.mark.long))
"""Every so many mutants, and from which on: some two thousand, some ten thousand."""


@pytest.mark.slow
@pytest.mark.skipif(
    not hasattr(resource, "getrusage"), reason="no memory figures on this system"
)
@pytest.mark.parametrize(("every", "first"), SHARES)
def test_thousands_of_damaged_recordings(tmp_path, every, first):
    seeds = [
        *make_seeds(tmp_path),
        *make_time_seeds(tmp_path),
        *(write(tmp_path) for write in CORE),
    ]
    judge = Judge(tmp_path, seeds)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    counts: Counter[str] = Counter()
    bad = []
    damaged = itertools.chain.from_iterable(mutants(seed) for seed in seeds)
    for number, mutant in itertools.islice(enumerate(damaged), first, None, every):
        outcome, message = judge.outcome(mutant)
        counts[outcome] += 1
        if outcome not in GOOD:
            bad.append((mutant.seed.name, mutant.kind, number, outcome, message))
    assert not bad
    assert sum(counts.values()) >= 600_000 // every
    rare = "times as the damaged file states them"  # one in some ten thousand
    assert all(counts[outcome] for outcome in GOOD if outcome != rare)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 200 * 1024


@pytest.mark.slow
@pytest.mark.parametrize("count", [30, pytest.param(2000, marks=pytest.mark.long)])
@pytest.mark.parametrize("package", EXTRAS)
def test_damaged_recordings_of_recorders(tmp_path, package, count, capfd):
    """Nothing hangs, blows up or is left on the terminal; what is lost is said."""
    pytest.importorskip(package, reason="needs the extra recorders")
    seed = EXTRAS[package](tmp_path)
    judge = Judge(tmp_path, [seed])
    every = list(mutants(seed))
    rng = np.random.default_rng(44)
    outcomes = Counter()
    for at in rng.choice(len(every), count, replace=False):
        outcome, message = judge.outcome(every[at])
        outcomes[outcome] += 1
        assert outcome in GOOD, (every[at].kind, int(at), outcome, message)
    assert outcomes["refused in one line"] > count // 20
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems hand no memory down")
def test_the_peak_of_a_worker_is_its_own_and_not_that_of_what_started_it():
    worker = "from tests.fuzz.campaign import peak_memory as p; print(p(), end='')"
    large = (
        "import subprocess, sys; held = bytearray(1_000_000_000); "
        f"subprocess.run([sys.executable, '-c', {worker!r}], check=True)"
    )
    done = subprocess.run(
        [sys.executable, "-c", large], capture_output=True, text=True, check=True
    )
    assert 20.0 < float(done.stdout) < 500.0


def test_the_judge_sees_rows_that_are_lost_displaced_or_made_up(tmp_path):
    (seed,) = [seed for seed in make_seeds(tmp_path) if seed.name == "comma.csv"]
    values, mutant = seed.values, Mutant("", seed, b"", rows=1)

    def outcome(samples, **said):
        channels = [Channel(name, "m/s^2", name, "g") for name in seed.channels]
        one = recording_of_arrays("run", channels, samples, 1000.0)
        return compared(replace(one, **said), samples, mutant)[0]

    skipped = SkippedRows(1, 0, 40, 40, "")
    without, shifted = np.delete(values, 40, axis=1), np.roll(values, 1, axis=1)
    assert outcome(values) == "read as it was"
    assert outcome(values[:, :70], expected_samples=80) == "prefix, marked"
    assert outcome(without) == "lost silently"
    assert outcome(np.insert(values, 40, 0.0, axis=1)) == "lost silently"
    assert outcome(shifted) == "rows displaced"
    assert outcome(without, skipped=skipped) == "rows displaced"
