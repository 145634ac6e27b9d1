"""A response curve with both branches and stability, against stepping through it in time.

python -m benchmarks.response [--harmonics 31] [--repeats 5]

Run it with OMP_NUM_THREADS=1: the matrices are too small for threads.
"""

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation.harmonic_balance import frequency_response

DAMPING = 2.0 * 0.01 * np.sqrt(1000.0)


def model(*effects: object) -> Model:
    """Return one mass of 1 kg on the base, shaken by a force."""
    elements = tuple(Element(effect, ("base", "mass")) for effect in effects)
    return Model("benchmark", {"mass": 1.0}, elements, Excitation("force", "mass"))


TASKS = {
    "gap, a = 0.5 mm, 5 N": (
        model(EFFECTS["gap"](stiffness=1000.0, clearance=5e-4), EFFECTS["damper"](DAMPING)),
        5.0,
        (1.5, 10.0),
    ),
    "gap, a = 5 mm, 5 N": (
        model(EFFECTS["gap"](stiffness=1000.0, clearance=5e-3), EFFECTS["damper"](DAMPING)),
        5.0,
        (1.5, 10.0),
    ),
    "Duffing, 0.5 N": (
        model(
            EFFECTS["spring"](stiffness=1000.0),
            EFFECTS["cubic_stiffness"](coefficient=1e7),
            EFFECTS["damper"](DAMPING),
        ),
        0.5,
        (3.0, 12.0),
    ),
}


def stepped_in_time(frequencies: Sequence[float], clearance: float) -> None:
    """Step through frequencies with scipy's LSODA: 100 periods to settle at each."""
    from scipy.integrate import solve_ivp

    state = np.zeros(2)
    for frequency in frequencies:
        omega = 2.0 * np.pi * frequency

        def motion(t: float, y: np.ndarray, omega: float = omega) -> list[float]:
            beyond = max(abs(y[0]) - clearance, 0.0) * np.sign(y[0])
            return [y[1], 5.0 * np.cos(omega * t) - 1000.0 * beyond - DAMPING * y[1]]

        found = solve_ivp(motion, (0.0, 100.0 / frequency), state, method="LSODA", rtol=1e-6)
        state = found.y[:, -1]


def best_of(repeats: int, task: Callable[[], object]) -> tuple[float, float]:
    """Return the least wall time and the least processor time of a task [s]."""
    times = []
    for _ in range(repeats):
        start, used = time.perf_counter(), time.process_time()
        task()
        times.append((time.perf_counter() - start, time.process_time() - used))
    return min(wall for wall, _ in times), min(used for _, used in times)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the time of each curve, and of one tenth of a stepped sine for comparison."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--harmonics", type=int, default=31)
    parser.add_argument("--repeats", type=int, default=5)
    chosen = parser.parse_args(arguments)
    times = {}
    for name, (shaken, level, band) in TASKS.items():

        def task(
            shaken: Model = shaken, level: float = level, band: tuple[float, float] = band
        ) -> object:
            return frequency_response(
                shaken, level, from_hz=band[0], to_hz=band[1], harmonics=chosen.harmonics
            )

        (branch,) = task().branches  # compiles, or loads what is compiled
        wall, times[name] = best_of(chosen.repeats, task)
        print(
            f"{name}: {wall:.3f} s ({times[name]:.3f} s of the processor), "
            f"{branch.frequency.size} points, "
            f"{len(branch.folds)} folds, {int(np.sum(~branch.stable))} unstable points; "
            f"{branch.ended}"
        )
    grid = np.linspace(2.0, 5.5, 4)
    stepped = best_of(1, lambda: stepped_in_time(grid, 5e-3))[1] / grid.size * 80
    print(
        f"80 frequencies up and 80 down stepped with LSODA at rtol 1e-6 (from {grid.size}): "
        f"{2 * stepped:.1f} s, stable branches only: "
        f"{2 * stepped / times['gap, a = 5 mm, 5 N']:.0f} times as long"
    )


if __name__ == "__main__":
    main()
