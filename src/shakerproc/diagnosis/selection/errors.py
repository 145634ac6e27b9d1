"""The free-run error of a model in the form in which the tests can be predicted."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.floor import floor_draws, over_draws
from shakerproc.comparison.free_run_error import Scored, free_run_error, pooled
from shakerproc.comparison.prediction import DRAWS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.passed_noise import FEW, prediction_of, under_noise
from shakerproc.diagnosis.estimation.residuals import Predicted
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.diagnosis.estimation.stacks import slope_in_time

LONGER: Final = 1.1
"""Free-run error over the least of shorter horizons up to which a longer one is taken: errors
of the numbers add up over it by as much, what cannot be predicted or is not in any law by far
more [-]."""

PARTED: Final = 0.1
"""Share of the response by which noise of the input may part two motions that are predicted:
beyond, a test cannot be predicted, whatever the model [-]."""

MOST: Final = 0.5
"""Share of a power that is most of it: of two that are all of it, one has it [-]."""


def scored_tests(
    data: DataSet, found: Fit, windows: Windows, *, near: FloatArray | None = None
) -> dict[int, Scored] | None:
    """Return measured and simulated responses of what counts, by the index of the test.

    Tests of which nothing counts are left out; None where the motion runs away. Where starts
    are known that are `near` those of the windows, they are not sought (`with_starts_fitted`).
    """
    settled = with_starts_fitted(data, found, windows, near=near)
    predicted = None if settled is None else prediction_of(data, settled, windows)
    if settled is None or predicted is None:
        return None
    out = {}
    for i, test in enumerate(data.tests):
        simulated, counted = _gathered(data, windows, predicted, i)
        counted &= ~test.clipped.any(axis=0)
        if not counted.any():
            continue
        late = found.delay[:, None] * slope_in_time(simulated, test.sample_rate)
        simulated = found.gain[:, None] * (simulated - late)
        measured = data.measured[i]
        out[i] = Scored(measured, simulated, test.sample_rate, test.error_band, counted)
    return out


def _gathered(
    data: DataSet, windows: Windows, predicted: Predicted, test: int
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return simulated signals of a test, and which samples count."""
    simulated = np.zeros_like(data.measured[test])
    counted = np.zeros(simulated.shape[1], bool)
    for (where, first, size), outputs, mask in zip(
        windows.table, predicted.outputs, windows.counted, strict=True
    ):
        if where == test:
            simulated[:, first : first + size] = outputs
            counted[first : first + size] |= mask
    return simulated, counted


def error_of(data: DataSet, found: Fit, windows: Windows) -> float:
    """Return the free-run error (see `compare.free_run_error`); infinite where it runs away."""
    return error_of_scored(scored_tests(data, found, windows))


def error_of_scored(tests: Mapping[int, Scored] | None) -> float:
    """Return the free-run error of `scored_tests`; infinite where the motion ran away [-]."""
    return free_run_error(tuple(tests.values())) if tests else float("inf")


def floors_of(data: DataSet, found: Fit, windows: Windows) -> dict[int, FloatArray]:
    """Return the error that even the true model has in each test, by its number.

    Noise, and noise sent through the model, (n_draws, n_sensors) arrays [-]; none where the
    motion runs away.
    """
    return {
        i: floor_draws(one, data.tests[i].noise_density, moved)
        for i, (one, moved) in _moved_tests(data, found, windows).items()
    }


def pooled_floor(floors: Mapping[int, FloatArray]) -> float:
    """Return the error of `floors_of` over draws and tests; NaN where there is none [-]."""
    return pooled([over_draws(draws) for draws in floors.values()]) if floors else float("nan")


def beyond_noise(left: float, floor: float) -> float:
    """Return the part of an error that the noise floor does not make, if that is known [-]."""
    known = floor if np.isfinite(floor) else 0.0
    return float(np.sqrt(max(left**2 - known**2, 0.0)))


def takes_most(before: Fit, after: Fit, windows: Windows) -> bool:
    """Return whether a fit takes most of the power that another one leaves beyond the noise.

    What every laboratory has is fitted only then: a little is taken by anything.
    """
    floor = pooled_floor(floors_of(after.data, after, windows))
    first, second = (
        beyond_noise(error_of(one.data, one, windows), floor) ** 2 for one in (before, after)
    )
    return second < MOST * first


def parted(data: DataSet, found: Fit, windows: Windows) -> float:
    """Return by how much the motion of a fit cannot be predicted, over the response [-].

    What noise of the input makes of it; infinite where it runs away.
    """
    moved, whole = 0.0, 0.0
    for one, apart in _moved_tests(data, found, windows, n_draws=FEW).values():
        moved += float(np.sum(np.mean(apart[..., one.counted] ** 2, axis=0)))
        whole += float(np.sum(one.measured[:, one.counted] ** 2))
    return float(np.sqrt(moved / whole)) if whole > 0.0 else float("inf")


def _moved_tests(
    data: DataSet,
    found: Fit,
    windows: Windows,
    *,
    n_draws: int = DRAWS,
) -> dict[int, tuple[Scored, FloatArray]]:
    """Return each test, and by how much draws of noise move its motion, by its number."""
    settled = with_starts_fitted(data, found, windows)
    still = None if settled is None else prediction_of(data, settled, windows)
    if settled is None or still is None:
        return {}
    noisy = list(under_noise(data, settled, windows, n_draws=n_draws, starts=True))
    out = {}
    for i, test in enumerate(data.tests):
        simulated, counted = _gathered(data, windows, still, i)
        if noisy and counted.any():
            moved = [_gathered(data, windows, one, i)[0] - simulated for one in noisy]
            one = Scored(
                data.measured[i], simulated, test.sample_rate, test.error_band, counted
            )
            out[i] = one, np.array(moved)
    return out
