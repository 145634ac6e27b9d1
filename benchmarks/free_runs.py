"""Free runs of every law, as identification needs them: cost and error.

python -m benchmarks.free_runs [--laws gap,lugre_friction] [--tolerance 1e-6] [--no-errors]

A mass of 0.2 kg on a spring (100 Hz, 1 % of critical damping) and one law more, of the size
that the motion asks for; four tests of 20.5 s at 5.69 kHz (a random vibration from 30 to 300 Hz
and a logarithmic sweep, each at two levels): 470,000 samples. Printed are processor
milliseconds for all four, whole and in windows of 2, 10 and 50 periods, and what each is of the
linear model's; the rms error of the acceleration of one random test against the fine solver, as
a share of its rms; and what a disturbance grows by.
"""

import argparse
import time
from functools import partial

import numpy as np

from shakerproc.models import Element, Excitation, Model, Sensor, effects
from shakerproc.models.effects.base import AbstractEffect
from shakerproc.simulation import Input, Runs, free_runs, motions_of, prepare, simulate

RATE, SECONDS, FREQUENCY, MASS = 5690.0, 20.5, 100.0, 0.2
OMEGA = 2.0 * np.pi * FREQUENCY
STIFFNESS = MASS * OMEGA**2
DAMPING = 2.0 * 0.01 * MASS * OMEGA
SENSORS = {"acceleration": Sensor("coupon")}
PERIODS = (2, 10, 50)


def laws(size: float) -> dict[str, tuple[AbstractEffect, ...]]:
    """Return the laws, for a displacement of this size [m]."""
    force, speed, k, z = STIFFNESS * size, OMEGA * size, STIFFNESS, size
    return {
        "linear": (),
        "gap": (effects.Gap(k, 0.5 * z),),
        "offset_gap": (effects.OffsetGap(k, 0.4 * z, 0.8 * z),),
        "stop": (effects.Stop(k, 0.4 * z, "positive"),),
        "jump_gap": (effects.JumpGap(0.3 * k, 0.5 * z),),
        "cubic_stiffness": (effects.CubicStiffness(0.3 * k / z**2),),
        "quadratic_stiffness": (effects.QuadraticStiffness(0.15 * k / z),),
        "power_law 5": (effects.PowerLaw(0.3 * force, z, 5.0),),
        "power_law 2.3": (effects.PowerLaw(0.3 * force, z, 2.3),),
        "power_law_damping": (effects.PowerLawDamping(0.05 * force / speed, z, 2.0),),
        "coulomb_friction": (effects.CoulombFriction(0.15 * force),),
        "stribeck_friction": (
            effects.StribeckFriction(0.1 * force, 0.16 * force, 0.25 * speed),
        ),
        "lugre_friction": (_lugre(0.1 * force, 0.08 * z, speed),),
        "lugre_friction, stiff": (_lugre(0.1 * force, 0.01 * z, speed),),
        "quadratic_damping": (effects.QuadraticDamping(0.06 * MASS * OMEGA / speed),),
        "contact_damping": (effects.ContactDamping(0.2 * MASS * OMEGA, 0.5 * z),),
        "jenkins": (effects.Jenkins(0.3 * k, 0.1 * force),),
        "iwan": (effects.Iwan(0.3 * k, 0.7 * z),),
        "iwan, stiff": (effects.Iwan(5.0 * k, 0.05 * z),),
        "bouc_wen": (effects.BoucWen(0.3 * k, 0.3 * z, 2.0),),
        "bouc_wen, stiff": (effects.BoucWen(3.0 * k, 0.03 * z, 1.0),),
        "bouc_wen 1.5": (effects.BoucWen(0.3 * k, 0.3 * z, 1.5),),
        "attached_mode": (effects.AttachedMode(0.05 * MASS, 120.0, 0.02),),
        "stiffness_drift": (effects.StiffnessDrift(-3e-3, 0.0, k),),
        "gap and cubic": (effects.Gap(k, 0.5 * z), effects.CubicStiffness(0.2 * k / z**2)),
        "coulomb and cubic": (
            effects.CoulombFriction(0.1 * force), effects.CubicStiffness(0.3 * k / z**2),
        ),
        "stribeck and iwan": (
            effects.StribeckFriction(0.05 * force, 0.08 * force, 0.25 * speed),
            effects.Iwan(0.3 * k, 0.7 * z),
        ),
    }  # fmt: skip


