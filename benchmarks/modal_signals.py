"""Simulated structures in closed form: modal superposition, none of the program's own code."""

from dataclasses import dataclass

import numpy as np

OVERSAMPLED = 8
"""Steps of the recursion in one sample; the force is linear between them."""

BANDWIDTH = 0.84
"""Where the forces end, over half the sample rate [-]."""


@dataclass(frozen=True)
class Structure:
    """Modes, forces and accelerations of one draw."""

    frequency: np.ndarray  # undamped [Hz]
    damping: np.ndarray  # [-]
    shapes: np.ndarray  # (n_modes, n_sensors)
    force: np.ndarray  # (n_inputs, n_samples) [N]
    response: np.ndarray  # (n_sensors, n_samples) [m/s^2], with noise
    sample_rate: float
    driven: tuple[int, ...]  # sensors at which the forces act
    noise: np.ndarray  # (n_sensors,) rms [m/s^2]


def draw(
    rng: np.random.Generator,
    n_modes: int,
    *,
    n_inputs: int = 1,
    noise_db: float = 40.0,
    n_sensors: int = 8,
    duration: float = 20.0,
    sample_rate: float = 512.0,
) -> Structure:
    """Return a structure with two close pairs (as many as fit) and its measured signals."""
    frequency = _frequencies(rng, n_modes, 0.4 * sample_rate)
    damping = np.exp(rng.uniform(np.log(0.002), np.log(0.05), n_modes))
    place = np.arange(1, n_sensors + 1) / (n_sensors + 1)
    orders = np.arange(1, n_modes + 1)
    shapes = np.sin(np.pi * np.outer(orders, place) + rng.uniform(-0.3, 0.3, (n_modes, 1)))
    shapes *= rng.choice([-1.0, 1.0], (n_modes, 1)) * rng.uniform(0.7, 1.3, shapes.shape)
    driven = tuple(int(i) for i in rng.choice(n_sensors, n_inputs, replace=False))
    for one in driven:  # nobody drives a node of what is to be found
        weak = np.abs(shapes[:, one]) < 0.3
        shapes[weak, one] = 0.3 * np.where(shapes[weak, one] < 0.0, -1.0, 1.0)
    n_samples = int(duration * sample_rate)
    force = band_limited(rng, n_inputs, n_samples)
    response = superposition(
        frequency, damping, shapes, shapes[:, list(driven)] @ force, sample_rate
    )
    noise = 10 ** (-noise_db / 20) * np.sqrt(np.mean(response**2, axis=1))
    response = response + noise[:, np.newaxis] * rng.standard_normal(response.shape)
    return Structure(
        frequency,
        damping,
        shapes,
        force[:, ::OVERSAMPLED],
        response,
        sample_rate,
        driven,
        noise,
    )


def _frequencies(rng: np.random.Generator, n_modes: int, highest: float) -> np.ndarray:
    """Return natural frequencies [Hz], the second of each close pair 1 to 3 % above."""
    pairs = 2 if n_modes >= 4 else 1
    singles = n_modes - pairs
    spaced = np.linspace(0.08, 0.9, singles) * highest
    spaced = spaced * (1.0 + rng.uniform(-0.02, 0.02, singles))
    first = rng.choice(singles, pairs, replace=False)
    close = spaced[first] * (1.0 + rng.uniform(0.01, 0.03, pairs))
    return np.sort(np.concatenate([spaced, close]))


def band_limited(rng: np.random.Generator, n_inputs: int, n_samples: int) -> np.ndarray:
    """Return Gaussian forces of one BANDWIDTH and rms 1, OVERSAMPLED times as fine."""
    extra = 4 * n_samples  # cut from a longer period: nothing is periodic in the record
    spectrum = np.zeros((n_inputs, extra * OVERSAMPLED // 2 + 1), dtype=complex)
    lines = int(0.5 * BANDWIDTH * extra)
    spectrum[:, 1:lines] = rng.standard_normal((n_inputs, lines - 1)) + 1j * (
        rng.standard_normal((n_inputs, lines - 1))
    )
    force = np.fft.irfft(spectrum, extra * OVERSAMPLED)
    force = force[:, : n_samples * OVERSAMPLED]
    return force / np.std(force)


def superposition(
    frequency: np.ndarray,
    damping: np.ndarray,
    shapes: np.ndarray,
    load: np.ndarray,
    sample_rate: float,
) -> np.ndarray:
    """Return accelerations from rest: exact recursion, modal forces linear in a step."""
    from scipy.signal import lfilter

    step = 1.0 / (sample_rate * OVERSAMPLED)
    total = np.zeros((shapes.shape[1], load.shape[1] // OVERSAMPLED))
    for f, zeta, shape, own in zip(frequency, damping, shapes, load, strict=True):
        omega = 2 * np.pi * f
        pole = -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
        # q' = pole q + load: first-order hold, closed form
        e = np.exp(pole * step)
        g0 = (e - 1) / pole
        g1 = (e - 1 - pole * step) / (pole**2 * step)
        q = lfilter([g1, g0 - g1], [1.0, -e], own.astype(complex))
        displacement_pole = q / (1j * 2 * pole.imag)
        acceleration = 2 * np.real(pole**2 * displacement_pole) + own
        total += np.outer(shape, acceleration[::OVERSAMPLED])
    return total
