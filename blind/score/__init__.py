"""What a set of blind trials adds up to: the table of the issue, and what stands behind it."""

from collections.abc import Sequence
from typing import Any

from blind.score import coverage, forecasts, rows, tables
from blind.trial import Trial


def summary(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return every figure of the score; a trial after a proposed test counts for that alone."""
    first = [trial for trial in trials if trial.retest is None]
    return {
        "trials": len(first),
        "rows": [row.as_json() for row in rows.all_rows(trials)],
        "ties": rows.ties(first),
        "confidence": forecasts.figures(first),
        "intervals": coverage.figures(first),
        "errors": rows.errors(first),
        "seconds": rows.seconds(first),
        "verdicts": tables.verdicts(first),
        "failed": [f"{t.kind} {t.seed}: {t.problem}" for t in trials if t.problem],
    }


def report(trials: Sequence[Trial]) -> str:
    """Return the score as text."""
    first = [trial for trial in trials if trial.retest is None]
    parts = [
        rows.text(trials),
        forecasts.text(first),
        coverage.text(first),
        tables.classes(first),
        tables.confusion(first),
        tables.misses(trials),
    ]
    return "\n\n".join(part for part in parts if part)
