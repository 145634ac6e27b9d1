"""The linear fit of a diagnosis: our damped steps, and scipy's least squares on the same sum.

python -m benchmarks.linear_least_squares [--repeats 3]

The linear stage runs on simulated campaigns of one mass whose model is off; every least-squares
problem that it solves on the way is solved once more by scipy from the same start.
Counted are residuals of tests; the sum is that of squares with the priors, scipy's over ours;
apart is the largest difference of the unknowns in standard deviations.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray
from tests.diagnosis.one_mass import DAMPING, STIFFNESS, arrays_of, one_mass

from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation import further_modes, linear
from shakerproc.diagnosis.estimation.linear_parameters import LinearParameters
from shakerproc.diagnosis.estimation.linear_problem import LinearTest, solve
from shakerproc.models import EFFECTS

CASES = {
    "as the model says": one_mass(),
    "3 % stiffer": one_mass(1.03 * STIFFNESS, 1.2 * DAMPING),
    "20 % stiffer": one_mass(1.2 * STIFFNESS, 0.5 * DAMPING),
    "half as stiff": one_mass(0.5 * STIFFNESS, 2.0 * DAMPING),
    "a mode besides": one_mass(
        effect=EFFECTS["attached_mode"](mass=0.1, frequency=90.0, damping_ratio=0.02)
    ),
    "a gap besides": one_mass(effect=EFFECTS["gap"](stiffness=8e4, clearance=1.5e-4)),
}


@dataclass(frozen=True)
class Problem:
    """What one call of the linear fit was given."""

    tests: Sequence[LinearTest]
    parameters: LinearParameters
    start: np.ndarray
    more: Sequence[np.ndarray]
    free: NDArray[np.bool_] | None = None

    @property
    def moving(self) -> np.ndarray:
        """Which unknowns move."""
        return np.ones(self.start.size, bool) if self.free is None else self.free

    def residual(self, values: np.ndarray) -> np.ndarray:
        """Return what both make the squares of least."""
        found = [
            (test.residual(self.parameters, values) / np.sqrt(1.0 + extra)).ravel()
            for test, extra in zip(self.tests, self.more, strict=True)
        ]
        both = np.concatenate(found)
        return np.concatenate([both.real, both.imag, values / self.parameters.spreads])


def problems_of(truth: object) -> list[Problem]:
    """Return the problems that the linear stage solves on a campaign."""
    met: list[Problem] = []

    def kept(*given: object) -> object:
        met.append(Problem(*given))
        return solve(*given)

    originals = linear.solve, further_modes.solve
    linear.solve = further_modes.solve = kept
    try:
        linear.fit_linear(one_mass(), prepared(arrays_of(truth)))
    finally:
        linear.solve, further_modes.solve = originals
    return [one for one in met if one.moving.any()]


def ours(problem: Problem) -> np.ndarray:
    """Return the unknowns that our fit finds."""
    given = (problem.tests, problem.parameters, problem.start, problem.more, problem.free)
    return np.asarray(solve(*given).values)


def scipys(method: str, accuracy: float) -> Callable[[Problem], np.ndarray]:
    """Return what finds the unknowns by scipy, told how large the priors are."""

    def work(problem: Problem) -> np.ndarray:
        moving, values = problem.moving, problem.start.copy()

        def residual(some: np.ndarray) -> np.ndarray:
            values[moving] = some
            return problem.residual(values)

        found = scipy.optimize.least_squares(
            residual, problem.start[moving], method=method,
            x_scale=problem.parameters.spreads[moving],
            ftol=accuracy, xtol=accuracy, gtol=accuracy,
        )  # fmt: skip
        values[moving] = found.x
        return values

    return work


def timed(
    work: Callable[[Problem], np.ndarray], problems: Sequence[Problem], repeats: int
) -> tuple[list[np.ndarray], int, float]:
    """Return the unknowns, residuals counted, and the least processor seconds."""
    count, original = 0, LinearTest.residual

    def counted(test: LinearTest, *given: object) -> object:
        nonlocal count
        count += 1
        return original(test, *given)

    seconds = []
    for _ in range(repeats):
        count, begun = 0, time.process_time()
        LinearTest.residual = counted
        try:
            found = [work(problem) for problem in problems]
        finally:
            LinearTest.residual = original
        seconds.append(time.process_time() - begun)
    return found, count, min(seconds)


def main() -> None:
    """Print a row for each campaign and method."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    repeats = parser.parse_args().repeats
    methods = {
        "ours": ours,
        "lm": scipys("lm", 1e-6),
        "trf": scipys("trf", 1e-6),
    }
    print("truth               fits  method    residuals  processor [s]  sum over ours  apart")
    for name, truth in CASES.items():
        problems = problems_of(truth)
        own, *_ = timed(ours, problems, 1)
        for method, work in methods.items():
            found, count, seconds = timed(work, problems, repeats)
            sums = [
                float(np.sum(p.residual(theirs) ** 2) / np.sum(p.residual(mine) ** 2))
                for p, theirs, mine in zip(problems, found, own, strict=True)
            ]
            apart = [
                float(np.max(np.abs(theirs - mine)[p.moving] / deviations(p, mine)))
                for p, theirs, mine in zip(problems, found, own, strict=True)
            ]
            print(
                f"{name:19} {len(problems):4}  {method:8} {count:10} {seconds:14.2f} "
                f"{min(sums):8.6f} to {max(sums):.6f} {max(apart):6.3f}"
            )


def deviations(problem: Problem, values: np.ndarray) -> np.ndarray:
    """Return the standard deviations of the unknowns that move."""
    given = (problem.tests, problem.parameters, values, problem.more, problem.free)
    return np.sqrt(np.diag(solve(*given).covariance))[problem.moving]


if __name__ == "__main__":
    main()
