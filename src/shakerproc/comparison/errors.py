"""How far model and measurement differ: in time, in densities, in response functions."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.free_run_error import relative_errors
from shakerproc.comparison.prediction import Prediction
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal import mac
from shakerproc.spectra import CrossSpectra, coherence, cross_spectra, h1, psd

LOBE: Final = 4.0
"""Width of the main lobe of a Hann or Hamming window [bins]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """Measured and predicted spectra of every sensor of one test, against the same input.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Bins within the compared band [Hz].
    excited : (n_frequencies,) array of bool
        Whether a bin lies in the excited band.
    input : (n_frequencies,) array
        Density of the input [(m/s^2)^2/Hz or N^2/Hz].
    psd, psd_model : (n_sensors, n_frequencies) array
        Densities of what was measured and predicted [unit^2/Hz].
    h1, h1_model : (n_sensors, n_frequencies) complex array
        Response functions [unit / unit of the input].
    coherence, coherence_model : (n_sensors, n_frequencies) array
        Coherence with the input [-].
    residual : (n_sensors, n_frequencies) array
        Density of measured less predicted [unit^2/Hz].
    averages : float
        Effective number of averages [-].
    resolution : float
        Distance of the bins [Hz].
    """

    frequency: FloatArray
    excited: NDArray[np.bool_]
    input: FloatArray
    psd: FloatArray
    psd_model: FloatArray
    h1: ComplexArray
    h1_model: ComplexArray
    coherence: FloatArray
    coherence_model: FloatArray
    residual: FloatArray
    averages: float
    resolution: float


@final
@dataclass(frozen=True, slots=True)
class SensorErrors:
    """Errors of one sensor in one test, each as a share of what was measured.

    Attributes
    ----------
    error : float
        The free-run error: rms of measured less simulated over rms measured [-].
    psd : float
        Difference of the square roots of the densities, bin by bin [-].
    psd_db : float
        Rms over the excited bins of the ratio of the densities [dB].
    h1 : float
        Rms of the difference of the response functions, weighted with the input [-].
    frac : float or None
        Frequency response assurance criterion over the excited bins: 1 where the response
        functions differ by a factor only [-]; None of a single bin.
    coherence : float
        Mean difference of the coherences over the excited bins, model less measurement [-].
    peak_hz, peak_model_hz : float
        Where the response function is largest within the excited band [Hz].
    peak_gain, peak_model_gain : float
        How large it is there [unit / unit of the input].
    rms, rms_model : float
        Of the response within the band [unit].
    """

    error: float
    psd: float
    psd_db: float
    h1: float
    frac: float | None
    coherence: float
    peak_hz: float
    peak_model_hz: float
    peak_gain: float
    peak_model_gain: float
    rms: float
    rms_model: float


def pair_of(prediction: Prediction) -> Pair:
    """Return the spectra of a prediction and of what was measured."""
    measured = prediction.measured
    n = len(measured.sensors)
    rows = np.concatenate([
        prediction.input[np.newaxis],
        prediction.response,
        prediction.predicted,
        prediction.residual,
    ])
    cross = cross_spectra(rows, measured.sample_rate, segment=segment_of(prediction))
    inside = _within(cross.frequency, measured.band)
    density = psd(cross)[:, inside]
    sensors, models = range(1, n + 1), range(n + 1, 2 * n + 1)
    frequency = cross.frequency[inside]
    lit = _within(frequency, measured.excited)
    return Pair(
        frequency=frequency,
        excited=lit,
        input=density[0],
        psd=density[1 : n + 1],
        psd_model=density[n + 1 : 2 * n + 1],
        h1=_h1(cross, sensors)[:, inside],
        h1_model=_h1(cross, models)[:, inside],
        coherence=_coherence(cross, sensors)[:, inside],
        coherence_model=_coherence(cross, models)[:, inside],
        residual=density[2 * n + 1 :],
        averages=cross.effective_averages,
        resolution=float(cross.frequency[1]),
    )


