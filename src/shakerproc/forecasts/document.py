"""A forecast as JSON, ``shakerproc-forecast/1``, and in sentences."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.forecasts.forecast import CampaignForecast, TestForecast
from shakerproc.forecasts.levels import JudgedLimit, decibels, raised_level_text
from shakerproc.forecasts.model_error import LastStep
from shakerproc.forecasts.notch_plan import NotchedTest, NotchPlan, lower_drive
from shakerproc.forecasts.notches import C_SQUARED, PROFILE_UNITS
from shakerproc.forecasts.quantities import Quantity
from shakerproc.numerals import numeral

SHOWN: Final[Mapping[str, tuple[str, float]]] = MappingProxyType({
    "m/s^2": ("g", STANDARD_GRAVITY),
    "m": ("mm", 1e-3),
})
"""Unit that a quantity is shown in, and its size in SI; others are shown in SI."""

SCHEMA: Final = "shakerproc-forecast/1"
"""What a forecast.json holds."""


def as_shown(unit: str, *values: float | None) -> tuple[str, list[float | None]]:
    """Return the unit that a quantity is shown in, and values of it [that unit]."""
    name, factor = SHOWN.get(unit, (unit, 1.0))
    return name, [None if value is None else value / factor for value in values]


def headline(forecast: CampaignForecast) -> str:
    """Return go or no-go of all planned tests, with the limit that decides."""
    judged = [(one, limit) for one in forecast.tests for limit in one.limits]
    if not judged:
        return "no verdict: the log has no limits; add limits: {ch3: 40 g peak}, say"
    test, worst = max(judged, key=lambda pair: pair[1].probability)
    text = f"test {test.planned.test.id} exceeds {worst.name} {limit_text(worst)}"
    if all(one.go for one in forecast.tests):
        return f"go: every limit is kept; at most {percent(worst.probability)} that {text}"
    verdict = f"no-go: {text} with a probability of {percent(worst.probability)}"
    plan = test.notch
    if plan is None or plan.notched is None:
        return verdict
    return f"{verdict}; notched, each limit is kept with {percent(plan.wish.probability)}"


def sentences(one: TestForecast) -> list[str]:
    """Return the findings on a planned test, a sentence each."""
    texts = [*departures(one), *(_of_limit(one, judged) for judged in one.limits)]
    return texts if one.notch is None else [*texts, *of_notches(one, one.notch)]


def departures(one: TestForecast) -> list[str]:
    """Return where responses depart from linear scaling, and why, a sentence each."""
    texts = [*filter(None, (_departure(one, name) for name in one.run.motion.responses))]
    if texts and one.reasons:
        texts.append(f"Why: {'; '.join(one.reasons)}.")
    for quantity, value in one.swept_back.items():
        unit, factor = SHOWN.get(quantity.unit, (quantity.unit, 1.0))
        there, here = (numeral(v / factor) for v in (value, one.spreads[quantity].value))
        texts.append(
            f"Swept the other way, {quantity.name} reaches {there} {unit} instead of {here} "
            f"{unit}: it depends on where the sweep comes from."
        )
    return texts


def _of_limit(one: TestForecast, judged: JudgedLimit) -> str:
    level = "" if judged.level_db is None else (
        f"; 5 % at {raised_level_text(one.planned.test, judged.level_db)}"
    )  # fmt: skip
    share = percent(judged.probability)
    return f"{judged.name} {limit_text(judged)} is exceeded with {share}{level}."


def of_notches(one: TestForecast, plan: NotchPlan) -> list[str]:
    """Return the effects of notches on a planned test, a sentence each."""
    texts = []
    if plan.notched is not None:
        each = f"each limit with {percent(plan.wish.probability)}"
        texts.append(f"Notches keep {each}: {_taken(one, plan.notched)}.")
        rows: dict[str, list[str]] = {}
        for quantity, cost in plan.notched.cost_db.items():
            word = "its largest value" if quantity.what == "peak" else quantity.what
            rows.setdefault(quantity.name, []).append(f"{cost:.1f} dB of {word}")
        texts += [f"They cost {name} {' and '.join(told)}." for name, told in rows.items()]
        texts.append(f"Under other phases {_exceeded(one, plan.notched)}.")
    elif plan.needless:
        texts.append(f"No notch is needed: {plan.why_none}.")
    else:
        levels = [judged.level_db for judged in one.limits]
        known = [level for level in levels if level is not None]
        to = f" to {raised_level_text(one.planned.test, min(known))}" if known else ""
        texts.append(f"No notch keeps every limit: {plan.why_none}{to}.")
    if plan.by_force is not None:
        texts.append(
            f"Force limiting (NASA-HDBK-7004C, C^2 = {C_SQUARED:g}) would take "
            f"{_taken(one, plan.by_force)}: {_exceeded(one, plan.by_force)}."
        )
    return texts


def _taken(one: TestForecast, notched: NotchedTest) -> str:
    lower = lower_drive(notched, one.planned.test)
    drive = f", the drive {lower:.1f} dB lower" if lower > 0.0 else ""
    octaves = numeral(notched.octaves, 2)
    return f"{notched.deepest_db:.1f} dB at most, over {octaves} octaves{drive}"


def _exceeded(one: TestForecast, notched: NotchedTest) -> str:
    each = [
        f"{judged.name} {limit_text(judged)} is exceeded with {percent(probability)}"
        for judged, probability in zip(one.limits, notched.exceeds, strict=True)
    ]
    return ", ".join(each)


def _departure(one: TestForecast, name: str) -> str:
    """Return where a response departs from linear scaling by more than its band."""
    parts = []
    for quantity, spread in one.spreads.items():
        if quantity.whose != "response" or quantity.name != name:
            continue
        linear = one.linear[quantity]
        if spread.holds(linear):
            continue
        if quantity.what == "peak_frequency_hz":
            parts.append(
                f"its peak moves from {numeral(linear, 4)} to {numeral(spread.value, 4)} Hz"
            )
        else:
            change_db = decibels(spread.value / linear)
            word = "more" if change_db > 0.0 else "less"
            parts.append(f"{quantity.what} is {numeral(abs(change_db), 2)} dB {word}")
    if not parts:
        return ""
    run = one.run.measured
    return f"{name} departs from linear scaling of test {run.name}: {', '.join(parts)}."


def owner(quantity: Quantity) -> str:
    """Return the owner of a quantity (response, joint, shaker), for people."""
    if quantity.whose == "response":
        return quantity.name
    if quantity.whose == "force":
        return "specimen"
    return f"{quantity.whose} {quantity.name}".strip()


def percent(probability: float) -> str:
    """Return a probability for people."""
    if probability < 0.001:
        return "less than 0.1 %"
    if probability > 0.999:
        return "more than 99.9 %"
    return f"{numeral(100.0 * probability, 2)} %"


def limit_text(judged: JudgedLimit) -> str:
    """Return the value of a limit for people, in g where it is an acceleration."""
    limit = judged.limit
    unit, factor = SHOWN.get(limit.unit, (limit.unit, 1.0))
    return f"{numeral(limit.value / factor)} {unit}"


def document_of(forecast: CampaignForecast) -> dict[str, Any]:
    """Return a forecast as JSON holds it: SI units, 90 % bands."""
    kinds = ("rms", "peak", "peak_frequency_hz")
    errors = {}
    for kind in kinds:
        quantity = next(
            q for q in forecast.tests[0].spreads if q.whose == "response" and q.what == kind
        )
        one = forecast.evidence.error(quantity)
        if one is not None:
            errors[kind] = {
                "fitted_db": one.fitted_db, "growth_db_per_db": one.growth,
                "degrees_of_freedom": one.freedom,
            }  # fmt: skip
    return {
        "schema": SCHEMA,
        "title": forecast.title,
        "tests": [_test(one) for one in forecast.tests],
        "model_error": errors,
        "levels": [
            {
                "test": one.test, "response": one.quantity.name, "what": one.quantity.what,
                "distance_db": one.distance_db, "predicted": one.predicted,
                "measured": one.measured, "error_db": one.error_db,
                "carried_db": one.carried_db,
            }
            for one in forecast.evidence.errors
        ],
        "last_step": _step(forecast.step),
        "notes": list(forecast.notes),
    }  # fmt: skip


def _step(step: LastStep | None) -> dict[str, Any] | None:
    if step is None:
        return None
    rows = [
        {
            "response": one.response, "what": one.what, "unit": one.unit,
            "predicted": one.predicted, "low": one.low, "high": one.high,
            "measured": one.measured, "error_db": one.error_db, "held": one.held,
        }
        for one in step.values
    ]  # fmt: skip
    return {"test": step.test, "told_before": step.told_before, "values": rows}


def _test(one: TestForecast) -> dict[str, Any]:
    responses: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    others: dict[str, Any] = {}
    for quantity in one.spreads:
        rows = {"response": responses, "joint": joints}.get(quantity.whose)
        if rows is None:
            name = (
                f"{quantity.whose} {quantity.what}" if quantity.whose == "shaker" else "force"
            )
            others[name] = _number(one, quantity)
        else:
            rows.setdefault(quantity.name, {})[quantity.what] = _number(one, quantity)
    test = one.planned.test
    entries = {
        "id": test.id,
        "level": raised_level_text(test),
        "go": one.go,
        "excitation": test.excitation,
        "duration_s": one.planned.duration,
        "distance_db": one.distance_db,
        "responses": responses,
        "joints": joints,
        "others": others,
        "limits": [
            {
                "quantity": judged.name,
                "limit": judged.limit.value,
                "unit": judged.limit.unit,
                "probability": judged.probability,
                "level_at_5_percent": (
                    None
                    if judged.level_db is None
                    else raised_level_text(test, judged.level_db)
                ),
            }
            for judged in one.limits
        ],
        "swept_back": {q.name: {q.what: value} for q, value in one.swept_back.items()},
        "sentences": sentences(one),
    }
    return entries if one.notch is None else {**entries, **_notch_plan(one, one.notch)}


def _notch_plan(one: TestForecast, plan: NotchPlan) -> dict[str, Any]:
    """Return a notch plan as JSON: breakpoints in the unit that their key names."""
    notched = plan.notched
    plan_entries: dict[str, Any] = {
        "probability": plan.wish.probability,
        "edges_db_per_octave": plan.wish.slope,
        "why_none": plan.why_none or None,
    }
    if notched is not None:
        plan_entries |= _notched(one, notched)
    if plan.by_force is not None:
        force_limiting = {"c_squared": C_SQUARED, "notch": _breakpoints(plan.by_force)}
        plan_entries["force_limited"] = force_limiting | _notched(one, plan.by_force)
    return {
        "notch": [] if notched is None else _breakpoints(notched),
        "notch_plan": plan_entries,
    }


def _breakpoints(notched: NotchedTest) -> list[dict[str, float]]:
    profile = notched.test.profile
    if profile is None:
        return []
    _, scale, key = PROFILE_UNITS[profile.unit]
    return [
        {"frequency_hz": at, key: level / scale}
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]


def _notched(one: TestForecast, notched: NotchedTest) -> dict[str, Any]:
    costs: dict[str, dict[str, float]] = {}
    for quantity, cost in notched.cost_db.items():
        costs.setdefault(quantity.name, {})[f"{quantity.what}_db"] = cost
    return {
        "deepest_db": notched.deepest_db,
        "octaves": notched.octaves,
        "drive_db": lower_drive(notched, one.planned.test),
        "cost": costs,
        "exceeded": [
            {"quantity": judged.name, "probability": probability}
            for judged, probability in zip(one.limits, notched.exceeds, strict=True)
        ],
    }


def _number(one: TestForecast, quantity: Quantity) -> dict[str, Any]:
    spread = one.spreads[quantity]
    low, high = spread.band
    return {
        "value": spread.value, "low": low, "high": high, "linear": one.linear.get(quantity),
        "unit": quantity.unit,
    }  # fmt: skip
