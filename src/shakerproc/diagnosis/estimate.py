"""A number with its interval, and the two parts of that."""

from dataclasses import dataclass
from typing import Any, Final, final

ESTIMATE_COLUMNS: Final = ("value", "low", "high", "unit", "by_tests", "by_calibration")
"""Columns of a table of numbers (see `Estimate`)."""


@final
@dataclass(frozen=True, slots=True)
class Estimate:
    """A parameter with its 95 % interval, in an SI unit; a word has no interval.

    A bound that the motion did not exercise is None: not below, or not above, the other. So are
    both of a number that no test tells.

    Attributes
    ----------
    value : float or str
        The number, or a word.
    low, high : float or None
        Bounds of 95 %, in which both parts are.
    unit : str
        SI unit.
    by_tests, by_calibration : float, optional
        Half widths of 95 %, as shares of the value: what these tests leave open, and what the
        calibration of the channels does, which no more tests of the same channels tell [-].
    """

    value: float | str
    low: float | None
    high: float | None
    unit: str
    by_tests: float | None = None
    by_calibration: float | None = None

    @property
    def bounds_by_tests(self) -> tuple[float | None, float | None]:
        """Bounds of what these tests leave open alone; both where they are not told apart.

        Numbers that were fitted together share the calibration.
        """
        if self.by_tests is None or isinstance(self.value, str):
            return self.low, self.high
        reach = self.by_tests * abs(self.value)
        return self.value - reach, self.value + reach

    @property
    def row(self) -> tuple[Any, ...]:
        """The number as a row of a table (see `ESTIMATE_COLUMNS`)."""
        parts = self.by_tests, self.by_calibration
        return self.value, self.low, self.high, self.unit, *parts

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        if isinstance(self.value, str):
            return {"value": self.value, "unit": self.unit}
        parts = {"by_tests": self.by_tests, "by_calibration": self.by_calibration}
        bounds = {"value": self.value, "low": self.low, "high": self.high, "unit": self.unit}
        return bounds if self.by_tests is None else {**bounds, **parts}


@final
@dataclass(frozen=True, slots=True)
class Known:
    """A combination that the tests tell of two numbers of which they tell neither.

    Attributes
    ----------
    numbers : (str, str)
        Their names.
    combination : str
        ``sum``, ``difference`` (first less second), ``ratio`` (first over second) or
        ``product``.
    estimate : Estimate
        Its value.
    """

    numbers: tuple[str, str]
    combination: str
    estimate: Estimate

    def as_json(self) -> dict[str, Any]:
        """Return the part of the document."""
        of = {"numbers": list(self.numbers), "combination": self.combination}
        return {**of, **self.estimate.as_json()}
