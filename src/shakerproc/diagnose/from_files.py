"""A diagnosis from a model and a test log."""

from collections.abc import Callable
from dataclasses import replace

from shakerproc.compare.measured import Usable
from shakerproc.diagnose.diagnosing import diagnose_arrays
from shakerproc.diagnosis.data.from_files import arrays, tests_of
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.models import Model
from shakerproc.testlog import TestLog


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
