"""Which test would settle what is open: where the candidates' predictions differ most."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.diagnose.fit import Fit
from shakerproc.diagnose.prepare import upsample
from shakerproc.diagnose.problem import Segment, assemble, law_table, run
from shakerproc.diagnose.search import Context
from shakerproc.diagnosis.data import TestArrays
from shakerproc.diagnosis.result import NextTest
from shakerproc.simulate.excitations import logarithmic_sweep, sampled
from shakerproc.simulate.noise import flat_profile, random_noise
from shakerproc.testlog import Shaker

LEVELS = (0.5, 1.0, 1.5, 2.0, 3.0)
"""Levels that are tried, as multiples of the loudest test [-]."""
SEEN = 0.02
"""Distance of spectra below which a test does not tell two candidates apart [-]."""
SECONDS = 10.0
"""Length of the trials [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """An excitation that may be asked for: its waveform at the level of the log.

    `like` names the test that lends everything but the level; empty where none is like it.
    """

    excitation: str
    level: float
    unit: str
    band: tuple[float, float]
    input: FloatArray
    like: str = ""

    def words(self, times: float) -> str:
        """Return the level times a factor, as a test log says it."""
        return level_text(self.level * times, self.unit)


def level_text(level: float, unit: str) -> str:
    """Return a level [SI] as a test log says it, accelerations in g."""
    for si, shown in (("(m/s^2)^2/Hz", "g^2/Hz"), ("m/s^2 rms", "g rms"), ("m/s^2", "g")):
        if unit == si:
            power = 2 if "^2/Hz" in shown else 1
            return f"{level / STANDARD_GRAVITY**power:.3g} {shown}"
    return f"{level:.3g} {unit}"


def times_level(test: TestArrays, times: float, *, forced: bool) -> str:
    """Return the level of a test whose waveform is scaled; its rms where no log says it."""
    if test.level is not None:
        density = test.level_unit.endswith("/Hz")
        return level_text(test.level * (times**2 if density else times), test.level_unit)
    rms = times * float(np.sqrt(np.mean(np.mean(test.controls, axis=0) ** 2)))
    return level_text(rms, "N rms" if forced else "m/s^2 rms")


def loudest(tests: Sequence[TestArrays]) -> TestArrays:
    """Return the test with the largest input."""
    return max(tests, key=lambda t: float(np.mean(np.mean(t.controls, axis=0) ** 2)))


def settle(
    at: Context, standing: Sequence[Fit], names: tuple[str, ...], tests: Sequence[TestArrays],
    shaker: Shaker, seed: int,
) -> tuple[NextTest, ...]:  # fmt: skip
    """Return excitation, level and band at which the spectra of two candidates differ most.

    Tried are the loudest test, a random and a sweep over its band and over twice that, each at
    several levels within the limits of the shaker.
    """
    test = loudest(tests)
    best: tuple[float, Trial, float] | None = None
    for trial in _trials(test, seed, forced=at.bench.structure.forced >= 0):
        for times in LEVELS:
            wave = trial.input * times
            if at.bench.structure.forced < 0 and not _within(wave, test.sample_rate, shaker):
                continue
            apart = _apart(at, standing, wave)
            if apart is not None and (best is None or apart > 1.05 * best[0]):
                best = apart, trial, times
    if best is None:
        return ()
    apart, trial, times = best
    power = 2 if trial.unit.endswith("/Hz") else 1
    reason = f"the spectra of the two differ by {100.0 * apart:.2g} % there on average"
    if apart < SEEN:
        reason += ", too little to tell them apart; no other test that was tried shows more"
    return (
        NextTest(
            trial.excitation, trial.words(times**power), names, reason,
            trial.band, trial.like,
        ),
    )  # fmt: skip


def _trials(test: TestArrays, seed: int, *, forced: bool) -> list[Trial]:
    """Return what may be asked for, the measured test first."""
    rate, wave = test.sample_rate, np.mean(test.controls, axis=0)
    rms = float(np.sqrt(np.mean(wave**2)))
    low, high = test.band
    n = int(SECONDS * rate)
    rms_unit = "N rms" if forced else "m/s^2 rms"
    level, unit = (rms, rms_unit) if test.level is None else (test.level, test.level_unit)
    measured = wave if test.excitation == "sine sweep" else wave[:n]
    out = [Trial(test.excitation or "random", level, unit, test.band, measured, test.name)]
    generator = np.random.default_rng(seed)
    for top in (high, min(2.0 * high, 0.4 * rate)):
        density = rms**2 / (top - low)
        noise = random_noise(flat_profile(low, top, density), SECONDS, rate, generator)
        density_unit = "N^2/Hz" if forced else "(m/s^2)^2/Hz"
        out.append(Trial("random", density, density_unit, (low, top), noise))
        amplitude, octaves = rms * np.sqrt(2.0), np.log2(top / low)
        sweep = sampled(
            logarithmic_sweep(low, top, 60.0 * octaves / SECONDS, amplitude), SECONDS, rate
        )
        out.append(
            Trial("sine sweep", amplitude, "N" if forced else "m/s^2", (low, top), sweep[:n])
        )
    return out


def _within(wave: FloatArray, sample_rate: float, shaker: Shaker) -> bool:
    """Return whether the table can move like this [m/s²]."""
    mass = shaker.moving_mass or 0.0
    limits = (
        (shaker.acceleration, 0),
        (shaker.force / mass if shaker.force and mass else None, 0),
        (shaker.velocity, 1),
        (shaker.stroke / 2.0 if shaker.stroke else None, 2),
    )
    omega = 2.0 * np.pi * rfftfreq(wave.size, 1.0 / sample_rate)
    kept = omega > 2.0 * np.pi * 2.0
    spectrum = rfft(wave) * kept
    for limit, order in limits:
        if limit is None:
            continue
        moved = irfft(spectrum / np.where(kept, omega, 1.0) ** order, wave.size)
        if float(np.max(np.abs(moved))) > limit:
            return False
    return True


def _apart(at: Context, standing: Sequence[Fit], wave: FloatArray) -> float | None:
    """Return how far the spectra of two fits lie apart: mean of their logarithms' distance."""
    segment = at.bench.whole[0]
    both = [simulated(at, fit, segment, wave) for fit in standing[:2]]
    if any(one is None for one in both):
        return None
    one, two = (spectrum(b) for b in both if b is not None)
    noise = at.tunings[segment.gain_key].noise[0] ** 2 * np.sum(np.hanning(2048) ** 2)
    return float(np.mean(np.abs(np.log((one + noise) / (two + noise)))))


def simulated(at: Context, fit: Fit, like: Segment, wave: FloatArray) -> FloatArray | None:
    """Return the responses (n_sensors, n) of a fit to an input; None if it runs away."""
    whole = assemble(at.bench.structure, fit.hypothesis, fit.parameters)
    table = law_table(at.bench.structure, fit.hypothesis, fit.parameters, whole.masses.size)
    nothing = np.zeros((len(at.bench.structure.sensing), wave.size))
    free = replace(
        like, start=0, skip=0, input=upsample(wave, like.fine), measured=nothing,
        slope=nothing, weight=nothing,
    )  # fmt: skip
    seen = run(whole, table, free, at.tunings[like.gain_key], fit.parameters, keep=True)
    return None if seen is None else seen.dense[:, :: like.fine]


def spectrum(samples: FloatArray, size: int = 2048) -> FloatArray:
    """Return averaged power in every bin, robust against the phase of chaotic motion."""
    parts = samples[:, : samples.shape[1] // size * size].reshape(samples.shape[0], -1, size)
    power: FloatArray = np.mean(np.abs(np.fft.rfft(parts * np.hanning(size))) ** 2, axis=(0, 1))
    return power
