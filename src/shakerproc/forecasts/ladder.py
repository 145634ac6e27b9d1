"""The last step of the ladder: what was predicted of the highest level, and what came."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, final

from shakerproc.forecasts.levels import decibels
from shakerproc.forecasts.model_error import LevelError


@final
@dataclass(frozen=True, slots=True)
class StepValue:
    """A quantity of a response: predicted and measured.

    Attributes
    ----------
    response, what, unit : str
        Which, and its SI unit.
    predicted, measured : float
        Before the test, or from the levels below it; and in the test [unit].
    low, high : float, optional
        The 90 % band that was told before the test [unit].
    """

    response: str
    what: str
    unit: str
    predicted: float
    measured: float
    low: float | None = None
    high: float | None = None

    @property
    def error_db(self) -> float:
        """Predicted over measured [dB]."""
        return decibels(self.predicted / self.measured)

    @property
    def held(self) -> bool | None:
        """Whether the band held it; None where none was told before."""
        if self.low is None or self.high is None:
            return None
        return self.low <= self.measured <= self.high


@final
@dataclass(frozen=True, slots=True)
class LastStep:
    """The highest level that was run, predicted and measured.

    Attributes
    ----------
    test : str
        Id of the test.
    told_before : bool
        Whether it was forecast before it was run; else from the levels below it, under the
        drive that was measured.
    values : tuple of StepValue
        Every response.
    """

    test: str
    told_before: bool
    values: tuple[StepValue, ...]

    @property
    def sentence(self) -> str:
        """How it went."""
        if not self.told_before:
            worst = max(self.values, key=lambda one: abs(one.error_db))
            return (
                f"Test {self.test}, predicted from the levels below it: missed by "
                f"{abs(worst.error_db):.2g} dB at most ({worst.response})."
            )
        held = sum(1 for one in self.values if one.held)
        return (
            f"Test {self.test} was forecast before it was run: {held} of {len(self.values)} "
            "values lie in their 90 % bands."
        )


def last_step(
    errors: Sequence[LevelError], earlier: Mapping[str, Any] | None
) -> LastStep | None:
    """Return the highest level that was run, predicted and measured; None where there is none.

    Parameters
    ----------
    errors : sequence of LevelError
        Of levels, the highest last.
    earlier : mapping, optional
        The document of the forecast that was made before, if any.
    """
    if not errors or not errors[-1].distance_db:
        return None
    test = errors[-1].test
    own = [one for one in errors if one.test == test and one.distance_db]
    before = _told_before(earlier or {}, test)
    values = []
    for one in own:
        found = before.get((one.quantity.name, one.quantity.what))
        predicted, low, high = found or (one.predicted, None, None)
        values.append(
            StepValue(
                one.quantity.name, one.quantity.what, one.quantity.unit, predicted,
                one.measured, low, high,
            )
        )  # fmt: skip
    return LastStep(test, all(one.low is not None for one in values), tuple(values))


Told: TypeAlias = dict[tuple[str, str], tuple[float, float, float]]
"""From a response and a quantity of it to the value and its band [unit]."""


def _told_before(earlier: Mapping[str, Any], test: str) -> Told:
    """Return what an earlier document told of the responses of a test before it was run.

    A document that somebody changed by hand told nothing.
    """
    found: Told = {}
    try:
        for one in earlier.get("tests", ()):
            if str(one["id"]) == test:
                for name, rows in one["responses"].items():
                    for what, row in rows.items():
                        band = (float(row["low"]), float(row["high"]))
                        found[name, what] = (float(row["value"]), *band)
                return found
        step = earlier.get("last_step")
        if step and step["test"] == test and step["told_before"]:
            for row in step["values"]:
                told = (float(row["predicted"]), float(row["low"]), float(row["high"]))
                found[row["response"], row["what"]] = told
    except (KeyError, TypeError, ValueError, AttributeError):
        return {}
    return found
