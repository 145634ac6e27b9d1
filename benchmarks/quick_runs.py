"""What a quick run of `simulate` takes, over one that tells its error.

``python -m benchmarks.quick_runs``: one mass on a joint under noise from 5 to 400 Hz at 4000
samples a second, 8 s, tolerance 1e-9 as `compare` takes it. Seconds of processor, the best of
four, and how far both motions are apart over the largest.
"""

import time

import numpy as np

from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.effects import EXAMPLES, GeneralBoucWen
from shakerproc.simulation import SimulatedResponse, prepare, simulate

RATE, SECONDS, RMS = 4000.0, 8.0, 10.0
LAWS = {
    kind: EXAMPLES[kind]
    for kind in (
        "gap",
        "cubic_stiffness",
        "hertz_contact",
        "bouc_wen",
        "iwan",
        "lugre_friction",
    )
} | {"general_bouc_wen, curved": GeneralBoucWen(5e4, 1e5, 5e4, 1.5)}


def noise() -> np.ndarray:
    """Return the acceleration of the base, (n,) array [m/s^2]."""
    n = round(RATE * SECONDS)
    spectrum = np.fft.rfft(np.random.default_rng(5).standard_normal(n))
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum[(frequency < 5.0) | (frequency > 400.0)] = 0.0
    samples = np.fft.irfft(spectrum, n)
    return np.asarray(samples * RMS / samples.std())


def timed(model: Model, samples: np.ndarray, solver: str) -> tuple[float, SimulatedResponse]:
    """Return the processor time of a run [s], and what it gives."""
    given, best = prepare(samples, RATE), np.inf
    for _ in range(4):  # the first one compiles
        begun = time.process_time()
        found = simulate(model, given, growth=False, tolerance=1e-9, solver=solver)
        best = min(best, time.process_time() - begun)
    return best, found


def main() -> None:
    """Print a line for each law."""
    samples = noise()
    for name, law in LAWS.items():
        held = (EFFECTS["spring"](stiffness=6e4), EFFECTS["damper"](damping=1.5), law)
        elements = tuple(Element(one, ("base", "coupon")) for one in held)
        sensors = {"c": Sensor("coupon", "acceleration")}
        model = Model(
            "m", {"coupon": 0.0286}, elements, Excitation("base acceleration"), sensors
        )
        (slow, one), (quick, other) = (timed(model, samples, s) for s in ("automatic", "quick"))
        apart = np.max(np.abs(one.displacement - other.displacement))
        apart /= np.max(np.abs(one.displacement))
        print(
            f"{name}: {slow:.3f} s, quick {quick:.3f} s, {quick / slow:.2f}; {apart:.1e} apart"
        )


if __name__ == "__main__":
    main()
