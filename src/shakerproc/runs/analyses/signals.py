"""Channels, frequencies and samples that several analyses of a run share."""

from collections.abc import Iterator, Sequence

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.result import RunResult
from shakerproc.spectra.response_spectra import HIGHEST, logarithmic_frequencies


def accelerations(result: RunResult, kind: str) -> list[int]:
    """Return the rows that are accelerations.

    Raises
    ------
    SpectrumError
        If there are none.
    """
    rows = [i for i, channel in enumerate(result.channels) if channel.unit == "m/s^2"]
    if not rows:
        raise SpectrumError(
            f"{kind}: no channel measures an acceleration; take {kind}: out of processing, or "
            "correct the units of the channels"
        )
    return rows


def natural_frequencies(
    result: RunResult, ends: tuple[float | None, float | None], per_octave: int, kind: str
) -> FloatArray:
    """Return natural frequencies of oscillators from the log's ends, or the data's.

    `ends` are frequencies [Hz].

    Raises
    ------
    SpectrumError
        If they reach beyond a tenth of the sample rate, or do not rise.
    """
    most = HIGHEST * result.sample_rate
    longest = result.sample_rate / result.crop.n_samples
    low = longest if ends[0] is None else ends[0]
    high = most if ends[1] is None else ends[1]
    if high > most * (1.0 + 1e-9):
        raise SpectrumError(
            f"{kind}: to is {high:g} Hz, above a tenth of the sample rate of "
            f"{result.sample_rate:g} Hz, where the samples do not show the peaks any more; "
            f"give to: {numeral(0.999 * most, 4)} Hz or less, or record faster"
        )
    if not low < high:
        raise SpectrumError(
            f"{kind}: from {low:g} Hz does not lie below to, {high:g} Hz; correct the log"
        )
    return logarithmic_frequencies(low, high, per_octave)


def offset_free(
    recording: Recording, result: RunResult, rows: Sequence[int]
) -> Iterator[FloatArray]:
    """Return the samples of the run in blocks, without the mean where the log detrends."""
    offset = np.zeros((len(rows), 1))
    if result.test.processing.detrend != "none":
        offset = result.statistics.mean[list(rows), np.newaxis]
    for block in recording.blocks(result.crop.start, result.crop.stop):
        yield block - offset
