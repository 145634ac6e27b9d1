"""What responses alone can tell of modes at most: Cramer and Rao's bound of a whole structure.

White forces that nobody measured move a structure whose modes may be complex; every sensor has
white noise of its own. The spectra of the responses at the lines of the band are normal with

    S = G G^H + diag(noise²),  G = direct + sum of shape gain^T / (s - p) + conjugates

(Whittle), which gives the information that they hold of all poles, shapes, gains, direct terms
and noises together. None of the program's own code.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.modal_signals import BANDWIDTH, Structure

DRAWN = 200
"""Estimates drawn from the normal law whose covariance is the bound."""

AT_ONCE = 100
"""Lines whose slopes are held at once."""

UNTOLD = 1e-13
"""Eigenvalue of the information, over the largest, that is none but for rounding [-]: forces
that are turned into each other, or passed through a filter of gain 1, leave the spectra as they
are. Poles and shapes do not change with them."""


@dataclass
class Bound:
    """How many modes of a structure are within a limit where the bound is reached."""

    close: float  # within 0.1 % and 5 %
    loose: float  # within 1 % and 10 %
    alike: float  # MAC above 0.99


@dataclass
class Functions:
    """Response functions of the forces at some lines, and what they are made of."""

    plain: np.ndarray  # (n_lines, n_modes) 1 / (s - p)
    mirrored: np.ndarray  # (n_lines, n_modes) 1 / (s - p*)
    poles: np.ndarray  # (n_modes,) [rad/s]
    shapes: np.ndarray  # (n_modes, n_sensors)
    gains: np.ndarray  # (n_modes, n_forces)
    values: np.ndarray  # (n_lines, n_sensors, n_forces), of forces of 1 at every line


def bound_of(structure: Structure, band: tuple[float, float]) -> Bound:
    """Return how many modes an estimator that reaches the bound has within the limits."""
    information = _information(structure, band)
    scale = np.sqrt(np.diag(information))
    values, vectors = np.linalg.eigh(information / scale / scale[:, np.newaxis])
    told = values > UNTOLD * values[-1]
    root = vectors[:, told] / np.sqrt(values[told]) / scale[:, np.newaxis]
    n, n_sensors = structure.shapes.shape
    drawn = root @ np.random.default_rng(0).standard_normal((root.shape[1], DRAWN))
    damping, frequency = np.abs(np.expm1(drawn[:n])), np.abs(np.expm1(drawn[n : 2 * n]))
    off = np.zeros((n, n_sensors, DRAWN), dtype=complex)
    real, imaginary = drawn[2 * n : 2 * n * n_sensors].reshape(2, -1, DRAWN)
    off[_free(structure.shapes)] = real + 1j * imaginary
    truth = structure.shapes[..., np.newaxis]
    shared = np.abs(np.sum(truth * (truth + off), axis=1)) ** 2
    mac = shared / np.sum(truth**2, axis=1) / np.sum(np.abs(truth + off) ** 2, axis=1)
    return Bound(
        close=float(np.sum((frequency < 1e-3) & (damping < 0.05)) / DRAWN),
        loose=float(np.sum((frequency < 1e-2) & (damping < 0.10)) / DRAWN),
        alike=float(np.sum(mac > 0.99) / DRAWN),
    )


def _free(shapes: np.ndarray) -> np.ndarray:
    """Return which components of shapes are unknown: the largest of each says its size."""
    largest = np.argmax(np.abs(shapes), axis=1)
    return np.arange(shapes.shape[1]) != largest[:, np.newaxis]


def _information(structure: Structure, band: tuple[float, float]) -> np.ndarray:
    """Return Fisher's information of all parameters.

    They are ln damping ratios, ln frequencies, real, then imaginary parts of shapes, and what
    nobody asks for: gains, direct terms, ln of the noises.
    """
    n_samples = structure.response.shape[1]
    frequency = np.fft.rfftfreq(n_samples, 1.0 / structure.sample_rate)
    frequency = frequency[(frequency >= band[0]) & (frequency <= band[1])]
    total = 0.0
    for start in range(0, frequency.size, AT_ONCE):
        slopes = _slopes(structure, 2j * np.pi * frequency[start : start + AT_ONCE])
        total = total + slopes.T @ slopes
    return np.asarray(total)


def _slopes(structure: Structure, s: np.ndarray) -> np.ndarray:
    """Return the slopes of the spectra over all parameters, whitened.

    Rows are the real and imaginary parts of the elements at every line.
    """
    parts = _functions(structure, s)
    g, n_sensors = parts.values, structure.shapes.shape[1]
    spectra = g @ _conjugate(g) + np.diag(structure.noise**2)
    white = np.linalg.inv(np.linalg.cholesky(spectra))
    along = np.concatenate([white[:, np.newaxis] @ one for one in _along(structure, parts)], 1)
    half = along @ _conjugate(white @ g)[:, np.newaxis]
    own = (white * structure.noise).swapaxes(1, 2)
    of_noise = own[..., np.newaxis] * own[:, :, np.newaxis].conj()
    whole = np.concatenate([half, of_noise], axis=1)
    whole = whole + _conjugate(whole)
    row, column = np.triu_indices(n_sensors, 1)
    above = np.sqrt(2.0) * whole[..., row, column]
    diagonal = np.diagonal(whole, axis1=-2, axis2=-1).real
    found = np.concatenate([diagonal, above.real, above.imag], axis=-1)
    return found.swapaxes(1, 2).reshape(-1, found.shape[1])


def _functions(structure: Structure, s: np.ndarray) -> Functions:
    """Return the response functions at lines `s` [rad/s]."""
    omega, ratio = 2.0 * np.pi * structure.frequency, structure.damping
    poles = omega * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
    level = 1.0 / np.sqrt(BANDWIDTH)  # of a force with an rms of 1
    at_forces = level * structure.shapes[:, list(structure.driven)]
    gains = (poles**2 / (2j * poles.imag))[:, np.newaxis] * at_forces
    plain, mirrored = 1.0 / (s[:, np.newaxis] - poles), 1.0 / (s[:, np.newaxis] - poles.conj())
    residues = structure.shapes[..., np.newaxis] * gains[:, np.newaxis]
    values = np.tensordot(plain, residues, 1) + np.tensordot(mirrored, residues.conj(), 1)
    values = values + structure.shapes.T @ at_forces
    return Functions(plain, mirrored, poles, structure.shapes, gains, values)


def _along(structure: Structure, parts: Functions) -> list[np.ndarray]:
    """Return slopes of the functions, (n_lines, n_parameters, n_sensors, n_forces) each."""
    ratio, poles = structure.damping, parts.poles
    n_lines, n_forces = parts.plain.shape[0], parts.gains.shape[1]
    residues = parts.shapes[..., np.newaxis] * parts.gains[:, np.newaxis]
    along_ratio = np.abs(poles) * ratio * (-1.0 - 1j * ratio / np.sqrt(1.0 - ratio**2))
    found = []
    for slope in (along_ratio, poles):
        one = (slope * parts.plain**2)[..., np.newaxis, np.newaxis] * residues
        other = (slope.conj() * parts.mirrored**2)[..., np.newaxis, np.newaxis]
        found.append(one + other * residues.conj())
    mode, sensor = np.nonzero(_free(parts.shapes))
    units, forces = np.eye(parts.shapes.shape[1])[sensor], np.eye(n_forces)
    driven = parts.plain[..., np.newaxis] * parts.gains
    mirror = parts.mirrored[..., np.newaxis] * parts.gains.conj()
    for one in (driven + mirror, 1j * (driven - mirror)):
        found.append(units[..., np.newaxis] * one[:, mode, np.newaxis])
    moved = parts.plain[..., np.newaxis] * parts.shapes
    mirror = parts.mirrored[..., np.newaxis] * parts.shapes
    for one in (moved + mirror, 1j * (moved - mirror)):
        every = one[:, :, np.newaxis, :, np.newaxis] * forces[:, np.newaxis]
        found.append(every.reshape(n_lines, -1, *residues.shape[1:]))
    direct = np.eye(residues[0].size).reshape(-1, *residues.shape[1:])
    return [*found, np.broadcast_to(direct, (n_lines, *direct.shape))]


def _conjugate(matrices: np.ndarray) -> np.ndarray:
    return matrices.conj().swapaxes(-1, -2)
