"""The notch plan: the profile that takes the least away and keeps every limit."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.fitted_numbers import FittedNumbers
from shakerproc.errors import LogError
from shakerproc.forecasts.ensemble import (
    PAIRED_DRAWS,
    Drives,
    Ensemble,
    Planned,
    ensemble,
    n_draws,
)
from shakerproc.forecasts.levels import amplitude_of, decibels
from shakerproc.forecasts.notches import (
    BREAKPOINT_ERROR,
    FORCE_INTO,
    PER_OCTAVE,
    Bound,
    centres_of_bins,
    demand_at,
    force_limited,
    notched_test,
    reduction_of,
)
from shakerproc.forecasts.quantities import Quantity, UncertainQuantity
from shakerproc.testlog import Test, TestLog
from shakerproc.testlog.header import Limit

EDGE_DB_PER_OCTAVE: Final = 24.0
"""Steepest edge of a notch unless another one is asked for: four poles of a filter [dB/oct]."""

PROBABILITY: Final = 0.95
"""With which each limit is kept unless another one is asked for: the usual confidence [-]."""

NOTCHED: Final = ("random", "sine sweep")
"""Kinds of excitation whose profile can have a notch."""

ROUNDS: Final = 8
"""How often the response to a notched profile is simulated anew [-]."""

NEAR_DB: Final = 0.3
"""So near below a limit nothing more can be left: a third of what controllers keep to [dB]."""

WIDEST: Final = 0.5
"""Share of the band, in octaves, up to which a reduction is a notch: beyond, a lower level
[-]."""

FRESH: Final = 3
"""Seeds that verify a plan, each after it was deepened by what the last one missed [-]."""

Spreads: TypeAlias = Callable[[Test, Quantity, Ensemble], UncertainQuantity]
"""From a planned test, a quantity and its simulated tests to all that it may be."""


@final
@dataclass(frozen=True, slots=True)
class NotchWish:
    """Probability that a notch plan keeps, and the slope of its edges.

    Attributes
    ----------
    probability : float
        With which each limit is kept [-].
    slope : float
        Steepest edge [dB/oct].
    """

    probability: float = PROBABILITY
    slope: float = EDGE_DB_PER_OCTAVE

    @classmethod
    def asked(cls, probability: float | None, slope: float | None) -> "NotchWish":
        """Return a wish, with the usual numbers where none are asked for."""
        return cls(
            PROBABILITY if probability is None else probability,
            EDGE_DB_PER_OCTAVE if slope is None else slope,
        )


@final
@dataclass(frozen=True, slots=True, eq=False)
class NotchedTest:
    """A notched test, and the effect of its notches.

    Attributes
    ----------
    test : Test
        As planned, with the notched profile.
    deepest_db, octaves : float
        Largest reduction [dB], and over how many octaves there is any.
    exceeds : tuple of float
        Probability that each limit is exceeded [-].
    cost_db : mapping of Quantity to float
        By how much rms and largest value of each response are lower [dB].
    """

    test: Test
    deepest_db: float
    octaves: float
    exceeds: tuple[float, ...]
    cost_db: dict[Quantity, float]


@final
@dataclass(frozen=True, slots=True, eq=False)
class NotchPlan:
    """The least notches that keep every limit of a planned test.

    Attributes
    ----------
    wish : NotchWish
        What was asked for.
    notched : NotchedTest, optional
        Verified with phases that it was not found with; None where there is none.
    why_none : str
        Why there is none, a clause.
    by_force : NotchedTest, optional
        Semi-empirical force limiting beside it; None where no base drives, or all is kept.
    needless : bool
        Whether every limit is kept without any notch.
    """

    wish: NotchWish
    notched: NotchedTest | None
    why_none: str = ""
    by_force: NotchedTest | None = None
    needless: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class NotchTask:
    """A planned test whose limits are to be kept.

    Attributes
    ----------
    numbers : FittedNumbers
        What the tests tell of the model.
    planned : Planned
        The test without any notch.
    made : Ensemble
        Simulated without any notch.
    limits : sequence of (Limit, Quantity)
        What must be kept.
    spread : callable
        From simulated tests to all that a quantity may be.
    wish : NotchWish
        Probability and edges.
    seed : int
        Of the phases of `made`.
    """

    numbers: FittedNumbers
    planned: Planned
    made: Ensemble
    limits: Sequence[tuple[Limit, Quantity]]
    spread: Spreads
    wish: NotchWish
    seed: int

    @property
    def frequency(self) -> FloatArray:
        """Frequencies at which a reduction is told, (n_bins,) array [Hz]."""
        return centres_of_bins(self.planned.excited)

    def with_reduction(self, reduction: FloatArray) -> Planned:
        """Return the test with a reduction of its profile, (n_bins,) array [dB]."""
        test = notched_test(self.planned.test, self.frequency, reduction)
        return replace(self.planned, test=test)

    def beyond(self, test: Test, made: Ensemble) -> FloatArray:
        """Return the quantile of each limited quantity over its limit, (n_limits,) [dB]."""
        share = self.wish.probability
        ratios = [
            self.spread(test, quantity, made).quantile(share) / limit.value
            for limit, quantity in self.limits
        ]
        return np.asarray(20.0 * np.log10(np.array(ratios)))


def check_notches(log: TestLog, planned: Sequence[Test]) -> None:
    """Pass planned tests whose profiles can have notches, and a log with limits.

    Raises
    ------
    LogError
        If the log has no limit, or an excitation no profile.
    """
    if not log.limits:
        raise LogError(
            f"{log.path.name}: notches keep limits, and the log has none; add limits: "
            "{ch3: 40 g peak}, say"
        )
    for test in planned:
        if test.excitation not in NOTCHED:
            raise log.error(
                test,
                f"notches are planned for random and sine sweep, got {test.excitation}; leave "
                "--notch out, or this test",
            )


def notch_plan(task: NotchTask, say: Callable[[str], None]) -> NotchPlan:
    """Return the least notches that keep every limit, verified with other phases.

    Parameters
    ----------
    task : NotchTask
        The test and its limits.
    say : callable
        Called with what is being done.
    """
    if np.all(task.beyond(task.planned.test, task.made) <= 0.0):
        return NotchPlan(task.wish, None, "every limit is kept without any", needless=True)
    by_force = _by_force(task)
    margin, why = np.zeros(len(task.limits)), ""
    for number in range(1, FRESH + 1):
        reduction = _least(task, margin, say)
        share = _octaves(reduction) / _octaves(np.ones_like(reduction))
        if share > WIDEST:
            why = f"notches would cover {100.0 * share:.0f} % of the band: lower the level"
            return NotchPlan(task.wish, None, why, by_force)
        planned = task.with_reduction(reduction)
        say(f"test {planned.test.id} with notches, other phases")
        drives = Drives(planned, task.seed + number)
        made = ensemble(task.numbers, drives, n_draws(planned))
        beyond = task.beyond(planned.test, made)
        if np.all(beyond <= 0.0):
            notched = _notched(task, planned.test, reduction, made)
            return NotchPlan(task.wish, notched, "", by_force)
        margin = margin + np.maximum(beyond, 0.0)
        why = f"with other phases a limit is missed by {float(np.max(beyond)):.2g} dB"
    return NotchPlan(task.wish, None, why, by_force)


def _least(task: NotchTask, margin: FloatArray, say: Callable[[str], None]) -> FloatArray:
    """Return the least reduction found that keeps limits by margins [dB], (n_bins,) array [dB].

    How the limited quantities follow the drive depends on the drive: they are simulated anew
    under each profile, with the same numbers and phases. Where none keeps every limit, the one
    that nearly does.
    """
    reduction = np.zeros(task.frequency.size)
    watched = tuple(dict.fromkeys(quantity for _, quantity in task.limits))
    before: Mapping[Quantity, FloatArray] = {}
    tried: list[tuple[float, float, FloatArray]] = []
    for number in range(ROUNDS):
        planned = task.with_reduction(reduction)
        say(f"test {planned.test.id} with notches, round {number + 1}")
        few = ensemble(task.numbers, Drives(planned, task.seed), PAIRED_DRAWS, watched=watched)
        beyond = task.beyond(planned.test, task.made.changed_as(few)) + margin
        worst = float(np.max(beyond))
        tried.append((max(worst, 0.0), float(np.sum(reduction)), reduction))
        if -NEAR_DB <= worst <= 0.0:
            break
        full = 10.0 ** (reduction / 20.0) if _sweeps(task) else np.ones_like(reduction)
        passed = {quantity: full * few.passed[quantity] for quantity in watched}
        before = {
            quantity: np.sqrt(one * before[quantity]) if number > 1 else one
            for quantity, one in passed.items()
        }
        reduction = _next(task, before, reduction, beyond)
    return min(tried, key=lambda one: one[:2])[2]


def _next(
    task: NotchTask, passed: Mapping[Quantity, FloatArray], now: FloatArray, beyond: FloatArray
) -> FloatArray:
    """Return the least reduction as the quantities follow the drive now, (n_bins,) array [dB].

    Parameters
    ----------
    task : NotchTask
        The test and its limits.
    passed : mapping of Quantity to (n_bins,) array
        Of noise the mean square of the gain, of a sweep the largest size under the full drive.
    now : (n_bins,) array
        Reduction under which this was found [dB].
    beyond : (n_limits,) array
        Quantiles over their limits there [dB].
    """
    frequency, test = task.frequency, task.planned.test
    least, bounds = np.zeros_like(now), []
    for (limit, quantity), over in zip(task.limits, beyond, strict=True):
        row = passed[quantity]
        if _sweeps(task) and limit.statistic == "peak":
            size = 20.0 * np.log10(np.maximum(row, np.finfo(float).tiny))
            least = np.maximum(least, size - np.max(size - now) + over)
            continue
        if _sweeps(task):  # equal times in each bin, or times that grow with its width
            power = row**2 * (frequency if test.rate_hz_per_s is not None else 1.0)
        else:
            power = row * frequency * demand_at(test, frequency)
        remaining = float(np.sum(power * 10.0 ** (-now / 10.0)))
        bounds.append(Bound(power, remaining * 10.0 ** (-float(over) / 10.0)))
    return reduction_of(np.log2(frequency), bounds, least, task.wish.slope)


def _by_force(task: NotchTask) -> NotchedTest | None:
    """Return the test under semi-empirical force limiting."""
    model = task.numbers.model
    if not model.excitation.moves_base:
        return None
    into = next(quantity for quantity in task.made.values if quantity.whose == FORCE_INTO)
    few = ensemble(
        task.numbers, Drives(task.planned, task.seed), PAIRED_DRAWS, watched=[into]
    )  # fmt: skip
    gain = few.passed[into]
    if _sweeps(task):
        gain = (gain / demand_at(task.planned.test, task.frequency)) ** 2
    reduction = force_limited(task.frequency, gain, model.moved_mass, task.wish.slope)
    planned = task.with_reduction(reduction)
    made = ensemble(task.numbers, Drives(planned, task.seed), PAIRED_DRAWS)
    return _notched(task, planned.test, reduction, task.made.changed_as(made))


def _notched(
    task: NotchTask,
    test: Test,
    reduction: FloatArray,
    made: Ensemble,
) -> NotchedTest:
    exceeds = tuple(
        task.spread(test, quantity, made).exceeds(limit.value)
        for limit, quantity in task.limits
    )
    cost = {
        quantity: decibels(float(np.median(before) / np.median(made.values[quantity])))
        for quantity, before in task.made.values.items()
        if quantity.whose == "response" and quantity.what != "peak_frequency_hz"
    }
    return NotchedTest(test, float(np.max(reduction)), _octaves(reduction), exceeds, cost)


def _sweeps(task: NotchTask) -> bool:
    return task.planned.test.excitation == "sine sweep"


def _octaves(reduction: FloatArray) -> float:
    """Return over how many octaves there is a reduction [-]."""
    return float(np.count_nonzero(reduction > BREAKPOINT_ERROR)) / PER_OCTAVE


def lower_drive(plan: NotchedTest, planned: Test) -> float:
    """Return by how much the drive of a notched test is lower, rms or largest [dB]."""
    before, after = amplitude_of(planned), amplitude_of(plan.test)
    return 0.0 if not before or not after else decibels(before / after)
