"""Time integration against scipy's LSODA, on one task: ratios at equal or smaller error.

python -m benchmarks.simulation [--repeats 7]

1 kg, 1000 N/m, 1 % of critical damping, a force chirp of 5 N from 0 to 30 Hz over 30 s, 15001
outputs: with free play of 0.5 mm, as a Duffing oscillator, with Coulomb friction, and mixed
(play, a cubic spring and friction). Times are of the processor, so that a busy machine does not
matter. Errors are the largest over the run, as a share of the largest displacement, against
plain Taylor series in extended precision (tests/simulation/long_double.py), which shares no
code with the program. Our time holds all of `simulate`, the chirp included; LSODA gets a
right-hand side in plain Python numbers, which is its quickest.
"""

import argparse
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context

import numpy as np
from scipy.integrate import solve_ivp
from tests.simulation import long_double

from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import Input, prepare, simulate
from shakerproc.simulation.excitations import linear_sweep

STIFFNESS, PLAY, FRICTION = 1000.0, 5e-4, 1.0
DAMPING = 2.0 * 0.01 * np.sqrt(STIFFNESS)
RATE, SECONDS, FORCE, LAST = 500.0, 30.0, 5.0, 30.0
OURS = (1e-15, 1e-10, 1e-7, 1e-5, 1e-3)
PATIENCE = 10.0
TOLERANCES = (1e-3, 1e-6, 1e-8, 1e-10, 1e-12)
Array = np.ndarray


@dataclass(frozen=True)
class Task:
    """A law of force and what it is made of.

    Attributes
    ----------
    name : str
        For the table.
    model : Model
        For shakerproc.
    smooth : function
        Restoring force over displacement, friction left out [N].
    oscillator : Oscillator
        For the reference.
    """

    name: str
    model: Model
    smooth: Callable[[float], float]
    oscillator: long_double.Oscillator


def model(*effects: object) -> Model:
    """Return one mass of 1 kg on the base, shaken by a force."""
    held = (*effects, EFFECTS["damper"](DAMPING))
    elements = tuple(Element(effect, ("base", "mass")) for effect in held)
    return Model("benchmark", {"mass": 1.0}, elements, Excitation("force", "mass"))


def beyond(x: float, play: float) -> float:
    """Return how far a displacement is past the play [m]."""
    return x - play if x > play else (x + play if x < -play else 0.0)


SPRING = EFFECTS["spring"](stiffness=STIFFNESS)
GAP = EFFECTS["gap"](stiffness=STIFFNESS, clearance=PLAY)
CUBIC = EFFECTS["cubic_stiffness"](coefficient=1e6)
COULOMB = EFFECTS["coulomb_friction"](sliding_force=FRICTION)
TASKS = (
    Task(
        "gap",
        model(GAP),
        lambda x: STIFFNESS * beyond(x, PLAY),
        long_double.Oscillator(1.0, DAMPING, contact=STIFFNESS, clearance=PLAY),
    ),
    Task(
        "Duffing",
        model(SPRING, CUBIC),
        lambda x: STIFFNESS * x + 1e6 * x**3,
        long_double.Oscillator(1.0, DAMPING, STIFFNESS, cubic=1e6),
    ),
    Task(
        "Coulomb",
        model(SPRING, COULOMB),
        lambda x: STIFFNESS * x,
        long_double.Oscillator(1.0, DAMPING, STIFFNESS, friction=FRICTION),
    ),
    Task(
        "gap + cubic + Coulomb",
        model(GAP, CUBIC, COULOMB),
        lambda x: STIFFNESS * beyond(x, PLAY) + 1e6 * x**3,
        long_double.Oscillator(
            1.0, DAMPING, contact=STIFFNESS, clearance=PLAY, cubic=1e6, friction=FRICTION
        ),
    ),
)


SIGNAL = linear_sweep(0.0, LAST, SECONDS, FORCE, 0.5 * np.pi)


def chirp(t: float) -> float:
    """Return the force at a time [s], in N."""
    return FORCE * math.cos(math.pi * LAST / SECONDS * t * t)


def lsoda(task: Task, times: Array, tolerance: float) -> Array | None:
    """Return what LSODA gives, or None where it has not come to an end in `PATIENCE`.

    A sign of the velocity would stop it for good, so friction is smoothed over 0.1 mm/s, a
    thousandth of the largest velocity.
    """
    rub, started = task.oscillator.friction, time.process_time()

    def rates(t: float, y: Array) -> tuple[float, float]:
        x, v = y.tolist()  # Python's own numbers are quicker than numpy's
        held = task.smooth(x) + DAMPING * v
        if rub:
            held += rub * math.tanh(v / 1e-4)
            if time.process_time() - started > PATIENCE:
                raise TimeoutError
        return v, chirp(t) - held

    try:
        found = solve_ivp(
            rates, (0.0, times[-1]), [0.0, 0.0], method="LSODA", t_eval=times,
            rtol=tolerance, atol=1e-3 * tolerance,
        )  # fmt: skip
    except TimeoutError:
        return None
    return found.y[0]


