"""Contents of a recording before a test: sweep against damping, averages, sample rate."""

from dataclasses import dataclass
from math import log
from typing import final

import numpy as np

from shakerproc.spectra import effective_averages, gain_random_error, window_samples
from shakerproc.testlog import Test, Welch, nominal_duration


@final
@dataclass(frozen=True, slots=True)
class Averaging:
    """Averages that Welch's segments give in a random test.

    Attributes
    ----------
    averages : float
        Independent averages that the overlapped segments are worth [-].
    density_error, gain_error : float
        Random errors of densities and of the gain at the assumed coherence, one standard
        deviation as a share [-].
    """

    averages: float
    density_error: float
    gain_error: float


def rate_at(test: Test, frequency: float) -> float | None:
    """Return how fast a sweep passes a frequency [Hz], in Hz/s; None for other tests."""
    if test.rate_oct_per_min is not None:
        return frequency * log(2.0) * test.rate_oct_per_min / 60.0
    return test.rate_hz_per_s


def duration_of_test(test: Test, otherwise: float | None = None) -> float | None:
    """Return how long a test runs [s]: by sweep or periods, as planned, expected or given."""
    needed = nominal_duration(test) or test.duration
    if needed is None and test.multisine is not None:
        needed = test.multisine.duration
    if needed is not None:
        return needed
    return test.expect.duration if test.expect.duration is not None else otherwise


def averaging(
    welch: Welch, duration: float, sample_rate: float, coherence: float = 0.9
) -> Averaging | None:
    """Return the averages of a random test; None where not two segments fit.

    Parameters
    ----------
    welch : Welch
        Segments, overlap and window.
    duration : float
        Length of the run [s].
    sample_rate : float
        Samples per second [Hz].
    coherence : float
        Assumed for the error of the gain [-].
    """
    step = welch.segment - welch.overlap
    segments = (round(duration * sample_rate) - welch.segment) // step + 1
    if segments < 2:
        return None
    window = window_samples(welch.window, welch.segment)
    averages = effective_averages(window, step, segments)
    if averages <= 1.0:
        return None
    return Averaging(
        averages,
        averages**-0.5,
        float(gain_random_error(np.array([coherence]), averages)[0]),
    )


def sample_rate_of_test(test: Test, otherwise: float | None = None) -> float | None:
    """Return the sample rate that the log says [Hz], or the given one."""
    return test.processing.sample_rate or test.expect.sample_rate or otherwise
