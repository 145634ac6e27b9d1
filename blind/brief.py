"""Brief campaigns: free decays, pushes of about a second, frames in a few ground motions.

What a student's bench, a teacher's pendulum and a shaking table hand over: one to three tests,
coarse rates, displacement as often as acceleration, an offset, steps of an encoder, no quiet
lead-in. The truth is that of the long campaigns; what is drawn is relative to it as well.

| form | test | rate |
|---|---|---|
| decay | one release, 12 to 80 periods of 0.4 to 10 Hz, rest included where friction ends it | 25 to 150 samples a period |
| short | one push by a force of 0.4 to 1.5 s, with a spring to the ground or (half) none | 200 to 2000 Hz |
| quake | two or three ground motions of 20 to 40 s, 1 to 3 storeys, the effect in the first | 50 to 200 Hz |

A `pendulum` hangs on its own arc: the force of the spring is that of the sine of the angle, 0.3
to 1.2 rad at the release; a cubic spring that softens is right for it.
"""  # noqa: E501 - a table

import zlib
from dataclasses import dataclass, replace

import numpy as np

from blind import ranges
from blind.assembly import assemble, exercised, shows
from blind.campaign import Campaign, TestRun
from blind.classes import CampaignClass, parse
from blind.draws import Rng, log_uniform
from blind.excitations import Drive
from blind.plan import GROWTH_LIMIT
from blind.ranges import Hidden
from blind.recorder import rms
from blind.structures import Joint, Structure, nominal_of, scale_of
from blind.truth import Motion, Truth, move

SUBSTEPS = 16
ATTEMPTS = 400
LIVES = 0.1
"""Share of the largest motion, or of that without the effect, that is motion yet [-]."""
CROSSINGS = 8
"""Turns of a decay before it rests, at least."""
OFFSET = 0.1
"""Largest offset of a displacement over its rms [-]."""
RACK_HZ = 4.0
"""Frequency that stands for that of a mass without a spring, where ranges need one."""


@dataclass(frozen=True)
class Bench:
    """What is tested, without and with what is hidden: masses, the tests' waves, their rate."""

    structure: Structure
    rate: float
    waves: tuple[np.ndarray, ...]
    release: float
    band: tuple[float, float]
    hidden: tuple[tuple[str, Hidden], ...] = ()

    def move(self, wave: np.ndarray, limit: float) -> tuple[Motion | None, list[list[int]]]:
        """Return the motion of a test, or None where it runs away, and the hidden elements."""
        truth, columns = assemble(self.structure, 0, [hidden for _, hidden in self.hidden])
        start = tuple(self.release + rest for rest in truth.start)
        truth = Truth(truth.masses, truth.joints, truth.elements, truth.force_on, start)
        still = np.zeros_like(wave)
        base, force = (still, wave) if truth.force_on >= 0 else (wave, still)
        return move(
            truth, base, force, sample_rate=self.rate, substeps=SUBSTEPS, limit=limit
        ), columns


def draw(seed: int, text: str) -> Campaign:
    """Return the campaign of this seed and class.

    Raises
    ------
    RuntimeError
        If no draw exercises the effect.
    """
    kind = parse(text)
    rng = np.random.default_rng([seed, zlib.crc32(kind.base.encode())])
    for _ in range(ATTEMPTS):
        snr = rng.uniform(35.0, 60.0)
        bench = {"decay": _decay, "short": _short, "quake": _quake}[kind.form](rng)
        linear, _ = bench.move(bench.waves[-1], np.inf)
        if linear is None:
            continue
        bench = replace(bench, hidden=tuple(_hidden(rng, kind, bench, linear)))
        limit = GROWTH_LIMIT * float(np.max(np.abs(linear.displacement)))
        moved = [bench.move(wave, limit) for wave in bench.waves]
        motions = [motion for motion, _ in moved if motion is not None]
        noise = 10.0 ** (-snr / 20.0)
        if len(motions) == len(moved) and _lives(motions[-1], linear, bench):
            shown = exercised(bench.structure, 0, motions[-1], moved[-1][1])
            if shows(shown, noise):
                return _recorded(rng, (seed, text), bench, motions, snr)
    raise RuntimeError(f"{text}, seed {seed}: no draw exercises the effect")


