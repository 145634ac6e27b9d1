"""Model error at levels that were not fitted to, and the last level: predicted, measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias, final

import numpy as np

from shakerproc.comparison import Measured
from shakerproc.comparison.free_run_error import in_band
from shakerproc.data import FloatArray
from shakerproc.diagnosis.fitted_numbers import FittedNumbers
from shakerproc.errors import SimulationError
from shakerproc.forecasts.levels import amplitude_of_measured, decibels
from shakerproc.forecasts.motion import TestMotion, motion_of
from shakerproc.forecasts.quantities import Density, Quantity, densities, values_of_response
from shakerproc.models import Model
from shakerproc.simulation import Input
from shakerproc.simulation.inputs import prepare_measured

SPREAD_DRAWS: Final = 8
"""Draws of the numbers that tell what these leave open of a level that was run [-]."""

FINEST_DB: Final = 0.1
"""Error below which forecasts of levels are equally telling: 1 % of calibration [dB]."""

UNEXPLAINED: Final = 4.0
"""Standard deviations from which an error is surely more than chance: one in some 16 000, rare
among all levels, responses and quantities of a log [-]."""

Told: TypeAlias = dict[tuple[str, str], tuple[float, float, float]]
"""From a response and a quantity of it to the value and its band [unit]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class LevelError:
    """A quantity of a test that was run, forecast with numbers of other tests or its own.

    Attributes
    ----------
    test : str
        Id of the test.
    quantity : Quantity
        Which.
    measured : float
        In the test [unit of the quantity].
    distance_db : float
        Level above the highest that was fitted; 0 of a test that was fitted [dB].
    alone_db : (1 + n_draws,) array
        Predicted over measured under the measured drive, of the fitted numbers and of draws of
        them; not a number where the motion runs away [dB].
    drawn_db : (1 + n_draws,) array
        The same that begins at what the nearest level measured (see `freed`) [dB].
    """

    test: str
    quantity: Quantity
    measured: float
    distance_db: float
    alone_db: FloatArray
    drawn_db: FloatArray

    @property
    def error_db(self) -> float:
        """Predicted over measured [dB]."""
        return float(np.nanmedian(self.drawn_db))

    @property
    def predicted(self) -> float:
        """Forecast [unit of the quantity]."""
        return self.measured * float(10.0 ** (self.error_db / 20.0))

    @property
    def spread_db(self) -> float:
        """Standard deviation that the numbers leave [dB]."""
        known = self.drawn_db[1:][np.isfinite(self.drawn_db[1:])]
        return float(np.std(known)) if known.size > 1 else np.inf

    @property
    def carried_db(self) -> float:
        """Error of the nearest level, which the forecast is freed from [dB]."""
        return float(np.nanmedian(self.alone_db)) - self.error_db

    @property
    def of_model(self) -> "LevelError":
        """The same of the model alone, with the error of the nearest level."""
        return replace(self, drawn_db=self.alone_db)

    @property
    def is_unexplained(self) -> bool:
        """Whether chance, calibration and the uncertainty of the numbers do not explain it."""
        return abs(self.error_db) > UNEXPLAINED * float(np.hypot(self.spread_db, FINEST_DB))


def carried_share(nearest: FloatArray, ahead: FloatArray, *, same_drive: bool = True) -> float:
    r"""Return which share of the error of the nearest level the next one has, too [-].

    .. math:: \beta = \frac{C + \tau^2}{V + \varepsilon^2 + \tau^2}, \qquad
        \tau^2 = \left(\bar e^2 - V - \varepsilon^2\right)_+

    with the variance :math:`V` of the errors that the numbers leave at the nearest level, their
    covariance :math:`C` with the next one, and what is left of the mean :math:`\bar e` beyond
    that and the calibration :math:`\varepsilon`: the model's own error :math:`\tau`, which
    stays. So numbers that no test tells leave open what they change between levels, but not
    what was measured; and a model that lacks what the joint does is no worse than linear
    scaling. Without a covariance it is the estimate of James and Stein [1]_. Where draws of the
    numbers reach what was measured, the model has no error: of two resonances as high as each
    other, now one is the largest, now the other.

    Parameters
    ----------
    nearest, ahead : (n,) array
        Errors at the nearest level, and values or errors at the next, with the same draws of
        the numbers; not a number where one ran away [dB].
    same_drive : bool
        Whether both are driven alike: else the model's own error is another one there.

    References
    ----------
    .. [1] W. James, C. Stein, "Estimation with quadratic loss", Proc. 4th Berkeley Symposium
       on Mathematical Statistics and Probability, vol. 1, 361-379, 1961.
    """
    both = np.isfinite(nearest) & np.isfinite(ahead)
    if np.count_nonzero(both) < 2:
        return 0.0
    near = nearest[both]
    (variance, shared), _ = np.cov(near, ahead[both])
    known, model_error = variance + FINEST_DB**2, 0.0
    if not near.min() <= 0.0 <= near.max():
        model_error = max(float(np.median(near)) ** 2 - known, 0.0)
    return float(np.clip((shared + same_drive * model_error) / (known + model_error), 0.0, 1.0))


