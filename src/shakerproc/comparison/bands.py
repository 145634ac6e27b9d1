"""Where in frequency the model fails: third octaves, test by test."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.errors import Pair
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import FloatArray

PER_OCTAVE: Final = 3
"""Bands in an octave."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class BandErrors:
    """Errors by frequency band, test and sensor.

    Attributes
    ----------
    edges : (n_bands + 1,) array
        Limits of the bands [Hz].
    error : (n_tests, n_sensors, n_bands) array
        Unexplained over measured rms within the band; not a number where a test has no bin
        or no response there [-].
    floor : (n_tests, n_sensors, n_bands) array
        Noise over measured rms within the band [-].
    share : (n_tests, n_sensors, n_bands) array
        Part of all that the model leaves of the sensor in that test, as power [-].
    driven : (n_tests, n_bands) array of bool
        Whether the middle of the band is driven in that test; of a drive that is narrower than
        a band, the band that holds it.
    """

    edges: FloatArray
    error: FloatArray
    floor: FloatArray
    share: FloatArray
    driven: NDArray[np.bool_]


def band_errors(
    predictions: Sequence[Prediction], pairs: Sequence[Pair], densities: Sequence[FloatArray]
) -> BandErrors:
    """Return the residual of the model in each third-octave band.

    Parameters
    ----------
    predictions, pairs : sequence of Prediction, sequence of Pair
        Of each test.
    densities : sequence of (n_sensors, n_frequencies) array
        Of the noise at the bins of each pair [unit^2/Hz].
    """
    low = min(prediction.measured.band[0] for prediction in predictions)
    high = max(prediction.measured.band[1] for prediction in predictions)
    n_bands = max(1, int(np.ceil(np.log2(high / low) * PER_OCTAVE)))
    edges = low * 2.0 ** (np.arange(n_bands + 1) / PER_OCTAVE)
    left, whole, noise = (
        np.array([_in_bands(edges, pair, of) for pair, of in zip(pairs, rows, strict=True)])
        for rows in (
            [pair.residual for pair in pairs],
            [pair.psd for pair in pairs],
            densities,
        )
    )
    known = whole > 0.0
    base = np.where(known, whole, 1.0)
    total = left.sum(axis=2, keepdims=True)
    return BandErrors(
        edges=edges,
        error=np.where(known, np.sqrt(left / base), np.nan),
        floor=np.where(known, np.sqrt(noise / base), np.nan),
        share=left / np.where(total > 0.0, total, 1.0),
        driven=np.array([_driven(edges, p.measured.excited) for p in predictions]),
    )


def _driven(edges: FloatArray, excited: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which bands are driven, (n_bands,) array."""
    middle = np.sqrt(edges[1:] * edges[:-1])
    inside: NDArray[np.bool_] = (middle >= excited[0]) & (middle <= excited[1])
    if not inside.any():
        inside[np.argmin(np.abs(np.log(middle**2 / (excited[0] * excited[1]))))] = True
    return inside


def _in_bands(edges: FloatArray, pair: Pair, rows: FloatArray) -> FloatArray:
    """Return the power of rows in bands, (n_sensors, n_bands) array."""
    which = np.searchsorted(edges, pair.frequency, side="right") - 1
    out = np.zeros((len(rows), edges.size - 1))
    for band in range(edges.size - 1):
        out[:, band] = rows[:, which == band].sum(axis=1)
    return out
