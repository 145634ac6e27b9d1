"""Tests of a log as arrays."""

from collections.abc import Sequence
from dataclasses import replace

from shakerproc.comparison.measured import Measured, Usable, usable_tests
from shakerproc.diagnosis.data.tests import TestArrays
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model
from shakerproc.recordings import MOST_CLIPPED
from shakerproc.recordings.time_base import CLOCKS
from shakerproc.testlog import TestLog, TimeCrop


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

    Rates are one where they differ by no more than clocks do, or the files resolve.

    Raises
    ------
    DiagnosisError
        If they differ.
    """
    best = min(tests, key=lambda test: test.rate_doubt)
    for test in tests:
        allowed = max(CLOCKS, best.rate_doubt + test.rate_doubt)
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
        measured.error_band,
        measured.gain_spread,
        measured.conditions,
    )
