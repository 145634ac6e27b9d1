"""Uncertainty of fitted numbers, and which of them no test determines.

References
----------
.. [1] JCGM 100:2008, "Evaluation of measurement data: guide to the expression of uncertainty in
   measurement" (GUM), 4.2 and 4.3: evaluation of type A and of type B.
.. [2] A. Raue et al., "Structural and practical identifiability analysis of partially observed
   dynamical models by exploiting the profile likelihood", Bioinformatics 25, 1923-1929, 2009.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimate import Estimate, Known
from shakerproc.diagnosis.estimation.scatter import UNTOLD

WIDTH: Final = 1.96
"""Half width of a 95 % interval in standard errors [-]."""

BENT: Final = 0.1
"""Standard deviation of the logarithm of a number beyond which slopes no longer tell how far it
may be from the truth: at the end of its interval the second order is a tenth of the first
[-]."""

INDEPENDENT: Final = 0.1
"""Part of the slopes of a combination that none of those before it has, at least, for it to
say something new [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Uncertainty:
    """Covariances of the coordinates, gains, delays and numbers of tests, by their source.

    1.96 standard deviations are a bound of 95 %.

    Attributes
    ----------
    tests : (n, n) array
        From the scatter within the tests and between them: type A.
    calibration : (n, n) array
        From the gains and delays of the channels, as far as no fit tells them: type B.
    beforehand : (n, n) array
        From what was known of the numbers before: it stands for what no test tells.
    """

    tests: FloatArray
    calibration: FloatArray
    beforehand: FloatArray

    @property
    def total(self) -> FloatArray:
        """All together, (n, n) array."""
        return self.tests + self.calibration + self.beforehand

    def of(self, slopes: FloatArray) -> "Parts":
        """Return the standard deviations of a number that moves with the first coordinates.

        Parameters
        ----------
        slopes : (n_x,) array
            Of the logarithm of its size, by the coordinates [-].
        """
        n = slopes.size
        found = (
            float(np.sqrt(max(float(slopes @ part[:n, :n] @ slopes), 0.0)))
            for part in (self.tests, self.calibration, self.beforehand)
        )
        return Parts(*found)


@final
@dataclass(frozen=True, slots=True)
class Parts:
    """Standard deviations of one number as shares of it, by their source [-].

    Attributes
    ----------
    tests, calibration, beforehand : float
        See `Uncertainty`.
    """

    tests: float
    calibration: float
    beforehand: float

    @property
    def of_tests(self) -> float:
        """Uncertainty from these tests."""
        return float(np.hypot(self.tests, self.beforehand))

    @property
    def is_untold(self) -> bool:
        """Whether what was known before is all that holds the number: no test tells it."""
        return self.beforehand > max(self.tests, self.calibration, BENT)

    def interval(self, value: float, unit: str) -> Estimate:
        """Return a number with its interval of 95 %, open where no test tells it."""
        total = float(np.hypot(self.of_tests, self.calibration))
        if value == 0.0 or self.is_untold or not total < UNTOLD:
            return Estimate(value, None, None, unit)
        both = WIDTH * self.of_tests, WIDTH * self.calibration
        if value > 0.0:
            factor = float(np.exp(WIDTH * total))
            return Estimate(value, value / factor, value * factor, unit, *both)
        reach = WIDTH * total * abs(value)
        return Estimate(value, value - reach, value + reach, unit, *both)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Number:
    """A number of a fit, and how it moves with the coordinates.

    Attributes
    ----------
    value : float
        The number [SI].
    slopes : (n_x,) array
        Of the logarithm of its size, by the coordinates [-].
    unit : str
        Its unit.
    """

    value: float
    slopes: FloatArray
    unit: str


def known_together(
    uncertainty: Uncertainty, numbers: Mapping[str, Number]
) -> tuple[Known, ...]:
    """Return the sums, ratios and products that tests tell of numbers that they do not tell.

    Of each pair those of which no more than a tenth is open of what is open of either; none
    that follows from those before it.

    Parameters
    ----------
    uncertainty : Uncertainty
        Of the coordinates.
    numbers : mapping of str to Number
        All numbers of the fit, by name.
    """
    open_ones = {k: v for k, v in numbers.items() if uncertainty.of(v.slopes).is_untold}
    found = []
    for pair in combinations(open_ones, 2):
        least = min(uncertainty.of(open_ones[name].slopes).beforehand for name in pair)
        for how, one in _combined(*(open_ones[name] for name in pair)):
            parts = uncertainty.of(one.slopes)
            estimate = parts.interval(one.value, one.unit)
            if estimate.low is not None and parts.beforehand < BENT * least:
                found.append((parts.of_tests, one, Known(pair, how, estimate)))
    found.sort(key=lambda row: row[0])
    return tuple(row[2] for row in _independent(found))


def _combined(one: Number, other: Number) -> Iterator[tuple[str, Number]]:
    """Yield sum and difference of two numbers of one unit, their ratio and their product."""
    if one.unit == other.unit:
        for how, sign in (("sum", 1.0), ("difference", -1.0)):
            value = one.value + sign * other.value
            if value != 0.0:
                slopes = one.value * one.slopes + sign * other.value * other.slopes
                yield how, Number(value, slopes / value, one.unit)
    below = f"({other.unit})" if "/" in other.unit else other.unit
    over = "1" if one.unit == other.unit else f"{one.unit}/{below}"
    yield "ratio", Number(one.value / other.value, one.slopes - other.slopes, over)
    times = f"{one.unit} {other.unit}"
    yield "product", Number(one.value * other.value, one.slopes + other.slopes, times)


def _independent(
    found: Sequence[tuple[float, Number, Known]],
) -> Iterator[tuple[float, Number, Known]]:
    """Yield the combinations that do not follow from those before them."""
    taken: list[FloatArray] = []
    for row in found:
        own = row[1].slopes / np.linalg.norm(row[1].slopes)
        rest = own - sum((float(own @ one) * one for one in taken), np.zeros_like(own))
        if np.linalg.norm(rest) > INDEPENDENT:
            taken.append(rest / np.linalg.norm(rest))
            yield row
