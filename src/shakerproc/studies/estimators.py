"""Peak frequency: the tallest peak of a spectrum, always with the way it was found."""

from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra import cross_spectra, periodogram, psd
from shakerproc.spectra.peaks.finding import local_maxima
from shakerproc.studies.study import Measure

SMALLEST = 1e-3
"""How tall the first peak must be, over the tallest [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """A density with the width of its bins.

    Attributes
    ----------
    frequency : (n,) array
        Frequencies [Hz].
    density : (n,) array
        Density [unit²/Hz].
    bin_width : float
        Distance of the bins [Hz].
    """

    frequency: FloatArray
    density: FloatArray
    bin_width: float


def spectrum(samples: FloatArray, sample_rate: float, measure: Measure) -> Spectrum:
    """Return the density of samples by the estimator of a measure.

    Parameters
    ----------
    samples : (n,) array
        What was measured [any unit].
    sample_rate : float
        Samples per second [Hz] [Hz].
    measure : Measure
        How.

    Raises
    ------
    ValueError
        If a Welch segment is longer than the run.
    """
    if measure.estimator == "periodogram":
        frequency, density = periodogram(samples[None], sample_rate)
        return Spectrum(frequency, density[0], sample_rate / samples.size)
    if samples.size < measure.segment:
        raise ValueError(
            f"a run of {samples.size} samples holds no segment of {measure.segment}"
        )
    found = cross_spectra(samples[None], sample_rate, segment=measure.segment)
    return Spectrum(found.frequency, psd(found)[0], found.bin_width)


def peak_frequency(found: Spectrum, measure: Measure) -> float:
    """Return the frequency of the tallest, or first, peak [Hz]; NaN where there is none.

    The first peak is the lowest local maximum of at least a thousandth of the tallest.
    """
    high = measure.to_hz or np.inf
    inside = (found.frequency >= measure.from_hz) & (found.frequency <= high)
    inside &= found.frequency > 0.0
    frequency, density = found.frequency[inside], found.density[inside]
    tops = local_maxima(density)
    if tops.size == 0:
        return float("nan")
    tallest = tops[np.argmax(density[tops])]
    if measure.take == "first":
        tallest = tops[density[tops] >= SMALLEST * density[tallest]][0]
    return float(frequency[tallest])


def in_words(measure: Measure, bin_width: float) -> str:
    """Return how the peak frequency was found, for people. `bin_width` is in [Hz]."""
    how = "periodogram of the whole run"
    if measure.estimator == "welch":
        how = f"Welch density in segments of {measure.segment}"
    which = "tallest peak" if measure.take == "tallest" else "first peak"
    return f"peak frequency: {which} of the {measure.of} {how}, bins {bin_width:.4g} Hz"
