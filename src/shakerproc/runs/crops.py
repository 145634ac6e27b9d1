"""Which part of a recording is the run, and which channel says so."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.errors import LogError
from shakerproc.numerals import numeral
from shakerproc.runs.result import (
    shown_unit,
)
from shakerproc.runs.roles import row_named, uses_of, without_tachometers
from shakerproc.spectra import Crop
from shakerproc.testlog import Test, ThresholdCrop, TimeCrop

DECIDES: Final = 0.5
"""Offset over the threshold from which on it decides the crop: more than what is left [-]."""

MEDIAN_OF: Final = 2**17
"""Samples from which a median is taken: to 0.4 % of the standard deviation, of noise."""


def _wanted_crop(test: Test) -> TimeCrop | ThresholdCrop | None:
    """Return how the log crops a test: what dies away is below any threshold, and whole."""
    crop = test.processing.crop
    return None if test.rings and isinstance(crop, ThresholdCrop) else crop


def find_crop(recording: Recording, test: Test) -> Crop:
    """Return the part of a recording that is the run."""
    crop = _wanted_crop(test)
    if crop is None:
        return Crop(0, recording.n_samples)
    if isinstance(crop, TimeCrop):
        return spectra.crop_by_time(
            recording.n_samples, recording.sample_rate, crop.start, crop.stop
        )
    only = recording.select([crop_row(recording, test, crop.channel)])
    rest = 0.0 if crop.remove_offset else _rest(only)
    decides = abs(rest) >= DECIDES * crop.threshold
    blocks = (block - rest for block in _first(only)) if decides else _first(only)
    unit, scale = shown_unit(only.channels[0].unit)
    found = spectra.crop_by_threshold(
        list(blocks) if crop.remove_offset else blocks,
        crop.threshold,
        recording.sample_rate,
        absolute=crop.absolute,
        hold=crop.hold,
        skip=crop.skip,
        remove_offset=crop.remove_offset,
        shown=(unit, scale),
    )
    if not decides:
        return found
    told = (
        f"{only.channels[0].name} rests at {numeral(scale * rest, 4)} {unit}, against a "
        f"threshold of {numeral(scale * crop.threshold, 4)} {unit}: the crop compares it "
        "without that offset"
    )
    return replace(found, warning="; ".join(filter(None, (told, found.warning))))


def _rest(recording: Recording) -> float:
    """Return the median of the one channel: where it rests, or moves about [its unit].

    Of a long recording it is that of every so many samples; a shock does not shift it, as it
    does the mean.
    """
    every = max(1, recording.n_samples // MEDIAN_OF)
    return float(np.nanmedian(np.concatenate([block[::every] for block in _first(recording)])))


def crop_channel(recording: Recording, test: Test) -> int | None:
    """Return the row that a threshold is compared with, None where there is none.

    Of the channels without the tachometers.
    """
    crop = _wanted_crop(test)
    if crop is None or isinstance(crop, TimeCrop):
        return None
    channel = recording.channels[crop_row(recording, test, crop.channel)]
    kept = without_tachometers(recording).channels
    return next((i for i, one in enumerate(kept) if one is channel), None)


def _first(recording: Recording) -> Iterator[FloatArray]:
    return (block[0] for block in recording.blocks())


def crop_row(recording: Recording, test: Test, wanted: str | int) -> int:
    """Return the row of the channel that the crop looks at.

    Parameters
    ----------
    recording : Recording
        The recording.
    test : Test
        Its channels, by their keys in the log.
    wanted : str or int
        Name of the channel, its key in the log, or ``control 2`` for the second control.

    Raises
    ------
    LogError
        If there is none.
    """
    used = [use.key for use in uses_of(recording, test)]
    if wanted in used:
        return used.index(wanted)
    row = row_named(recording.channels, wanted)
    if row is not None:
        return row
    controls = [i for i, c in enumerate(recording.channels) if c.role == "control"]
    word, _, number = str(wanted).partition(" ")
    if word == "control" and controls:
        return controls[min(int(number), len(controls)) - 1 if number.isdigit() else -1]
    there = ", ".join(c.name for c in recording.channels)
    raise LogError(
        f"{recording.run}: no channel {wanted!r} to crop by. The recording has {there}. Name "
        "one of them in crop: {channel: ...}, give a channel the role control, or use "
        "crop: none (or --no-crop)."
    )
