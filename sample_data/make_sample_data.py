"""Make the recordings of sample_data from a physical model, bit for bit the same each time.

A coupon of 28.6 g sits on a joint and is shaken at its base. Two things hold it: a support that
is always there, and a bushing in a hole, which carries only once its play is used up:

    m x'' + c z' + k_support z + k_bushing g(z) = 0,    z = x - y
    g(z) = 0 within the play, |z| - clearance / 2 beyond it

With no clearance, or with glue in it, the joint is linear and the coupon rings at 367 Hz. With
clearance the bushing carries for part of the motion only, and the frequency falls: the more,
the larger the clearance, and the less, the higher the level.
Nothing of that is put in by hand.

The equation is integrated by Runge and Kutta's fourth-order method, 16 steps a sample. Base and
coupon are low-passed alike, as the recorder would, read by accelerometers with a little noise,
gain error and offset, and written in the layout of NI SignalExpress.

    python sample_data/make_sample_data.py            writes recordings/ and prints what it did
    python sample_data/make_sample_data.py --check    compares with what is there instead
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from numba import njit
from numpy.typing import NDArray
from scipy import fft, signal

Array = NDArray[np.float64]

HERE = Path(__file__).resolve().parent

G = 9.80665  # [m/s²]
SAMPLE_RATE = 5688.9  # [Hz]
STEPS = 16  # integration steps for each sample

MASS = 28.6e-3  # [kg]
NATURAL_FREQUENCY = 367.0  # of the glued joint [Hz]
DAMPING_RATIO = 0.02  # of the glued joint [-]
STIFFNESS = MASS * (2.0 * np.pi * NATURAL_FREQUENCY) ** 2  # of the glued joint [N/m]
DAMPING = 2.0 * DAMPING_RATIO * np.sqrt(MASS * STIFFNESS)  # [N s/m]
SUPPORT = {"radial": 0.40, "slot": 0.45}  # share of the stiffness that is always there [-]

LEAD_IN, TAIL, RAMP = 0.6, 0.3, 0.05  # quiet at both ends, and how it swells [s]
NOISE = 0.003  # of each accelerometer over its whole band [g rms]
BIT = 2.0**-20  # least step of the recorder [g]
SENSORS = {  # gain error [-] and offset [g]
    "control 1": (0.001, 0.002),
    "control 2": (-0.001, -0.003),
    "response 1": (0.0, 0.001),
    "response 2": (0.0, 0.004),
}

TITLE = "06/05/2018 10:12:00 AM - Acceleration"
START = np.datetime64("2018-06-05T08:12:00")
PAIR = 100  # samples of which a decimated copy keeps the smallest and the largest


@dataclass(frozen=True)
class Run:
    """One recording; see testlog.yaml."""

    id: int
    joint: str
    clearance: float  # hole less bushing [m]
    kind: str  # "random", "sweep" or "sine"
    level: float  # [g²/Hz] for random, else [g]
    seconds: float = 0.0
    low: float = 5.0  # [Hz]
    high: float = 1000.0  # [Hz]
    rate: float = 20.0  # of a sweep [oct/min]
    kept: float = 1.0  # share of the file that survived
    spike_at: float = 0.0  # a knock on the cable of control 2 [s]


RUNS = (
    Run(1, "radial", 0.00e-3, "random", 0.02, 6.0),
    Run(2, "radial", 0.05e-3, "random", 0.02, 6.0),
    Run(3, "radial", 0.10e-3, "random", 0.02, 6.5),
    Run(4, "radial", 0.10e-3, "random", 0.005, 6.5),
    Run(5, "radial", 0.10e-3, "random", 0.08, 6.5),
    Run(7, "slot", 0.00e-3, "random", 0.02, 3.5),
    Run(8, "slot", 0.05e-3, "random", 0.02, 3.5),
    Run(9, "slot", 0.10e-3, "random", 0.02, 3.5),
    Run(10, "radial", 0.00e-3, "sweep", 5.0, low=150.0, high=500.0),
    Run(11, "radial", 0.05e-3, "sweep", 5.0, low=150.0, high=500.0, kept=0.87),
    Run(12, "radial", 0.10e-3, "sweep", 5.0, low=150.0, high=500.0),
    Run(13, "radial", 0.10e-3, "sweep", 2.0, low=150.0, high=500.0, spike_at=0.2),
    Run(14, "radial", 0.10e-3, "sine", 15.0, 1.5, low=50.0, high=50.0),
    Run(15, "radial", 0.10e-3, "random", 0.04, 4.5),
)


@njit(cache=False)
def relative_motion(
    base: Array, step: float, joint: tuple[float, float, float, float, float]
) -> tuple[Array, Array]:
    """Return relative displacement [m] and absolute acceleration [m/s²] at every step.

    `base` holds the acceleration of the base [m/s²] at every half step; `joint` is mass,
    damping, stiffness of the support, stiffness of the bushing and its play either way.
    """
    mass, damping, support, bushing, play = joint
    n = base.size // 2
    displacement, acceleration = np.zeros(n), np.zeros(n)
    z, v = 0.0, 0.0
    for i in range(n):
        slope_z, slope_v = np.zeros(4), np.zeros(4)
        for stage in range(4):
            part = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
            zs = z + part * step * (slope_z[stage - 1] if stage else 0.0)
            vs = v + part * step * (slope_v[stage - 1] if stage else 0.0)
            beyond = max(abs(zs) - play, 0.0)
            force = support * zs + bushing * (beyond if zs > 0.0 else -beyond) + damping * vs
            slope_z[stage] = vs
            slope_v[stage] = -force / mass - base[min(2 * i + (stage + 1) // 2, base.size - 1)]
            if stage == 0:
                displacement[i], acceleration[i] = z, -force / mass
        z += step / 6.0 * (slope_z[0] + 2.0 * slope_z[1] + 2.0 * slope_z[2] + slope_z[3])
        v += step / 6.0 * (slope_v[0] + 2.0 * slope_v[1] + 2.0 * slope_v[2] + slope_v[3])
    return displacement, acceleration


def excitation(run: Run, rng: np.random.Generator) -> Array:
    """Return the acceleration of the base at every half step, in m/s²."""
    octaves = np.log2(run.high / run.low)
    seconds = octaves / run.rate * 60.0 if run.kind == "sweep" else run.seconds
    lead_in = LEAD_IN + (0.7 if run.spike_at else 0.0)
    n = fft.next_fast_len(round((lead_in + seconds + TAIL) * SAMPLE_RATE))
    rate = 2 * STEPS * SAMPLE_RATE
    time = np.arange(2 * STEPS * n) / rate - lead_in
    swell = np.clip(np.minimum(time, seconds - time) / RAMP, 0.0, 1.0)
    envelope = 0.5 - 0.5 * np.cos(np.pi * swell)
    if run.kind == "random":
        unit = noise_of_density(run, time.size, rate, rng)
    elif run.kind == "sweep":
        # The phase is the integral of a frequency that doubles rate / 60 times a second.
        doublings = run.rate / 60.0
        unit = run.level * np.sin(
            2.0
            * np.pi
            * run.low
            * (2.0 ** (doublings * time) - 1.0)
            / (doublings * np.log(2.0))
        )
    else:
        unit = run.level * np.sin(2.0 * np.pi * run.low * time)
    # In steps of 2^-16 m/s², so that the last digits of another machine's sine do not matter:
    # a rattling joint would blow them up.
    return np.round(envelope * unit * G * 2.0**16) / 2.0**16


def noise_of_density(run: Run, n: int, rate: float, rng: np.random.Generator) -> Array:
    """Return Gaussian noise in g with the density of the run between its limits."""
    frequency = np.arange(n // 2 + 1) * (rate / n)
    edge = np.minimum(frequency / run.low, run.high / np.maximum(frequency, 1.0))
    density = np.where(edge >= 1.0, run.level, 0.0)
    lines = int(np.searchsorted(frequency, run.high)) + 1
    spectrum = np.zeros(frequency.size, dtype=complex)
    pairs = rng.standard_normal((2, lines))
    spectrum[:lines] = (pairs[0] + 1j * pairs[1]) * np.sqrt(density[:lines] * rate * n) / 2.0
    return fft.irfft(spectrum, n)


def sampled(steps: Array) -> Array:
    """Return what a recorder makes of a quantity known at every step, low-passed."""
    n = steps.size // STEPS
    spectrum = fft.rfft(steps)[: n // 2 + 1]
    share = np.arange(n // 2 + 1) / n  # of the sample rate
    fall = np.clip((share - 0.45) / 0.04, 0.0, 1.0)
    return fft.irfft(spectrum * (0.5 + 0.5 * np.cos(np.pi * fall)), n) / STEPS


def measured(run: Run) -> tuple[Array, Array]:
    """Return what the sensors say, (4, n) array in g, and the relative displacement [m]."""
    rng = np.random.default_rng([20180605, run.id])
    base = excitation(run, rng)
    share = SUPPORT[run.joint]
    joint = (
        MASS, DAMPING, share * STIFFNESS, (1.0 - share) * STIFFNESS, run.clearance / 2.0,
    )  # fmt: skip
    displacement, coupon = relative_motion(base, 1.0 / (STEPS * SAMPLE_RATE), joint)
    control, response = sampled(base[::2]) / G, sampled(coupon) / G
    signals = np.stack([control, control, response, response])
    noise = NOISE * rng.standard_normal(signals.shape)
    gain, offset = np.array(list(SENSORS.values())).T[:, :, None]
    seen = (1.0 + gain) * signals + offset + noise
    if run.spike_at:
        knock = np.arange(seen.shape[1]) / SAMPLE_RATE - run.spike_at
        seen[1] += 1.2 * np.exp(-knock / 0.0008) * (knock >= 0.0)
    return np.round(seen / BIT) * BIT, displacement


def write(path: Path, run: Run, samples: Array) -> None:
    """Write a recording as SignalExpress does, a segment a second, cut where it was cut."""
    root = {
        "name": "Acceleration",
        "Title": TITLE,
        "WriterName": "shakerproc sample data",
        "log-dt": 1.0 / SAMPLE_RATE,
        "log-duration": samples.shape[1] / SAMPLE_RATE,
        "recording-complete": run.kept == 1.0,
    }
    with TdmsWriter(str(path)) as writer:
        name = f"{TITLE} - All Data"
        group = GroupObject(name, {"DecimationLevel": 0, "IntervalIndex": 0})
        second = round(SAMPLE_RATE)
        for first in range(0, samples.shape[1], second):
            block = samples[:, first : first + second]
            head = [RootObject(root), group] if first == 0 else []
            writer.write_segment([*head, *channels(name, block, 1)])
        name = f"{TITLE} - Decimated Data_Level1"
        group = GroupObject(name, {"DecimationLevel": 1, "IntervalIndex": 0})
        pairs = samples[:, : samples.shape[1] // PAIR * PAIR].reshape(len(samples), -1, PAIR)
        extremes = np.stack([pairs.min(axis=2), pairs.max(axis=2)], axis=2)
        writer.write_segment([
            group,
            *channels(name, extremes.reshape(len(samples), -1), PAIR // 2),
        ])
    if run.kept < 1.0:
        content = path.read_bytes()
        path.write_bytes(content[: round(run.kept * len(content))])


def channels(group: str, block: Array, step: int) -> Iterator[ChannelObject]:
    """Yield the channels of a group with the properties of a waveform in g."""
    for name, row in zip(SENSORS, block, strict=True):
        properties = {
            "wf_start_time": START,
            "wf_start_offset": 0.0,
            "wf_increment": step / SAMPLE_RATE,
            "wf_samples": len(row),
            "unit_string": "g",
            "NI_ChannelName": name,
        }
        yield ChannelObject(group, name, row.astype(np.float32), properties)


def peak_frequency(samples: Array, run: Run) -> float:
    """Return where the density of response 1 is largest within the excited band [Hz]."""
    frequency, density = signal.welch(
        samples[2], SAMPLE_RATE, "hamming", 1024, detrend="constant"
    )
    inside = (frequency >= 0.8 * run.low) & (frequency <= 1.2 * run.high)
    return float(frequency[inside][np.argmax(density[inside])])


def make(folder: Path, runs: tuple[Run, ...] = RUNS) -> Iterator[tuple[Path, str]]:
    """Write the recordings below a folder, and yield the path of each and a row of facts."""
    for run in runs:
        samples, displacement = measured(run)
        path = folder / f"Test_{run.id}" / "Acceleration.tdms"
        path.parent.mkdir(parents=True, exist_ok=True)
        write(path, run, samples)
        yield path, row(run, displacement, peak_frequency(samples, run), path.stat().st_size)


def row(run: Run, displacement: Array, peak: float, size: int) -> str:
    """Return a row of the table: what was shaken, how far it moved, where it rang."""
    play = run.clearance / 2.0
    contact = float(np.mean(np.abs(displacement) > play)) if play else 1.0
    farthest = np.max(np.abs(displacement)) * 1e6
    return (
        f"{run.id:>4} {run.joint:<7}{run.clearance * 1e3:9.2f}  {run.kind:<7}{run.level:7.3f} "
        f"{farthest:9.0f} {contact:8.0%} {peak:10.1f} {size / 1e6:7.2f}"
    )


def main() -> int:
    """Write the recordings, or compare them with those that are there."""
    parser = argparse.ArgumentParser(description="Make the recordings of sample_data.")
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    check = parser.parse_args().check
    there = HERE / "recordings"
    print("test joint   clearance  kind    level  max |z|  in contact   peak PSD    size")
    print("                    mm          g, g²/Hz     µm                     Hz      MB")
    differing = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) if check else there
        for path, facts in make(folder):
            print(facts)
            if check and path.read_bytes() != (there / path.relative_to(folder)).read_bytes():
                differing.append(str(path.relative_to(folder)))
    print(f"differ: {', '.join(differing)}" if differing else "done")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
