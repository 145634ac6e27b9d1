"""How often the intervals of decays hold, and how quickly they are read: linear, with noise.

``python -m benchmarks.decays [DRAWS]``
"""

import sys
import time

import numpy as np

from shakerproc.spectra.decays import decay_curve, decay_lines, trend_of

RATE, SECONDS, NOISE = 2048.0, 4.0, 0.2  # Hz, s, rms over amplitudes of 100 and 40
MODES = ((60.0, 0.005, 100.0), (143.0, 0.008, 40.0))  # Hz, damping ratio, amplitude


def decay(seed: int) -> np.ndarray:
    """Return two decaying sinusoids of random phases in noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(SECONDS * RATE)) / RATE
    total = NOISE * rng.standard_normal(t.size)
    for frequency, zeta, amplitude in MODES:
        omega = 2.0 * np.pi * frequency
        angle = omega * np.sqrt(1.0 - zeta**2) * t + rng.uniform(0.0, 2.0 * np.pi)
        total += amplitude * np.exp(-zeta * omega * t) * np.cos(angle)
    return total


def main(draws: int) -> None:
    """Print how many modes are found, how often intervals hold, and how many trends show."""
    held, n_readings, n_lines, n_trends = np.zeros((2, 2)), 0, 0, 0
    start = time.perf_counter()
    for seed in range(draws):
        samples = decay(seed)
        lines = decay_lines(samples[np.newaxis], RATE, (20.0, 350.0))
        n_lines += len(lines)
        for line in lines:
            frequency, zeta, _ = min(MODES, key=lambda mode: abs(mode[0] - line.frequency))
            curve = decay_curve(samples, RATE, line)
            n_readings += len(curve.fitted)
            for k, readings in enumerate((curve.fitted, curve.charted)):
                for one in readings:
                    held[k, 0] += abs(one.frequency - frequency) < one.frequency_error
                    held[k, 1] += abs(one.damping - zeta) < one.damping_error
                trend = trend_of(readings)
                n_trends += trend is not None and (trend.shifts or trend.damps)
    seconds = time.perf_counter() - start
    print(f"{n_lines} modes of {2 * draws}, {n_readings} stretches, {n_trends} trends")
    for k, name in enumerate(("least squares", "peaks and crossings")):
        shares = 100.0 * held[k] / n_readings
        print(
            f"{name}: intervals hold for frequency {shares[0]:.1f} %, damping {shares[1]:.1f} %"
        )
    print(f"{seconds / draws * 1e3:.0f} ms a decay of {SECONDS:g} s")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 60)
