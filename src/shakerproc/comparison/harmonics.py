"""How the error spreads over harmonic orders, in sweeps and at steady tones."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.errors import share
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra import stepped_response, swept_response, tone_response

ORDERS: Final = 5
"""Harmonics that are followed, the fundamental included."""

_BLOCK_S: Final = 0.05
_LOUD: Final = 0.2


@final
@dataclass(frozen=True, slots=True, eq=False)
class HarmonicErrors:
    """Harmonics of one sensor in one test.

    Attributes
    ----------
    measured, predicted : (n_orders,) array
        Rms amplitude of each harmonic over that of the measured fundamental [-].
    error : (n_orders,) array
        Rms of the complex difference over the measured fundamental [-].
    """

    measured: FloatArray
    predicted: FloatArray
    error: FloatArray


def harmonic_errors(prediction: Prediction) -> tuple[HarmonicErrors, ...] | None:
    """Return the errors by harmonic order for every sensor, or None where there are no tones.

    They are followed over the whole recording, along the control signal.
    """
    followed = _followed(prediction)
    if followed is None:
        return None
    n = len(prediction.measured.sensors)
    return tuple(_errors(followed[1 + i], followed[1 + n + i]) for i in range(n))


def _followed(prediction: Prediction) -> ComplexArray | None:
    """Return the harmonics of input, measured and predicted rows: (n_rows, n_orders, n)."""
    measured = prediction.measured
    rows = np.concatenate([
        prediction.input[np.newaxis],
        prediction.response,
        prediction.predicted,
    ])
    rate, test = measured.sample_rate, measured.test
    rows = rows[:, shaken(prediction.input, rate)]
    try:
        if test.excitation == "sine sweep":
            sweeps = swept_response(rows, rate, [0], measured.excited, n_harmonics=ORDERS)
            return np.concatenate([sweep.harmonics for sweep in sweeps], axis=2)
        if test.excitation == "stepped sine":
            tones = stepped_response(rows, rate, [0], measured.excited, n_harmonics=ORDERS)
            return np.stack([tone.harmonics for tone in tones], axis=2)
        if test.excitation == "sine" and test.frequency_hz is not None:
            tone = tone_response(rows, rate, [0], frequency=test.frequency_hz)
            return tone.harmonics[:, :, np.newaxis]
    except SpectrumError:
        return None
    return None


def shaken(drive: FloatArray, sample_rate: float) -> slice:
    """Return the samples between which the input is a fifth of its loudest or more.

    `drive` is an (n,) array [m/s² or N], `sample_rate` in [Hz].
    """
    size = max(8, round(_BLOCK_S * sample_rate))
    n_blocks = drive.size // size
    if n_blocks < 4:
        return slice(0, drive.size)
    level = drive[: n_blocks * size].reshape(n_blocks, size).std(axis=1)
    loud = np.flatnonzero(level >= _LOUD * level.max())
    return slice(int(loud[0]) * size, int(loud[-1] + 1) * size)


def _errors(measured: ComplexArray, predicted: ComplexArray) -> HarmonicErrors:
    fundamental = _rms(measured[0])
    orders = range(len(measured))
    return HarmonicErrors(
        measured=np.array([share(_rms(measured[k]), fundamental) for k in orders]),
        predicted=np.array([share(_rms(predicted[k]), fundamental) for k in orders]),
        error=np.array([share(_rms(measured[k] - predicted[k]), fundamental) for k in orders]),
    )


def _rms(values: ComplexArray) -> float:
    """Return the rms of what is a number: a harmonic above half the sample rate is none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(np.abs(known) ** 2))) if known.size else 0.0
