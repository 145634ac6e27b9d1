"""Work through a share of the mutants, and make a table of what became of them."""

import gc
import itertools
import re
import resource
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from tests.fuzz.judge import GOOD, OUTCOMES, Judge
from tests.fuzz.mutants import mutants
from tests.fuzz.recorder_seeds import CORE
from tests.fuzz.seeds import Seed, make_seeds
from tests.fuzz.time_seeds import make_time_seeds


def share(number: int, count: int) -> tuple[Counter, list[str], float]:
    """Judge a share, counted from 0; return counts, what is bad, peak memory [MB]."""
    counts: Counter[tuple[str, str]] = Counter()
    bad: list[str] = []
    memory = Path("/dev/shm")  # noqa: S108  a file system in memory spares the disk
    with tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None) as name:
        folder = Path(name)
        with tempfile.TemporaryDirectory() as elsewhere:
            seeds = [*make_seeds(Path(elsewhere)), *make_time_seeds(Path(elsewhere))]
            seeds += [write(Path(elsewhere)) for write in CORE]
        judge = Judge(folder, seeds)
        every_mutant = itertools.chain.from_iterable(mutants(seed) for seed in seeds)
        for i, mutant in enumerate(every_mutant):
            if i % count != number:
                continue
            outcome, message = judge.outcome(mutant)
            counts[mutant.kind, outcome] += 1
            if outcome not in GOOD:
                bad.append(
                    f"{mutant.seed.name}: {mutant.kind}: number {i}: {outcome}: {message}"
                )
    return counts, bad, peak_memory()


def drawn(
    write: Callable[[Path], Seed], count: int, seed: int = 44
) -> Iterator[tuple[str, str, str]]:
    """Yield damage, outcome and what is bad of mutants of one format, drawn by chance."""
    with tempfile.TemporaryDirectory() as name:
        good = write(Path(name))
        judge = Judge(Path(name), [good])
        every = list(mutants(good))
        gc.freeze()  # readers of damaged files collect what they have made: nothing else
        for at in np.random.default_rng(seed).choice(len(every), count, replace=False):
            kind = every[at].kind
            outcome, message = judge.outcome(every[at])
            bad = "" if outcome in GOOD else f"{kind}: number {at}: {outcome}: {message}"
            yield kind, outcome, bad


def peak_memory() -> float:
    """Return the largest memory that this process has had [MB].

    Linux hands `ru_maxrss` down: a process that is started by one of 4 GB has had 4 GB by it.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        own = re.search(r"VmHWM:\s+(\d+) kB", status.read_text())
        if own is not None:
            return int(own[1]) / 1024.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def table(counts: Counter) -> str:
    """The outcomes as text."""
    kinds = list(dict.fromkeys(kind for kind, _ in counts))
    rows = [("damage", "n", *OUTCOMES)]
    for kind in [*kinds, "all"]:
        row = [
            sum(n for (k, o), n in counts.items() if o == outcome and kind in {k, "all"})
            for outcome in OUTCOMES
        ]
        rows.append((kind, str(sum(row)), *map(str, row)))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [
        "| " + " | ".join(c.ljust(w) for c, w in zip(r, widths, strict=True)) + " |"
        for r in rows
    ]
    lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return "\n".join(lines)
