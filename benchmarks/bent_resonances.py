"""One resonance that bends with level: how often it is split, how often intervals hold.

python -m benchmarks.bent_resonances [--draws 200] [--seed 0]

An oscillator of 22 Hz and 0.6 % whose softening spring lowers it by 2 % at its largest motion
of a linear one, 40 s of white force at 200 Hz, 1 % of noise; and two linear modes 12 % and 2 %
apart with the same damping and noise of 10 %. What a bent resonance "is" is its mean over the
draws. Simulated with numpy alone.
"""

import argparse
from collections.abc import Sequence
from typing import Final

import numpy as np
from scipy import signal

from shakerproc.data import FloatArray
from shakerproc.modal import ModeSet, Settings, identify_samples

RATE: Final = 200.0
SECONDS: Final = 40.0
FREQUENCY: Final = 22.0
DAMPING: Final = 0.006
SHIFT: Final = 0.02
SUBSTEPS: Final = 64
BAND: Final = (5.0, 60.0)


def bent(forces: FloatArray) -> FloatArray:
    """Return the accelerations of the softening oscillator, all draws at once."""
    omega, step = 2.0 * np.pi * FREQUENCY, 1.0 / RATE / SUBSTEPS
    largest = 3.0 * np.sqrt(1.0 / (4.0 * DAMPING * omega**3 * RATE))
    softer = 8.0 / 3.0 * SHIFT / largest**2  # 3/8 k3 A^2
    x, v = np.zeros((2, len(forces)))
    out = np.empty_like(forces)
    for i, force in enumerate(forces.T):
        for _ in range(SUBSTEPS):
            inner = omega**2 * x * (1.0 - softer * x * x) + 2.0 * DAMPING * omega * v
            v = v + step * (force - inner)
            x = x + step * v
        out[:, i] = -(omega**2 * x * (1.0 - softer * x * x) + 2.0 * DAMPING * omega * v)
    return out


def linear(forces: FloatArray, frequencies: Sequence[float]) -> FloatArray:
    """Return the accelerations of modes that move one sensor alike."""
    out = np.zeros_like(forces)
    for omega in 2.0 * np.pi * np.array(frequencies):
        law = ([2.0 * DAMPING * omega, omega**2], [1.0, 2.0 * DAMPING * omega, omega**2])
        above, below, _ = signal.cont2discrete(law, 1.0 / RATE, "foh")
        out += signal.lfilter(above.ravel(), below, forces)
    return out


def modes_of(
    forces: FloatArray, out: FloatArray, noise: float, rng: np.random.Generator
) -> list[ModeSet]:
    """Return the modes of each draw, with noise added to its response."""
    noisy = out + noise * out.std(axis=1, keepdims=True) * rng.standard_normal(out.shape)
    return [
        identify_samples(force[np.newaxis], one[np.newaxis], RATE, Settings(BAND))
        for force, one in zip(forces, noisy, strict=True)
    ]


def told(found: Sequence[ModeSet], n_modes: int, truth: FloatArray | None) -> str:
    """Return how many draws have the right number, and how many intervals hold the truth."""
    right = [one for one in found if one.poles.size == n_modes]
    if not right:
        return f"0 of {len(found)} draws with {n_modes}"
    values = np.log([[one.frequency, one.damping] for one in right])
    errors = np.array([[one.frequency_error, one.damping_error] for one in right])
    centre = values.mean(axis=0) if truth is None else np.log(truth)
    held = np.mean(np.abs(values - centre) < 1.96 * errors, axis=(0, 2))
    return (
        f"{len(right)} of {len(found)} draws with {n_modes}; 95 % intervals hold "
        f"{held[0]:.1%} of frequencies, {held[1]:.1%} of dampings"
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print how many modes are found, and the coverage of their intervals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    rng = np.random.default_rng(options.seed)
    forces = rng.standard_normal((options.draws, round(SECONDS * RATE)))
    print(f"{options.draws} draws, seed {options.seed}")
    print("bent:", told(modes_of(forces, bent(forces), 0.01, rng), 1, None), flush=True)
    for apart in (0.12, 0.02):
        frequencies = FREQUENCY * np.array([1.0, 1.0 + apart])
        found = modes_of(forces, linear(forces, frequencies), 0.1, rng)
        truth = np.array([frequencies, [DAMPING, DAMPING]])
        print(f"two, {apart:.0%} apart:", told(found, 2, truth), flush=True)


if __name__ == "__main__":
    main()