def reference(task: Task) -> Array:
    """Return the displacement in extended precision, by plain Taylor series: slow [m]."""
    step = long_double.EXTENDED(1) / round(RATE)

    def force(j: int, start: object, share: object) -> object:
        return long_double.chirp_series(
            FORCE, LAST / SECONDS, (j + start) * step, share * step, cosine=True
        )

    n_steps = round(SECONDS * RATE)
    return long_double.respond(task.oscillator, force, n_steps, step).astype(float)


def best_of(repeats: int, task: Callable[[], object]) -> float:
    """Return the least processor time of a task [s]."""
    used = []
    for _ in range(repeats):
        start = time.process_time()
        task()
        used.append(time.process_time() - start)
    return min(used)


def worst(found: Array, reference: Array) -> float:
    """Return the largest error as a share of the largest displacement."""
    return float(np.max(np.abs(found - reference)) / np.max(np.abs(reference)))


def main(arguments: Sequence[str] | None = None) -> None:
    """Print errors and times of both, and the ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    repeats = parser.parse_args(arguments).repeats
    times = np.arange(round(SECONDS * RATE) + 1) / RATE
    given = prepare(SIGNAL, RATE, duration=SECONDS)
    print(f"{'task':24}{'solver':34}{'error':>10}{'time [ms]':>12}{'ratio':>8}")
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        references = list(pool.map(reference_of, range(len(TASKS))))
    for task, exact in zip(TASKS, references, strict=True):
        compare(task, given, exact, times, repeats)
    sampled = prepare(SIGNAL(times), RATE, hold="linear")
    quick = best_of(repeats, lambda: simulate(TASKS[0].model, sampled, growth=False))
    print(f"{'gap':24}{'shakerproc, sampled force':34}{'':10}{1e3 * quick:12.2f}")
    sets = [
        model(EFFECTS["gap"](stiffness=STIFFNESS * (1.0 + 1e-4 * i), clearance=PLAY))
        for i in range(1000)
    ]
    several(sets, given, "analytic chirp")
    several(sets, sampled, "sampled force")


def reference_of(number: int) -> Array:
    """Return the reference of a task by its number, in another process."""
    return reference(TASKS[number])


def compare(task: Task, given: Input, exact: Array, times: Array, repeats: int) -> None:
    """Print time and error of both; the ratio is to our fastest that errs no more."""
    ours = []
    for tolerance in OURS:
        run = partial(
            simulate, task.model, SIGNAL, RATE, duration=SECONDS, tolerance=tolerance,
            growth=False,
        )  # fmt: skip
        error = worst(run().displacement[0], exact)
        ours.append((f"shakerproc, tolerance {tolerance:g}", error, best_of(repeats, run)))
    for tolerance in TOLERANCES:
        start = time.process_time()
        found = lsoda(task, times, tolerance)
        used = time.process_time() - start
        if found is None:
            least = min(seconds for _, _, seconds in ours)
            row(task, f"LSODA {tolerance:g}, given up", math.nan, used, f"{used / least:>8.0f}")
            continue
        error = worst(found, exact)
        beating = [seconds for _, own, seconds in ours if own <= error]
        ratio = f"{used / min(beating):8.0f}" if beating else f"{'-':>8}"
        row(task, f"LSODA {tolerance:g}", error, used, ratio)
    for name, error, seconds in ours:
        row(task, name, error, seconds)
    prepared = best_of(repeats, partial(simulate, task.model, given, growth=False))
    row(task, "shakerproc, chirp prepared before", ours[0][1], prepared)


def row(task: Task, solver: str, error: float, seconds: float, ratio: str = "") -> None:
    """Print a line of the table."""
    print(f"{task.name:24}{solver:34}{error:10.1e}{1e3 * seconds:12.2f}{ratio}", flush=True)


def several(sets: Sequence[Model], given: Input, what: str) -> None:
    """Print the time of many sets of parameters, on all cores."""
    start, used = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor() as pool:
        list(pool.map(partial(simulate, excitation=given, growth=False), sets))
    print(
        f"{len(sets)} sets of the gap over {SECONDS:g} s, {what}: "
        f"{time.perf_counter() - start:.2f} s ({time.process_time() - used:.2f} s of processor)"
    )


if __name__ == "__main__":
    main()
