"""Shock and fatigue spectra against pyyeti, if installed: python -m benchmarks.shock."""

import time
from importlib.util import find_spec

import numpy as np

from shakerproc.spectra.fatigue import fatigue_spectra
from shakerproc.spectra.rainflow import rainflow
from shakerproc.spectra.shock import logarithmic_frequencies, shock_spectra

RATE, DURATION, HEIGHT, Q = 50_000.0, 0.011, 100.0, 10.0
FINER = 8
PAIRS = {
    "absolute_acceleration": "absacce",
    "relative_displacement": "reldisp",
    "relative_velocity": "relvelo",
    "pseudo_velocity": "pvelo",
    "equivalent_static_acceleration": "pacce",
}


def records():
    """A half-sine of 11 ms, and noise with a decay, as of a pyrotechnic shock."""
    t = np.arange(round(0.05 * RATE)) / RATE
    rng = np.random.default_rng(1)
    yield "half-sine", np.where(t <= DURATION, HEIGHT * np.sin(np.pi * t / DURATION), 0.0)
    noise = np.cumsum(rng.standard_normal(t.size))  # little at high frequencies, as measured
    yield "decaying noise", HEIGHT * (noise - noise.mean()) / noise.std() * np.exp(-t / 0.01)


def shock():
    """Shock response spectra of both records."""
    from pyyeti import srs

    frequency = logarithmic_frequencies(5.0, RATE / 10.0, 12)

    print(f"largest deviation from pyyeti, its input straight between samples ({FINER} steps)")
    for name, samples in records():
        shock_spectra([samples[np.newaxis]], RATE, frequency, 0.5 / Q)  # compiled
        start = time.process_time()
        found = shock_spectra([samples[np.newaxis]], RATE, frequency, 0.5 / Q).values
        print(f"{name}: all kinds in {(time.process_time() - start) * 1e3:.0f} ms of processor")
        places = np.arange(-FINER + 1, FINER * (samples.size - 1) + 1) / FINER
        finer = np.interp(places, np.arange(-1, samples.size), np.append(0.0, samples))
        for quantity, kind in PAIRS.items():
            how = {"ic": "zero", "stype": kind, "rolloff": "none"}
            start = time.process_time()
            total = srs.srs(finer, FINER * RATE, frequency, Q, time="total", **how)
            theirs = (time.process_time() - start) * 1e3
            residual = srs.srs(finer, FINER * RATE, frequency, Q, time="residual", **how)
            of = found[quantity]
            after = np.maximum(of["residual_positive"], of["residual_negative"])[0]
            largest = np.max(np.abs(of["maximax"][0] / total - 1.0))
            later = np.max(np.abs(after - residual) / total)
            print(
                f"  {quantity:31} maximax {largest:.1e}, residual {later:.1e}, {theirs:.0f} ms"
            )


def fatigue():
    """Rainflow of noise, and the vibration response spectrum of white noise."""
    from pyyeti import cyclecount, srs

    rng = np.random.default_rng(2)
    noise = np.cumsum(rng.standard_normal(100_000)) * 0.01 + rng.standard_normal(100_000)
    ranges, counts = rainflow(noise)
    theirs = cyclecount.rainflow(noise[cyclecount.findap(noise)])
    for b in (1.0, 4.0, 8.0):
        own = np.sum(counts * (0.5 * ranges) ** b)
        other = np.sum(theirs["count"] * theirs["amp"] ** b)
        print(f"rainflow, sum of amplitudes to the {b:g}: {own / other - 1.0:+.1e} off pyyeti")
    rate, seconds, density = 4000.0, 600.0, 1.0
    white = rng.standard_normal((1, round(rate * seconds))) * np.sqrt(density * rate / 2.0)
    frequency = np.array([10.0, 50.0, 200.0])
    found = fatigue_spectra([white], rate, frequency, damping=0.05, exponent=4.0)
    flat = np.arange(0.25, rate / 2.0, 0.25)
    theirs = srs.vrs((flat, np.ones(flat.size)), flat, 10.0, linear=False, Fn=frequency)
    off = found.acceleration[0] / np.ravel(theirs) - 1.0
    print(f"vibration response to white noise: {np.max(np.abs(off)):.1e} off pyyeti's spectrum")


if __name__ == "__main__":
    if find_spec("pyyeti") is None:
        print("pyyeti is not installed: python -m pip install pyyeti")
    else:
        shock()
        fatigue()
