"""Free-running oscillators fitted to Silverbox: python docs/silverbox_free_run.py.

Runge-Kutta of its own and least squares, no code of the diagnosis: what a linear and a cubic
spring leave of V2 between the samples 5000 and 40600, and k3/k1.
"""

import sys
from pathlib import Path

import numpy as np
from numba import njit
from scipy.io import loadmat
from scipy.optimize import least_squares
from scipy.signal import resample

FILE = Path(__file__).parents[2] / "shared" / "data" / "silverbox" / "SNLS80mV.mat"
RATE, FINE, FIRST, LAST, RUN_IN = 610.35, 8, 5000, 40600, 600


@njit(cache=True)
def acceleration(x, v, force, p):
    """Newton's law; p is mass, damping, k1 and k3."""
    return (force - p[1] * v - p[2] * x - p[3] * x * x * x) / p[0]


@njit(cache=True)
def free_run(force, n, p):
    """Displacement at n samples: classical Runge-Kutta over two fine samples a step."""
    h = 2.0 / (RATE * FINE)
    out = np.empty(n)
    x = v = 0.0
    for i in range(n * FINE // 2):
        if i % (FINE // 2) == 0:
            out[i // (FINE // 2)] = x
        f0, f1, f2 = force[2 * i], force[2 * i + 1], force[min(2 * i + 2, force.size - 1)]
        a0 = acceleration(x, v, f0, p)
        v1 = v + 0.5 * h * a0
        a1 = acceleration(x + 0.5 * h * v, v1, f1, p)
        v2 = v + 0.5 * h * a1
        a2 = acceleration(x + 0.5 * h * v1, v2, f1, p)
        v3 = v + h * a2
        a3 = acceleration(x + h * v2, v3, f2, p)
        x += h / 6.0 * (v + 2.0 * v1 + 2.0 * v2 + v3)
        v += h / 6.0 * (a0 + 2.0 * a1 + 2.0 * a2 + a3)
    return out


def main() -> None:
    """Fit both and print what they leave."""
    content = loadmat(FILE)
    force, moved = (
        (content[name].ravel() - content[name].mean())[FIRST:LAST] for name in ("V1", "V2")
    )
    n = moved.size
    # mirrored, so that the ends meet
    fine = resample(np.concatenate([force, force[::-1]]), 2 * n * FINE)[: n * FINE]
    scale = np.array([5.36e-6, 2.3e-4, 1.0, 3.2])
    for name, size in (("linear", 3), ("cubic", 4)):

        def left(p: np.ndarray) -> np.ndarray:
            full = np.append(p, 0.0)[:4] * scale
            return (free_run(fine, n, full) - moved)[RUN_IN:]

        found = least_squares(left, np.ones(size), x_scale=0.01, max_nfev=25)
        share = np.sqrt(np.mean(found.fun**2) / np.mean(moved**2))
        ratio = (
            f", k3/k1 = {found.x[3] * scale[3] / found.x[2]:.3g} per V^2" if size == 4 else ""
        )
        sys.stdout.write(f"{name}: leaves {100.0 * share:.3g} % of V2{ratio}\n")


if __name__ == "__main__":
    main()
