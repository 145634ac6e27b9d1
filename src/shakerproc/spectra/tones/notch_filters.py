"""Taking one frequency out of a signal: the thesis' filter and a centred one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

THESIS_PAD: Final = 6
"""Samples that MATLAB's filtfilt adds at both ends for a filter of second order."""

SETTLED: Final = 1e-4
"""Share of a transient of the filter that is left where the edges are trimmed."""

TWO_PASSES: Final = float(np.sqrt(np.sqrt(2.0) - 1.0))
"""Width of one pass over the half-power width of two."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Notched:
    """Samples without a tone, the edges that the filter spoils cut off.

    Attributes
    ----------
    samples : (n_channels, n) array
        Filtered samples, in the unit of the input.
    start, stop : int
        Which samples of the input they are.
    """

    samples: FloatArray
    start: int
    stop: int


def butterworth_band_stop(
    low: float, high: float, sample_rate: float
) -> tuple[FloatArray, FloatArray]:
    r"""Return the Butterworth band-stop filter of second order, as the thesis designs it.

    .. math:: H(s) = \frac{s^2 + \omega_0^2}{s^2 + B s + \omega_0^2}, \quad
              \omega_0^2 = \omega_1 \omega_2, \; B = \omega_2 - \omega_1

    with prewarped edges and the bilinear transform. Its null is the geometric mean of the
    warped edges, a little below the middle.

    Parameters
    ----------
    low, high : float
        Half-power frequencies of one pass [Hz].
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    (3,) array, (3,) array
        Numerator and denominator, the latter beginning with 1.

    Raises
    ------
    SpectrumError
        If the band does not lie between 0 and half the sample rate.
    """
    _check_band(low, high, sample_rate)
    edge_1, edge_2 = np.tan(np.pi * low / sample_rate), np.tan(np.pi * high / sample_rate)
    return _second_order(float(edge_1 * edge_2), float(edge_2 - edge_1))


def centred_notch(
    frequency: float, width: float, sample_rate: float
) -> tuple[FloatArray, FloatArray]:
    """Return a filter of second order with its null exactly at a frequency.

    Parameters
    ----------
    frequency : float
        Frequency of the null [Hz].
    width : float
        Half-power width after the filter has run forwards and backwards [Hz].
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    (3,) array, (3,) array
        Numerator and denominator, the latter beginning with 1.

    Raises
    ------
    SpectrumError
        If the band does not lie between 0 and half the sample rate.
    """
    _check_band(frequency - width / 2.0, frequency + width / 2.0, sample_rate)
    centre = np.tan(np.pi * frequency / sample_rate) ** 2
    slope = np.tan(np.pi * width / sample_rate) * (1.0 + centre)
    return _second_order(float(centre), float(TWO_PASSES * slope))


def thesis_notch(
    samples: FloatArray, sample_rate: float, frequency: float = 50.0
) -> FloatArray:
    """Return samples filtered to the letter of the thesis, spoiled edges and all.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples [any unit].
    sample_rate : float
        Samples per second, for the design of the filter [Hz].
    frequency : float
        Middle of the band-stop, whose half-power frequencies lie 1 Hz beside it [Hz].

    Returns
    -------
    (n_channels, n_samples) array
        Filtered samples, in the unit of the input.

    Raises
    ------
    SpectrumError
        If the band does not fit the sample rate, or there are 6 samples or fewer.

    References
    ----------
    .. [1] THESIS, appendix C, "Notch filter"; MATLAB's designfilt and filtfilt.
    """
    band = butterworth_band_stop(frequency - 1.0, frequency + 1.0, sample_rate)
    return filter_both_ways(samples, *band, pad=THESIS_PAD)


def notch(
    samples: FloatArray,
    sample_rate: float,
    frequency: float,
    *,
    width: float = 2.0,
    harmonics: Sequence[int] = (1,),
    trim: float | None = None,
) -> Notched:
    """Return samples without a tone and, on request, its harmonics; phase is kept.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples [any unit].
    sample_rate : float
        Samples per second [Hz].
    frequency : float
        Frequency of the tone [Hz].
    width : float
        Half-power width of each notch [Hz].
    harmonics : sequence of int
        Which multiples of the frequency to take out; those above 0.45 times the sample rate
        are not in the samples and left alone.
    trim : float, optional
        What to cut off at both ends [s]; by default until transients have fallen to 1e-4.

    Returns
    -------
    Notched
        Filtered samples without the trimmed edges.

    Raises
    ------
    SpectrumError
        If a notch does not fit the sample rate, or trimming leaves nothing.
    """
    checks.positive("frequency", frequency, "Hz")
    checks.positive("width", width, "Hz")
    if trim is None:
        settling = -np.log(SETTLED) / (np.pi * TWO_PASSES * width)
    else:
        checks.not_negative("trim", trim, "s")
        settling = trim
    edge, n_samples = round(settling * sample_rate), samples.shape[1]
    if 2 * edge >= n_samples:
        raise SpectrumError(
            f"trimming {numeral(settling)} s at both ends leaves nothing of "
            f"{numeral(n_samples / sample_rate)} s: take a wider notch or give a shorter trim"
        )
    filtered = samples
    for multiple in harmonics:
        if multiple * frequency + width < 0.45 * sample_rate:
            one = centred_notch(multiple * frequency, width, sample_rate)
            filtered = filter_both_ways(filtered, *one, pad=min(edge, n_samples - 1))
    return Notched(np.array(filtered[:, edge : n_samples - edge]), edge, n_samples - edge)


def filter_both_ways(
    samples: FloatArray, numerator: FloatArray, denominator: FloatArray, *, pad: int
) -> FloatArray:
    """Return samples filtered forwards and backwards, as MATLAB's and scipy's filtfilt do.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples [any unit].
    numerator, denominator : (3,) arrays
        Filter of second order, denominator beginning with 1 [-].
    pad : int
        Samples added at both ends, turned about the end points.

    Returns
    -------
    (n_channels, n_samples) array
        Filtered samples, in the unit of the input.

    Raises
    ------
    SpectrumError
        If there are no more samples than are to be added.
    """
    if samples.shape[1] <= pad:
        raise SpectrumError(f"filtering needs more than {pad} samples, not {samples.shape[1]}")
    from shakerproc.spectra.kernels import filter_second_order  # loads the compiler: late

    filtered = np.empty(samples.shape)
    for channel, row in enumerate(samples):
        before = 2.0 * row[0] - row[pad:0:-1]
        after = 2.0 * row[-1] - row[-2 : -pad - 2 : -1]
        extended = np.concatenate([before, row, after])
        filter_second_order(extended, numerator, denominator)
        backwards = extended[::-1].copy()
        filter_second_order(backwards, numerator, denominator)
        filtered[channel] = backwards[::-1][pad : pad + row.size]
    return filtered


def _check_band(low: float, high: float, sample_rate: float) -> None:
    """Pass a band between 0 and half the sample rate.

    Raises
    ------
    SpectrumError
        If it lies elsewhere.
    """
    if not 0.0 < low < high < sample_rate / 2.0:
        raise SpectrumError(
            f"a notch from {low:g} to {high:g} Hz does not lie between 0 and half the sample "
            f"rate of {sample_rate:g} Hz"
        )


def _second_order(centre: float, slope: float) -> tuple[FloatArray, FloatArray]:
    """Return the bilinear transform of (s² + centre) / (s² + slope s + centre)."""
    numerator = np.array([1.0 + centre, 2.0 * (centre - 1.0), 1.0 + centre])
    denominator = np.array([1.0 + slope + centre, 2.0 * (centre - 1.0), 1.0 - slope + centre])
    return numerator / denominator[0], denominator / denominator[0]
