"""Further linear modes of the specimen in the band: found, fitted, judged."""

from itertools import product
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.diagnosis.estimation.linear_parameters import LinearParameters
from shakerproc.diagnosis.estimation.linear_problem import (
    LinearSolution,
    LinearTest,
    misfit,
    refined,
    solve,
)
from shakerproc.diagnosis.estimation.linear_response import poles_of

APART: Final = 3.0
r"""Factor between a further mode and the model's own. At a ratio r of the frequencies, an
attached mass acts on the other mode as :math:`\mu / (1 - r^{-2})`: from 3 on as its own mass to
within an eighth, so that a mode of a few per cent of the mass shifts the other one by less than
its width, at every level alike. Nearer, it is an attached mode, which a diagnosis names [-]."""

MOST: Final = 4
"""Further modes that are sought at most [-]."""

GAIN_ENOUGH: Final = 40.0
"""Fall of chi-square that a mode must bring: three numbers and a place among some thousand
frequencies cost about 3 + 2 ln 1000 (starting value) [-]."""

WIDEST: Final = 0.1
"""Damping ratio from which a peak is no mode: physics that is missing looks like that [-]."""

_NEAR: Final = 0.1  # share of the frequency around a peak in which a start is sought
_SHIFTS: Final = tuple(np.linspace(-0.06, 0.06, 25))  # of the logarithm of its frequency
_DAMPINGS: Final = (-0.7, 0.4, 1.5)  # of the logarithm of its damping ratio
_LARGEST: Final = 3.0  # change of the logarithm of its mass
_STARTS: Final = 2  # frequencies from which a mode is sought, weighted and not
_ROUNDS: Final = 3  # of weights by what is left beside a mode
_WIDTH: Final = 0.01  # share of the frequency over which what is left is smoothed
_LOCAL: Final = 0.05  # share of the frequency around a mode in which it must explain
_EXPLAINED: Final = 0.6  # of the power there, beyond noise


def ranges(
    parameters: LinearParameters, values: FloatArray, *, below: bool = True
) -> tuple[float, float]:
    """Return below and above which frequency a mode is a further one [Hz]."""
    own = poles_of(parameters.model_at(values[: len(values) - parameters.n_of_modes]))
    found = own.frequencies
    if not found.size:
        return 0.0, 0.0
    return float(found[0]) / APART if below else 0.0, APART * float(found[-1])


def with_further_modes(
    test: LinearTest,
    parameters: LinearParameters,
    solution: LinearSolution,
    state: tuple[FloatArray, NDArray[np.bool_]],
    *,
    below: bool,
) -> tuple[LinearParameters, LinearSolution]:
    """Return unknowns and solution with every further mode that a test shows.

    Parameters
    ----------
    test : LinearTest
        The test that shows most.
    parameters, solution
        Without further modes.
    state : (n_sensors, n_bins) array and (n,) array of bool
        What else the model leaves, over the noise, and which unknowns move.
    below : bool
        Whether modes below the model's own are sought too: what a nonlinear joint leaves there
        looks like one.
    """
    extra, free = state
    limits = ranges(parameters, solution.values, below=below)
    for _ in range(MOST):
        found = _next_mode(test, parameters, solution, (extra, free), limits)
        if found is None:
            break
        parameters, solution = found
        more = solution.values.size - free.size
        free = np.concatenate([free, np.ones(more, bool)])
        for _ in range(_ROUNDS):
            test = refined(test, parameters, solution.values)  # a narrow mode is not coherent
            extra = misfit(test, parameters, solution.values)
            solution = solve([test], parameters, solution.values, [extra], free)
    return parameters, solution


def _next_mode(
    test: LinearTest,
    parameters: LinearParameters,
    solution: LinearSolution,
    state: tuple[FloatArray, NDArray[np.bool_]],
    limits: tuple[float, float],
) -> tuple[LinearParameters, LinearSolution] | None:
    extra, free = state
    before = parameters, solution.values
    peaks = _peaks(test, parameters, solution, extra, limits)
    attached = [
        _local(test, before, extra, place, frequency)
        for frequency in peaks
        for place in parameters.model.masses
    ]
    # beside what does not swing none is a further one; structures state theirs
    swings = limits[1] > 0.0 and not parameters.model.structures
    driven = [_local_driven(test, before, extra, f) for f in (peaks if swings else [])]
    found: list[tuple[float, LinearParameters, LinearSolution]] = []
    without = None
    for kind, worse in ((attached, 0.0), (driven, GAIN_ENOUGH)):  # all else alike, one attached
        fall, richer, start = max(
            kind, key=lambda one: one[0], default=(0.0, parameters, solution.values)
        )
        if fall < GAIN_ENOUGH:
            continue
        without = without or solve([test], parameters, solution.values, [extra], free)
        moving = np.concatenate([free, np.ones(start.size - free.size, bool)])
        one = solve([test], richer, start, [extra], moving)
        if (
            richer.heaviest(one.values) <= 1.0  # than all else: no mode, but missing physics
            and one.chi_square <= without.chi_square - GAIN_ENOUGH
            and _is_mode(test, (parameters, without), (richer, one), extra, limits)
        ):
            found.append((one.chi_square + worse, richer, one))
    if not found:
        return None
    _, richer, best = min(found, key=lambda one: one[0])
    return richer, best


