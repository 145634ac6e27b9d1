"""What the recording of a test will hold: sweep against damping, averages, sample rate."""

from dataclasses import dataclass
from math import log
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.spectra import effective_averages, gain_random_error, window_samples
from shakerproc.testlog import Test, Welch, nominal_duration

ENOUGH: Final = 0.95
"""Share of the steady resonance that a sweep should reach [-]."""


@final
@dataclass(frozen=True, slots=True)
class Averaging:
    """What Welch's segments make of a random test.

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


def swept_peak(rate: float, frequency: float, damping_ratio: float) -> float:
    r"""Return the peak that a sweep reaches, as a share of the steady resonance [-].

    .. math:: \max_\tau \left| \int_0^\infty e^{-s + i \kappa (\tau - s)^2 / 2} ds \right|,
              \qquad \kappa = \frac{\dot f}{2 \pi \zeta^2 f_n^2}

    the envelope of a lightly damped mode under a sine whose frequency passes through it; the
    integral is a complex error function. Upwards and downwards it is the same.

    Parameters
    ----------
    rate : float
        How fast the frequency changes where it passes the resonance [Hz/s].
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Of the mode [-].

    References
    ----------
    .. [1] F. M. Lewis, "Vibration during acceleration through a critical speed", Transactions
       of the ASME 54, 253-261, 1932.
    """
    checks.positive("rate", rate, "Hz/s")
    checks.positive("frequency", frequency, "Hz")
    checks.positive("damping_ratio", damping_ratio, "-")
    kappa = rate / (2.0 * np.pi * (damping_ratio * frequency) ** 2)
    # The peak lags by a time constant where the sweep is slow, by 2 / sqrt(kappa) where fast.
    late = min(3.0, 8.0 / np.sqrt(kappa)) + 2.0 / np.sqrt(kappa)

    def envelope(time: float) -> float:
        root = np.sqrt(kappa / 2.0) * np.exp(-0.25j * np.pi)
        argument = (1.0 + 1j * kappa * time) / (2.0 * root)
        return float(abs(0.5 * np.sqrt(np.pi) / root * scipy.special.wofz(1j * argument)))

    times = np.linspace(0.0, late, 400)
    start = int(np.argmax([envelope(time) for time in times]))
    bounds = times[max(start - 1, 0)], times[min(start + 1, times.size - 1)]
    found = scipy.optimize.minimize_scalar(
        lambda time: -envelope(time), bounds=bounds, method="bounded", options={"xatol": 1e-9}
    )
    return float(-found.fun)


def fastest_rate(frequency: float, damping_ratio: float, share: float = ENOUGH) -> float:
    """Return the fastest sweep that reaches a share of the steady resonance [Hz/s].

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        Of the mode [-].
    share : float
        Of the steady peak, below 1 [-].
    """
    scale = (damping_ratio * frequency) ** 2
    root = scipy.optimize.brentq(
        lambda power: swept_peak(10.0**power * scale, frequency, damping_ratio) - share,
        -2.0,
        3.0,
        xtol=1e-6,
    )
    return float(10.0**root * scale)


def rate_at(test: Test, frequency: float) -> float | None:
    """Return how fast a sweep passes a frequency [Hz], in Hz/s; None for other tests."""
    if test.rate_oct_per_min is not None:
        return frequency * log(2.0) * test.rate_oct_per_min / 60.0
    return test.rate_hz_per_s


def duration_of_test(test: Test, otherwise: float | None = None) -> float | None:
    """Return how long a test runs [s]: by its sweep, by what the log expects, or as given."""
    swept = nominal_duration(test)
    if swept is not None:
        return swept
    return test.expect.duration if test.expect.duration is not None else otherwise


def averaging(
    welch: Welch, duration: float, sample_rate: float, coherence: float = 0.9
) -> Averaging | None:
    """Return what the segments of a random test are worth; None where not two of them fit.

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
