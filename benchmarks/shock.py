"""Shock and fatigue spectra, integrals and bands against pyyeti and endaq, if installed."""

import time
from importlib.util import find_spec

import numpy as np

from shakerproc.spectra import cross_spectra, psd
from shakerproc.spectra.integration import integrated
from shakerproc.spectra.kernels import rainflow
from shakerproc.spectra.octaves import octave_bands, rms_of_density
from shakerproc.spectra.response_spectra import (
    STEPS,
    fatigue_spectra,
    logarithmic_frequencies,
    shock_spectra,
)

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
    """Yield a half-sine of 11 ms, and noise with a decay, as of a pyrotechnic shock."""
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


def endaq():
    """Spectra, integrals from rest and levels of bands of the same records."""
    import endaq.calc.integrate
    import endaq.calc.psd
    import endaq.calc.shock
    import pandas as pd

    frequency = logarithmic_frequencies(5.0, RATE / 10.0, 12)
    for name, samples in records():
        table = pd.DataFrame({"a": samples}, pd.Index(np.arange(samples.size) / RATE))
        spectra = shock_spectra([samples[np.newaxis]], RATE, frequency, 0.5 / Q)
        for mode, quantity in (("srs", "absolute_acceleration"), ("pvss", "pseudo_velocity")):
            theirs = endaq.calc.shock.shock_spectrum(
                table, freqs=frequency, damp=0.5 / Q, mode=mode
            )
            ours = spectra.values[quantity]["maximax"][0]  # noqa: PD011 - no table
            off = np.abs(ours / theirs["a"].to_numpy() - 1.0)
            low = frequency <= RATE / STEPS  # above it, endaq looks at the samples alone
            print(
                f"{name}: {quantity}, maximax, {off[low].max():.1e} off endaq up to a "
                f"{STEPS}th of the sample rate, {off.max():.1e} up to a tenth"
            )
        pairs = list(
            integrated(
                lambda a, b, row=samples: row[np.newaxis, a:b], samples.size, RATE,
                (0, samples.size), corner=None,
            )
        )  # fmt: skip
        theirs = endaq.calc.integrate.integrals(table, n=2, zero="start")
        for order, quantity in ((1, "velocity"), (2, "displacement")):
            ours = np.concatenate([pair[order - 1][0] for pair in pairs])
            other = theirs[order]["a"].to_numpy()
            off = np.max(np.abs(ours - other)) / np.max(np.abs(ours))
            print(f"{name}: {quantity} from rest, {off:.1e} of its largest off endaq")
    white = np.random.default_rng(3).standard_normal(200_000)
    spectra = cross_spectra(white[np.newaxis], 2000.0, segment=2000, window="periodic hann")
    bands = octave_bands(3, 50.0, 630.0)
    ours = rms_of_density(spectra, bands)[0]
    table = pd.DataFrame({"a": psd(spectra)[0]}, pd.Index(spectra.frequency))
    edges = np.append(bands.lower, bands.upper[-1])
    theirs = endaq.calc.psd.to_jagged(table, edges, agg="mean")["a"].to_numpy()
    levels = np.sqrt(theirs * (bands.upper - bands.lower))
    print(f"thirds of an octave from a density: {np.max(np.abs(ours / levels - 1)):.1e} off")


def main():
    """Print what can be compared."""
    for name, compare in (("pyyeti", (shock, fatigue)), ("endaq", (endaq,))):
        if find_spec(name) is None:
            print(f"{name} is not installed: python -m pip install {name}")
            continue
        for one in compare:
            one()


if __name__ == "__main__":
    main()