def freed(
    errors: Sequence[LevelError], nearest: Sequence[LevelError], *, same_drive: bool = True
) -> list[LevelError]:
    """Return errors of a model that begins at the measured values of the nearest level.

    Parameters
    ----------
    errors : sequence of LevelError
        Of one test.
    nearest : sequence of LevelError
        Of tests of the nearest level, with the same draws of the numbers.
    same_drive : bool
        Whether these are driven alike.
    """
    near, freed_errors = mean_errors(nearest), []
    for one in errors:
        there = near.get(one.quantity, np.zeros_like(one.alone_db))
        share = carried_share(there, one.alone_db, same_drive=same_drive)
        freed_errors.append(replace(one, drawn_db=one.alone_db - share * there))
    return freed_errors


def mean_errors(errors: Sequence[LevelError]) -> dict[Quantity, FloatArray]:
    """Return the mean errors of a model in tests of one level, (1 + n_draws,) arrays [dB]."""
    return {
        quantity: np.mean([e.alone_db for e in errors if e.quantity == quantity], axis=0)
        for quantity in {one.quantity: None for one in errors}
    }


@final
@dataclass(frozen=True, slots=True)
class Error:
    r"""Model error of one kind of quantity, by the distance in level.

    .. math:: \sigma^2(d) = \sigma_0^2 + (g d)^2, \qquad
        \sigma_0^2 = \overline{(e_0^2 - v_0)_+}, \qquad
        g^2 = \frac{\sum_k w_k (e_k^2 - v_k)_+}{\sum_k w_k d_k^2}, \quad
        w_k = \frac{1}{v_k + \sigma_0^2 + \varepsilon^2}

    with the errors :math:`e` of levels that were fitted (0) and that were forecast (k), and the
    variance :math:`v` that the fitted numbers leave: what that explains is no model error,
    and is in the band already (DerSimonian and Laird [1]_, each term above 0). Of so few
    levels the error follows Student's law, with as many degrees of freedom as levels that were
    forecast.

    Attributes
    ----------
    fitted_db : float
        :math:`\sigma_0` [dB].
    growth : float
        :math:`g`, decibels for each decibel of level [-].
    freedom : float
        Degrees of freedom: levels that were forecast, by their weights [-].

    References
    ----------
    .. [1] R. DerSimonian and N. Laird, "Meta-analysis in clinical trials", Controlled Clinical
       Trials 7, 177-188, 1986.
    """

    fitted_db: float
    growth: float
    freedom: float

    def at(self, distance_db: float) -> float:
        """Return the scale of the error at a distance in level [dB]."""
        return float(np.hypot(self.fitted_db, self.growth * max(distance_db, 0.0)))


def error_of(errors: Sequence[LevelError]) -> Error:
    """Return the model error of one kind of quantity, of all sensors and levels together."""
    level_errors_here = [one for one in errors if not one.distance_db]
    ahead = [one for one in errors if one.distance_db]
    excess = [max(one.error_db**2 - one.spread_db**2, 0.0) for one in level_errors_here]
    fitted = float(np.sqrt(np.mean(excess))) if level_errors_here else 0.0
    spread = np.array([one.spread_db for one in ahead]) ** 2
    square = np.maximum(np.array([one.error_db for one in ahead]) ** 2 - spread, 0.0)
    distance = np.array([one.distance_db for one in ahead]) ** 2
    weight = 1.0 / (spread + fitted**2 + FINEST_DB**2)
    known = float(np.sum(weight * distance))
    if not known:  # no level tells it
        return Error(fitted, np.inf, 1.0)
    growth = float(np.sqrt(np.sum(weight * square) / known))
    tests = np.array([one.test for one in ahead])
    shares = np.array([np.sum((weight * distance)[tests == name]) for name in np.unique(tests)])
    return Error(fitted, growth, float(np.sum(shares) ** 2 / np.sum(shares**2)))


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModelledRun:
    """A test that was run, with the motion that the model predicts.

    Attributes
    ----------
    measured : Measured
        The test.
    values : mapping of Quantity to float
        What was measured.
    spectra : mapping of str to Density
        Density of each response, measured.
    motion : TestMotion
        Of the model under the measured drive.
    """

    measured: Measured
    values: dict[Quantity, float]
    spectra: dict[str, Density]
    motion: TestMotion


