"""The inner loops of shock and fatigue spectra, compiled once and kept on disk."""

import numba
import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray

jit = numba.njit(cache=True, nogil=True)


@jit
def follow_oscillators(  # noqa: PLR0917  (compiled functions have no keyword-only arguments)
    samples: FloatArray,
    steps: FloatArray,
    substeps: NDArray[np.int64],
    damping: float,
    states: FloatArray,
    extremes: FloatArray,
) -> None:
    """Carry oscillators on over a block; widen their extremes.

    `states` (n_channels, n_frequencies, 3) holds displacement, velocity and the last input,
    `extremes` (n_channels, n_frequencies, 3, 2) least and largest displacement, velocity and
    absolute acceleration.
    """
    n_channels, n_samples = samples.shape
    for channel in range(n_channels):
        for j in range(substeps.size):
            a, b, c, d = steps[j, 0, 0], steps[j, 0, 1], steps[j, 1, 0], steps[j, 1, 1]
            p, q, r, s = steps[j, 0, 2], steps[j, 0, 3], steps[j, 1, 2], steps[j, 1, 3]
            y, v, last = states[channel, j, 0], states[channel, j, 1], states[channel, j, 2]
            limits = extremes[channel, j]
            for k in range(n_samples):
                rise = (samples[channel, k] - last) / substeps[j]
                for _ in range(substeps[j]):
                    following = last + rise
                    ahead = a * y + b * v + p * last + q * following
                    v = c * y + d * v + r * last + s * following
                    y, last = ahead, following
                    acceleration = -y - 2.0 * damping * v
                    limits[0, 0] = min(limits[0, 0], y)
                    limits[0, 1] = max(limits[0, 1], y)
                    limits[1, 0] = min(limits[1, 0], v)
                    limits[1, 1] = max(limits[1, 1], v)
                    limits[2, 0] = min(limits[2, 0], acceleration)
                    limits[2, 1] = max(limits[2, 1], acceleration)
                last = samples[channel, k]
            states[channel, j, 0], states[channel, j, 1], states[channel, j, 2] = y, v, last
