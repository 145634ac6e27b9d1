"""A forecast as JSON, ``shakerproc-forecast/1``."""

from typing import Any, Final

from shakerproc.forecasts.forecast import Forecast, TestForecast
from shakerproc.forecasts.levels import told_level
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
        "notes": list(found.notes),
    }  # fmt: skip


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
    return {
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
        "sentences": sentences(one),
    }


def _number(one: TestForecast, quantity: Quantity) -> dict[str, Any]:
    spread = one.spreads[quantity]
    low, high = spread.band
    return {
        "value": spread.value, "low": low, "high": high, "linear": one.linear.get(quantity),
        "unit": quantity.unit,
    }  # fmt: skip
