"""The numbers of a verdict that matter, in one line: what was found, how large, how surely."""

import math
from collections.abc import Iterable, Sequence
from typing import Final

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.found import is_within
from shakerproc.diagnosis.number_wording import shown
from shakerproc.diagnosis.result import Diagnosis, Finding
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE
from shakerproc.testlog import Test

BOTH_SIDES: Final = ("gap", "contact_damping")
"""Kinds whose clearance is that of one side, the same on both."""


def headline(diagnosis: Diagnosis, tests: Iterable[Test]) -> str:
    """Return effects with their numbers and the probability; empty where none was found.

    A clearance stands there per side and in total, beside what the log says.
    """
    if not diagnosis.effects:
        return ""
    values = [t.clearance if t.actual_clearance is None else t.actual_clearance for t in tests]
    logged = sorted({value for value in values if value is not None})
    found = "; ".join(_finding(effect, logged) for effect in diagnosis.effects)
    surely = diagnosis.confidence
    return found + ("." if surely is None else f"; probability {surely:.2f}.")


def probability_text(diagnosis: Diagnosis) -> str:
    """Return how probable a verdict is, or why that is not known; empty of component tests."""
    if diagnosis.confidence is not None:
        return f"exactly right with a probability of {100.0 * diagnosis.confidence:.0f} %"
    left, floor = diagnosis.errors.among.held_out.after, diagnosis.errors.among.noise_floor
    if diagnosis.complete and is_within(left, floor):
        return ""
    if not math.isfinite(floor):
        return "no probability: the noise is not known"
    if diagnosis.complete or left <= NEGLIGIBLE:
        return "no probability: more than noise is left"
    return "no probability: more is missing than the library explains"


def _finding(found: Finding, logged: Sequence[float]) -> str:
    """Return an effect and its numbers. `logged` are clearances of the log [m]."""
    numbers = [
        _clearance(found, logged)
        if name == "clearance"
        else f"{name.replace('_', ' ')} {_told(estimate)}"
        for name, estimate in found.parameters.items()
    ]
    numbers.sort(key=lambda text: not text.startswith("clearance"))
    where = " and ".join(found.between)
    joined = "between" if len(found.between) > 1 else "of"
    kind = found.kind.replace("_", " ")
    return ": ".join(filter(None, (f"{kind} {joined} {where}", ", ".join(numbers))))


def _clearance(found: Finding, logged: Sequence[float]) -> str:
    estimate = found.parameters["clearance"]
    if not isinstance(estimate.value, float):
        return f"clearance {estimate.value}"
    beside = ""
    if logged:
        beside = f"the log says {' and '.join(f'{1e3 * v:.2f}' for v in logged)} mm"
    if found.kind not in BOTH_SIDES:
        return f"clearance {_told(estimate)}" + (f" ({beside})" if beside else "")
    total = f"per side, {2e3 * estimate.value:#.3g} mm in total"
    return f"clearance {_told(estimate)} ({'; '.join(filter(None, (total, beside)))})"


def _told(estimate: Estimate) -> str:
    """Return a number, and on which side no test tells it."""
    open_ends = estimate.low is None, estimate.high is None
    if not isinstance(estimate.value, float) or not any(open_ends):
        return shown(estimate)
    if all(open_ends):
        return f"{shown(estimate)}, which no test tells"
    return f"{shown(estimate)}, without {'lower' if open_ends[0] else 'upper'} bound"
