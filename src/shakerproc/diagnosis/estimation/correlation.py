"""How many neighbouring residuals are worth one independent one."""

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray


def correlation_of(rows: list[FloatArray]) -> float:
    """Return how many neighbouring residuals are worth one independent one, at least 1.

    References
    ----------
    .. [1] M. S. Bartlett, "On the theoretical specification and sampling properties of
       autocorrelated time-series", Journal of the Royal Statistical Society Supplement 8,
       27-41, 1946: the sum of the squared autocorrelation.
    """
    squared, power = 0.0, 0.0
    for row in rows:
        size = scipy.fft.next_fast_len(2 * row.shape[1], real=True)
        spectrum = np.abs(scipy.fft.rfft(row, size, axis=1)) ** 2
        squared += 2.0 * float(np.sum(spectrum**2)) / size
        power += float(np.sum(np.sum(row**2, axis=1) ** 2))
    return max(1.0, squared / power) if power > 0.0 else 1.0
