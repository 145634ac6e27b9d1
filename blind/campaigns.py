"""Hidden campaigns: three levels and a held-out test, drawn by seed and class.

Classes: `none`, `unexercised`, every effect by its name, every fault by its name, `outside`
(or `outside:KIND`), `pair` (or `pair:A+B`), `chain:KIND` and `chain3:KIND` (two or three masses
in a row, the effect in one of the joints), `force:KIND` (the mass is driven, not the base).
Seeds below 100000 are for tuning; seeds from 100000 on are looked at once.
"""

import zlib
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import fft, signal

from blind import laws, ranges
from blind.excitations import N_SAMPLES, SAMPLE_RATE, Drive, waveform
from blind.ranges import Hidden, Rng, Scale, log_uniform, sign
from blind.truth import Motion, Truth, move

SUBSTEPS = 8
G = 9.80665
TUNING_SEEDS_END = 100_000


@dataclass(frozen=True)
class Joint:
    """A linear spring and damper between two masses; -1 is the base."""

    first: int
    second: int
    stiffness: float
    damping: float


@dataclass(frozen=True)
class Structure:
    """The linear part of the truth."""

    masses: tuple[float, ...]
    joints: tuple[Joint, ...]
    force_on: int = -1
    measures: str = "acceleration"

    def name(self, mass: int) -> str:
        """Return what the model file calls a mass."""
        if mass < 0:
            return "base"
        return "coupon" if len(self.masses) == 1 else f"m{mass + 1}"


@dataclass(frozen=True)
class TestRun:
    """One test: the drive, and what each channel records [SI]."""

    __test__ = False
    number: int
    drive: Drive
    hold_out: bool
    control: np.ndarray
    response: np.ndarray
    clean: np.ndarray


@dataclass(frozen=True)
class Campaign:
    """Everything a diagnosis gets, and the truth it does not get."""

    seed: int
    kind: str
    structure: Structure
    nominal: Structure
    tests: tuple[TestRun, ...]
    truth: dict[str, Any]
    noise_floor: float
    details: dict[str, Any] = field(default_factory=dict)


