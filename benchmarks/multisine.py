"""Distortion of simulated oscillators from multisines, against many realisations without noise.

``python -m benchmarks.multisine [REALISATIONS]``

A mass on a spring and a damper, and with it a cubic spring, play or a stop, is integrated by
Runge-Kutta steps, all realisations at once. What is measured is some realisations from rest,
with noise. The truth is read by numpy alone from the last period without noise, of five times
as many other realisations, and of the same ones. At the end: how often the odd distortion of
some realisations, drawn from these many, lies within 1 dB of that of all.
"""

import sys
import time
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from shakerproc.spectra.multisines import (
    cut,
    grid_of,
    layout_of,
    line_spectra,
    shares_of,
    transient_periods,
)

RATE, PERIOD, PERIODS = 1024.0, 4.0, 5  # Hz, s, of each realisation, with the transient
BAND, RMS = (5.0, 150.0), 20.0  # Hz, N
FINER = 4  # steps of the integration in a sample
MASS, STIFFNESS, DAMPING = 1.0, 1e5, 12.0  # kg, N/m, N s/m: 50.3 Hz, 1.9 %
SIGNAL_TO_NOISE = (30.0, 50.0, 70.0)  # dB of the rms of the acceleration

Law = Callable[[np.ndarray], np.ndarray]
LAWS: Final[Mapping[str, Law]] = {
    "linear": lambda x: 0.0 * x,
    "cubic": lambda x: 4e8 * x**3,
    "gap": lambda x: 1e4 * np.sign(x) * np.maximum(np.abs(x) - 1.5e-3, 0.0),
    "stop": lambda x: 2e4 * np.maximum(x - 1e-3, 0.0),
}
"""Force beside the spring [N] over displacement [m]."""


