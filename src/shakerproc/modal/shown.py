"""Curves of a modal analysis: response functions, measured and of the model."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import spectra
from shakerproc.data import FloatArray
from shakerproc.modal.analysis import Functions
from shakerproc.modal.modal_model import ModalFit, response_functions
from shakerproc.modal.mode_set import ModeSet

SHOWN_SEGMENTS: Final = 8
"""Segments without overlap of which measured response functions are averages."""

MOST_SEGMENT: Final = 2**15
"""Samples of such a segment at most."""

Records: TypeAlias = Sequence[tuple[FloatArray, FloatArray]]
"""Inputs and responses of each record, (n_channels, n_samples) arrays."""


def cross_of(records: Records, sample_rate: float) -> spectra.CrossSpectra:
    """Return the spectra of inputs, then responses, of which functions are drawn.

    Parameters
    ----------
    records : sequence of (array, array)
        Inputs and responses of each record [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    """
    shortest = min(inputs.shape[1] for inputs, _ in records)
    return _pooled(records, sample_rate, _segment(shortest))


def _pooled(records: Records, sample_rate: float, segment: int) -> spectra.CrossSpectra:
    """Return spectra over the segments of all records."""
    found = [
        spectra.cross_spectra(
            np.concatenate(record),
            sample_rate,
            segment=segment,
            window="periodic hann",
            detrend="mean",
            inputs=range(len(record[0])),
        )
        for record in records
    ]
    counts = [one.n_segments for one in found]
    matrix = np.average([one.matrix for one in found], axis=0, weights=counts)
    density = np.average([one.density for one in found], axis=0, weights=counts)
    return replace(
        found[0],
        matrix=np.asarray(matrix, dtype=np.complex128),
        density=np.asarray(density, dtype=np.float64),
        n_segments=sum(counts),
    )


def _segment(n_samples: int) -> int:
    most = min(n_samples // SHOWN_SEGMENTS, MOST_SEGMENT)
    return max(8, 1 << max(most.bit_length() - 1, 3))


def functions_of(
    cross: spectra.CrossSpectra, records: Records, band: tuple[float, float], modes: ModeSet
) -> Functions | None:
    """Return response functions, measured and synthesised through the same window.

    Parameters
    ----------
    cross : CrossSpectra
        Of inputs, then responses, from `cross_of`.
    records : sequence of (array, array)
        Inputs and responses of each record [unit of the channel].
    band : (float, float)
        Limits [Hz].
    modes : ModeSet
        With their model; None is returned where there is none.
    """
    if modes.model is None:
        return None
    n_inputs = records[0][0].shape[0]
    rows = range(n_inputs, cross.n_channels)
    answers = [
        (inputs, _answer(inputs, cross.sample_rate, band, modes.model)) for inputs, _ in records
    ]
    model = _pooled(answers, cross.sample_rate, cross.segment)
    edge = 2.0 * cross.bin_width  # where the window mixes in what lies outside the band
    shown = (cross.frequency >= band[0] + edge) & (cross.frequency <= band[1] - edge)
    driven = range(n_inputs)
    return Functions(
        cross.frequency[shown],
        spectra.h1_of_inputs(cross, driven, rows)[..., shown],
        spectra.h1_of_inputs(model, driven, rows)[..., shown],
        spectra.multiple_coherence(cross, driven, rows)[..., shown],
    )


def _answer(
    inputs: FloatArray, sample_rate: float, band: tuple[float, float], model: ModalFit
) -> FloatArray:
    """Return the response of the model to the inputs within the band."""
    frequency = scipy.fft.rfftfreq(inputs.shape[1], 1.0 / sample_rate)
    inside = (frequency >= band[0]) & (frequency <= band[1])
    n_responses = model.residues.shape[1]
    synthesis = np.zeros((n_responses, frequency.size), dtype=np.complex128)
    synthesis[:, inside] = np.einsum(
        "oif,if->of",
        response_functions(model, frequency[inside]),
        scipy.fft.rfft(inputs)[:, inside],
    )
    return np.asarray(scipy.fft.irfft(synthesis, inputs.shape[1]))


def density_of(
    cross: spectra.CrossSpectra, n_inputs: int, band: tuple[float, float]
) -> FloatArray:
    """Return frequencies [Hz], then densities of the responses [unit²/Hz], as rows."""
    shown = (cross.frequency >= band[0]) & (cross.frequency <= band[1])
    return np.concatenate([
        cross.frequency[np.newaxis, shown],
        spectra.psd(cross)[n_inputs:, shown],
    ])