def draw(seed: int, kind: str) -> Campaign:
    """Return the campaign of this seed and class.

    Raises
    ------
    ValueError
        If the class is unknown.
    RuntimeError
        If no draw exercises the effect.
    """
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    form, _, name = (
        kind.rpartition(":") if kind.startswith(("chain", "force")) else ("", "", kind)
    )
    snr = rng.uniform(30.0, 60.0)
    for attempt in range(40):
        structure = _structure(rng, form)
        campaign = _attempt(
            rng, seed, kind, name, structure, min(snr + 6.0 * (attempt // 6), 60.0)
        )
        if campaign is not None:
            return campaign
    raise RuntimeError(f"{kind}, seed {seed}: no draw exercises the effect")


def classes() -> tuple[str, ...]:
    """Return the classes of the standard score."""
    return (*ranges.EFFECTS, "none", "unexercised", *ranges.FAULTS, "outside", "pair")


def _structure(rng: Rng, form: str) -> Structure:
    n = {"": 1, "force": 1, "chain": 2, "chain3": 3}[form]
    omega = 2.0 * np.pi * log_uniform(rng, 50.0, 400.0 if n == 1 else 250.0)
    mass = log_uniform(rng, 0.02, 2.0)
    masses, joints = [], []
    for i in range(n):
        m = mass if i == 0 else masses[-1] * rng.uniform(0.3, 1.0)
        w = omega if n == 1 else omega * rng.uniform(1.0, 1.8)
        zeta = log_uniform(rng, 0.006, 0.04)
        masses.append(m)
        joints.append(Joint(i - 1, i, m * w**2, 2.0 * zeta * m * w))
    forced = form == "force"
    measures = "acceleration"
    if forced:
        measures = str(rng.choice(["acceleration", "displacement", "velocity"]))
    return Structure(tuple(masses), tuple(joints), 0 if forced else -1, measures)


def _drives(rng: Rng, seed: int, structure: Structure) -> list[Drive]:
    f_n = np.sqrt(structure.joints[0].stiffness / structure.masses[0]) / (2.0 * np.pi)
    random = rng.random() < 0.5
    up = rng.random() < 0.5
    if random:
        low = rng.uniform(5.0, 15.0)
        high = float(rng.choice([f for f in (500.0, 1000.0, 1500.0, 2000.0) if f > 2.0 * f_n]))
        level = log_uniform(rng, 0.3, 2.0) * G
    else:
        low, high = max(5.0, f_n / rng.uniform(4.0, 8.0)), f_n * rng.uniform(2.5, 4.0)
        level = log_uniform(rng, 0.2, 2.0) * G
    if structure.force_on >= 0:
        level *= structure.masses[structure.force_on]
    ratio = rng.uniform(1.7, 3.0)
    aside = float(rng.choice([1.0, np.sqrt(ratio), ratio]))
    drives = []
    for i, step in enumerate((1.0 / ratio, 1.0, ratio, aside)):
        way = up if i < 3 or rng.random() < 0.5 else not up
        drives.append(Drive("random" if random else "sine sweep", level * step, low, high, way,
                            rng.uniform(0.8, 1.3), rng.uniform(0.1, 0.3),
                            (seed, i, int(rng.integers(2**31)))))  # fmt: skip
    return drives


def linear_stretch(structure: Structure, excitation: np.ndarray) -> np.ndarray:
    """Return the linear model's joint displacements, (n_joints, n) array, by spectra."""
    n = excitation.size
    omega = 2.0 * np.pi * fft.rfftfreq(n, 1.0 / SAMPLE_RATE)
    size = len(structure.masses)
    matrix = np.zeros((omega.size, size, size), complex)
    for i, m in enumerate(structure.masses):
        matrix[:, i, i] -= m * omega**2
    for joint in structure.joints:
        k = joint.stiffness + 1j * omega * joint.damping
        ends = [(joint.second, 1.0)] + ([(joint.first, -1.0)] if joint.first >= 0 else [])
        for row, a in ends:
            for column, b in ends:
                matrix[:, row, column] += a * b * k
    load = np.zeros((omega.size, size, 1), complex)
    spectrum = fft.rfft(excitation)
    if structure.force_on >= 0:
        load[:, structure.force_on, 0] = spectrum
    else:
        load[:, :, 0] = -np.outer(spectrum, structure.masses)
    q = fft.irfft(np.linalg.solve(matrix, load)[:, :, 0], n, axis=0).T
    q = np.vstack([q, np.zeros(n)])
    return np.array([q[j.second] - q[j.first] for j in structure.joints])


def _scale(structure: Structure, joint: Joint, stretch: np.ndarray) -> Scale:
    mass = structure.masses[joint.second]
    omega = float(np.sqrt(joint.stiffness / mass))
    rms, peak = float(np.sqrt(np.mean(stretch**2))), float(np.max(np.abs(stretch)))
    middle = float(np.sqrt(rms * peak))
    return Scale(mass, joint.stiffness, omega, middle, omega * middle, joint.stiffness * rms)


def _attempt(
    rng: Rng, seed: int, kind: str, name: str, structure: Structure, snr: float
) -> Campaign | None:
    drives = _drives(rng, seed, structure)
    fine = [waveform(drive, 2 * SUBSTEPS) for drive in drives]
    middle = linear_stretch(structure, fine[1][:-1][:: 2 * SUBSTEPS])
    peak = np.max(np.abs(middle), axis=1) * drives[2].level / drives[1].level
    at = int(rng.integers(len(structure.joints)))
    names, fault = _contents(rng, name)
    hidden = []
    for label in names:
        scale = _scale(structure, structure.joints[at], middle[at])
        if label == "unexercised":
            scale = replace(scale, displacement=float(peak[at]) * rng.uniform(1.5, 3.0) / 0.9)
            while (effect := ranges.EFFECTS["gap"](rng, scale)).parameters[
                "clearance"
            ] < 1.3 * peak[at]:
                pass
        else:
            effect = {**ranges.EFFECTS, **ranges.OUTSIDE}[label](rng, scale)
        hidden.append(effect)
    truth, columns = assemble(structure, at, hidden)
    limit = 100.0 * float(np.max(peak))
    order = (2, 0, 1, 3)
    motions: dict[int, Motion] = {}
    for i in order:
        motion = _move(truth, fine[i], limit)
        if motion is None:
            return None
        motions[i] = motion
        if (
            i == 2
            and "unexercised" not in names
            and not all(
                e > max(0.03, 3.0 * 10.0 ** (-snr / 20.0))
                for e in exercised(structure, at, motion, columns)
            )
        ):
            return None
    filtered = bool(rng.random() < 0.5)
    clean = [np.array(_responses(structure, motions[i], filtered)) for i in range(4)]
    control = [wave[:-1][:: 2 * SUBSTEPS] for wave in fine]
    return _record(rng, seed, kind, structure, drives, control, clean, snr,
                   [*zip(names, hidden, strict=True)], fault, at)  # fmt: skip


def _contents(rng: Rng, name: str) -> tuple[list[str], str | None]:
    """Return the hidden effects and the fault of a class."""
    if name == "none":
        return [], None
    if name == "unexercised":
        return [name], None
    if name in ranges.FAULTS:
        return [], name
    if name in ranges.EFFECTS:
        return [name], None
    family, _, chosen = name.partition(":")
    if family == "outside":
        return [chosen or str(rng.choice(list(ranges.OUTSIDE)))], None
    if family == "pair":
        pair = (
            chosen.split("+") if chosen else list(ranges.PAIRS[rng.integers(len(ranges.PAIRS))])
        )
        effects = [label for label in pair if label not in ranges.FAULTS]
        return effects, next((label for label in pair if label in ranges.FAULTS), None)
    raise ValueError(f"no class {name!r}; there are {', '.join(classes())}")


def assemble(
    structure: Structure, at: int, hidden: list[Hidden]
) -> tuple[Truth, list[list[int]]]:
    """Return what to integrate, and the elements that belong to each hidden effect."""
    masses = list(structure.masses)
    joints = [(j.first, j.second, j.stiffness, j.damping) for j in structure.joints]
    elements: list[Any] = []
    where = structure.joints[at]
    columns = []
    for effect in hidden:
        first = len(elements)
        for code, parameters, thresholds in effect.parts:
            elements.append((code, where.first, where.second, parameters, thresholds))
        if effect.attached:
            mass, k, c = effect.attached
            masses.append(mass)
            elements.append((laws.SPRING, where.second, len(masses) - 1, (k,), ()))
            elements.append((laws.DAMPER, where.second, len(masses) - 1, (c,), ()))
        columns.append(list(range(first, len(elements))))
    return Truth(tuple(masses), tuple(joints), tuple(elements), structure.force_on), columns


def _move(
    truth: Truth, wave: np.ndarray, limit: float, substeps: int = SUBSTEPS
) -> Motion | None:
    still = np.zeros_like(wave)
    base, force = (still, wave) if truth.force_on >= 0 else (wave, still)
    return move(truth, base, force, SAMPLE_RATE, substeps, limit)


def exercised(
    structure: Structure, at: int, motion: Motion, columns: list[list[int]]
) -> list[float]:
    """Return what no linear refit makes of each hidden force, as a share of the response."""
    mass = structure.masses[structure.joints[at].second]
    forces = [motion.force[:, indices].sum(axis=1) / mass for indices in columns]
    joint = structure.joints[at]
    z, w = (
        x[:, joint.second] - (x[:, joint.first] if joint.first >= 0 else 0.0)
        for x in (motion.displacement, motion.velocity)
    )
    fine = motion.acceleration[
        :: motion.acceleration.shape[0] // z.size, structure.joints[at].second
    ]
    out = []
    for i, force in enumerate(forces):
        beside = np.array([z, w, *(f for j, f in enumerate(forces) if j != i)])
        size = np.sqrt(np.mean(beside**2, axis=1, keepdims=True))
        beside = beside / np.where(size > 0.0, size, 1.0)
        left = force - np.linalg.lstsq(beside.T, force, rcond=None)[0] @ beside
        out.append(float(np.sqrt(np.mean(left**2) / np.mean(fine**2))))
    return out


def _responses(structure: Structure, motion: Motion, filtered: bool) -> list[np.ndarray]:
    n = len(structure.masses)
    if structure.measures == "displacement":
        return [motion.displacement[:, i].copy() for i in range(n)]
    if structure.measures == "velocity":
        return [motion.velocity[:, i].copy() for i in range(n)]
    if not filtered:
        return [motion.acceleration[::SUBSTEPS, i].copy() for i in range(n)]
    taps = signal.firwin(64 * SUBSTEPS + 1, 0.45 / SUBSTEPS, fs=1.0)
    return [signal.resample_poly(motion.acceleration[:, i], 1, SUBSTEPS, window=taps)
            for i in range(n)]  # fmt: skip


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _record(
    rng: Rng, seed: int, kind: str, structure: Structure, drives: list[Drive],
    control: list[np.ndarray], clean: list[np.ndarray], snr: float,
    hidden: list[tuple[str, Hidden]], fault: str | None, at: int,
) -> Campaign | None:  # fmt: skip
    own = bool(rng.random() < 0.3)  # noise follows the level, instead of standing still
    share = 10.0 ** (-snr / 20.0)
    spoil, fault_truth = _fault(rng, fault, clean, share)
    faulty = int(rng.integers(clean[0].shape[0]))
    n_controls = 1 if structure.force_on >= 0 else 2
    tests = []
    for i, drive in enumerate(drives):
        reference = i if own else 1
        noisy = np.array([
            row + share * _rms(clean[reference][j]) * rng.standard_normal(row.size)
            for j, row in enumerate(clean[i])
        ])  # fmt: skip
        noisy[faulty] = spoil(noisy[faulty])
        inputs = control[i] + share * _rms(control[reference]) * rng.standard_normal((
            n_controls,
            control[i].size,
        ))
        tests.append(TestRun(i + 1, drive, i == 3, inputs, noisy, clean[i]))
    joint = structure.joints[at]
    between = [structure.name(joint.first), structure.name(joint.second)]
    truth = {
        "class": kind,
        "effects": [
            {
                "kind": label,
                "between": between,
                "parameters": effect.parameters,
                "main": effect.main,
            }
            for label, effect in hidden
        ],
        "fault": {"kind": fault, "channel": f"ch{3 + faulty}", **fault_truth}
        if fault
        else None,
    }
    nominal = replace(structure, joints=tuple(
        replace(j, stiffness=j.stiffness * (1.0 + 0.05 * sign(rng)),
                damping=j.damping * (1.0 + 0.25 * sign(rng)))
        for j in structure.joints
    ))  # fmt: skip
    floor = share * _rms(clean[3 if own else 1][0]) / _rms(clean[3][0])
    return Campaign(seed, kind, structure, nominal, tuple(tests), truth, floor,
                    {"snr_db": snr, "noise_follows_level": own})  # fmt: skip


def _fault(rng: Rng, fault: str | None, clean: list[np.ndarray], share: float) -> Any:
    """Return what spoils a channel, and its parameters."""
    t = np.arange(N_SAMPLES) / SAMPLE_RATE
    if fault == "sensor_delay":
        tau = log_uniform(rng, 5e-5, 1e-2)
        f = fft.rfftfreq(2 * N_SAMPLES, 1.0 / SAMPLE_RATE)
        turn = np.exp(-2j * np.pi * f * tau)
        return (
            lambda x: fft.irfft(fft.rfft(x, 2 * N_SAMPLES) * turn, 2 * N_SAMPLES)[:N_SAMPLES],
            {"delay": tau},
        )
    if fault == "sensor_gain":
        gain = float(np.exp(sign(rng) * rng.uniform(0.06, 0.6)))
        return lambda x: gain * x, {"gain": gain}
    if fault == "sensor_polarity":
        return np.negative, {}
    if fault == "clipping":
        peak = float(np.max(np.abs(clean[2])))
        level = peak * rng.uniform(0.3, 0.75)
        return lambda x: np.clip(x, -level, level), {"level": level}
    if fault == "mains_hum":
        f, rms = float(rng.choice([50.0, 60.0])), _rms(clean[1][0])
        a = rms * max(log_uniform(rng, 0.05, 0.5), 2.0 * share)
        p = rng.uniform(0.0, 6.28, 3)
        hum = sum(
            a * s * np.sin(2.0 * np.pi * h * f * t + x)
            for h, s, x in zip((1, 3, 5), (1.0, 0.3, 0.1), p, strict=True)
        )
        return lambda x: x + hum, {"frequency": f, "amplitude": a}
    return lambda x: x, {}
