"""Where a structure is left to itself."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.hammer.strikes import LOUD, NORMAL

DRIVEN: Final = 0.05
"""Share of the largest input below which it drives no more [-]: what a hammer or a table rings
with after a pulse."""

FREE: Final = 0.05
"""Share of a run that its free part lasts at least [-]: less is the end of a test, no decay."""


def free_start(samples: FloatArray, inputs: FloatArray) -> int:
    """Return the first sample of the free part of a run.

    Parameters
    ----------
    samples : (n_responses, n_samples) array
        The responses [unit of the channel].
    inputs : (n_inputs, n_samples) array
        Forces or controls, if any: the free part begins when the last of them is at rest.
        Without any it begins at the largest motion of all responses [unit of the channel].

    Raises
    ------
    SpectrumError
        If less than `FREE` of the run is left.
    """
    n_samples = samples.shape[1]
    if inputs.shape[0]:
        starts = [_at_rest(row) for row in inputs]
        why = "the input moves to its end"
    else:
        rest = samples - np.median(samples, axis=1, keepdims=True)
        power = np.mean(rest**2, axis=1, keepdims=True)
        shares = np.divide(rest**2, power, out=np.zeros_like(rest), where=power > 0.0)
        starts = [int(np.argmax(shares.sum(axis=0))) + 1]
        why = "the largest motion is at its end, and no channel is an input"
    start = max(starts)
    if start > (1.0 - FREE) * n_samples:
        raise SpectrumError(
            f"no free part: {why}; record until the motion has died away, give the input the "
            "role force or control and what is none another, or crop: {from: ..., to: ...}"
        )
    return start


def _at_rest(row: FloatArray) -> int:
    """Return the sample after the last at which an input drives, the end if it never rests."""
    size = np.abs(row - np.median(row))
    noise = LOUD * NORMAL * float(np.median(size))
    largest = float(size.max())
    if largest <= noise:
        return row.size
    return int(np.flatnonzero(size > max(DRIVEN * largest, noise))[-1]) + 1