def excited() -> np.ndarray:
    """Return which multiples of one over the period are excited: odd, 3 of 4, always those."""
    rng = np.random.default_rng(4)
    number = np.arange(round(RATE * PERIOD) // 2)
    inside = (number >= BAND[0] * PERIOD) & (number <= BAND[1] * PERIOD) & (number % 2 == 1)
    lines = np.flatnonzero(inside)
    for group in np.array_split(lines, lines.size // 4):
        inside[rng.choice(group)] = False
    return inside


def forces(count: int, seed: int) -> np.ndarray:
    """Return one period of so many realisations at every half step, (count, n) array [N]."""
    rng = np.random.default_rng(seed)
    chosen = excited()
    n = round(RATE * PERIOD) * FINER * 2
    spectrum = np.zeros((count, n // 2 + 1), dtype=complex)
    size = RMS * np.sqrt(2.0 / chosen.sum())
    phases = np.exp(2j * np.pi * rng.random((count, int(chosen.sum()))))
    spectrum[:, np.flatnonzero(chosen)] = 0.5 * n * size * phases
    return np.fft.irfft(spectrum, n, axis=1)


def accelerations(force: np.ndarray, law: Law) -> np.ndarray:
    """Return the acceleration from rest at every sample, (count, n_periods, n_period)."""
    step, n = 1.0 / (RATE * FINER), force.shape[1] // 2
    x, v = np.zeros((2, len(force)))

    def slope(x: np.ndarray, v: np.ndarray, f: np.ndarray) -> np.ndarray:
        return (f - DAMPING * v - STIFFNESS * x - law(x)) / MASS

    out = np.empty((PERIODS, n // FINER, len(force)))
    for p in range(PERIODS):
        for i in range(n):
            first, half, last = (force[:, (2 * i + j) % (2 * n)] for j in range(3))
            a1 = slope(x, v, first)
            if i % FINER == 0:
                out[p, i // FINER] = a1
            v2 = v + 0.5 * step * a1
            a2 = slope(x + 0.5 * step * v, v2, half)
            v3 = v + 0.5 * step * a2
            a3 = slope(x + 0.5 * step * v2, v3, half)
            v4 = v + step * a3
            a4 = slope(x + step * v3, v4, last)
            x = x + step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v = v + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return np.moveaxis(out, -1, 0)


def truth(force: np.ndarray, response: np.ndarray) -> dict[str, float]:
    """Return each level over the response in the band [dB], by numpy alone."""
    chosen = excited()
    u = np.fft.rfft(force[:, :: 2 * FINER], axis=1)[:, : chosen.size]
    y = np.fft.rfft(response[:, -1], axis=1)[:, : chosen.size]
    lines = np.flatnonzero(chosen)
    number = np.arange(lines[0], lines[-1] + 1)
    left = number[~chosen[number]]
    power = {
        "even": np.mean(np.abs(y[:, left[left % 2 == 0]]) ** 2),
        "odd": np.mean(np.abs(y[:, left[left % 2 == 1]]) ** 2),
    }
    ratio = y[:, lines] / u[:, lines]
    rest = (ratio - ratio.mean(axis=0)) * u[:, lines]
    power["all"] = np.sum(np.abs(rest) ** 2) / (len(y) - 1) / lines.size
    whole = np.mean(np.abs(y[:, lines]) ** 2)
    return {kind: float(10.0 * np.log10(max(p / whole, 1e-30))) for kind, p in power.items()}


def near(response: np.ndarray, sizes: tuple[int, ...] = (1, 20, 80)) -> list[float]:
    """Return the share of draws of so many realisations whose odd level is within 1 dB."""
    chosen = excited()
    y = np.fft.rfft(response[:, -1], axis=1)[:, : chosen.size]
    lines = np.flatnonzero(chosen)
    number = np.arange(lines[0], lines[-1] + 1)
    left = number[~chosen[number] & (number % 2 == 1)]
    power = np.mean(np.abs(y[:, left]) ** 2, axis=1)
    rng = np.random.default_rng(0)
    shares = []
    for size in sizes:
        drawn = power[rng.integers(power.size, size=(20_000, size))].mean(axis=1)
        shares.append(float(np.mean(np.abs(10.0 * np.log10(drawn / power.mean())) < 1.0)))
    return shares


def measured(force: np.ndarray, response: np.ndarray, noise: float, seed: int):
    """Return the shares of every kind and the noise's, and how many periods are left out."""
    count, n_periods, n = response.shape
    rng = np.random.default_rng(seed)
    samples = np.array([
        np.tile(force[:, :: 2 * FINER], n_periods).ravel(),
        response.ravel() + noise * rng.standard_normal(response.size),
    ])
    layout = layout_of(samples.shape[1], RATE, PERIOD, periods=n_periods, realisations=count)
    lines = 2.0 / n * np.fft.rfft(cut(samples, layout))[..., : n // 2]
    left_out = transient_periods(lines[..., excited()])
    lines = lines[:, :, left_out:]
    grid = grid_of(lines[0], 1.0 / PERIOD, BAND)
    kept = lines[..., grid.number]
    spectra = line_spectra(kept[0], kept[1], grid)
    return shares_of(spectra), spectra.noise_share, left_out


def main(count: int) -> None:
    """Print what was measured of every law at every noise level, and the truth."""
    worst, start, within = np.zeros(2), time.perf_counter(), []
    print(
        "law     S/N [dB]  noise [dB]  left out  kind  truth of many, of these [dB]  found [dB]"
        "  limit [dB]  out"
    )
    for number, (name, law) in enumerate(LAWS.items()):
        known = forces(5 * count, 100 + number)
        played = accelerations(known, law)
        many = truth(known, played)
        if name != "linear":
            shares = ", ".join(f"{share:.2f}" for share in near(played))
            within.append(f"{name} {shares}")
        force = forces(count, 200 + number)
        response = accelerations(force, law)
        these = truth(force, response)
        for ratio in SIGNAL_TO_NOISE:
            noise = np.sqrt(np.mean(response**2)) * 10.0 ** (-ratio / 20.0)
            shares, noisy, left_out = measured(force, response, noise, number)
            for kind, share in shares.items():
                found, limit = (
                    20.0 * np.log10(max(v, 1e-15)) for v in (share.value, share.limit)
                )
                true = np.array([many[kind], these[kind]])
                if share.bands:
                    worst = np.maximum(worst, np.abs(found - true))
                print(
                    f"{name:8s}{ratio:8.0f}{20.0 * np.log10(noisy):12.1f}{left_out:10d}  "
                    f"{kind:>4s}{true[0]:15.2f}{true[1]:15.2f}{found:12.2f}{limit:12.2f}  "
                    f"{'yes' if share.bands else 'no'}"
                )
    print(
        "largest departure of a level that stands out of the noise: from many realisations "
        f"{worst[0]:.2f} dB, from the same ones {worst[1]:.2f} dB"
    )
    print(f"odd level of 1, 20, 80 drawn realisations within 1 dB: {'; '.join(within)}")
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 80)
