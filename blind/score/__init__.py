"""What a set of blind trials adds up to: the table of the issue, and what stands behind it."""

from collections.abc import Sequence
from typing import Any

from blind.score import coverage, forecasts, rows, tables
from blind.trial import Trial


def summary(trials: Sequence[Trial]) -> dict[str, Any]:
    """Return every figure of the score."""
    return {
        "trials": len(trials),
        "rows": [row.as_json() for row in rows.all_rows(trials)],
        "ties": rows.ties(trials),
        "confidence": forecasts.figures(trials),
        "intervals": coverage.figures(trials),
        "errors": rows.errors(trials),
        "seconds": rows.seconds(trials),
        "verdicts": tables.verdicts(trials),
        "failed": [f"{t.kind} {t.seed}: {t.problem}" for t in trials if t.problem],
    }


def report(trials: Sequence[Trial]) -> str:
    """Return the score as text."""
    parts = [
        rows.text(trials),
        forecasts.text(trials),
        coverage.text(trials),
        tables.classes(trials),
        tables.confusion(trials),
        tables.misses(trials),
    ]
    return "\n\n".join(part for part in parts if part)
