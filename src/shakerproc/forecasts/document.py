"""A forecast as JSON, ``shakerproc-forecast/1``."""

from typing import Any, Final

from shakerproc.forecasts.force_limits import C_SQUARED
from shakerproc.forecasts.forecast import Forecast, TestForecast
from shakerproc.forecasts.ladder import LastStep
from shakerproc.forecasts.levels import told_level
from shakerproc.forecasts.notch_plan import Notched, NotchPlan, lower_drive
from shakerproc.forecasts.notched_profiles import WRITTEN
from shakerproc.forecasts.quantities import Quantity
from shakerproc.forecasts.sentences import sentences

SCHEMA: Final = "shakerproc-forecast/1"
"""What a forecast.json holds."""


def document_of(found: Forecast) -> dict[str, Any]:
    """Return a forecast as JSON holds it: SI units, 90 % bands."""
    kinds = ("rms", "peak", "peak_frequency_hz")
    errors = {}
    for kind in kinds:
        quantity = next(
            q for q in found.tests[0].spreads if q.whose == "response" and q.what == kind
        )
        one = found.evidence.error(quantity)
        if one is not None:
            errors[kind] = {
                "fitted_db": one.fitted_db, "growth_db_per_db": one.growth,
                "degrees_of_freedom": one.freedom,
            }  # fmt: skip
    return {
        "schema": SCHEMA,
        "title": found.title,
        "tests": [_test(one) for one in found.tests],
        "model_error": errors,
        "levels": [
            {
                "test": one.test, "response": one.quantity.name, "what": one.quantity.what,
                "distance_db": one.distance_db, "predicted": one.predicted,
                "measured": one.measured, "error_db": one.error_db,
            }
            for one in found.evidence.errors
        ],
        "last_step": _step(found.step),
        "notes": list(found.notes),
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
    found = {
        "id": test.id,
        "level": told_level(test),
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
                    None if judged.level_db is None else told_level(test, judged.level_db)
                ),
            }
            for judged in one.limits
        ],
        "swept_back": {q.name: {q.what: value} for q, value in one.swept_back.items()},
        "sentences": sentences(one),
    }
    return found if one.notch is None else {**found, **_notch_plan(one, one.notch)}


def _notch_plan(one: TestForecast, plan: NotchPlan) -> dict[str, Any]:
    """Return a notch plan as JSON: breakpoints in the unit that their key names."""
    found = plan.found
    told: dict[str, Any] = {
        "probability": plan.wish.probability,
        "edges_db_per_octave": plan.wish.slope,
        "why_none": plan.why_none or None,
    }
    if found is not None:
        told |= _notched(one, found)
    if plan.by_force is not None:
        own = {"c_squared": C_SQUARED, "notch": _breakpoints(plan.by_force)}
        told["force_limited"] = own | _notched(one, plan.by_force)
    return {"notch": [] if found is None else _breakpoints(found), "notch_plan": told}


def _breakpoints(notched: Notched) -> list[dict[str, float]]:
    profile = notched.test.profile
    if profile is None:
        return []
    _, scale, key = WRITTEN[profile.unit]
    return [
        {"frequency_hz": at, key: level / scale}
        for at, level in zip(profile.frequency_hz, profile.level, strict=True)
    ]


def _notched(one: TestForecast, notched: Notched) -> dict[str, Any]:
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
