"""The linear part of the truth: masses in a row, its spectra, and what it is driven by."""

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft

from blind.classes import FORMS
from blind.draws import Rng, log_uniform, sign
from blind.excitations import SAMPLE_RATE, Drive
from blind.ranges import Scale

G = 9.80665


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


def draw_structure(rng: Rng, form: str) -> Structure:
    """Return the masses and joints of a form."""
    n = FORMS[form]
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


def draw_drives(rng: Rng, seed: int, structure: Structure, wanted: str) -> list[Drive]:
    """Return three levels and a held-out test; `wanted` is a kind of drive, or empty."""
    f_n = np.sqrt(structure.joints[0].stiffness / structure.masses[0]) / (2.0 * np.pi)
    random = rng.random() < 0.5
    if wanted:
        random = wanted == "random"
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


def scale_of(structure: Structure, joint: Joint, stretch: np.ndarray) -> Scale:
    """Return the scales of a joint's motion that ranges are relative to."""
    mass = structure.masses[joint.second]
    omega = float(np.sqrt(joint.stiffness / mass))
    rms, peak = float(np.sqrt(np.mean(stretch**2))), float(np.max(np.abs(stretch)))
    middle = float(np.sqrt(rms * peak))
    return Scale(mass, joint.stiffness, omega, middle, omega * middle, joint.stiffness * rms)


def rigid_force(structure: Structure, at: int, excitation: np.ndarray) -> np.ndarray:
    """Return the force that a joint carries while nothing in the structure moves [N]."""
    if structure.force_on >= 0:
        return excitation
    return sum(structure.masses[at:]) * excitation


def nominal_of(rng: Rng, structure: Structure) -> Structure:
    """Return what the user's model says: 5 % off in stiffness, 25 % in damping."""
    return replace(structure, joints=tuple(
        replace(j, stiffness=j.stiffness * (1.0 + 0.05 * sign(rng)),
                damping=j.damping * (1.0 + 0.25 * sign(rng)))
        for j in structure.joints
    ))  # fmt: skip
