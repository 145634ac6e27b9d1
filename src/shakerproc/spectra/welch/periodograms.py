"""The spectrum of a whole crop at once, without window or average."""

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray


def periodogram(samples: FloatArray, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    r"""Return the one-sided periodogram of each channel.

    .. math:: S_k = \frac{2}{f_s N} \Big| \sum_n x_n e^{-2 \pi i k n / N} \Big|^2

    (not doubled at 0 and at half the sample rate).

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples of the crop [unit of the channel].
    sample_rate : float
        Samples per second [Hz].

    Returns
    -------
    (n_frequencies,) array
        Frequencies [Hz].
    (n_channels, n_frequencies) array
        Densities [unit²/Hz].
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    n_samples = samples.shape[1]
    spectrum = np.array([np.abs(np.fft.rfft(row)) ** 2 for row in samples])
    spectrum /= sample_rate * n_samples
    spectrum[:, 1 : (n_samples + 1) // 2] *= 2.0
    return np.array(np.fft.rfftfreq(n_samples, 1.0 / sample_rate), dtype=np.float64), spectrum
