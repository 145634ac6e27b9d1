"""Channels that a model needs and that did not measure."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.comparison.part import Part
from shakerproc.data import (
    FloatArray,
    Recording,
    recording_of_arrays,
)
from shakerproc.errors import DiagnosisError
from shakerproc.recordings import FAULTS, MOST_LOST, measuring, unusable

MOST_RATIO: Final = 1e8
"""Responses above so many times the drive, or below its inverse, have a wrong unit [-]."""


class NotMeasuredError(DiagnosisError):
    """A channel that a model needs did not measure in a test."""


def check_measured(
    recording: Recording, samples: FloatArray, part: Part, rows: list[int], clipped: float
) -> None:
    """Pass the samples of a test of which every channel that is needed was measured.

    Of several that were not, the first of `rows` is named: where the controls are dead, no
    response has anything in common with them. Not being numbers goes before all else.

    `samples` are in the units of the channels, `clipped` is a share [-].

    Raises
    ------
    NotMeasuredError
        If one was not.
    """
    judged = samples[:, part.start - part.first : part.stop - part.first]
    seen = recording_of_arrays(recording.run, recording.channels, judged, recording.sample_rate)
    needed = [recording.channels[row].name for row in rows]
    found = [
        f for f in measuring(replace(seen, driven=recording.driven)) if f.channel in needed
    ]
    for flag in sorted(
        found, key=lambda f: (f.kind != "not a number", needed.index(f.channel))
    ):
        most = {"clipping": clipped, "not a number": 0.0}.get(flag.kind, MOST_LOST)
        if unusable([flag], 0.0, seen.duration, most=most):
            start = part.start / recording.sample_rate
            since = ""
            if start and flag.start:
                since = f" (Times count from {start:.6g} s on, where the crop begins.)"
            raise NotMeasuredError(
                f"{recording.run} is left out: {flag.channel} "
                f"{FAULTS.get(flag.kind, flag.kind)}. {flag.message}{since}"
            )


def check_sizes(
    recording: Recording, samples: FloatArray, inputs: list[int], rows: list[int]
) -> None:
    """Pass responses that are not out of all proportion to what drives them.

    Raises
    ------
    NotMeasuredError
        If one is, as no structure and no sensor makes it, but a wrong unit does.
    """
    if not inputs:
        return
    size = np.sqrt(np.mean(np.square(samples), axis=1))
    drive = float(size[inputs].max())
    for row in rows:
        channel = recording.channels[row]
        ratio = (
            float(size[row]) / drive
            if channel.unit == recording.channels[inputs[0]].unit
            else 1.0
        )
        if not 1.0 / MOST_RATIO <= ratio <= MOST_RATIO:
            raise NotMeasuredError(
                f"{recording.run} is left out: {channel.name} has {size[row]:.3g} "
                f"{channel.unit} rms, {ratio:.2g} times the drive. Check its unit and "
                "sensitivity in the log."
            )
