"""What is done with a task in a process of its own."""

from pathlib import Path

from blind import next_test, records
from blind.trial import Trial, attempt, diagnose


def first(seed: int, kind: str, limit: float) -> Trial:
    """Return the trial of a campaign."""
    return attempt(seed, kind, limit=limit)


def retest(seed: int, kind: str, limit: float, *, path: Path) -> Trial:
    """Return the trial of a file after the test that it proposes."""
    known = {(trial.seed, trial.kind): trial for trial in records.read(path)}
    return next_test.again(known[seed, kind], diagnose, limit=limit)
