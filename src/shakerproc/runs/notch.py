"""A second look at a run, with one tone taken out."""

from typing import Final

import numpy as np

from shakerproc import spectra
from shakerproc.data import Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.averaging import welch
from shakerproc.runs.result import (
    NotchResult,
)
from shakerproc.spectra import Crop
from shakerproc.testlog import Test

FILTERED: Final = 2**20
"""Samples of each channel that a notch is cut into at most, from the middle."""


def notched(recording: Recording, crop: Crop, test: Test) -> tuple[NotchResult | None, str]:
    """Return the second look that the log asks for, or why it cannot be had."""
    if test.notch_hz is None:
        return None, ""
    longest = FILTERED
    part, problem = crop, ""
    if crop.n_samples > longest:
        first = crop.start + (crop.n_samples - longest) // 2
        part = Crop(first, first + longest)
        problem = (
            f"only {numeral(longest / recording.sample_rate, 4)} s from the middle were "
            "filtered"
        )
    try:
        return _without_tone(recording, part, test, test.notch_hz), problem
    except SpectrumError as error:
        return None, str(error)


def _without_tone(
    recording: Recording, crop: Crop, test: Test, frequency: float
) -> NotchResult:
    """Return the responses without the tone: two periods from the middle, and densities.

    One channel after the other, so that a long recording needs little memory.
    """
    rate, cut = recording.sample_rate, test.processing.notch
    before, after, density = [], [], []
    start, part = 0, slice(0)
    for row, channel in enumerate(recording.channels):
        if channel.role == "control":
            continue
        samples = recording.select([row]).samples(crop.start, crop.stop)
        result = spectra.notch(
            samples, rate, frequency, width=cut.width, harmonics=cut.harmonics, trim=cut.trim
        )
        n_samples, size = result.samples.shape[1], round(2.0 * rate / frequency) + 1
        first = max(0, (n_samples - size) // 2)
        start, part = result.start, slice(first, min(first + size, n_samples))
        before.append(samples[0, start + part.start : start + part.stop].copy())
        after.append(result.samples[0, part].copy())
        density.append(spectra.psd(welch(iter((result.samples,)), rate, test))[0])
    return NotchResult(
        frequency=frequency,
        time=(crop.start + start + np.arange(part.start, part.stop)) / rate,
        before=np.array(before),
        after=np.array(after),
        psd=np.array(density),
    )
