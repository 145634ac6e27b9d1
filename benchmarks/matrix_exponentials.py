"""Matrix exponentials within compiled loops: ours, and scipy.linalg.expm on the same matrices.

python -m benchmarks.matrix_exponentials

Time is that of one matrix in a product of 2000 propagators, as over a period of harmonic
balance. The rates are constant there, so that one exponential of the whole period says what the
product should be; error is the largest over its elements. The exact integrator adds exp(A) - 1
in a step: how many digits of it are lost where expm(A) - 1 is taken is told below.
"""

import time
from collections.abc import Callable

import numpy as np
import scipy.linalg

from shakerproc.simulation.kernels.harmonic import exponential, propagate

N_SPANS = 2000


def oscillators(n: int, step: float) -> np.ndarray:
    """Return the rates of n masses on springs, over a step [rad of the slowest]."""
    stiffness = np.diag(np.arange(1.0, n + 1.0) ** 2) + 0.1
    upper = np.hstack([np.zeros((n, n)), np.eye(n)])
    return step * np.vstack([upper, np.hstack([-stiffness, -0.02 * np.eye(n)])])


def best(work: Callable[[], object], repeats: int = 7) -> float:
    """Return the least time of a call [s]."""
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return min(times)


def products(n: int) -> tuple[float, float, float, float]:
    """Return time of one exponential in a product, ours and scipy's [s], and both errors."""
    step = 2.0 * np.pi / N_SPANS
    rates = np.tile(oscillators(n, 1.0), (N_SPANS, 1, 1))
    spans, jumps = np.full(N_SPANS, step), np.tile(np.eye(2 * n), (N_SPANS, 1, 1))

    def scipys() -> np.ndarray:
        result = np.eye(2 * n)
        for rate in rates:
            result = scipy.linalg.expm(step * rate) @ result
        return result

    def ours() -> np.ndarray:
        return propagate(spans, rates, rates, jumps)

    exact = scipy.linalg.expm(2.0 * np.pi * rates[0])
    ours()  # compiles
    errors = [float(np.max(np.abs(work() - exact))) for work in (ours, scipys)]
    return best(ours) / N_SPANS, best(scipys, 3) / N_SPANS, *errors


def main() -> None:
    """Print both tables."""
    print("masses   ours [us]   scipy [us]   error, ours   error, scipy")
    for n in (1, 2, 3, 6):
        own, other, error, their = products(n)
        print(f"{n:6} {1e6 * own:11.2f} {1e6 * other:12.1f} {error:13.1e} {their:14.1e}")
    print("\nstep [rad]   digits that expm(A) - 1 has lost against expm's phi function")
    for step in (0.1, 1e-3, 1e-5):
        rates = oscillators(1, step)
        whole = np.zeros((4, 4))
        whole[:2, :2], whole[:2, 2:] = rates, np.eye(2)
        exact = rates @ scipy.linalg.expm(whole)[:2, 2:]  # A phi(A) = exp(A) - 1
        lost = np.abs(scipy.linalg.expm(rates) - np.eye(2) - exact) / np.abs(exact)
        print(f"{step:10g} {np.log10(max(float(lost.max()) / 2.2e-16, 1.0)):12.1f}")
    room = np.empty((3, 2, 2))
    alone = best(lambda: exponential(oscillators(1, 1e-3), room))
    print(f"\none call of ours from Python: {1e6 * alone:.1f} us")


if __name__ == "__main__":
    main()