def _lives(motion: Motion, linear: Motion, bench: Bench) -> bool:
    """Whether the mass moves for some periods, which dry friction may deny it."""
    if not bench.release:
        return rms(motion.velocity[:, 0]) > LIVES * rms(linear.velocity[:, 0])
    moved = motion.displacement[:, 0]
    large = np.abs(moved) > LIVES * np.max(np.abs(moved))
    return int(np.sum(np.diff(np.sign(moved[: _last(large)])) != 0.0)) >= CROSSINGS


def _last(flags: np.ndarray) -> int:
    return int(np.flatnonzero(flags)[-1])


def _fine(n: int) -> int:
    """Return how many values drive a test of n samples."""
    return 2 * SUBSTEPS * n + 1


def _decay(rng: Rng) -> Bench:
    frequency, ratio = log_uniform(rng, 0.4, 10.0), log_uniform(rng, 0.002, 0.02)
    rate = float(round(frequency * rng.uniform(25.0, 150.0), 1))
    periods = min(max(rng.uniform(1.0, 3.0) / (2.0 * np.pi * ratio), 12.0), 80.0)
    structure = _storeys(rng, log_uniform(rng, 0.05, 5.0), frequency, [ratio])
    measures = "displacement" if rng.random() < 0.7 else "acceleration"
    still = np.zeros(_fine(int(periods / frequency * rate)))
    release, band = log_uniform(rng, 0.003, 0.3), (0.2 * frequency, 0.4 * rate)
    return Bench(replace(structure, measures=measures), rate, (still,), release, band)


def _short(rng: Rng) -> Bench:
    frequency, seconds = log_uniform(rng, 3.0, 15.0), rng.uniform(0.4, 1.5)
    rate = float(rng.choice([200.0, 500.0, 1000.0, 2000.0]))
    structure = _storeys(
        rng, log_uniform(rng, 0.2, 20.0), frequency, [log_uniform(rng, 0.01, 0.1)]
    )
    mass, joint = structure.masses[0], structure.joints[0]
    if rng.random() < 0.5:
        omega = 2.0 * np.pi * RACK_HZ
        loose = replace(joint, stiffness=0.0, damping=mass * omega * rng.uniform(0.1, 0.6))
        structure = replace(structure, joints=(loose,))
    measures = str(rng.choice(["displacement", "displacement", "velocity", "acceleration"]))
    t = np.arange(_fine(int(seconds * rate))) / (2 * SUBSTEPS * rate)
    size = mass * log_uniform(rng, 2.0, 40.0)
    low, high = rng.uniform(1.0, 3.0), frequency * rng.uniform(1.5, 3.0)
    sweep = np.sin(2.0 * np.pi * (low * t + 0.5 * (high - low) / seconds * t**2))
    steps = np.tanh(8.0 * np.sin(2.0 * np.pi * rng.uniform(2.0, 5.0) * t + rng.uniform(0, 6.0)))
    wave = size * (sweep + rng.uniform(0.0, 0.6) * steps) * np.minimum(t * 50.0, 1.0)
    return Bench(
        replace(structure, force_on=0, measures=measures),
        rate,
        (wave,),
        0.0,
        (0.5 * low, 2.0 * high),
    )


def _quake(rng: Rng) -> Bench:
    frequency, rate = log_uniform(rng, 0.8, 4.0), float(rng.choice([50.0, 100.0, 200.0]))
    ratios = [rng.uniform(0.01, 0.04) for _ in range(int(rng.integers(1, 4)))]
    structure = _storeys(rng, log_uniform(rng, 1.0, 2e4), frequency, ratios)
    measures = "acceleration" if rng.random() < 0.7 else "relative displacement"
    n, size = int(rng.uniform(20.0, 40.0) * rate), log_uniform(rng, 1.0, 6.0)
    steps = [1.0, rng.uniform(1.6, 2.5)]
    if rng.random() < 0.5:
        steps.insert(1, steps[1] ** 0.5)
    band = (0.3, 2.5 * frequency)
    waves = tuple(_ground(rng, n, rate, band, size * step) for step in steps)
    return Bench(replace(structure, measures=measures), rate, waves, 0.0, band)


def _storeys(rng: Rng, mass: float, frequency: float, ratios: list[float]) -> Structure:
    omega = 2.0 * np.pi * frequency * (1.0 + 0.6 * (len(ratios) - 1))
    joints = tuple(
        Joint(i - 1, i, mass * omega**2 * rng.uniform(0.8, 1.2), 2.0 * ratio * mass * omega)
        for i, ratio in enumerate(ratios)
    )
    return Structure(tuple(mass for _ in ratios), joints)


