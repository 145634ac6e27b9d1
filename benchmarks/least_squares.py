"""The fit of a hypothesis to windows: ours, and scipy's least squares on the same residual.

python -m benchmarks.least_squares [--windows 48]

One mass, shaken at random at two levels, with a gap, friction or a cubic spring that the model
lacks. Unknown are the numbers of model and effect, gain and delay of the sensor, and the motion
with which every window begins. scipy is told that windows do not depend on each other's starts
(`jac_sparsity`), so that it moves all starts at once. Counted are simulations of all windows;
error is the largest of the numbers, in logarithms.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy.optimize
import scipy.sparse
from tests.diagnosis.one_mass import added, data_of, one_mass

from shakerproc.diagnosis.estimation import residual_slopes
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import fit, perfect
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.windows import windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.models import EFFECTS

CASES = {
    "gap": {"stiffness": 8e4, "clearance": 1.5e-4},
    "coulomb_friction": {"sliding_force": 0.4},
    "cubic_stiffness": {"coefficient": 3e11},
}
AWAY = 0.08
RUNAWAY = 1e3


@dataclass(frozen=True)
class Case:
    """One fit: data, hypothesis, its true numbers, where it starts, and the windows."""

    data: DataSet
    hypothesis: Hypothesis
    truth: np.ndarray
    start: np.ndarray
    windows: Windows


def case_of(kind: str, n_windows: int) -> Case:
    """Return a simulated campaign and what is fitted to it."""
    data = data_of(one_mass(effect=EFFECTS[kind](**CASES[kind])))
    hypothesis, truth = added(data, kind, **CASES[kind])
    start = truth + AWAY * np.array([0.6, -1.0, *([1.0] * (truth.size - 2))])
    return Case(
        data, hypothesis, truth, start, windows_of(data, 220, held_out=False, most=n_windows)
    )


def ours(case: Case) -> np.ndarray:
    """Return the numbers that our fit finds."""
    found = fit(case.data, case.hypothesis, case.start, case.windows, rounds=50)
    return np.full(case.truth.size, np.nan) if found is None else found.x


def theirs(case: Case) -> np.ndarray:
    """Return the numbers that scipy finds with the starts of windows as further unknowns."""
    linearisation = Linearisation(case.data, case.hypothesis, case.windows)
    first = linearisation.point(case.start, perfect(case.data))
    size = linearisation.sizes_of_starts(first)
    n_x, n_sensors, shape = case.start.size, case.data.n_sensors, first.starts.shape
    n_shared = n_x + 2 * n_sensors

    def point(values: np.ndarray) -> Point:
        gain, delay = np.split(values[n_x:n_shared], 2)
        starts = first.starts + values[n_shared:].reshape(shape) * size
        return replace(
            first, x=values[:n_x], gain=1.0 + gain, delay=1e-3 * delay, starts=starts
        )

    def residual(values: np.ndarray) -> np.ndarray:
        state = linearisation.residual(point(values))
        prior = linearisation.values(point(values)) / linearisation.spread
        if state is None:
            return np.full(n_rows + prior.size, RUNAWAY)
        return np.concatenate([*(rows.ravel() for rows in state[0]), prior])

    values = np.concatenate([case.start, np.zeros(2 * n_sensors + first.starts.size)])
    each = [rows.shape for rows in linearisation.residual(first)[0]]
    n_rows = sum(n * m for n, m in each)
    members = np.concatenate([
        np.repeat(stack.members, m)
        for stack, (_, m) in zip(linearisation.stacks, each, strict=True)
    ])
    n_prior = residual(values).size - n_rows
    pattern = scipy.sparse.lil_array((n_rows + n_prior, values.size), dtype=int)
    pattern[:, :n_shared] = 1
    for column in range(first.starts.size):
        pattern[np.flatnonzero(members == column // shape[1]), n_shared + column] = 1
    found = scipy.optimize.least_squares(
        residual, values, jac_sparsity=pattern, x_scale="jac", max_nfev=50
    )
    return np.asarray(found.x[:n_x])


def timed(work: Callable[[Case], np.ndarray], case: Case) -> tuple[float, int, float]:
    """Return the largest error, simulations of all windows, and processor seconds."""
    count = 0
    original = residual_slopes.predict

    def counted(*given: object, **named: object) -> object:
        nonlocal count
        count += 1
        return original(*given, **named)

    residual_slopes.predict = counted
    begun = time.process_time()
    try:
        found = work(case)
    finally:
        residual_slopes.predict = original
    seconds = time.process_time() - begun
    return float(np.max(np.abs(found - case.truth))), count, seconds


def main() -> None:
    """Print a row for each law and method."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--windows", type=int, default=48)
    n_windows = parser.parse_args().windows
    print("effect            method   error  simulations  processor [s]")
    for kind in CASES:
        case = case_of(kind, n_windows)
        ours(case)  # compiles
        for work in (ours, theirs):
            error, count, seconds = timed(work, case)
            print(f"{kind:17} {work.__name__:7} {error:6.4f} {count:12} {seconds:14.2f}")


if __name__ == "__main__":
    main()
