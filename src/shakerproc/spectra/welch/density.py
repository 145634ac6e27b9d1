"""Densities from the cross spectra."""

from shakerproc.data import FloatArray
from shakerproc.spectra.welch.cross import CrossSpectra


def psd(spectra: CrossSpectra) -> FloatArray:
    """Return the power spectral density of every channel.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.

    Returns
    -------
    (n_channels, n_frequencies) array
        One-sided densities [unit²/Hz].
    """
    return spectra.density.copy()
