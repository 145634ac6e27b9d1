"""Which test would settle what is open: where the candidates' predictions differ most."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.problem import Segment, assemble, law_table, run
from shakerproc.diagnose.result import NextTest
from shakerproc.diagnose.search import Context

LEVELS = (0.5, 1.0, 1.5, 2.0, 3.0)
"""Levels that are tried, as multiples of the loudest test [-]."""


def simulated(at: Context, fit: Fit, segment: Segment, scale: float) -> FloatArray | None:
    """Return the responses (n_sensors, n) of a fit to a scaled input; None if it runs away."""
    whole = assemble(at.bench.structure, fit.hypothesis, fit.parameters)
    table = law_table(at.bench.structure, fit.hypothesis, fit.parameters, whole.masses.size)
    free = replace(segment, input=scale * segment.input, weight=np.zeros_like(segment.weight))
    seen = run(whole, table, free, at.tunings[segment.gain_key], fit.parameters, keep=True)
    return None if seen is None else seen.dense[:, :: segment.fine]


def spectrum(samples: FloatArray, size: int = 2048) -> FloatArray:
    """Return averaged power in every bin, robust against the phase of chaotic motion."""
    parts = samples[:, : samples.shape[1] // size * size].reshape(samples.shape[0], -1, size)
    power: FloatArray = np.mean(np.abs(np.fft.rfft(parts * np.hanning(size))) ** 2, axis=(0, 1))
    return power


def loudest(at: Context) -> Segment:
    """Return the whole test with the largest input."""
    return max(at.bench.whole, key=lambda s: float(np.sum(s.input**2)) / s.input.size)


def settle(
    at: Context, standing: Sequence[Fit], names: tuple[str, ...]
) -> tuple[NextTest, ...]:
    """Return the level at which the spectra of two candidates differ most, within 3 times."""
    segment = loudest(at)
    best: tuple[float, float] | None = None
    for scale in LEVELS:
        both = [simulated(at, fit, segment, scale) for fit in standing[:2]]
        if any(one is None for one in both):
            continue
        one, two = (spectrum(b) for b in both if b is not None)
        noise = at.tunings[segment.gain_key].noise[0] ** 2 * np.sum(np.hanning(2048) ** 2)
        apart = float(np.mean(np.abs(np.log((one + noise) / (two + noise)))))
        if best is None or apart > best[0]:
            best = apart, scale
    if best is None:
        return ()
    return (
        NextTest(
            segment.name, level_text(segment, best[1], at),
            names, f"the spectra of the two differ by {100.0 * best[0]:.2g} % there on average",
        ),
    )  # fmt: skip


def level_text(segment: Segment, scale: float, at: Context) -> str:
    """Return a level in words: rms of the control in g or N."""
    rms = scale * float(np.sqrt(np.mean(at.bench.prepared[segment.test].raw_input ** 2)))
    if at.bench.structure.forced >= 0:
        return f"{rms:.3g} N rms"
    return f"{rms / STANDARD_GRAVITY:.3g} g rms"
