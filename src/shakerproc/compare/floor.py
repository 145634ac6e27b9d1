"""The noise floor: the error that even the true model would have."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.compare.errors import Pair
from shakerproc.compare.measured import Measured
from shakerproc.compare.prediction import Prediction
from shakerproc.data import FloatArray
from shakerproc.spectra import cross_spectra, psd

Source: TypeAlias = Literal["quiet lead-in", "repeats", "incoherent part", "unknown"]

_SEGMENT: Final = 512


@final
@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """Noise of one test.

    Attributes
    ----------
    share : (n_sensors,) array
        Noise over response, both rms within the band; not a number where it is unknown [-].
    density : (n_sensors, n_frequencies) array
        Noise at the bins of the pair of spectra [unit^2/Hz].
    source : str
        Where it was taken from.
    """

    share: FloatArray
    density: FloatArray
    source: Source


def floors_of(predictions: Sequence[Prediction], pairs: Sequence[Pair]) -> tuple[Floor, ...]:
    """Return the noise floor of every test.

    The quiet lead-in tells the noise of the sensors, and the noise of the controls that the
    model passes on to its response (one that is not linear is simulated with it once more).
    Without one, tests that were run twice tell it, or else the part of the response that is not
    coherent with the input at the lowest level, which also holds what a nonlinear joint
    scatters there.
    """
    return tuple(
        _quiet(prediction, pair)
        or _repeated(i, predictions, pairs)
        or _incoherent(i, predictions, pairs)
        for i, (prediction, pair) in enumerate(zip(predictions, pairs, strict=True))
    )


def _floor(pair: Pair, density: FloatArray, source: Source) -> Floor:
    ratio = density.sum(axis=1) / np.maximum(pair.psd.sum(axis=1), np.finfo(float).tiny)
    return Floor(np.sqrt(ratio), density, source)


def _quiet(prediction: Prediction, pair: Pair) -> Floor | None:
    """Return the noise of sensors and controls at rest, the latter through the model."""
    measured = prediction.measured
    quiet = measured.quiet
    if quiet is None:
        return None
    own = _density(quiet.responses, measured, pair.frequency)
    if prediction.scatter is not None:
        through = _density(prediction.scatter, measured, pair.frequency)
    else:
        inputs = _density(quiet.controls, measured, pair.frequency)
        through = np.abs(pair.h1_model) ** 2 * inputs.sum(axis=0) / len(inputs) ** 2
        through = through * pair.excited
    return _floor(pair, own + through, "quiet lead-in")


def _density(rows: FloatArray, measured: Measured, frequency: FloatArray) -> FloatArray:
    """Return densities of noise, smoothed, at other frequencies."""
    segment = min(_SEGMENT, rows.shape[1])
    cross = cross_spectra(rows, measured.sample_rate, segment=segment)
    # bins 0 and 1 hold what is left of the mean
    return np.array([np.interp(frequency, cross.frequency[2:], row[2:]) for row in psd(cross)])


def _repeated(
    index: int, predictions: Sequence[Prediction], pairs: Sequence[Pair]
) -> Floor | None:
    """Return half the power by which a test differs from one that was run alike."""
    test, pair = predictions[index].measured.test, pairs[index]
    for other, its in zip(predictions, pairs, strict=True):
        twin = other.measured.test
        alike = (twin.excitation, twin.level, twin.band) == (
            test.excitation, test.level, test.band,
        )  # fmt: skip
        same = its.frequency.size == pair.frequency.size
        if other is not predictions[index] and test.level is not None and alike and same:
            density = 0.5 * np.abs(pair.h1 - its.h1) ** 2 * pair.input
            return _floor(pair, density, "repeats")
    return None


def _incoherent(index: int, predictions: Sequence[Prediction], pairs: Sequence[Pair]) -> Floor:
    """Return the incoherent part of the test with the smallest response."""
    lowest = min(range(len(pairs)), key=lambda i: float(np.mean(predictions[i].response ** 2)))
    pair, low = pairs[index], pairs[lowest]
    if low.averages < 4.0:
        return Floor(np.full(len(pair.psd), np.nan), np.zeros_like(pair.psd), "unknown")
    # what leaks between bins lowers the coherence of the noiseless model too
    lost = np.where(low.excited, np.maximum(0.0, low.coherence_model - low.coherence), 0.0)
    lost = lost * low.psd
    density = np.array([np.interp(pair.frequency, low.frequency, row) for row in lost])
    return _floor(pair, density, "incoherent part")


def worst(floor: Floor) -> float:
    """Return the floor of the noisiest sensor [-]."""
    known = floor.share[np.isfinite(floor.share)]
    return float(known.max()) if known.size else float("nan")
