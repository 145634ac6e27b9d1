"""A share of ``make fuzz``, drawn with a fixed seed: nothing hangs, blows up or lies."""

import itertools
from collections import Counter

import pytest
from tests.fuzz.judge import GOOD, Judge
from tests.fuzz.mutants import mutants
from tests.fuzz.seeds import make_seeds

resource = pytest.importorskip("resource", reason="no memory figures on this system")
EVERY, FIRST = 58, 17
"""Which mutants are taken: some five thousand, of every seed and kind."""


@pytest.mark.slow
@pytest.mark.skipif(
    not hasattr(resource, "getrusage"), reason="no memory figures on this system"
)
def test_five_thousand_damaged_recordings(tmp_path):
    seeds = make_seeds(tmp_path)
    judge = Judge(tmp_path, seeds)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    counts: Counter[str] = Counter()
    bad = []
    every = itertools.chain.from_iterable(mutants(seed) for seed in seeds)
    for number, mutant in enumerate(every):
        if number % EVERY != FIRST:
            continue
        outcome, message = judge.outcome(mutant)
        counts[outcome] += 1
        if outcome not in GOOD:
            bad.append((mutant.seed.name, mutant.kind, number, outcome, message))
    assert not bad
    assert sum(counts.values()) >= 5000
    assert all(counts[outcome] for outcome in GOOD)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 200 * 1024
