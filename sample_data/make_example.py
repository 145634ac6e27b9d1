"""Make the recordings that `shakerproc init` writes: a coupon whose joint has play.

    python sample_data/make_example.py            writes them into the package
    python sample_data/make_example.py --check    compares with what is there instead

Log and model beside them are written by hand; the model lacks the gap.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import (
    STANDARD_GRAVITY,
    Channel,
    FloatArray,
    Recording,
    recording_of_arrays,
)
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Gap, Spring
from shakerproc.recordings import open_recording, write_tdms
from shakerproc.simulation import simulate

HERE: Final = Path(__file__).resolve().parent
SHIPPED: Final = HERE.parent / "src/shakerproc/workflows/example_campaign/recordings"

RATE: Final = 2560.0
BAND: Final = (20.0, 800.0)
QUIET: Final = 0.5
RAMP: Final = 0.1
NOISE_G: Final = 0.01
OVERSAMPLED: Final = 4
"""Samples that the converter takes for each one that it stores, past its filter [-]."""

MASS: Final = 28.6e-3
SUPPORT: Final = 3.6e4
DAMPING: Final = 2.6
CONTACT: Final = 5.0e4
PLAY: Final = 5.0e-5


@dataclass(frozen=True, slots=True)
class ExampleTest:
    """One test of the example.

    Attributes
    ----------
    number : int
        Its id.
    level : float
        Density of the excitation [g²/Hz].
    seconds : float
        Length of the run [s].
    """

    number: int
    level: float
    seconds: float


TESTS: Final = (
    ExampleTest(1, 0.001, 6.0),
    ExampleTest(2, 0.005, 6.0),
    ExampleTest(3, 0.02, 6.0),
    ExampleTest(4, 0.01, 6.0),
)


def truth() -> Model:
    """Return what the recordings come from; the model that is written lacks the gap."""
    between = ("base", "coupon")
    return Model(
        title="truth",
        masses={"coupon": MASS},
        elements=(
            Element(Spring(stiffness=SUPPORT), between),
            Element(Damper(damping=DAMPING), between),
            Element(Gap(stiffness=CONTACT, clearance=PLAY), between),
        ),
        excitation=Excitation("base acceleration"),
        sensors={"ch3": Sensor("coupon")},
    )


def base_motion(test: ExampleTest) -> FloatArray:
    """Return random acceleration of the table, quiet before and after, (n,) array [m/s²]."""
    rng = np.random.default_rng(20180605 + test.number)
    n = round((test.seconds + 2.0 * QUIET) * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < BAND[0]) | (frequency > BAND[1])] = 0.0
    motion = np.fft.irfft(spectrum, n)
    motion *= np.sqrt(test.level * (BAND[1] - BAND[0])) / np.std(motion)
    from_end = np.minimum(np.arange(n), np.arange(n)[::-1]) / RATE
    return np.asarray(
        motion * np.clip((from_end - QUIET) / RAMP, 0.0, 1.0) * STANDARD_GRAVITY, dtype=float
    )


def resampled(samples: FloatArray, count: int) -> FloatArray:
    """Return the same signal in so many samples, without what they cannot hold, (count,) array.

    A contact bends the acceleration, which holds frequencies without end; a recorder's filter
    keeps them from folding into the band.
    """
    spectrum = np.fft.rfft(samples)[: count // 2 + 1]
    return np.asarray(np.fft.irfft(spectrum, count) * (count / samples.size), dtype=float)


def recorded(test: ExampleTest) -> Recording:
    """Return what the logger would have stored of a test."""
    base = base_motion(test)
    finer = resampled(base, OVERSAMPLED * base.size)
    response = simulate(truth(), finer, OVERSAMPLED * RATE, growth=False).outputs["ch3"]
    response = resampled(response, base.size)
    rng = np.random.default_rng(test.number)
    rows = np.array([base, base, response])
    rows += NOISE_G * STANDARD_GRAVITY * rng.standard_normal(rows.shape)
    channels = [
        Channel(name, "m/s^2", name, "g") for name in ("control 1", "control 2", "response 1")
    ]
    return recording_of_arrays(f"test {test.number}", channels, rows, RATE)


def main() -> int:
    """Write the recordings, or compare them with those that are there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    check = parser.parse_args().check
    for test in TESTS:
        made, path = recorded(test), SHIPPED / f"test_{test.number}.tdms"
        if not check:
            write_tdms(path, made)
            continue
        with open_recording(path) as there:
            apart = np.abs(there.samples() - made.samples()).max()
        print(f"test {test.number}: at most {apart:.2g} m/s^2 apart")
    return 0


if __name__ == "__main__":
    sys.exit(main())