def _lugre(force: float, bristle: float, speed: float) -> AbstractEffect:
    stiffness = force / bristle
    damping = 0.3 * np.sqrt(stiffness * MASS)
    return effects.LuGreFriction(force, 1.6 * force, 0.25 * speed, stiffness, damping, 0.0)


def specimen(law: tuple[AbstractEffect, ...]) -> Model:
    """Return the mass with its spring and a law."""
    elements = (effects.Spring(STIFFNESS), effects.Damper(damping=DAMPING), *law)
    joined = tuple(Element(effect, ("base", "coupon")) for effect in elements)
    return Model("one mass", {"coupon": MASS}, joined, Excitation("base acceleration"), SENSORS)


def tests() -> tuple[Input, ...]:
    """Return the input of four tests."""
    n = round(RATE * SECONDS)
    rng = np.random.default_rng(1)
    spectrum = np.fft.rfft(rng.standard_normal(n))
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum[(frequency < 30.0) | (frequency > 300.0)] = 0.0
    t = np.arange(n) / RATE
    ramp = np.minimum(1.0, np.minimum(t, t[-1] - t) / 0.5)
    noise = np.fft.irfft(spectrum, n) * ramp
    noise /= np.std(noise)
    rate = np.log(10.0) / SECONDS
    sweep = np.sin(2.0 * np.pi * 30.0 * (np.exp(rate * t) - 1.0) / rate) * ramp
    prepared = partial(prepare, sample_rate=RATE)
    return (
        prepared(5.0 * noise), prepared(10.0 * noise), prepared(2.0 * sweep),
        prepared(4.0 * sweep),
    )  # fmt: skip


def windows(periods: int | None) -> np.ndarray:
    """Return windows of all tests, of so many periods."""
    n = round(RATE * SECONDS)
    length = n if periods is None else round(periods * RATE / FREQUENCY)
    firsts = range(0, n - length + 1, length)
    return np.array([[test, first, length] for test in range(4) for first in firsts])


def cost(model: Model, runs: Runs, tolerance: float, repeats: int) -> float:
    """Return processor milliseconds of a call, the quickest of several."""
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        free_runs(model, runs, tolerance=tolerance)
        best = min(best, time.process_time() - begin)
    return 1e3 * best


def error(model: Model, given: Input, tolerance: float) -> tuple[float, float, int]:
    """Return the largest error of acceleration over its rms, growth and switchings."""
    runs = Runs((given,), np.array([[0, 0, given.n_samples]]))
    found = free_runs(model, runs, tolerance=tolerance, means=False)
    if found.failed[0]:
        return np.nan, np.nan, 0
    fine = simulate(model, given, tolerance=1e-13)
    wanted = fine.outputs["acceleration"]
    apart = np.sqrt(np.mean((found.outputs[0][0] - wanted) ** 2))
    return float(apart / np.std(wanted)), fine.growth or np.nan, fine.switchings


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--laws", default="")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--no-errors", action="store_true")
    chosen = parser.parse_args()
    given = tests()
    base = specimen(())
    free_runs(base, Runs(given, windows(None)))
    moved = simulate(base, given[1], growth=False).displacement[0]
    size = 2.0 * float(np.std(moved))
    wanted = [name.strip() for name in chosen.laws.split(";") if name]
    first: list[float] = []
    heads = ("whole", *(f"{p} periods" for p in PERIODS))
    print(f"{'law':24s}" + "".join(f"{head:>18s}" for head in heads), end="")
    print(f"{'error':>10s}{'growth':>10s}{'switchings':>12s}")
    for name, law in laws(size).items():
        if wanted and name not in wanted and name != "linear":
            continue
        model = specimen(law)
        n_y = len(motions_of(model))
        times = []
        for periods in (None, *PERIODS):
            at = windows(periods)
            runs = Runs(given, at, np.zeros((len(at), n_y)))
            times.append(cost(model, runs, chosen.tolerance, chosen.repeats))
        first = first or times
        shares = [f"{t:9.1f} ({t / f:5.1f})" for t, f in zip(times, first, strict=True)]
        print(f"{name:24s}" + "".join(f"{share:>18s}" for share in shares), end="", flush=True)
        if not chosen.no_errors:
            off, growth, switchings = error(model, given[1], chosen.tolerance)
            print(f"{off:10.1e}{growth:10.1e}{switchings:12d}", end="")
        print(flush=True)


if __name__ == "__main__":
    main()
