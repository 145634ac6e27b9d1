"""Which frequencies mean something: inside the excited band, beside notches, with input."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

NOTCH_BINS: Final = 3.0
"""Bins to both sides of a notch that the window smears it over."""

AUDIBLE: Final = 1e-4
"""Share of the largest density of the input in the band below which a bin is not excited [-]:
40 dB below, where the side lobes of a Hamming window (-43 dB) carry what leaks."""


def excited(
    frequency: FloatArray,
    band: tuple[float, float],
    *,
    notches: Sequence[float] = (),
    half_width: float = 1.0,
) -> NDArray[np.bool_]:
    """Return which frequencies the excitation reaches and no notch has emptied.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Equally spaced frequencies [Hz].
    band : (float, float)
        Lower and upper limit of the excitation [Hz].
    notches : sequence of float
        Frequencies of notch filters [Hz].
    half_width : float
        Half the width of a notch [Hz]; three bins are added for the window.

    Returns
    -------
    (n_frequencies,) array of bool
        True where a response function means something.
    """
    keep = (frequency >= band[0]) & (frequency <= band[1])
    reach = half_width + NOTCH_BINS * (frequency[1] - frequency[0])
    for notch in notches:
        keep &= np.abs(frequency - notch) > reach
    return keep


def audible(
    frequency: FloatArray, density: FloatArray, band: tuple[float, float]
) -> NDArray[np.bool_]:
    """Return which frequencies, inside the band or not, have an input to divide by.

    Parameters
    ----------
    frequency : (n_frequencies,) array
        Equally spaced frequencies [Hz].
    density : (n_frequencies,) array
        Of the input, such as that of the mean control [unit²/Hz].
    band : (float, float)
        Lower and upper limit of the excitation [Hz].

    Returns
    -------
    (n_frequencies,) array of bool
        True where the density exceeds `AUDIBLE` of its largest value in the band; nowhere
        where there is none.
    """
    largest = density[excited(frequency, band)].max(initial=0.0)
    return np.array((largest > 0.0) & (density > AUDIBLE * largest))


def driven(
    frequency: FloatArray, density: FloatArray, band: tuple[float, float]
) -> NDArray[np.bool_]:
    """Return where `audible` holds within the excited band, (n_frequencies,) array of bool.

    Parameters
    ----------
    frequency, density, band
        As of `audible` [Hz], [unit²/Hz], [Hz].
    """
    return np.array(excited(frequency, band) & audible(frequency, density, band))


def masked(values: FloatArray, keep: NDArray[np.bool_]) -> FloatArray:
    """Return values, those that are not kept replaced by not-a-number.

    Parameters
    ----------
    values : (..., n_frequencies) array
        Real or complex values [any unit].
    keep : (n_frequencies,) array of bool
        What is kept.

    Returns
    -------
    (..., n_frequencies) array
        New array of the same kind.
    """
    return np.where(keep, values, np.nan)
