"""Forecasts of planned tests, with bands that were earned on the levels that were run."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from types import MappingProxyType
from typing import Any, Final, final

import numpy as np

from shakerproc.comparison import Measured
from shakerproc.data import FloatArray
from shakerproc.diagnosis.fitted_numbers import FittedNumbers, fit_of, fit_to_fewer, numbers_of
from shakerproc.errors import DiagnosisError, LogError
from shakerproc.forecasts.ensemble import (
    PAIRED_DRAWS,
    Drives,
    Ensemble,
    Planned,
    ensemble,
    fitted_motion,
    n_draws,
    spreads_of,
)
from shakerproc.forecasts.levels import (
    ALLOWED,
    JudgedLimit,
    amplitude_of,
    amplitude_of_measured,
    decibels,
    drive_rms,
    excited_band,
    grouped,
    in_order,
    kind_of,
    kind_of_measured,
    level_of,
    nearest_level,
    quantity_of,
)
from shakerproc.forecasts.model_error import (
    Error,
    LastStep,
    LevelError,
    ModelledRun,
    carried_share,
    error_of,
    freed,
    last_step,
    level_errors,
    mean_errors,
    prepared_drive,
    run_of,
)
from shakerproc.forecasts.motion import reasons
from shakerproc.forecasts.notch_plan import (
    NotchPlan,
    NotchTask,
    NotchWish,
    check_notches,
    notch_plan,
)
from shakerproc.forecasts.quantities import (
    Quantity,
    UncertainQuantity,
    densities,
    largest_in,
    samples_besides,
    spread_of,
    values_of_motion,
)
from shakerproc.models import Model
from shakerproc.numerals import numeral
from shakerproc.planning.drive import duration_of_test
from shakerproc.planning.rehearsal import check_drive
from shakerproc.runs.opening import stated
from shakerproc.testlog import Test, TestLog
from shakerproc.testlog.header import Limit

OUTSIDE: Final = 0.01
"""Share of its ends by which band or condition of a planned test may lie outside those of the
tests that were run [-]."""

FAR_DB: Final = 12.0
"""Distance in level from which a forecast is called far: four times the amplitude [dB]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModelEvidence:
    """Numbers of the model from tests that were run, and its errors there.

    Attributes
    ----------
    numbers : FittedNumbers
        Fitted to all of them that are not held out.
    runs : tuple of ModelledRun
        Every test that was run beside the fitted model, the lowest level first.
    errors : tuple of LevelError
        Of levels that were fitted, and of each forecast from those below it.
    highest : float
        Amplitude of the highest level that was fitted [SI].
    simulated : dict
        Errors of draws in nearest levels so far, by their tests and the number of draws.
    """

    numbers: FittedNumbers
    runs: tuple[ModelledRun, ...]
    errors: tuple[LevelError, ...]
    highest: float
    simulated: dict[tuple[tuple[str, ...], int], dict[Quantity, FloatArray]] = field(
        default_factory=dict
    )

    def error(self, quantity: Quantity) -> Error | None:
        """Return the model error of a quantity; None of the table, which no model moves.

        Of responses beside the nearest level, whose error is carried on; joints and forces are
        not measured, so theirs is that of the model alone.
        """
        if quantity.whose == "shaker" and quantity.what != "force":
            return None
        if quantity.whose == "response":
            return error_of([one for one in self.errors if one.quantity.what == quantity.what])
        return error_of([one.of_model for one in self.errors if one.quantity.what == "peak"])

    def nearest(self, test: Test, count: int) -> "Nearest":
        """Return the level that was run next to a planned test, and so many draws of it [-]."""
        fitted = [run.measured for run in self.runs if not run.measured.test.hold_out]
        model = self.numbers.model
        kind = kind_of(model, test, stated(test))
        near = nearest_level(model, fitted, kind, amplitude_of(test) or self.highest)
        key = (tuple(one.name for one in near), count)
        if key not in self.simulated:
            self.simulated[key] = mean_errors([
                error
                for one in near
                for error in level_errors(
                    self.numbers, one, prepared_drive(one), self.highest, count
                )
            ])
        same_drive = kind_of_measured(model, near[0]) == kind
        amplitude = max(map(amplitude_of_measured, near))
        return Nearest(self.simulated[key], amplitude, same_drive)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The level that was run next to a planned test.

    Attributes
    ----------
    errors : mapping of Quantity to (1 + n_draws,) array
        Of the fitted numbers and of draws of them there [dB].
    amplitude : float
        Rms of its drive [SI].
    same_drive : bool
        Whether it is driven alike.
    """

    errors: dict[Quantity, FloatArray]
    amplitude: float
    same_drive: bool

    def freed(self, quantity: Quantity, made: Ensemble) -> FloatArray:
        """Return drawn values that begin at the measured one, (n_draws,) array [its unit]."""
        values = made.values[quantity]
        if quantity not in self.errors:
            return values
        near = self.errors[quantity][1 + made.draws]
        near = np.where(np.isfinite(near), near, np.nanmedian(self.errors[quantity]))
        share = carried_share(near, 20.0 * np.log10(values), same_drive=self.same_drive)
        return np.asarray(values * 10.0 ** (-share * near / 20.0))


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestForecast:
    """Forecast of one planned test.

    Attributes
    ----------
    planned : Planned
        The test.
    distance_db : float
        Its level above the highest that was fitted [dB].
    made : Ensemble
        Simulated at its level.
    spreads : mapping of Quantity to UncertainQuantity
        Each quantity with its band.
    linear : mapping of Quantity to float
        What scaling of the highest level that was run says [unit of the quantity].
    limits : tuple of JudgedLimit
        Limits of the log.
    near : Nearest
        The level next to it, at which responses begin.
    run : ModelledRun
        The highest level that was run, which is scaled.
    reasons : tuple of str
        What joints do otherwise than there.
    swept_back : mapping of Quantity to float
        Of a sweep, what responses do in the other direction, where that is outside the band
        [unit of the quantity].
    notch : NotchPlan, optional
        The least notches that keep every limit, where they were asked for.
    """

    __test__ = False

    planned: Planned
    distance_db: float
    made: Ensemble
    spreads: dict[Quantity, UncertainQuantity]
    linear: dict[Quantity, float]
    limits: tuple[JudgedLimit, ...]
    near: Nearest
    run: ModelledRun
    reasons: tuple[str, ...]
    swept_back: dict[Quantity, float] = field(default_factory=dict)
    notch: NotchPlan | None = None

    @property
    def go(self) -> bool | None:
        """Whether every limit is kept with 95 %; None where the log has no limit."""
        if not self.limits:
            return None
        return all(one.probability <= ALLOWED for one in self.limits)


@final
@dataclass(frozen=True, slots=True, eq=False)
class CampaignForecast:
    """Forecasts of planned tests.

    Attributes
    ----------
    title : str
        Of the log.
    evidence : ModelEvidence
        What it rests on.
    tests : tuple of TestForecast
        In the order of the log.
    notes : tuple of str
        What the reader must know besides, a sentence each.
    step : LastStep, optional
        The highest level that was run, predicted and measured.
    """

    title: str
    evidence: ModelEvidence
    tests: tuple[TestForecast, ...]
    notes: tuple[str, ...]
    step: LastStep | None = None


def forecast_tests(
    model: Model,
    log: TestLog,
    tests: Sequence[Measured],
    planned: Sequence[Test],
    *,
    wish: NotchWish | None = None,
    earlier: Mapping[str, Any] | None = None,
    seed: int = 0,
    say: Callable[[str], None] = lambda _text: None,
) -> CampaignForecast:
    """Return the forecasts of planned tests.

    Parameters
    ----------
    model : Model
        The model, with the effects that the specimen has.
    log : TestLog
        Its limits and its shaker count.
    tests : sequence of Measured
        Those that were run.
    planned : sequence of Test
        Those to forecast.
    wish : NotchWish, optional
        What a notch plan shall keep; none is made by default.
    earlier : mapping, optional
        The document of the forecast that was made before the last test was run.
    seed : int
        Of all that is drawn.
    say : callable
        Called with what is being done.

    Raises
    ------
    DiagnosisError
        If fewer than two levels were run, or the model does not fit the tests.
    LogError
        If a planned test or a limit cannot be forecast.
    ModelError
        If a test does not say a condition that scales the model.
    SimulationError
        If a motion runs away.
    """
    for conditions in (*(one.conditions for one in tests), *map(stated, planned)):
        model.under(conditions)  # says whether one lacks what scales the model
    ready = [_planned(log, one, model, tests) for one in planned]
    quantities = [(limit, quantity_of(limit, model, log)) for limit in log.limits]
    if wish is not None:
        check_notches(log, planned)
    levels = _levels(log, tests)
    evidence = evidence_of(model, levels, say)
    made = []
    for one in ready:
        say(f"test {one.test.id}")
        test_forecast = _forecast(evidence, one, quantities, seed, say)
        if wish is not None:
            task = NotchTask(
                evidence.numbers, one, test_forecast.made, quantities,
                partial(_spread, evidence, test_forecast.near), wish, seed,
            )  # fmt: skip
            test_forecast = replace(test_forecast, notch=notch_plan(task, say))
        made.append(test_forecast)
    step = last_step(evidence.errors, earlier)
    return CampaignForecast(log.title, evidence, tuple(made), _notes(evidence, made), step)


def evidence_of(
    model: Model, levels: Sequence[Sequence[Measured]], say: Callable[[str], None]
) -> ModelEvidence:
    """Return the numbers of a model by tests, and how far it misses the next level.

    Parameters
    ----------
    model : Model
        The model.
    levels : sequence of sequence of Measured
        Tests of each level, the lowest first.
    say : callable
        Called with what is being done.
    """
    drives = {test: prepared_drive(test) for group in levels for test in group}
    fitted = tuple(test for test in drives if not test.test.hold_out)

    @cache
    def raw(fitted_numbers: FittedNumbers, test: Measured, highest: float) -> list[LevelError]:
        return level_errors(fitted_numbers, test, drives[test], highest)

    def errors_of(
        fitted_numbers: FittedNumbers, of: Sequence[Measured], known: Sequence[Measured]
    ) -> Iterator[LevelError]:
        highest = max(map(amplitude_of_measured, known))
        for test in of:
            kind = kind_of_measured(model, test)
            near = nearest_level(model, known, kind, amplitude_of_measured(test))
            there = [one for other in near for one in raw(fitted_numbers, other, highest)]
            same_drive = kind_of_measured(model, near[0]) == kind
            yield from freed(raw(fitted_numbers, test, highest), there, same_drive=same_drive)

    alone = fit_of(model, fitted, say)
    numbers = numbers_of(alone)
    errors = list(errors_of(numbers, fitted, fitted))
    below: tuple[Measured, ...] = ()
    for group in levels:
        say(f"level {group[0].test.level_text} forecast from those below it")
        fewer = fit_to_fewer(alone, [test in below for test in fitted])
        if fewer is not None:
            fewer_numbers = numbers if fewer is alone else numbers_of(fewer)
            errors += errors_of(fewer_numbers, group, below)
        below += tuple(test for test in group if not test.test.hold_out)
    runs = tuple(run_of(numbers, test, given) for test, given in drives.items())
    return ModelEvidence(numbers, runs, tuple(errors), max(map(amplitude_of_measured, fitted)))


def _levels(log: TestLog, tests: Sequence[Measured]) -> list[list[Measured]]:
    """Return the tests of each level, the lowest first.

    Raises
    ------
    DiagnosisError
        If fewer than two levels were run.
    """
    levels = grouped(tests)
    free = [group for group in levels if any(not one.test.hold_out for one in group)]
    if len(free) < 2:
        said = in_order(levels)
        raise DiagnosisError(
            f"{log.path.name}: tests were run at one level only ({said}), so nothing tells how "
            "far the model misses the next one. Run a test at another level, 3 dB away or more."
        )
    while levels and all(one.test.hold_out for one in levels[0]):
        levels.pop(0)
    return levels


def _planned(log: TestLog, test: Test, model: Model, tests: Sequence[Measured]) -> Planned:
    """Return a planned test that can be forecast.

    Raises
    ------
    LogError
        If it cannot.
    """
    check_drive(model, test)
    band = excited_band(test)
    amplitude = amplitude_of(test)
    if band is None or amplitude is None:
        raise LogError(
            f"{test.source}: test {test.id}: the log does not say level and band; add them"
        )
    low = min(one.excited[0] for one in tests)
    high = max(one.excited[1] for one in tests)
    if band[0] < low * (1.0 - OUTSIDE) or band[1] > high * (1.0 + OUTSIDE):
        raise log.error(
            test,
            f"expected a band within {numeral(low, 4)} to {numeral(high, 4)} Hz, which tests "
            f"have excited, got {numeral(band[0], 4)} to {numeral(band[1], 4)} Hz; nothing "
            "tells how the specimen responds outside",
        )
    duration = duration_of_test(test)
    if duration is None:
        raise log.error(test, 'expected the key "duration", such as duration: 60 s')
    rate = tests[0].sample_rate
    compared = (min(0.7 * band[0], tests[0].band[0]), max(one.band[1] for one in tests))
    moving, shaker_mass = log.shaker.moving_mass, None
    if moving is not None and model.excitation.moves_base:
        shaker_mass = max(moving - model.moved_mass, 0.0)
    table = any(limit.whose == "shaker" for limit in log.limits)
    spreads = spreads_of(tuple(tests))
    return Planned(test, duration, rate, band, compared, spreads, shaker_mass, table)


def _forecast(
    evidence: ModelEvidence,
    planned: Planned,
    limits: Sequence[tuple[Limit, Quantity]],
    seed: int,
    say: Callable[[str], None],
) -> TestForecast:
    amplitude = amplitude_of(planned.test) or 0.0
    distance = decibels(amplitude / evidence.highest)
    drives = Drives(planned, seed)
    made = ensemble(evidence.numbers, drives, n_draws(planned))
    near = evidence.nearest(planned.test, n_draws(planned))
    spreads = {q: _spread(evidence, near, planned.test, q, made) for q in made.values}
    at = {0.0: made}

    def beyond(quantity: Quantity, limit: float, level: float) -> float:
        if level not in at:
            say(f"test {planned.test.id} at {level:+.0f} dB")
            factor = 10.0 ** (level / 20.0)
            few = ensemble(evidence.numbers, drives, PAIRED_DRAWS, factor)
            at[level] = made.changed_as(few)
        spread = _spread(evidence, near, planned.test, quantity, at[level], above=level)
        return decibels(spread.quantile(1.0 - ALLOWED) / limit)

    judged = []
    for limit, quantity in limits:
        reached = level_of(partial(beyond, quantity, limit.value))
        exceeds = spreads[quantity].exceeds(limit.value)
        judged.append(JudgedLimit(limit, quantity, exceeds, reached))
    run = _scaled_run(evidence, planned)
    ratio = amplitude / amplitude_of_measured(run.measured)
    motion = fitted_motion(evidence.numbers, drives)
    why = reasons(evidence.numbers.model, run.motion, motion)
    linear = _linear(evidence.numbers.model, run, spreads, float(np.std(motion.drive)), ratio)
    nearest_errors = {
        q: decibels(float(np.median(made.values[q]) / one.value)) for q, one in spreads.items()
    }
    back = swept_back(evidence.numbers, planned, spreads, seed, nearest_errors)
    return TestForecast(
        planned, distance, made, spreads, linear, tuple(judged), near, run, tuple(why), back
    )


def swept_back(
    numbers: FittedNumbers,
    planned: Planned,
    spreads: Mapping[Quantity, UncertainQuantity],
    seed: int,
    nearest_errors: Mapping[Quantity, float] = MappingProxyType({}),
) -> dict[Quantity, float]:
    """Return the largest responses of a sweep in the other direction that leave their bands.

    Where two motions are possible at one frequency, a sweep follows the one that it comes from.

    Parameters
    ----------
    numbers : FittedNumbers
        What the tests tell of the model.
    planned : Planned
        The test; of any other excitation nothing is returned.
    spreads : mapping of Quantity to UncertainQuantity
        Its quantities as planned.
    seed : int
        Of all that is drawn.
    nearest_errors : mapping of Quantity to float
        Errors of the nearest level, which responses are freed from [dB].
    """
    test = planned.test
    if test.excitation != "sine sweep":
        return {}
    other = replace(test, from_hz=test.to_hz, to_hz=test.from_hz)
    motion = fitted_motion(numbers, Drives(replace(planned, test=other), seed))
    rows = np.array(list(motion.responses.values()))
    spectra = densities(rows, motion.sample_rate, planned.excited)
    beyond_bands = {
        quantity: value * 10.0 ** (-nearest_errors.get(quantity, 0.0) / 20.0)
        for quantity, value in values_of_motion(
            numbers.model, motion, spectra, largest_in
        ).items()
    }
    return {
        quantity: value
        for quantity, value in beyond_bands.items()
        if quantity.what == "peak" and not spreads[quantity].holds(value)
    }


def _spread(
    evidence: ModelEvidence,
    near: Nearest,
    test: Test,
    quantity: Quantity,
    made: Ensemble,
    *,
    above: float = 0.0,
) -> UncertainQuantity:
    """Return a quantity with its model error, so far above the level of a planned test [dB]."""
    error = evidence.error(quantity)
    if error is None:
        return spread_of(made.values[quantity], 0.0, np.inf)
    amplitude = amplitude_of(test) or evidence.highest
    if quantity.whose != "response":
        distance = max(decibels(amplitude / evidence.highest) + above, 0.0)
        return spread_of(made.values[quantity], error.at(distance), error.freedom)
    distance = abs(decibels(amplitude / near.amplitude) + above)
    read = made.read.get(quantity, 0.0)
    return spread_of(near.freed(quantity, made), error.at(distance), error.freedom, read)


def _scaled_run(evidence: ModelEvidence, planned: Planned) -> ModelledRun:
    """Return the highest level that was run, of the same excitation where there is one.

    And under the same conditions, if it is.
    """
    model, test = evidence.numbers.model, planned.test
    excitation, _, shares = kind_of(model, test, stated(test))
    same_excitation = [r for r in evidence.runs if r.measured.test.excitation == excitation]
    same = [r for r in same_excitation if kind_of_measured(model, r.measured)[2] == shares]
    runs = same or same_excitation or evidence.runs
    return max(runs, key=lambda run: amplitude_of_measured(run.measured))


def _linear(
    model: Model,
    run: ModelledRun,
    spreads: dict[Quantity, UncertainQuantity],
    drive: float,
    ratio: float,
) -> dict[Quantity, float]:
    """Return each quantity by linear scaling of a run.

    Of responses as measured; of joints and forces, which no sensor measures, as the model has
    them under the measured drive. A drive that is measured at rest in part is scaled as it is.
    """
    part = slice(run.measured.start, run.measured.stop)
    besides = samples_besides(model, run.motion)
    louder = drive / drive_rms(run.measured)
    values = {}
    for quantity in spreads:
        if quantity.whose == "response":
            scale = 1.0 if quantity.what == "peak_frequency_hz" else louder
            values[quantity] = scale * run.values[quantity]
        elif quantity in besides:
            values[quantity] = ratio * largest_in(besides[quantity][part])
    return values


def _conditions_beyond(evidence: ModelEvidence, test: Test) -> list[str]:
    """Return that a planned test is at a condition beyond those that were run, for each."""
    texts, said = [], stated(test)
    for scale in evidence.numbers.model.scales:
        run = [scale.share(one.measured.conditions) for one in evidence.runs]
        share = scale.share(said)
        if not min(run) * (1.0 - OUTSIDE) <= share <= max(run) * (1.0 + OUTSIDE):
            texts.append(
                f"test {test.id} is at a {scale.condition} of {said.values[scale.condition]}, "
                "which no test was run at or beyond; its bands hold if force goes on "
                "in proportion"
            )
    return texts


def _notes(evidence: ModelEvidence, tests: Sequence[TestForecast]) -> tuple[str, ...]:
    texts = []
    if evidence.numbers.untold:
        names = ", ".join(evidence.numbers.untold)
        texts.append(f"no test tells {names}: the bands are as wide as that leaves them")
    missed = [one for one in evidence.errors if one.distance_db and one.of_model.is_unexplained]
    if missed:
        worst = max((one.of_model for one in missed), key=lambda one: abs(one.error_db))
        texts.append(
            f"the model misses levels that were run by up to {numeral(abs(worst.error_db), 2)} "
            f"dB ({worst.quantity.name}, test {worst.test}), more than its numbers leave open: "
            "ask diagnose what it lacks; responses are carried on from the nearest level, and "
            "the bands are widened"
        )
    for one in tests:
        if one.distance_db > FAR_DB:
            texts.append(
                f"test {one.planned.test.id} is {numeral(one.distance_db)} dB above what was "
                "run: its bands hold only if nothing new happens in between; run a level there"
            )
        texts += _conditions_beyond(evidence, one.planned.test)
        if one.made.failed:
            texts.append(
                f"test {one.planned.test.id}: the motion ran away in {one.made.failed} draws "
                "of the numbers, which are left out"
            )
    return tuple(texts)
