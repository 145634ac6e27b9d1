"""Mistakes of a newcomer in blind campaigns: which are told before a long search, and wrongly.

python -m benchmarks.mistakes [--seed 0] [--classes standard] [--each 1]

Each campaign of `blind` is read as `diagnose` reads it; nothing is searched for. "As it is" and
factors of 2, gains, polarities and delays are for the search to name: to stop there is wrong.
"""

import argparse
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from blind.campaigns import draw

from blind import classes, folder
from shakerproc.comparison import measured_tests
from shakerproc.comparison.measured import Measured
from shakerproc.diagnosis.plausibility import check_plausible
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import read_model
from shakerproc.models import Model
from shakerproc.testlog import read_testlog

Case = tuple[str, Model, list[Measured]]


def heavier(model: Model, factor: float) -> Model:
    """Return the model with every mass multiplied."""
    return replace(model, masses={name: factor * m for name, m in model.masses.items()})


def cases(model: Model, tests: Sequence[Measured]) -> Iterator[Case]:
    """Return what is for the search to name, then mistakes (their names begin with `!`)."""

    def scaled(factor: float) -> list[Measured]:
        return [replace(t, responses=factor * t.responses) for t in tests]

    yield "as it is", model, list(tests)
    for factor in (0.5, 2.0):
        yield f"masses times {factor:g}", heavier(model, factor), list(tests)
    for factor in (0.1, -1.0, 10.0):
        yield f"responses times {factor:g}", model, scaled(factor)
    late = [replace(t, responses=np.roll(t.responses, 3, axis=-1)) for t in tests]
    yield "responses 3 samples late", model, late
    for factor in (1e-3, 1e3):
        yield f"! masses times {factor:g}", heavier(model, factor), list(tests)
        yield f"! responses times {factor:g}", model, scaled(factor)
    if model.excitation.moves_base:
        exchanged = [
            replace(t, controls=t.responses[:1], responses=np.concatenate(
                [t.controls[:1], t.responses[1:]]
            ))
            for t in tests
        ]  # fmt: skip
        yield "! control and first response exchanged", model, exchanged
        turned = [
            replace(t, responses=np.repeat(-t.controls[:1], len(t.responses), axis=0))
            for t in tests
        ]
        yield "! responses are the control turned round", model, turned


def stopped(model: Model, tests: Sequence[Measured]) -> bool:
    """Return whether a diagnosis would stop before its search."""
    try:
        check_plausible(model, tests)
    except DiagnosisError:
        return True
    return False


def main(arguments: Sequence[str] | None = None) -> None:
    """Print for each case in how many of the campaigns it is stopped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--classes", default="standard")
    parser.add_argument("--each", type=int, default=1)
    options = parser.parse_args(arguments)
    asked, found = Counter[str](), Counter[str]()
    wanted = classes.tasks(classes.expand(options.classes, options.each), options.seed)
    for seed, kind in wanted:
        with tempfile.TemporaryDirectory() as place:
            log, path = folder.write(draw(seed, kind), Path(place))
            model = read_model(path)
            tests = measured_tests(read_testlog(log), model)
        for name, wrong, given in cases(model, tests):
            asked[name] += 1
            found[name] += stopped(wrong, given)
    print(f"{len(wanted)} campaigns of {options.classes}, seed {options.seed}: stopped")
    for name, count in asked.items():
        print(f"{name:42s} {found[name]:3d} of {count}")


if __name__ == "__main__":
    main()
