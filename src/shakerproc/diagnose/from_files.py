"""A diagnosis from a model and a test log."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from shakerproc.compare.measured import Measured, Usable, usable_tests
from shakerproc.diagnose.diagnosing import diagnose_arrays
from shakerproc.diagnose.prepare import TestArrays
from shakerproc.diagnose.result import Diagnosis
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model
from shakerproc.recordings import MOST_CLIPPED
from shakerproc.recordings.choosing import SAME_RATE
from shakerproc.testlog import TestLog, TimeCrop


def diagnose(
    model: Model,
    log: TestLog,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from the tests of a log.

    Parameters
    ----------
    model : Model
        The model as it is.
    log : TestLog
        The tests; those with ``hold_out: true`` are only scored.
    seed : int
        Returned with the result; nothing is drawn.
    progress : callable, optional
        Called with what is being done.

    Raises
    ------
    DiagnosisError
        If the tests and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    return diagnose_tests(model, log, tests_of(log, model), seed=seed, progress=progress)


def diagnose_tests(
    model: Model,
    log: TestLog,
    usable: Usable,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Return which effect a model lacks, judged from tests that were read from a log."""
    measured = usable.tests
    clearances = [float(m.test.actual_clearance or m.test.clearance or 0.0) for m in measured]
    found = diagnose_arrays(
        model,
        [arrays(m) for m in measured],
        sensors=measured[0].sensors,
        clearances=[c for c in clearances if c > 0.0],
        shaker=log.shaker,
        seed=seed,
        progress=progress,
    )
    return replace(found, notes=(*usable.left_out, *found.notes))


def tests_of(log: TestLog, model: Model) -> Usable:
    """Return the tests of a log that can be judged together.

    Raises
    ------
    DiagnosisError
        If there are none, they do not go together, or there is nothing to fit to.
    ShakerprocError
        If a recording cannot be used.
    """
    usable = usable_tests(log, model, most_clipped=MOST_CLIPPED)
    usable = replace(usable, tests=at_one_rate(log, usable.tests))
    if all(m.test.hold_out for m in usable.tests):
        why = f" {usable.left_out[0]}" if usable.left_out else ""
        raise DiagnosisError(
            f"{log.path.name}: every test is held out, so there is nothing to fit to; take "
            f"hold_out from some.{why}"
        )
    return usable


def at_one_rate(log: TestLog, tests: Sequence[Measured]) -> tuple[Measured, ...]:
    """Return the tests at the rate that is known best, where they have one.

    Rates are one where they differ by no more than the files resolve.

    Raises
    ------
    DiagnosisError
        If they differ.
    """
    best = min(tests, key=lambda test: test.rate_doubt)
    for test in tests:
        allowed = max(SAME_RATE, best.rate_doubt + test.rate_doubt)
        if abs(test.sample_rate / best.sample_rate - 1.0) > allowed:
            raise DiagnosisError(
                f"{log.path.name}: test {best.name} has {best.sample_rate:.9g} samples per "
                f"second, test {test.name} {test.sample_rate:.9g}: they cannot be judged "
                "together; put them into logs of their own."
            )
    return tuple(replace(test, sample_rate=best.sample_rate) for test in tests)


def arrays(measured: Measured) -> TestArrays:
    """Return a measured test as the search takes it: the part that the log names, or all.

    A threshold cuts nothing away: rest before and after the run shows the noise.
    """
    test = measured.test
    kept = slice(None)
    if isinstance(test.processing.crop, TimeCrop):
        kept = slice(measured.start, measured.stop)
    return TestArrays(
        f"test {measured.name}",
        measured.sample_rate,
        measured.controls[:, kept],
        measured.responses[:, kept],
        bool(test.hold_out),
        test.excitation or "",
        test.level,
        test.level_unit or "",
        measured.excited,
    )
