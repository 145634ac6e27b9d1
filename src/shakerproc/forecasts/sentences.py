"""A forecast in sentences: go or no-go, and where linear scaling is wrong and why."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.forecasts.forecast import Forecast, TestForecast
from shakerproc.forecasts.levels import decibels, told_level
from shakerproc.forecasts.limits import Judged
from shakerproc.numerals import numeral

SHOWN: Final[Mapping[str, tuple[str, float]]] = MappingProxyType({
    "m/s^2": ("g", STANDARD_GRAVITY),
    "m": ("mm", 1e-3),
})
"""Unit that a quantity is shown in, and its size in SI; others are shown in SI."""


def headline(found: Forecast) -> str:
    """Return go or no-go of all planned tests, with the limit that decides."""
    judged = [(one, limit) for one in found.tests for limit in one.limits]
    if not judged:
        return "no verdict: the log has no limits; add limits: {ch3: 40 g peak}, say"
    test, worst = max(judged, key=lambda pair: pair[1].probability)
    told = f"test {test.planned.test.id} exceeds {worst.name} {told_limit(worst)}"
    if all(one.go for one in found.tests):
        return f"go: every limit is kept; at most {percent(worst.probability)} that {told}"
    return f"no-go: {told} with a probability of {percent(worst.probability)}"


def sentences(one: TestForecast) -> list[str]:
    """Return what to know of a planned test, a sentence each."""
    found = [*filter(None, (_departure(one, name) for name in one.run.motion.responses))]
    if found and one.reasons:
        found.append(f"Why: {'; '.join(one.reasons)}.")
    for judged in one.limits:
        level = "" if judged.level_db is None else (
            f"; 5 % at {told_level(one.planned.test, judged.level_db)}"
        )  # fmt: skip
        found.append(
            f"{judged.name} {told_limit(judged)} is exceeded with "
            f"{percent(judged.probability)}{level}."
        )
    return found


def _departure(one: TestForecast, name: str) -> str:
    """Return where a response departs from linear scaling by more than its band."""
    told = []
    for quantity, spread in one.spreads.items():
        if quantity.whose != "response" or quantity.name != name:
            continue
        linear, (low, high) = one.linear[quantity], spread.band
        if low <= linear <= high:
            continue
        if quantity.what == "peak_frequency_hz":
            told.append(
                f"its peak moves from {numeral(linear, 4)} to {numeral(spread.value, 4)} Hz"
            )
        else:
            apart = decibels(spread.value / linear)
            word = "more" if apart > 0.0 else "less"
            told.append(f"{quantity.what} is {numeral(abs(apart), 2)} dB {word}")
    if not told:
        return ""
    run = one.run.measured
    return f"{name} departs from linear scaling of test {run.name}: {', '.join(told)}."


def percent(probability: float) -> str:
    """Return a probability for people."""
    if probability < 0.001:
        return "less than 0.1 %"
    if probability > 0.999:
        return "more than 99.9 %"
    return f"{numeral(100.0 * probability, 2)} %"


def told_limit(judged: Judged) -> str:
    """Return the value of a limit for people, in g where it is an acceleration."""
    limit = judged.limit
    unit, factor = SHOWN.get(limit.unit, (limit.unit, 1.0))
    return f"{numeral(limit.value / factor)} {unit}"
