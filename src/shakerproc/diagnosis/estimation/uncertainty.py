"""Uncertainty of each sample of a response, of the measurement alone."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test

MODEL_SHARE: Final = 1e-3
"""Share of a response to which no model is held: calibration, noise of the controls [-]."""

ENVELOPE_S: Final = 0.05
"""Length over which the size of a response is taken: some periods of most resonances [s]."""


def uncertainty(test: Test) -> FloatArray:
    """Return the standard deviation of each sample, (n_sensors, n) array.

    Noise of the sensor, and a share of the response as it is just then.
    """
    size = max(8, round(ENVELOPE_S * test.sample_rate))
    squared = scipy.ndimage.uniform_filter1d(test.responses**2, size, axis=1)
    local = MODEL_SHARE * np.sqrt(np.maximum(squared, 0.0))
    found: FloatArray = np.hypot(np.maximum(test.noise, 1e-300)[:, None], local)
    return found
