"""Further linear modes of the specimen in the band: found, fitted, judged."""

from dataclasses import dataclass
from itertools import product
from typing import Final, final

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


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Left:
    """What a linear model leaves of a test, in which modes are sought.

    Attributes
    ----------
    test : LinearTest
        The test.
    parameters : LinearParameters
        The model's.
    values : (n,) array
        Its numbers.
    extra : (n_sensors, n_bins) array
        What else it leaves, over the noise [-].
    rows : (n_sensors, n_bins) array
        What it leaves, whitened.
    drive : (1, n_bins) array
        What drives it, whitened.
    """

    test: LinearTest
    parameters: LinearParameters
    values: FloatArray
    extra: FloatArray
    rows: ComplexArray
    drive: ComplexArray

    def near(
        self, frequency: float
    ) -> tuple[NDArray[np.bool_], FloatArray, ComplexArray, ComplexArray]:
        """Return which bins lie near a frequency [Hz], and weights, rows and drive there."""
        near = np.abs(self.test.bins / frequency - 1.0) < _NEAR
        weight = 1.0 / np.sqrt(self.test.density[:, near] * (1.0 + self.extra[:, near]))
        return near, weight, weight * self.rows[:, near], self.drive[:, near]


def _left(
    test: LinearTest, parameters: LinearParameters, values: FloatArray, extra: FloatArray
) -> _Left:
    controls = parameters.chain_at(values).weights @ test.test.arrays.controls
    rows = test.test.responses - test.simulated(parameters, values)
    drive = test.whitened(controls[np.newaxis])
    return _Left(test, parameters, values, extra, test.whitened(rows), drive)


def _next_mode(
    test: LinearTest,
    parameters: LinearParameters,
    solution: LinearSolution,
    state: tuple[FloatArray, NDArray[np.bool_]],
    limits: tuple[float, float],
) -> tuple[LinearParameters, LinearSolution] | None:
    extra, free = state
    left = _left(test, parameters, solution.values, extra)
    peaks = _peaks(left, limits)
    attached = [
        _local(left, place, frequency)
        for frequency in peaks
        for place in parameters.model.masses
    ]
    # beside what does not swing none is a further one; structures state theirs
    swings = limits[1] > 0.0 and not parameters.model.structures
    driven = [_local_driven(left, frequency) for frequency in (peaks if swings else [])]
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
    left: _Left, place: str, frequency: float
) -> tuple[float, LinearParameters, FloatArray]:
    """Return the fall of chi-square that a mode near a frequency brings there, and its start.

    All other numbers stand still, and what the mode changes is seen bin by bin.
    """
    test, values = left.test, left.values
    richer = left.parameters.with_mode(place, frequency)
    near, weight, rows, drive = left.near(frequency)
    chain = left.parameters.chain_at(values)
    as_is = test.response(left.parameters, values, test.bins[near])
    best = (0.0, richer, np.concatenate([values, np.zeros(3)]))
    for shift, damping in product(_SHIFTS, _DAMPINGS):
        mass = 0.0
        for _ in range(2):  # the change is nearly proportional to the mass
            trial = np.concatenate([values, (shift, damping, mass)])
            change = test.response(richer, trial, test.bins[near]) - as_is
            change = weight * drive * change * chain.gains[:, np.newaxis]
            power = float(np.sum(np.abs(change) ** 2))
            factor = float(np.sum((change.conj() * rows).real)) / max(power, 1e-300)
            if not factor > 0.0:
                break
            fall = float(np.sum(np.abs(rows) ** 2) - np.sum(np.abs(rows - change) ** 2))
            if fall > best[0]:
                best = (fall, richer, trial)
            mass = float(np.clip(mass + np.log(factor), -_LARGEST, _LARGEST))
    return best


def _local_driven(left: _Left, frequency: float) -> tuple[float, LinearParameters, FloatArray]:
    """Return, as `_local`, what a mode does that the drive alone excites."""
    richer = left.parameters.with_mode(None, frequency)
    near, weight, rows, drive = left.near(frequency)
    turned = left.parameters.chain_at(left.values).gains[:, np.newaxis] * weight * drive
    ones = np.ones(left.parameters.n_sensors)
    best = (0.0, richer, np.concatenate([left.values, np.zeros(2 + ones.size)]))
    for shift, damping in product(_SHIFTS, _DAMPINGS):
        trial = np.concatenate([left.values, (shift, damping), ones])
        unit = turned * richer.driven(trial)[-1].responses(richer.model, left.test.bins[near])
        power = np.maximum(np.sum(np.abs(unit) ** 2, axis=1), 1e-300)
        along = np.sum((unit.conj() * rows).real, axis=1)
        fall = float(np.sum(along**2 / power))
        if fall > best[0]:
            best = (fall, richer, np.concatenate([trial[: -ones.size], along / power]))
    return best


def _peaks(left: _Left, limits: tuple[float, float]) -> list[float]:
    """Return the frequencies at which most is left beyond noise, where a mode may be [Hz]."""
    bins, power = left.test.bins, np.abs(left.rows) ** 2 / left.test.density
    allowed = (bins < limits[0]) | (bins > limits[1])
    width = max(3, round(_WIDTH * float(bins[-1]) / float(np.diff(bins[:2])[0])))
    found: list[float] = []
    for weighted in (power / (1.0 + left.extra), power):  # a tall peak's skirts are in `extra`
        smooth = scipy.ndimage.uniform_filter1d(weighted.sum(axis=0), width)
        smooth = np.where(allowed, smooth, 0.0)
        for _ in range(_STARTS):
            i = int(np.argmax(smooth))
            if not smooth[i] > 0.0:
                break
            near = np.abs(bins / bins[i] - 1.0) < _NEAR
            if not any(abs(one / bins[i] - 1.0) < 0.5 * _NEAR for one in found):
                found.append(float(bins[i]))
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
