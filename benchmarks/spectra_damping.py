"""Damping read from simulated single masses, and how often the bounds hold the truth.

python -m benchmarks.spectra_damping [--runs 40]
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy import signal

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.spectra import (
    Damping,
    cross_spectra,
    damping_of_response,
    find_peaks,
    h1,
    psd_bounds,
    response_bounds,
)
from shakerproc.testlog import Test

RATE = 5688.9
SEGMENTS = (512, 1024, 2048, 8192)


def simulated(rng: np.random.Generator) -> tuple[np.ndarray, float, float]:
    """Return control and response of a random mass, its frequency and damping ratio."""
    seconds, noise = rng.choice([15.0, 40.0, 120.0]), rng.choice([0.01, 0.3, 2.0])
    frequency, ratio = rng.uniform(60.0, 900.0), np.exp(rng.uniform(*np.log([0.005, 0.05])))
    base = rng.standard_normal(round(seconds * RATE))
    omega = 2.0 * np.pi * frequency
    continuous = ([2.0 * ratio * omega, omega**2], [1.0, 2.0 * ratio * omega, omega**2])
    above, below, _ = signal.cont2discrete(continuous, 1.0 / RATE, "foh")
    response = signal.lfilter(above.ravel(), below, base)
    response += noise * rng.standard_normal(base.size)
    return np.array([base, response]), frequency, ratio


def as_process_reads_it(samples: np.ndarray) -> Damping | None:
    """Return the damping of the tallest peak of |H1| as `shakerproc process` gives it."""
    roles = ("control", "response")
    channels = [Channel(role, "m/s^2", role, "m/s^2", role) for role in roles]
    test = Test("simulated", excitation="random", from_hz=5.0, to_hz=2000.0)
    test = replace(test, processing=replace(test.processing, crop=None))
    recording = recording_of_arrays("simulated", channels, samples, RATE)
    peaks = process_recording(recording, test).averages.response_peaks[1]
    return peaks[0].damping if peaks else None


def damping_errors(n_runs: int) -> None:
    """Print, for each segment length, how many are reported and how far they are off."""
    found: dict[int, list[tuple[float, bool]]] = {segment: [] for segment in (0, *SEGMENTS)}
    rng = np.random.default_rng(2)
    for _ in range(n_runs):
        samples, _, ratio = simulated(rng)
        read = as_process_reads_it(samples)
        if read is not None and read.ratio is not None:
            inside = read.ratio_low <= ratio <= read.ratio_high
            found[0].append((abs(read.ratio / ratio - 1.0), inside))
        for segment in SEGMENTS:
            spectra = cross_spectra(samples, RATE, segment=segment)
            gain = np.abs(h1(spectra, [0], [1])[0])
            (peak,) = find_peaks(spectra.frequency, gain, (5.0, 2000.0), count=1)
            damping = damping_of_response(spectra, [0], 1, peak.frequency, (5.0, 2000.0))
            if damping.ratio is not None:
                inside = damping.ratio_low <= ratio <= damping.ratio_high
                found[segment].append((abs(damping.ratio / ratio - 1.0), inside))
    print(f"{n_runs} masses, 60-900 Hz, zeta 0.5-5 %, 15-120 s, noise 1-200 % of the base")
    for segment, results in found.items():
        if results:
            errors, inside = zip(*results, strict=True)
            how = f"bins {RATE / segment:6.2f} Hz" if segment else "process        "
            print(
                f"{how}: reported {len(errors):3d} of {n_runs}, "
                f"largest error {max(errors):.1%} (aim: 5 %), "
                f"in the 95 % interval {np.mean(inside):.0%}"
            )


def coverage(n_runs: int) -> None:
    """Print how often the 95 % bounds hold the truth."""
    rng, hits = np.random.default_rng(3), []
    for _ in range(n_runs):
        x = rng.standard_normal(2560)
        y = 2.0 * x + 2.0 * rng.standard_normal(2560)
        spectra = cross_spectra(np.array([x, y]), 1000.0, segment=256)
        density, (gain, phase) = psd_bounds(spectra), response_bounds(spectra, [0], [1])
        inner = slice(1, -1)
        angle = np.angle(spectra.matrix[0, 1])[inner]
        hits.append([
            np.mean((density.low[0] <= 0.002) & (density.high[0] >= 0.002), where=_inner(129)),
            np.mean((gain.low[0] <= 2.0) & (gain.high[0] >= 2.0), where=_inner(129)),
            np.mean(np.abs(angle) <= phase[0, inner]),
        ])
    shares = np.mean(hits, axis=0)
    print("95 % bounds, 19 overlapping segments (aim: 93 to 97 %):")
    for name, share in zip(("PSD", "gain of H1", "phase of H1"), shares, strict=True):
        print(f"{name:12s} {share:.1%}")


def _inner(size: int) -> np.ndarray:
    keep = np.ones(size, dtype=bool)
    keep[[0, -1]] = False
    return keep


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=40)
    options = parser.parse_args(arguments)
    damping_errors(options.runs)
    coverage(400)


if __name__ == "__main__":
    main()