def _local(
    test: LinearTest,
    before: tuple[LinearParameters, FloatArray],
    extra: FloatArray,
    place: str,
    frequency: float,
) -> tuple[float, LinearParameters, FloatArray]:
    """Return the fall of chi-square that a mode near a frequency brings there, and its start.

    All other numbers stand still, and what the mode changes is seen bin by bin.
    """
    parameters, values = before
    richer = parameters.with_mode(place, frequency)
    near, weight, left, drive = _around(test, before, extra, frequency)
    chain = parameters.chain_at(values)
    as_is = test.response(parameters, values, test.bins[near])
    best = (0.0, richer, np.concatenate([values, np.zeros(3)]))
    for shift, damping in product(_SHIFTS, _DAMPINGS):
        mass = 0.0
        for _ in range(2):  # the change is nearly proportional to the mass
            trial = np.concatenate([values, (shift, damping, mass)])
            change = test.response(richer, trial, test.bins[near]) - as_is
            change = weight * drive * change * chain.gains[:, np.newaxis]
            power = float(np.sum(np.abs(change) ** 2))
            factor = float(np.sum((change.conj() * left).real)) / max(power, 1e-300)
            if not factor > 0.0:
                break
            fall = float(np.sum(np.abs(left) ** 2) - np.sum(np.abs(left - change) ** 2))
            if fall > best[0]:
                best = (fall, richer, trial)
            mass = float(np.clip(mass + np.log(factor), -_LARGEST, _LARGEST))
    return best


def _local_driven(
    test: LinearTest,
    before: tuple[LinearParameters, FloatArray],
    extra: FloatArray,
    frequency: float,
) -> tuple[float, LinearParameters, FloatArray]:
    """Return, as `_local`, what a mode does that the drive alone excites."""
    parameters, values = before
    richer = parameters.with_mode(None, frequency)
    near, weight, left, drive = _around(test, before, extra, frequency)
    turned = parameters.chain_at(values).gains[:, np.newaxis] * weight * drive
    ones = np.ones(parameters.n_sensors)
    best = (0.0, richer, np.concatenate([values, np.zeros(2 + ones.size)]))
    for shift, damping in product(_SHIFTS, _DAMPINGS):
        trial = np.concatenate([values, (shift, damping), ones])
        unit = turned * richer.driven(trial)[-1].responses(richer.model, test.bins[near])
        power = np.maximum(np.sum(np.abs(unit) ** 2, axis=1), 1e-300)
        along = np.sum((unit.conj() * left).real, axis=1)
        fall = float(np.sum(along**2 / power))
        if fall > best[0]:
            best = (fall, richer, np.concatenate([trial[: -ones.size], along / power]))
    return best


def _around(
    test: LinearTest,
    before: tuple[LinearParameters, FloatArray],
    extra: FloatArray,
    frequency: float,
) -> tuple[NDArray[np.bool_], FloatArray, ComplexArray, ComplexArray]:
    """Return which bins lie near a frequency, and weights, residual and drive there."""
    parameters, values = before
    near = np.abs(test.bins / frequency - 1.0) < _NEAR
    weight = 1.0 / np.sqrt(test.density[:, near] * (1.0 + extra[:, near]))
    rows = test.test.responses - test.simulated(parameters, values)
    controls = parameters.chain_at(values).weights @ test.test.arrays.controls
    left = weight * test.whitened(rows)[:, near]
    return near, weight, left, test.whitened(controls[np.newaxis])[:, near]


def _peaks(
    test: LinearTest,
    parameters: LinearParameters,
    solution: LinearSolution,
    extra: FloatArray,
    limits: tuple[float, float],
) -> list[float]:
    """Return the frequencies at which most is left beyond noise, where a mode may be [Hz]."""
    power = np.abs(test.residual(parameters, solution.values)) ** 2
    allowed = (test.bins < limits[0]) | (test.bins > limits[1])
    width = max(3, round(_WIDTH * float(test.bins[-1]) / float(np.diff(test.bins[:2])[0])))
    found: list[float] = []
    for weighted in (power / (1.0 + extra), power):  # skirts of a tall peak are in `extra`
        smooth = scipy.ndimage.uniform_filter1d(weighted.sum(axis=0), width)
        smooth = np.where(allowed, smooth, 0.0)
        for _ in range(_STARTS):
            i = int(np.argmax(smooth))
            if not smooth[i] > 0.0:
                break
            near = np.abs(test.bins / test.bins[i] - 1.0) < _NEAR
            if not any(abs(one / test.bins[i] - 1.0) < 0.5 * _NEAR for one in found):
                found.append(float(test.bins[i]))
            smooth[near] = 0.0
    return found


def _is_mode(
    test: LinearTest,
    before: tuple[LinearParameters, LinearSolution],
    after: tuple[LinearParameters, LinearSolution],
    extra: FloatArray,
    limits: tuple[float, float],
) -> bool:
    """Return whether what was fitted lies where it may, and explains what is left there.

    A wide peak is none (see `WIDEST`).
    """
    parameters, solution = after
    frequency, damping_ratio = parameters.last_mode(solution.values)
    if limits[0] <= frequency <= limits[1] or damping_ratio > WIDEST:
        return False
    near = np.abs(test.bins / frequency - 1.0) < _LOCAL
    if not near.any():  # of a mode beyond the band its skirt alone shows
        near = np.ones(test.bins.size, bool)
    left = [
        float(
            np.sum(
                (np.abs(test.residual(which, found.values)[:, near]) ** 2 - 2.0)
                / (1.0 + extra[:, near])
            )
        )
        for which, found in (before, after)
    ]
    return left[0] > 0.0 and left[1] < (1.0 - _EXPLAINED) * left[0]