def run_of(numbers: FittedNumbers, measured: Measured, given: Input) -> ModelledRun:
    """Return a test that was run beside the motion of the fitted model.

    Parameters
    ----------
    numbers : FittedNumbers
        Of any tests.
    measured : Measured
        The test.
    given : Input
        What drove it, prepared (see `prepared_drive`).

    Raises
    ------
    SimulationError
        If the model runs away in it.
    """
    model = numbers.model
    motion = motion_of(
        model, given, measured.input, measured.band, numbers.gain,
        conditions=measured.conditions,
    )  # fmt: skip
    if motion is None:
        raise SimulationError(f"{measured.run}: the motion of {model.title} runs away.")
    rows = in_band(measured.responses, measured.sample_rate, measured.band)
    values, spectra = _of_responses(model, measured, rows)
    return ModelledRun(measured, values, spectra, motion)


def prepared_drive(measured: Measured) -> Input:
    """Return the measured drive of a test, prepared for the engine."""
    return prepare_measured(measured.input, measured.sample_rate, imposed=False)


def level_errors(
    numbers: FittedNumbers,
    measured: Measured,
    given: Input,
    highest: float,
    count: int = SPREAD_DRAWS,
) -> list[LevelError]:
    """Return how far the numbers of a model miss the measurements of a test.

    Parameters
    ----------
    numbers : FittedNumbers
        Of any tests.
    measured : Measured
        The test.
    given : Input
        What drove it, prepared.
    highest : float
        Amplitude of the highest level that the numbers are of [SI].
    count : int
        Draws of the numbers.
    """
    run = run_of(numbers, measured, given)
    every = [_predicted(run.motion, numbers.model, measured)]
    for model, gains in numbers.drawn(count, np.random.default_rng(0)):
        motion = motion_of(
            model, given, measured.input, measured.band, gains, conditions=measured.conditions
        )
        every.append({} if motion is None else _predicted(motion, model, measured))
    distance = max(decibels(amplitude_of_measured(measured) / highest), 0.0)
    level_errors = []
    for quantity, value in run.values.items():
        ratios = np.array([one.get(quantity, np.nan) for one in every]) / value
        errors = 20.0 * np.log10(ratios)
        level_errors.append(
            LevelError(measured.name, quantity, value, distance, errors, errors)
        )
    return level_errors


def _predicted(motion: TestMotion, model: Model, measured: Measured) -> dict[Quantity, float]:
    rows = np.array([motion.responses[name] for name in measured.sensors])
    return _of_responses(model, measured, rows)[0]


def _of_responses(
    model: Model, measured: Measured, rows: FloatArray
) -> tuple[dict[Quantity, float], dict[str, Density]]:
    part = rows[:, measured.start : measured.stop]
    spectra = densities(part, measured.sample_rate, measured.excited)
    values: dict[Quantity, float] = {}
    for name, samples, spectrum in zip(measured.sensors, part, spectra, strict=True):
        unit = model.sensor_unit(model.sensors[name])
        values |= values_of_response(name, unit, samples, spectrum)
    return values, dict(zip(measured.sensors, spectra, strict=True))


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
    test_errors = [one for one in errors if one.test == test and one.distance_db]
    before = _earlier_prediction(earlier or {}, test)
    values = []
    for one in test_errors:
        found = before.get((one.quantity.name, one.quantity.what))
        predicted, low, high = found or (one.predicted, None, None)
        values.append(
            StepValue(
                one.quantity.name, one.quantity.what, one.quantity.unit, predicted,
                one.measured, low, high,
            )
        )  # fmt: skip
    return LastStep(test, all(one.low is not None for one in values), tuple(values))


def _earlier_prediction(earlier: Mapping[str, Any], test: str) -> Told:
    """Return the responses that an earlier document predicted of a test before it was run.

    A document that somebody changed by hand told nothing.
    """
    predictions: Told = {}
    try:
        for one in earlier.get("tests", ()):
            if str(one["id"]) == test:
                for name, rows in one["responses"].items():
                    for what, row in rows.items():
                        band = (float(row["low"]), float(row["high"]))
                        predictions[name, what] = (float(row["value"]), *band)
                return predictions
        step = earlier.get("last_step")
        if step and step["test"] == test and step["told_before"]:
            for row in step["values"]:
                prediction = (float(row["predicted"]), float(row["low"]), float(row["high"]))
                predictions[row["response"], row["what"]] = prediction
    except (KeyError, TypeError, ValueError, AttributeError):
        return {}
    return predictions
