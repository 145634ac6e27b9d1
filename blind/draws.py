"""Draws that every table of ranges uses."""

import numpy as np

Rng = np.random.Generator


def log_uniform(rng: Rng, low: float, high: float) -> float:
    """Return a number whose logarithm is spread evenly."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def sign(rng: Rng) -> float:
    """Return 1 or -1."""
    return float(rng.choice([-1.0, 1.0]))
