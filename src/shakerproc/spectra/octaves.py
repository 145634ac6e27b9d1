"""Octave and fractional-octave bands (IEC 61260-1): by filters, and from a density."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra.welch.cross import CrossSpectra, rms_in_band

RATIO: Final = 10.0**0.3
"""The octave of the standard, to the base ten [-]."""

REFERENCE: Final = 1000.0
"""Frequency that the bands are counted from [Hz]."""

ORDER: Final = 4
"""Order of the Butterworth filters, to each side."""

HIGHEST: Final = 0.45
"""Highest upper edge of a band, as a share of the sample rate [-]."""

_THIRDS: Final = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
"""Nominal frequencies of a decade of thirds of an octave (ISO 266)."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class OctaveBands:
    """Bands of a fraction of an octave, (n_bands,) arrays.

    Attributes
    ----------
    fraction : int
        Bands to an octave.
    nominal : array
        Names of the bands [Hz].
    middle, lower, upper : arrays
        Exact middles and edges [Hz].
    """

    fraction: int
    nominal: FloatArray
    middle: FloatArray
    lower: FloatArray
    upper: FloatArray


def octave_bands(fraction: int, low: float, high: float) -> OctaveBands:
    r"""Return the bands whose middles lie from low to high.

    .. math:: f_m = f_r \, G^{x / b} \;\text{(odd } b\text{)}, \quad
        f_r \, G^{(2x + 1) / (2b)} \;\text{(even } b\text{)}, \quad G = 10^{3/10}

    Parameters
    ----------
    fraction : int
        Bands to an octave, b: 1, 3, 6, 12, ...
    low, high : float
        From where to where [Hz]; a nominal frequency means its band.

    Returns
    -------
    OctaveBands
        In rising order, possibly none.

    Raises
    ------
    ValueError
        If low is not above 0, or a fraction is below 1.

    References
    ----------
    .. [1] IEC 61260-1:2014, Electroacoustics - Octave-band and fractional-octave-band filters -
       Part 1: Specifications.
    """
    if low <= 0.0 or fraction < 1:
        raise ValueError(f"no bands of 1/{fraction} octave from {low:g} Hz")
    shift = 0.0 if fraction % 2 else 0.5
    first, last = (
        fraction * np.log(f / REFERENCE) / np.log(RATIO) - shift for f in (low, high)
    )
    room = 0.02 * fraction  # nominal frequencies lie up to 1.2 % off the exact ones
    x = np.arange(np.ceil(first - room), np.floor(last + room) + 1.0)
    middle = REFERENCE * RATIO ** ((x + shift) / fraction)
    half = RATIO ** (0.5 / fraction)
    return OctaveBands(
        fraction, _nominal(middle, fraction), middle, middle / half, middle * half
    )


def _nominal(middle: FloatArray, fraction: int) -> FloatArray:
    """Return the nominal frequencies: preferred numbers, or three digits of narrower bands."""
    if fraction not in {1, 3}:
        return np.array([float(f"{f:.3g}") for f in middle])
    # rounding may leave the first band of a decade just below it
    decade = np.floor(np.log10(middle * 1.001))
    step = np.rint(10.0 * (np.log10(middle) - decade)).astype(int)
    exact = np.array(_THIRDS)[step] * 10.0**decade
    return np.array([float(f"{f:.6g}") for f in exact])


def octave_filter(bands: OctaveBands, band: int, sample_rate: float) -> FloatArray:
    """Return the filter of one band as second-order sections, (n_sections, 6) array [-]."""
    edges = [bands.lower[band], bands.upper[band]]
    return np.asarray(
        scipy.signal.butter(ORDER, edges, "bandpass", fs=sample_rate, output="sos")
    )


def rms_through_filters(
    blocks: Iterable[FloatArray], sample_rate: float, bands: OctaveBands
) -> FloatArray:
    """Return the root mean square of each band by its filter.

    Butterworth filters of fourth order to each side; they keep the limits of class 1.

    Parameters
    ----------
    blocks : iterable of (n_channels, n_samples) arrays
        Samples, one part after the other [unit].
    sample_rate : float
        Samples per second [Hz].
    bands : OctaveBands
        Bands.

    Returns
    -------
    (n_channels, n_bands) array
        Over all samples, from filters at rest [unit].

    Raises
    ------
    ValueError
        If a band reaches beyond 0.45 times the sample rate.
    """
    if bands.upper.size and bands.upper[-1] > HIGHEST * sample_rate:
        raise ValueError(f"bands must end below {HIGHEST * sample_rate:g} Hz")
    filters = [octave_filter(bands, i, sample_rate) for i in range(bands.middle.size)]
    memory: list[FloatArray] = []
    power, count = np.zeros((0, len(filters))), 0
    for block in blocks:
        if not memory:
            memory = [np.zeros((len(sos), len(block), 2)) for sos in filters]
            power = np.zeros((len(block), len(filters)))
        for i, sos in enumerate(filters):
            passed, memory[i] = scipy.signal.sosfilt(sos, block, axis=-1, zi=memory[i])
            power[:, i] += np.sum(passed**2, axis=-1)
        count += block.shape[1]
    return np.asarray(np.sqrt(power / max(count, 1)))


def rms_of_density(spectra: CrossSpectra, bands: OctaveBands) -> FloatArray:
    """Return the root mean square of each band by the density.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    bands : OctaveBands
        Bands.

    Returns
    -------
    (n_channels, n_bands) array
        Not a number where a band is narrower than the bins are apart [unit].
    """
    columns = [
        rms_in_band(spectra, (float(low), float(high)))
        for low, high in zip(bands.lower, bands.upper, strict=True)
    ]
    values = np.array(columns).reshape(len(columns), -1).T.copy()
    values[:, bands.upper - bands.lower < spectra.bin_width] = np.nan
    return values
