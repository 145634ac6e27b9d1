"""Numbers of a diagnosis with their intervals, for people."""

import math
from collections.abc import Mapping
from typing import Final

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.number_wording import LEAST_SHARE
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.numerals import numeral
from shakerproc.report.page.sections import ReportTable

_SHOWN_UNITS: Final[Mapping[str, tuple[str, float]]] = {
    "m": ("mm", 1e3),
    "kg": ("g", 1e3),
    "m/s^2": ("m/s²", 1.0),
    "1": ("-", 1.0),
}


def candidate_name(kind: str, parameters: Mapping[str, Estimate]) -> str:
    """Return the kind of a candidate, with its side where it has one."""
    side = parameters.get("side")
    name = kind.replace("_", " ").replace("+", " + ")
    return name if side is None else f"{name}, {side.value}"


def parameter_tables(diagnosis: Diagnosis) -> list[ReportTable]:
    """Return the numbers of effects found, of the linear joints, and of every candidate."""
    parts = ("± by tests", "± by calibration")
    columns = ("", "between", "number", "value", "low", "high", *parts, "unit")
    found = [
        (
            effect.kind.replace("_", " "), " - ".join(effect.between), name,
            *_apart(estimate),
        )
        for effect in diagnosis.effects
        for name, estimate in (effect.parameters or {"": Estimate("", None, None, "")}).items()
    ]  # fmt: skip
    linear = [
        ("linear joint", place, number, *_apart(estimate))
        for name, estimate in diagnosis.linear.items()
        for number, place in [name.split(" ", 1)]
    ]
    tried = [
        (
            candidate_name(c.kind, c.parameters), " - ".join(c.between), name,
            *_apart(estimate),
        )
        for c in diagnosis.candidates
        if c.held_out_error is not None
        for name, estimate in c.parameters.items()
    ]  # fmt: skip
    together = [
        (one.combination, " and ".join(one.numbers), *_apart(one.estimate))
        for one in diagnosis.known_together
    ]
    tables = [
        ReportTable("Found, with 95 % intervals", columns, [*found, *linear]),
        ReportTable("Known of numbers that no test tells one by one", ("", "of", *columns[3:]),
              together),
        ReportTable("Candidates that were fitted, with 95 % intervals of those that stand",
              columns, tried),
    ]  # fmt: skip
    return [table for table in tables if table.rows]


def interval(estimate: Estimate) -> tuple[str, str, str, str, str]:
    """Return value, low, high, half width in per cent, and unit, for people."""
    if isinstance(estimate.value, str):
        return estimate.value, "", "", "", ""
    unit, factor = _SHOWN_UNITS.get(estimate.unit, (estimate.unit, 1.0))
    value = estimate.value * factor
    low, high = (
        "" if end is None or not math.isfinite(end) else numeral(end * factor, 4)
        for end in (estimate.low, estimate.high)
    )
    half = ""
    if estimate.low is not None and estimate.high is not None and value:
        half = f"{numeral(50.0 * abs((estimate.high - estimate.low) / estimate.value), 2)} %"
    return numeral(value, 4), low, high, half, unit


def _apart(estimate: Estimate) -> tuple[str, str, str, str, str, str]:
    """Return value, low, high, what tests and what calibration leave open, and unit."""
    value, low, high, _, unit = interval(estimate)
    tests, calibration = map(_per_cent, (estimate.by_tests, estimate.by_calibration))
    return value, low, high, tests, calibration, unit


def _per_cent(share: float | None) -> str:
    """Return a share [-] in per cent; below LEAST_SHARE only that it is."""
    if share is None:
        return ""
    return (
        f"< {100.0 * LEAST_SHARE:g} %"
        if share < LEAST_SHARE
        else f"{numeral(100.0 * share, 2)} %"
    )


def shown_value(estimate: Estimate) -> str:
    """Return a value in the unit that people use, without it."""
    return interval(estimate)[0]
