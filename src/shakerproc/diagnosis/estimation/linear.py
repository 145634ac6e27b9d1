"""Linear first: own numbers, chain of measurement and further modes, before any effect."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison import at_samples
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.estimation.further_modes import with_further_modes
from shakerproc.diagnosis.estimation.linear_model import (
    LinearModel,
    LinearNumber,
    scanned,
    wrong_way_and_late,
)
from shakerproc.diagnosis.estimation.linear_parameters import Chain, LinearParameters
from shakerproc.diagnosis.estimation.linear_problem import (
    LinearSolution,
    LinearTest,
    misfit,
    prepared,
    refined,
    solve,
)
from shakerproc.models import Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.laws import Law
from shakerproc.simulation import Runs, free_runs
from shakerproc.simulation.inputs import prepare_measured

SAME_LEVEL: Final = 1.5
"""Responses up to so many times the lowest are of the lowest level: random drives of one level
scatter less, and levels of a campaign differ by more [-]."""

LINEAR_ENOUGH: Final = 0.1
"""Share of the response that the linear model may leave in a test in which further modes are
sought: a resonance that has shifted leaves it, and a mode apart from it still shows [-]."""

UNUSUAL: Final = 3.0
"""Deviations of its prior from which a number of the chain of measurement is unusual [-]."""

_ROUNDS: Final = 3  # of weights by what the model leaves
_QUANTILE: Final = 1.96  # of a 95 % interval, in standard deviations


def fit_linear(
    model: Model, tests: Sequence[PreparedTest], *, own_numbers: bool = True
) -> LinearModel:
    """Return the linear model of tests: own numbers, chain of measurement, further modes.

    It is fitted to the tests of the lowest level that are not held out, in the frequency
    domain, whitened with noise and with what is not coherent with the input there, all numbers
    under their priors. What the model leaves beyond that is systematic, however long the test:
    a third octave of it counts as one sample, so that the priors hold where physics is missing.
    Modes more than `further_modes.APART` times above or below the model's own are fitted; a
    mode nearer is an effect, and left to the choice.

    Parameters
    ----------
    model : Model
        The prior.
    tests : sequence of PreparedTest
        All tests of the campaign.
    own_numbers : bool
        Whether stiffness and damping of the model are fitted; not where an effect that it has
        was fitted with them, beside which only chain and further modes are sought.
    """
    if model.excitation.role is None:
        return as_given(model, tests)
    chosen = [_prepared(model, test) for test in _lowest(tests)]
    parameters = LinearParameters(model, len(tests[0].arrays.controls))
    none = [np.zeros_like(test.density) for test in chosen]
    free = np.arange(parameters.spreads.size) >= (0 if own_numbers else len(parameters.own))
    start = scanned(chosen, parameters) if own_numbers else np.zeros(free.size)
    solution = solve(chosen, parameters, start, none, free)
    chosen = [refined(test, parameters, solution.values) for test in chosen]
    solution = solve(chosen, parameters, solution.values, none, free)
    telling = _most_telling(tests, chosen, parameters, solution)
    extra = misfit(telling, parameters, solution.values)
    linear = _share_left(telling, parameters, solution.values) < LINEAR_ENOUGH
    richer, with_modes = with_further_modes(
        telling, parameters, solution, (extra, free), below=linear
    )
    modes = with_modes.values[free.size :]
    values = np.concatenate([solution.values, modes])
    moving = np.concatenate([free, np.zeros(modes.size, bool)])
    if modes.size:
        chosen = [refined(test, richer, values) for test in chosen]
    solution = _settled(chosen, richer, values, moving)
    solution.covariance[free.size :] = with_modes.covariance[free.size :]
    return _result(tests, richer, solution)


def as_given(model: Model, tests: Sequence[PreparedTest]) -> LinearModel:
    """Return the linear model of tests whose chain of measurement is taken as it is.

    No linear response tells it where a motion is imposed, or where nothing drives.
    """
    sensors, controls = len(model.sensors), len(tests[0].arrays.controls)
    chain = Chain(np.ones(sensors), np.zeros(sensors), np.full(controls, 1.0 / controls))
    return LinearModel(model, chain, (), (), {}, ())


def signs_and_delays(
    model: Model, tests: Sequence[PreparedTest]
) -> tuple[FloatArray, FloatArray]:
    """Return which sensors are the wrong way round (-1), and large delays [s].

    See `linear_start.wrong_way_and_late`; of the tests at the lowest level.
    """
    chosen = [_prepared(model, test) for test in _lowest(tests)]
    return wrong_way_and_late(chosen, LinearParameters(model, len(tests[0].arrays.controls)))


def _settled(
    tests: Sequence[LinearTest],
    parameters: LinearParameters,
    values: FloatArray,
    free: NDArray[np.bool_],
) -> LinearSolution:
    """Return the solution with what the model leaves as a systematic error."""
    more = [_systematic(test, parameters, values) for test in tests]
    solution = solve(tests, parameters, values, more, free)
    for _ in range(_ROUNDS - 1):
        if not any(extra.any() for extra in more):
            break
        more = [_systematic(test, parameters, solution.values) for test in tests]
        solution = solve(tests, parameters, solution.values, more, free)
    return solution


def _most_telling(
    tests: Sequence[PreparedTest],
    chosen: Sequence[LinearTest],
    parameters: LinearParameters,
    solution: LinearSolution,
) -> LinearTest:
    """Return the loudest test that the linear model explains: it shows most above the noise."""
    for test in sorted(_free(tests), key=_size, reverse=True):
        ready = _prepared(parameters.model, test)
        if _share_left(ready, parameters, solution.values) < LINEAR_ENOUGH:
            return refined(ready, parameters, solution.values)
    return chosen[0]


def _free(tests: Sequence[PreparedTest]) -> list[PreparedTest]:
    """Return the tests that may be fitted to; all of them where all are held out."""
    return [test for test in tests if not test.arrays.hold_out] or list(tests)


def _size(test: PreparedTest) -> float:
    """Return the rms of the responses."""
    return float(np.sqrt(np.mean(test.responses[:, test.start : test.stop] ** 2)))


def _lowest(tests: Sequence[PreparedTest]) -> list[PreparedTest]:
    """Return the tests that may be fitted to at the lowest level."""
    free = _free(tests)
    least = min(map(_size, free))
    return [test for test in free if _size(test) <= SAME_LEVEL * least]


def _prepared(model: Model, test: PreparedTest) -> LinearTest:
    """Return a test with what the model adds to its own linear part."""
    model = model.under(test.conditions)
    apart = np.zeros_like(test.responses)
    linear = {Law.LINEAR, Law.ATTACHED}
    laws = {row.law for element in resolved(model) for row in element.effect.rows()}
    if laws <= linear and not any(sensor.faults for sensor in model.sensors.values()):
        return prepared(model, test, apart)
    given = prepare_measured(test.input, test.sample_rate, imposed=False)
    found = free_runs(model, Runs((given,), np.array([(0, 0, given.n_samples)])))
    plain = prepared(model, test, apart)
    parameters = LinearParameters(model, len(test.arrays.controls))
    own = plain.simulated(parameters, np.zeros(parameters.spreads.size))
    if found.failed[0]:
        return plain
    return prepared(model, test, at_samples(model, found.outputs[0]) - own)


def _systematic(
    test: LinearTest, parameters: LinearParameters, values: FloatArray
) -> FloatArray:
    """Return the misfit over the noise, times the bins of the third octave that share it."""
    width = test.bins * (2.0 ** (1.0 / 6.0) - 2.0 ** (-1.0 / 6.0))
    share = np.maximum(1.0, width / float(np.diff(test.bins[:2])[0]))
    return np.asarray(misfit(test, parameters, values) * share)


def _result(
    tests: Sequence[PreparedTest], parameters: LinearParameters, solution: LinearSolution
) -> LinearModel:
    model = parameters.model_at(solution.values)
    deviations = np.sqrt(np.maximum(np.diag(solution.covariance), 0.0))
    numbers = tuple(
        LinearNumber(
            c.name, c.unit, float(x), float(x - _QUANTILE * d), float(x + _QUANTILE * d),
            float(x / c.spread),
        )
        for c, x, d in zip(parameters.coordinates, solution.values, deviations, strict=True)
    )  # fmt: skip
    first = len(parameters.own)
    last = numbers[first : len(numbers) - parameters.n_of_modes]
    return LinearModel(
        model=model,
        chain=parameters.chain_at(solution.values),
        driven=parameters.driven(solution.values),
        own=numbers[:first],
        numbers=numbers,
        left={
            test.name: _share_left(
                _prepared(parameters.model, test), parameters, solution.values
            )
            for test in tests
        },
        unusual=tuple(n for n in last if abs(n.deviations) > UNUSUAL),
    )


def _share_left(test: LinearTest, parameters: LinearParameters, values: FloatArray) -> float:
    """Return the rms that the linear model leaves over that measured, in the band [-]."""
    left = test.test.responses - test.simulated(parameters, values)
    part, whole = (
        float(np.sum(np.abs(test.whitened(rows)) ** 2)) for rows in (left, test.test.responses)
    )
    return float(np.sqrt(part / whole)) if whole > 0.0 else 0.0