def _within(frequency: FloatArray, band: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which bins lie in a band; of a band between two bins, the one next to it."""
    low, high = band
    inside: NDArray[np.bool_] = (frequency >= low) & (frequency <= high)
    if not inside.any():
        inside[1 + np.argmin(np.abs(frequency[1:] - np.sqrt(low * high)))] = True
    return inside


def segment_of(prediction: Prediction) -> int:
    """Return the length of Welch segments: the log's, or longer where the run allows it.

    The resonances of joints are narrower than the 5.6 Hz of the usual 1024 samples; 24
    segments are kept at least. The excited band is as wide as the main lobe of the window, so
    that a tone is seen in it, as far as the run is long enough.
    """
    measured, most = prediction.measured, prediction.input.size
    wanted = measured.test.processing.welch.segment
    while wanted * 2 <= most // 24 and wanted < 8192:
        wanted *= 2
    low, high = measured.excited
    return min(max(wanted, round(LOBE * measured.sample_rate / (high - low))), most)


def _h1(cross: CrossSpectra, rows: range) -> ComplexArray:
    return h1(cross, [0], list(rows))


def _coherence(cross: CrossSpectra, rows: range) -> FloatArray:
    return coherence(cross, [0], list(rows))


def errors_of(prediction: Prediction, pair: Pair) -> tuple[SensorErrors, ...]:
    """Return the errors of every sensor in one test."""
    errors = relative_errors(prediction.scored)
    return tuple(
        _sensor_errors(prediction, pair, i, float(error)) for i, error in enumerate(errors)
    )


def _sensor_errors(prediction: Prediction, pair: Pair, i: int, error: float) -> SensorErrors:
    rms, rms_model = (
        float(np.sqrt(np.mean(x[i] ** 2))) for x in (prediction.response, prediction.predicted)
    )
    amplitude, amplitude_model = np.sqrt(pair.psd[i]), np.sqrt(pair.psd_model[i])
    lit, gain, gain_model = pair.excited, np.abs(pair.h1[i]), np.abs(pair.h1_model[i])
    peak, peak_model = (int(np.argmax(np.where(lit, g, 0.0))) for g in (gain, gain_model))
    return SensorErrors(
        error=error,
        psd=share(_norm(amplitude - amplitude_model), _norm(amplitude)),
        psd_db=_decibels(pair.psd[i, lit], pair.psd_model[i, lit]),
        h1=share(
            _norm(np.abs(pair.h1[i] - pair.h1_model[i]) * np.sqrt(pair.input) * lit),
            _norm(gain * np.sqrt(pair.input) * lit),
        ),
        frac=frac(pair.h1[i, lit], pair.h1_model[i, lit]) if lit.sum() > 1 else None,
        coherence=float(np.mean((pair.coherence_model[i] - pair.coherence[i])[lit])),
        peak_hz=float(pair.frequency[peak]),
        peak_model_hz=float(pair.frequency[peak_model]),
        peak_gain=float(gain[peak]),
        peak_model_gain=float(gain_model[peak_model]),
        rms=rms,
        rms_model=rms_model,
    )


def frac(measured: ComplexArray, model: ComplexArray) -> float:
    r"""Return the frequency response assurance criterion of two response functions.

    .. math:: FRAC = \frac{|H^H \hat H|^2}{(H^H H)(\hat H^H \hat H)}

    It is the MAC along frequency: 1 where both differ by a factor only.

    Parameters
    ----------
    measured, model : (n_lines,) complex array
        The same lines of both, in any unit [-].

    Returns
    -------
    float
        0 to 1 [-]; 1 of a single line, which tells nothing.

    References
    ----------
    .. [1] W. Heylen and S. Lammens, "FRAC: a consistent way of comparing frequency response
       functions", International Conference on Identification in Engineering, 1996, 48-57.
    """
    return float(mac(measured, model)[0, 0])


def share(part: float, whole: float) -> float:
    """Return a part over a whole; 0 of nothing [-]."""
    return part / whole if whole > 0.0 else 0.0


def _norm(values: FloatArray) -> float:
    return float(np.sqrt(np.sum(values**2)))


def _decibels(density: FloatArray, density_model: FloatArray) -> float:
    """Return the rms ratio of two densities where both are above 0 [dB]."""
    both = (density > 0.0) & (density_model > 0.0)
    if not both.any():
        return 0.0
    ratio = 10.0 * np.log10(density[both] / density_model[both])
    return float(np.sqrt(np.mean(ratio**2)))
