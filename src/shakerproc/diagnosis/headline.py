"""The numbers of a verdict that matter, in one line: what was found, how large, how surely."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from shakerproc.diagnosis.estimate import Estimate, Known
from shakerproc.diagnosis.found import is_within
from shakerproc.diagnosis.result import Diagnosis, Errors, Finding
from shakerproc.diagnosis.selection.choice import NEGLIGIBLE
from shakerproc.diagnosis.selection.each_test import OneTest
from shakerproc.numerals import numeral
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
    scale = found.scaled_by
    if scale is not None and numbers:
        numbers[-1] += f" at a {scale.condition} of {scale.at}, proportional to it"
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


LEAST_SHARE: Final = 1e-4
"""Share of a number below which what calibration leaves open of it has no figure: stiffness
does not move with the scale of base and response [-]."""

MODAL: Final = ("frequency ", "damping_ratio ")
"""How the names of numbers of modes of structures begin (see `naming.mode_name`)."""


def off_sentences(off: Mapping[str, tuple[float, Estimate]]) -> list[str]:
    """Return which numbers of the model were off, old and new; nothing where none was."""
    modal = {name: both for name, both in off.items() if name.startswith(MODAL)}
    numbers = "; ".join(
        f"{name} {shown(replace(new, value=was), within=False)} in the file, "
        f"fitted {shown(new)}"
        for name, (was, new) in off.items()
        if name not in modal
    )
    said = [f"Numbers of the model were off: {numbers}."] if numbers else []
    for what in MODAL:
        changes = [
            float(new.value) / was - 1.0
            for name, (was, new) in modal.items()
            if name.startswith(what)
        ]
        if changes:
            most = max(changes, key=abs)
            count = f"{len(changes)} mode" + ("s were" if len(changes) > 1 else " was")
            which = what.strip().replace("_", " ")
            said.append(f"{count} off in {which}, by {100.0 * most:+.2g} % at most.")
    return said


def known_sentences(known: Sequence[Known]) -> list[str]:
    """Return which numbers no test tells one by one, and what it tells of them together."""
    by_pair: dict[tuple[str, str], list[str]] = {}
    for one in known:
        said = f"their {one.combination}, {shown(one.estimate)}"
        by_pair.setdefault(one.numbers, []).append(said)
    return [
        f"These tests do not tell {a} and {b} one by one, only {' and '.join(said)}."
        for (a, b), said in by_pair.items()
    ]


def shown_by_one_sentence(test: OneTest) -> str:
    """Return that one test alone shows what was found, and what to hold out instead."""
    return f"Of these tests {test.name} alone shows it: {_held_out_instead(test)}."


def unexplained_sentence(test: OneTest) -> str:
    """Return that a model leaves more than noise of a test, and what to hold out instead."""
    which = "which was fitted" if test.fitted else "which was held out"
    return (
        f"Of {test.name}, {which}, {numeral(test.error)} is left, "
        f"{numeral(test.error / test.floor, 2)} times its noise: {_held_out_instead(test)}."
    )


def whole_sentence(errors: Errors) -> str:
    """Return that whole tests are not explained as the time ahead is that was judged."""
    left, without = errors.held_out.after, errors.without
    beside = "" if without is None else f", {numeral(without)} without it"
    return f"Over whole tests {numeral(left)} is left{beside}: more is missing."


def short_sentence(horizon_s: float | None) -> str:
    """Return that a model predicts worse further ahead than candidates were judged."""
    return f"Further than {numeral(horizon_s or 0.0, 2)} s ahead more is missing."


def _held_out_instead(test: OneTest) -> str:
    others = [name for name in test.instead_of if name != test.name]
    if others:
        return f"repeat it, and hold the repeat out instead of {' and '.join(others)}"
    return "repeat it, and mark the repeat hold_out: true"


def shown(estimate: Estimate, *, within: bool = True) -> str:
    """Return a number for people, `within` what tests and calibration leave open of it."""
    value = estimate.value
    if not isinstance(value, float):
        return str(value)
    unit, factor = ("mm", 1e3) if estimate.unit == "m" else (estimate.unit, 1.0)
    number = f"{factor * value:#.3g}" if unit == "mm" else numeral(value, 4)
    said = f"{number} {unit}".removesuffix(" 1").removesuffix(" -")
    if not within or estimate.by_tests is None:
        return said
    said += f" +- {_per_cent(estimate.by_tests)} by these tests"
    if (estimate.by_calibration or 0.0) < LEAST_SHARE:
        return said
    return f"{said}, +- {_per_cent(estimate.by_calibration or 0.0)} by calibration"


def _per_cent(share: float) -> str:
    return f"{numeral(100.0 * share, 2)} %"
