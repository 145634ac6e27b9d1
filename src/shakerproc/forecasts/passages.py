"""How a quantity follows the drive at each frequency: what a notch acts on."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts.motion import Motion
from shakerproc.forecasts.quantities import segment_of
from shakerproc.planning.drive import frequency_of_sweep
from shakerproc.spectra import cross_spectra
from shakerproc.testlog import Test

PER_OCTAVE: Final = 48
"""Bins in an octave: half a decibel along an edge of 24 dB/oct [-]."""


def edges_of_bins(band: tuple[float, float]) -> FloatArray:
    """Return the edges of bins of equal width in octaves, (n_bins + 1,) array [Hz].

    `band` is what a test excites [Hz].
    """
    octaves = float(np.log2(band[1] / band[0]))
    return np.geomspace(*band, max(2, round(PER_OCTAVE * octaves)) + 1)


def centres_of_bins(band: tuple[float, float]) -> FloatArray:
    """Return the middles of the bins of a band [Hz], (n_bins,) array [Hz]."""
    edges = edges_of_bins(band)
    return np.sqrt(edges[:-1] * edges[1:])


def passage(test: Test, motion: Motion, samples: FloatArray) -> FloatArray:
    r"""Return how a quantity follows the drive of one motion, bin by bin, (n_bins,) array.

    Of noise the mean square of the gain of the linear system nearest to it,
    :math:`|H_1|^2 = |S_{xy} / S_{xx}|^2`: what is not coherent with the drive at a frequency
    no notch there takes away [1]_. Of a sweep the largest size while it passes the bin.

    Parameters
    ----------
    test : Test
        What drives: random or a sine sweep.
    motion : Motion
        Its drive.
    samples : (n,) array
        The quantity.

    References
    ----------
    .. [1] J. S. Bendat, "Nonlinear System Techniques and Applications", Wiley, 1998, ch. 1.
    """
    band = test.band or (1.0, 0.5 * motion.sample_rate)
    edges = edges_of_bins(band)
    if test.excitation == "sine sweep":
        shares = np.arange(samples.size) / samples.size
        at = np.searchsorted(edges, frequency_of_sweep(test, shares), "right") - 1
        largest = np.zeros(edges.size - 1)
        inside = np.clip(at, 0, largest.size - 1)
        np.maximum.at(largest, inside, np.abs(samples - np.mean(samples)))
        return largest
    rows = np.array([motion.drive, samples])
    spectra = cross_spectra(
        rows, motion.sample_rate, segment=segment_of(samples.size), window="hann", inputs=[0]
    )
    cross = np.abs(spectra.between([0], [1])[0, 0])
    gain = cross / np.maximum(spectra.density[0], np.finfo(float).tiny)
    squares = np.where(spectra.frequency <= band[1], gain, 0.0) ** 2
    step = float(spectra.frequency[1] - spectra.frequency[0])
    whole = step * (np.cumsum(squares) - 0.5 * squares)
    return np.asarray(np.diff(np.interp(edges, spectra.frequency, whole)) / np.diff(edges))
