"""The `error` that a simulation states at loose tolerances, over its true one.

python -m benchmarks.stated_errors [--draws 12] [--seed 0]

Duffing oscillators of random stiffness, damping, level, start and frequency, 5 s each at
tolerances from 1e-3 to 1e-9; the truth is scipy's DOP853 at 1e-13.
"""

import argparse
from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.data import FloatArray
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import CubicStiffness, Damper, Spring
from shakerproc.simulation import simulate
from shakerproc.simulation.excitations import harmonic

RATE = 50.0
TIME = np.arange(251) / RATE


def ratios_of(rng: np.random.Generator, tolerances: Sequence[float]) -> list[float]:
    """Return stated over true error of a random oscillator at each tolerance [-]."""
    stiffness, damping = rng.uniform(5.0, 40.0), rng.uniform(0.02, 0.5)
    cubic = np.exp(rng.uniform(np.log(5.0), np.log(1e4)))
    frequency, force = rng.uniform(0.3, 3.0), rng.uniform(0.5, 5.0)
    start, signal = rng.uniform(-0.2, 0.2), harmonic(frequency, force)

    def slope(t: float, y: FloatArray) -> list[float]:
        drive = float(signal(np.array([t]))[0])
        return [y[1], drive - stiffness * y[0] - damping * y[1] - cubic * y[0] ** 3]

    ends = (0.0, float(TIME[-1]))
    truth = solve_ivp(slope, ends, [start, 0.0], "DOP853", TIME, rtol=1e-13, atol=1e-15).y[0]
    effects = (CubicStiffness(cubic), Spring(stiffness), Damper(damping=damping))
    elements = tuple(Element(effect, ("base", "coupon")) for effect in effects)
    excitation = Excitation("force", "coupon")
    model = Model("Duffing", {"coupon": 1.0}, elements, excitation, {"a": Sensor("coupon")})
    found = [
        simulate(
            model,
            signal,
            RATE,
            duration=ends[1],
            tolerance=tolerance,
            start={"coupon": (start, 0.0)},
            growth=False,
        )
        for tolerance in tolerances
    ]
    largest = np.max(np.abs(truth))
    return [
        float(one.error * largest / np.max(np.abs(one.displacement[0] - truth)))
        for one in found
    ]


def main(arguments: Sequence[str] | None = None) -> None:
    """Print for each tolerance how often the stated error is the larger one, and by what."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    rng, tolerances = np.random.default_rng(options.seed), 10.0 ** -np.arange(3.0, 10.0)
    ratios = np.array([ratios_of(rng, tolerances) for _ in range(options.draws)])
    print(f"{options.draws} oscillators, seed {options.seed}: stated over true error")
    for tolerance, each in zip([*tolerances, None], [*ratios.T, ratios.ravel()], strict=True):
        name = "all" if tolerance is None else f"{tolerance:.0e}"
        print(
            f"{name:>6s}  above 1 in {np.mean(each >= 1.0):.0%} of {each.size}; "
            f"least {each.min():.2g}, median {np.median(each):.2g}, most {each.max():.2g}"
        )


if __name__ == "__main__":
    main()
