"""Free beams by finite elements of their own, and how they move on feet with an effect."""

from dataclasses import dataclass

import numpy as np

from blind.compiled import kernel

ELEMENTS, MODES = 24, 14  # of the beam; two of them rigid


@dataclass(frozen=True)
class Body:
    """A free beam by its modes, mass-normalised, at its nodes."""

    frequency: np.ndarray
    shapes: np.ndarray
    ratio: np.ndarray


def beam(first_hz: float, mass: float, ratios: np.ndarray) -> Body:
    """Return a free beam of unit length whose first bending mode has a frequency [Hz]."""
    n, h = ELEMENTS + 1, 1.0 / ELEMENTS
    k, m = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    stiff = np.array([
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, 4.0 * h**2, -6.0 * h, 2.0 * h**2],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, 2.0 * h**2, -6.0 * h, 4.0 * h**2],
    ])
    heavy = np.array([
        [156.0, 22.0 * h, 54.0, -13.0 * h],
        [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
        [54.0, 13.0 * h, 156.0, -22.0 * h],
        [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
    ])
    for i in range(ELEMENTS):
        part = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        k[part] += stiff / h**3
        m[part] += mass * h * heavy / 420.0
    root = np.linalg.inv(np.linalg.cholesky(m))
    values, vectors = np.linalg.eigh(root @ k @ root.T)
    shapes = (root.T @ vectors)[::2, :MODES]
    omega = np.sqrt(np.maximum(values[:MODES], 0.0))
    omega[:2] = 0.0
    return Body(omega / omega[2] * first_hz, shapes, ratios)


@kernel
def turned(turn, q, v):
    """Let every mode go on by half a step."""
    for j in range(q.size):
        a, b = q[j], v[j]
        q[j] = turn[j, 0] * a + turn[j, 1] * b
        v[j] = turn[j, 2] * a + turn[j, 3] * b


@kernel
def damped(dampers, foot, h, v):
    """Let the dampers of the feet act for a step, each as if it were alone."""
    for f in range(foot.shape[0]):
        w, mobility = np.sum(foot[f] * v), np.sum(foot[f] ** 2)
        v -= foot[f] * (w * (1.0 - np.exp(-h * dampers[f] * mobility)) / mobility)


@kernel
def force_of(kind, p, motion, most):
    """Return what the effect pushes with; friction at most what stops the foot in a step."""
    z, slip = motion
    if kind == 1:
        return p[0] * (z - min(max(z, -p[1]), p[1]))
    if kind == 2:
        return p[0] * z**3
    if kind == 3:
        return p[0] * slip
    if kind == 4:
        return min(max(most, -p[0]), p[0])
    return 0.0


@kernel
def march(body, effect, drive, out, force):
    """Fill mean accelerations of the modes and, of the effect, mean force, stretch and rate.

    `body` holds exact turns of half a step, what the base does to the modes, the dampers, the
    shapes at the feet, which of these has the effect, and the step; `effect` is kind and
    numbers; `force` has a column a sample.
    """
    turn, base, dampers, foot, at, h = body
    kind, p = effect
    q, v, slip = np.zeros(turn.shape[0]), np.zeros(turn.shape[0]), 0.0
    substeps, mobility = drive.size // out.shape[1], np.sum(foot[at] ** 2)
    for i in range(out.shape[1]):
        out[:, i] = -v
        for s in range(substeps):
            turned(turn, q, v)
            v -= h * drive[i * substeps + s] * base
            damped(dampers, foot, h, v)
            z, w = np.sum(foot[at] * q), np.sum(foot[at] * v)
            slip = min(max(slip + h * w, -p[1]), p[1])
            given = force_of(kind, p, (z, slip), w / (mobility * h))
            v -= h * given * foot[at]
            force[0, i] += given / substeps
            force[1, i] += z / substeps
            force[2, i] += w / substeps
            turned(turn, q, v)
        out[:, i] = (out[:, i] + v) / (h * substeps)
