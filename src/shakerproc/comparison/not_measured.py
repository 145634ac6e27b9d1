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
from shakerproc.numerals import numeral
from shakerproc.recordings import (
    FAULTS,
    MOST_LOST,
    Flag,
    file_flags,
    health,
    unusable,
    within,
)
from shakerproc.spectra import periodogram
from shakerproc.testlog import Test

MOST_RATIO: Final = 1e8
"""Responses above so many times the drive, or below its inverse, have a wrong unit [-]."""

AROUND: Final = (0.8, 1.25)
"""Band of a sine over its frequency: a third of an octave to both sides [-]."""

MOST_OF_IT: Final = 0.5
"""Share of the power of a drive that lies in the band of its sine: the larger half [-]."""


class NotMeasuredError(DiagnosisError):
    """A channel that a model needs did not measure in a test."""


def check_measured(
    recording: Recording, samples: FloatArray, part: Part, rows: list[int], clipped: float
) -> tuple[str, ...]:
    """Return what else is wrong with a test of which every channel that is needed measured.

    Of several that did not, the first of `rows` is named: where the controls are dead, no
    response has anything in common with them. Not being numbers goes before all else.

    `samples` are in the units of the channels, `clipped` is a share [-].

    Raises
    ------
    NotMeasuredError
        If one was not.
    """
    rate = recording.sample_rate
    looked_at = recording_of_arrays(recording.run, recording.channels, samples, rate)
    start, stop = ((at - part.first) / rate for at in (part.start, part.stop))
    needed = [recording.channels[row].name for row in rows]
    found = [
        f for f in health(replace(looked_at, driven=recording.driven)) if f.channel in needed
    ]
    for flag in sorted(
        found, key=lambda f: (f.kind != "not a number", needed.index(f.channel))
    ):
        most = {"clipping": clipped, "not a number": 0.0}.get(flag.kind, MOST_LOST)
        if unusable([flag], start, stop, most=most):
            raise NotMeasuredError(
                f"{recording.run} is left out: {flag.channel} "
                f"{FAULTS.get(flag.kind, flag.kind)}. {flag.message}"
                f"{_since(flag, part.first / rate)}"
            )
    told = [flag.line for flag in file_flags(recording)]
    told += [f"{f.line}{_since(f, part.first / rate)}" for f in within(found, start, stop)]
    return tuple(f"{recording.run}: {line}" for line in told)


def _since(flag: Flag, start: float) -> str:
    """Return from when on the times of a flag count, if not from 0 s."""
    return f" (Times count from {start:.6g} s on.)" if start and flag.start else ""


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
                f"{recording.run} is left out: {channel.name} has {numeral(size[row])} "
                f"{channel.unit} rms, {numeral(ratio, 2)} times the drive. Check its unit and "
                "sensitivity in the log."
            )


def check_frequency(
    recording: Recording, test: Test, samples: FloatArray, inputs: list[int]
) -> None:
    """Pass a drive that is the sine that the log says, where it says one.

    Parameters
    ----------
    recording : Recording
        The recording.
    test : Test
        What the log says of it.
    samples : (n_channels, n_samples) array
        The run.
    inputs : list of int
        Rows of what drives the model.

    Raises
    ------
    NotMeasuredError
        If most of its power lies elsewhere than `AROUND` that frequency: it would be compared
        in a band in which nothing moves.
    """
    if not inputs or test.frequency_hz is None or test.band is not None:
        return
    drive = samples[inputs].mean(axis=0)
    level = (drive - drive.mean())[np.newaxis]
    frequency, (power,) = periodogram(level, recording.sample_rate)
    low, high = (share * test.frequency_hz for share in AROUND)
    inside = float(power[(frequency >= low) & (frequency <= high)].sum() / power.sum())
    if inside < MOST_OF_IT:
        name = recording.channels[inputs[0]].name
        raise NotMeasuredError(
            f"{recording.run} is left out: the log says a sine of {test.frequency_hz:g} Hz, "
            f"but {name} has most power at {numeral(frequency[power.argmax()])} Hz, and "
            f"{numeral(inside, 2)} of it from {numeral(low)} to {numeral(high)} Hz. Correct "
            "frequency in the log."
        )
