"""A hidden gap found from arrays: three levels simulated, judged by a model that lacks it."""

from dataclasses import replace

import numpy as np

from shakerproc.diagnosis import TestArrays, diagnose_arrays
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Gap, Spring
from shakerproc.simulation import prepare, simulate

RATE, SECONDS, CLEARANCE = 2560.0, 2.0, 5e-5
LEVELS = (10.0, 25.0, 60.0)  # rms of the table [m/s²]
BETWEEN = ("base", "coupon")

believed = Model(
    title="glued joint",
    masses={"coupon": 28.6e-3},
    elements=(
        Element(Spring(stiffness=3.8e4), BETWEEN),
        Element(Damper(damping=3.0), BETWEEN),
    ),
    excitation=Excitation("base acceleration"),
    sensors={"ch3": Sensor("coupon")},
)
truth = replace(
    believed,
    elements=(
        Element(Spring(stiffness=3.6e4), BETWEEN),
        Element(Damper(damping=2.6), BETWEEN),
        Element(Gap(stiffness=5e4, clearance=CLEARANCE), BETWEEN),
    ),
)


def measured(number: int, rms: float, *, hold_out: bool) -> TestArrays:
    """Return one test: what two sensors record of it, with noise."""
    rng = np.random.default_rng(number)
    n = round(SECONDS * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < 20.0) | (frequency > 800.0)] = 0.0
    table = np.fft.irfft(spectrum, n)
    table *= rms / np.std(table)
    coupon = simulate(truth, prepare(table, RATE, upsample=4), growth=False).outputs["ch3"]
    noisy = [samples + 0.1 * rng.standard_normal(n) for samples in (table, coupon)]
    return TestArrays(
        f"{rms:g} m/s²", RATE, noisy[0][np.newaxis], noisy[1][np.newaxis], hold_out=hold_out
    )


tests = [measured(i, rms, hold_out=i == 1) for i, rms in enumerate(LEVELS)]


def diagnosis():
    """Return the verdict; it takes about half a minute of processor."""
    return diagnose_arrays(believed, tests)


if __name__ == "__main__":
    found = diagnosis()
    print(found.sentence)
    for effect in found.effects:
        for name, value in effect.parameters.items():
            print(f"{effect.kind} {name}: {value.value:.4g} {value.unit}")
