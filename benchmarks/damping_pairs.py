"""Damping of pairs of modes: how often the 95 % intervals hold the truth, how many are told.

python -m benchmarks.damping_pairs [--pairs 60] [--seed 1000] [--apart 0.12]

Two modes 3 to 30 half-power widths apart, 0.3 to 5 % of damping each, base excitation, heights
up to 5 to 1 in or against phase, 40 or 120 s, noise of 1 to 50 % of the base; read as `process`
reads them, with nothing set by hand. `--apart` sets the relative distance of all of them.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import signal

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.spectra import Damping
from shakerproc.testlog import Test

RATE = 5688.9
ROLES = ("control", "response")
CHANNELS = tuple(Channel(role, "m/s^2", role, "m/s^2", role) for role in ROLES)
RANDOM = Test("simulated", excitation="random", from_hz=5.0, to_hz=2000.0)
RANDOM = replace(RANDOM, processing=replace(RANDOM.processing, crop=None))


@dataclass(frozen=True)
class Pair:
    """Two modes on one base, and how far apart they are in mean half-power widths."""

    samples: np.ndarray
    frequency: np.ndarray
    ratio: np.ndarray
    widths: float
    seconds: float
    noise: float


def simulated(rng: np.random.Generator, distance: float | None = None) -> Pair:
    """Return control and response of a random pair, of a given relative distance."""
    seconds, noise = rng.choice([40.0, 120.0]), rng.choice([0.01, 0.1, 0.5])
    while True:
        ratio = np.exp(rng.uniform(*np.log([0.003, 0.05]), 2))
        low, widths = rng.uniform(100.0, 700.0), np.exp(rng.uniform(*np.log([3.0, 30.0])))
        if distance is not None:
            widths = distance / (ratio @ [1.0, 1.0 + distance])
            if not 3.0 < widths < 30.0:
                continue
        room = 1.0 - widths * ratio[1]
        if room > 0.2 and low * (1.0 + widths * ratio[0]) / room < 1500.0:
            break
    frequency = np.array([low, low * (1.0 + widths * ratio[0]) / room])
    height = np.exp(rng.uniform(*np.log([0.2, 5.0]))) * rng.choice([-1.0, 1.0])
    share = np.array([1.0, height * ratio[1] / ratio[0]])
    base = rng.standard_normal(round(seconds * RATE))
    response = sum(
        part * mode(base, f, z) for part, f, z in zip(share, frequency, ratio, strict=True)
    )
    response = response + noise * np.abs(share).max() * rng.standard_normal(base.size)
    return Pair(np.array([base, response]), frequency, ratio, widths, seconds, noise)


def mode(base: np.ndarray, frequency: float, ratio: float) -> np.ndarray:
    """Absolute acceleration of a mass on a spring and damper."""
    omega = 2.0 * np.pi * frequency
    continuous = ([2.0 * ratio * omega, omega**2], [1.0, 2.0 * ratio * omega, omega**2])
    above, below, _ = signal.cont2discrete(continuous, 1.0 / RATE, "foh")
    return np.asarray(signal.lfilter(above.ravel(), below, base))


def readings(pair: Pair, *, with_control: bool = True) -> list[Damping | None]:
    """Return what `process` says of each mode: of the peak within its half-power width."""
    rows = slice(0, 2) if with_control else slice(1, 2)
    recording = recording_of_arrays("pair", CHANNELS[rows], pair.samples[rows], RATE)
    result = process_recording(recording, RANDOM)
    peaks = (result.averages.response_peaks if with_control else result.averages.psd_peaks)[-1]
    found = []
    for f, z in zip(pair.frequency, pair.ratio, strict=True):
        apart = {abs((p.damping.frequency or p.peak.frequency) - f): p.damping for p in peaks
                 if p.damping is not None}  # fmt: skip
        nearest = min(apart, default=np.inf)
        found.append(apart[nearest] if nearest < 2.0 * z * f else None)
    return found


def campaign(
    n_pairs: int, seed: int, *, with_control: bool = True, distance: float | None = None
) -> np.ndarray:
    """Return for each mode: widths apart, told, held by the interval, relative error."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(n_pairs):
        pair = simulated(rng, distance)
        read = readings(pair, with_control=with_control)
        for damping, ratio in zip(read, pair.ratio, strict=True):
            told = damping is not None and damping.ratio is not None
            inside = told and damping.ratio_low <= ratio <= damping.ratio_high
            error = abs(damping.ratio / ratio - 1.0) if told else np.nan
            rows.append((pair.widths, told, inside, error))
    return np.array(rows, dtype=float)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print coverage and what is withheld."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--densities", action="store_true", help="without the control")
    parser.add_argument("--apart", type=float, help="relative distance of the modes")
    options = parser.parse_args(arguments)
    rows = campaign(
        options.pairs, options.seed,
        with_control=not options.densities, distance=options.apart,
    )  # fmt: skip
    parts = (("all", 3.0, 30.0), ("3 to 6 widths", 3.0, 6.0), ("6 to 30 widths", 6.0, 30.0))
    print(f"{options.pairs} pairs, seed {options.seed} (aim: 93 to 97 % of intervals)")
    for name, low, high in parts:
        part = rows[(rows[:, 0] >= low) & (rows[:, 0] <= high)]
        told = part[part[:, 1] > 0.0]
        if not told.size:
            continue
        pairs = part.reshape(-1, 2, 4)[:, :, 1].all(axis=1)
        print(
            f"{name:15s} told {len(told)} of {len(part)} modes, both of "
            f"{np.mean(pairs):.0%} of the pairs; truth in the 95 % interval "
            f"{np.mean(told[:, 2]):.1%}; error, median {np.median(told[:, 3]):.2%}, "
            f"largest {np.max(told[:, 3]):.1%}"
        )


if __name__ == "__main__":
    main()