def _ground(
    rng: Rng, n: int, rate: float, band: tuple[float, float], peak: float
) -> np.ndarray:
    """Return noise of a band under the envelope of an earthquake [m/s^2]."""
    t = np.arange(_fine(n)) / (2 * SUBSTEPS * rate)
    first, last = (max(1, int(f / rate * n)) for f in band)
    bins = np.zeros(n * SUBSTEPS + 1, complex)
    bins[first : last + 1] = rng.standard_normal((last + 1 - first, 2)) @ [1.0, 1.0j]
    noise = np.append(np.fft.irfft(bins, 2 * SUBSTEPS * n, norm="forward"), 0.0)
    rise = t[-1] * rng.uniform(0.1, 0.25)
    wave = noise * (t / rise) ** 2 * np.exp(2.0 - 2.0 * t / rise)
    return np.asarray(peak * wave / np.max(np.abs(wave)))


def _hidden(
    rng: Rng, kind: CampaignClass, bench: Bench, linear: Motion
) -> list[tuple[str, Hidden]]:
    """Return what is hidden in the first joint, in units of how that moves without it."""
    if kind.name == "none":
        return []
    structure = bench.structure
    joint = structure.joints[0]
    if not joint.stiffness:
        joint = replace(joint, stiffness=structure.masses[0] * (2.0 * np.pi * RACK_HZ) ** 2)
    scale = scale_of(structure, joint, linear.displacement[:, 0])
    drawn = {**ranges.EFFECTS, **ranges.OUTSIDE, **ranges.BENCH}
    names = kind.chosen.split("+") if kind.name in {"pair", "outside"} else [kind.name]
    return [(name, drawn[name](rng, scale)) for name in names]


def _recorded(
    rng: Rng, named: tuple[int, str], bench: Bench, motions: list[Motion], snr: float
) -> Campaign:
    """Return the campaign as recorded: noise, an offset, the steps of an encoder."""
    seed, text = named
    structure, share = bench.structure, 10.0 ** (-snr / 20.0)
    coarse = rng.random() < 0.5 and "displacement" in structure.measures
    skipped = int(rng.uniform(0.0, 1.0) * 20) if text.startswith("decay") else 0
    tests = []
    # somebody stops the recorder some time after the rest
    rests = motions[-1].displacement[:, 0]
    rests = np.abs(rests - rests[-1]) > 0.02 * np.max(np.abs(rests))
    stop = int((1.05 + rng.exponential(0.5)) * _last(rests)) if bench.release else rests.size
    for i, (motion, wave) in enumerate(zip(motions, bench.waves, strict=True)):
        seen = {
            "displacement": motion.displacement.T,
            "velocity": motion.velocity.T,
            "acceleration": motion.acceleration[::SUBSTEPS].T,
        }[structure.measures.removeprefix("relative ")][: len(structure.masses), skipped:stop]
        size = rms(seen)
        noisy = seen + share * size * rng.standard_normal(seen.shape)
        if "displacement" in structure.measures:
            noisy += OFFSET * size * rng.uniform(-1.0, 1.0)
        if coarse:
            step = size * rng.uniform(1.0, 3.0) * share
            noisy = np.round(noisy / step) * step
        felt = wave[:-1][:: 2 * SUBSTEPS][None]
        control = felt + share * rms(felt) * rng.standard_normal(felt.shape)
        words = "free decay" if bench.release else "random"
        drive = Drive(
            words, rms(felt), *bench.band, up=True, lead_in=0.0, tail=0.0, seed=(seed, i)
        )  # fmt: skip
        held = i == 0 and len(motions) > 1
        used = control[:0] if bench.release else control
        tests.append(TestRun(i + 1, drive, held, used, noisy, seen))
    truth = {
        "class": text,
        "effects": [
            hidden.as_truth(name, ["base", structure.name(0)]) for name, hidden in bench.hidden
        ],
        "fault": None,
    }
    details = {"snr_db": snr, "noise_follows_level": True, "known": []}
    return Campaign(
        seed, text, structure, nominal_of(rng, structure), tuple(tests), truth, share, details,
        bench.rate,
    )  # fmt: skip
