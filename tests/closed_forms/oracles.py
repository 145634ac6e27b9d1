"""Closed forms that other tests hold the solvers to."""

import numpy as np


def gap_backbone(amplitude, clearance):
    """The exact free frequency with play, over that without: half sines and times of flight."""
    return 1.0 / (1.0 + 2.0 * clearance / (np.pi * (amplitude - clearance)))


def duffing_harmonic_frequency(amplitude, natural, cubic, force):
    """The forcing frequency of an amplitude by one harmonic, undamped (eq. 3.47) [Hz]."""
    square = (2.0 * np.pi * natural) ** 2 + 0.75 * cubic * amplitude**2 - force / amplitude
    return np.sqrt(square) / (2.0 * np.pi)
