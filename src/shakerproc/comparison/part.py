"""Which part of a recording is looked at, and which part of that is judged."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import (
    FloatArray,
    Recording,
    recording_of_arrays,
)
from shakerproc.errors import DiagnosisError, SpectrumError
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
from shakerproc.runs import find_crop
from shakerproc.runs.roles import moving
from shakerproc.spectra import periodogram
from shakerproc.spectra.decays import free_start
from shakerproc.testlog import Test
from shakerproc.testlog.excitation import PULSES

PASSING: Final = frozenset({"sine sweep", "stepped sine", "shock", "hammer"})
"""Excitations that do not do the same all the time."""

PARTS: Final = 16
"""Steps in which the loudest part is sought, over its length."""

RUN_IN: Final = 16
"""The model runs in for this share of the part that is judged: its inverse [-]."""

FEW_PERIODS: Final = 10
r"""Periods of the motion below which an error is said to be known roughly.

The rms of :math:`n` periods is known to :math:`1 / (2 \sqrt{n})`, 16 % here: Bendat and
Piersol, "Random Data", 4th ed., eq. 8.58, with one independent value a period.
"""


@final
@dataclass(frozen=True, slots=True)
class Part:
    """Part of a recording that is used, `first` to `last`, and judged, `start` to `stop`."""

    first: int
    last: int
    start: int
    stop: int
    notes: tuple[str, ...] = ()


def part_of(recording: Recording, test: Test, most: int) -> Part:
    """Return the samples to be judged; where the crop finds nothing, all of them.

    The model begins at rest: where the part does not, it runs in before it is judged.
    """
    n, notes = recording.n_samples, []
    try:
        crop = find_crop(recording, test)
        start, stop = crop.start, crop.stop
    except SpectrumError:
        start, stop = 0, n
        notes.append(
            f"{recording.run}: the crop of the log finds no run, so all of it is compared."
        )
    if stop - start > most:
        whole = (stop - start) / recording.sample_rate
        start = _loudest(recording, test, start, stop, most)
        stop = start + most
        notes.append(
            f"{recording.run}: used {numeral(most / recording.sample_rate, 4)} s of "
            f"{numeral(whole, 4)} s, from {numeral(start / recording.sample_rate, 4)} s on."
        )
    if n <= 2 * most:
        return Part(0, n, start, stop, tuple(notes))
    first = 0 if start <= most else start - most // RUN_IN
    return Part(first, stop, start, stop, tuple(notes))


def few_periods(run: str, motion: FloatArray) -> list[str]:
    """Return the note that motion holds few periods, of the channel that moves most.

    Parameters
    ----------
    run : str
        Opens the message.
    motion : (n_channels, n_samples) array
        What was measured on the structure, in the units of the channels.

    Raises
    ------
    DiagnosisError
        If nothing moves.
    """
    n_periods, size = periods_of(motion), motion.shape[1]
    if not np.any(np.ptp(np.nan_to_num(motion), axis=1) > 0.0):
        raise DiagnosisError(
            f"{run}: nothing moves in the {size} samples that are compared. Crop less, "
            "or record longer."
        )
    if n_periods >= FEW_PERIODS:
        return []
    known = 0.5 / np.sqrt(max(n_periods, 1))
    return [
        f"{run}: the {size} samples that are compared hold {n_periods} periods of the "
        f"motion, so the error is known to {known:.0%} only; a longer record tells more."
    ]


def periods_of(motion: FloatArray) -> int:
    """Return how many periods the channel that moves most holds, an (n_channels, n) array."""
    motion = np.nan_to_num(motion)
    motion = motion - motion.mean(axis=1, keepdims=True)
    above = motion[int(np.argmax(motion.std(axis=1)))] > 0.0
    return int(np.count_nonzero(above[1:] & ~above[:-1]))


def free_part(recording: Recording, test: Test, part: Part, rows: list[int]) -> Part:
    """Return the part in which the structure is left to itself; what is before tells nothing.

    Raises
    ------
    DiagnosisError
        If the test is driven all along, or has no free part.
    """
    if test.excitation not in (None, *PULSES):
        raise DiagnosisError(
            f"{recording.run}: its excitation is {test.excitation}, but nothing excites the "
            "model, which takes a free decay. Give what excites it in the model: "
            "{base: acceleration}, say."
        )
    samples = recording.samples(part.start, part.stop)
    driving = [i for i, c in enumerate(recording.channels) if c.role in {"control", "force"}]
    try:
        start = part.start + free_start(samples[rows], samples[driving])
    except SpectrumError as error:
        raise DiagnosisError(f"{recording.run}: {error}") from error
    return replace(part, first=start, start=start, last=part.stop)


def _loudest(recording: Recording, test: Test, start: int, stop: int, size: int) -> int:
    """Return where the most telling part of so many samples begins.

    Steady vibration is the same everywhere: its beginning, which shows the noise before it. A
    sweep tells most where it drives a resonance: the part with most power.
    """
    if test.excitation not in PASSING:
        return start
    step = max(1, size // PARTS)
    blocks = moving(recording).blocks(start, stop, step)
    power = np.array([float(np.sum(np.square(np.nan_to_num(block)))) for block in blocks])
    kept = max(1, min(PARTS, power.size - 1))
    return start + step * int(np.argmax(np.convolve(power[:-1], np.ones(kept), "valid")))


MOST_RATIO: Final = 1e8
"""Responses above so many times the drive, or below its inverse, have a wrong unit [-]."""

AROUND: Final = (0.8, 1.25)
"""Band of a sine over its frequency: a third of an octave to both sides [-]."""

MOST_OF_IT: Final = 0.5
"""Share of the power of a drive that lies in the band of its sine: the larger half [-]."""

LEAST_OF_IT: Final = 0.01
"""Share of the power of a drive that lies in the band that the log states, at least [-]."""


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
    """Pass a drive that is the sine that the log says, or moves in the band that it states.

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
        If most of its power lies elsewhere than `AROUND` that frequency, or nearly all of it
        out of that band: it would be compared in a band in which nothing moves.
    """
    if not inputs or (test.band is None and test.frequency_hz is None):
        return
    if test.band is not None:
        low, high = test.band
        said, wrong, least = f"{low:g} to {high:g} Hz", "from and to", LEAST_OF_IT
    else:
        low, high = (share * (test.frequency_hz or 0.0) for share in AROUND)
        said, wrong, least = f"a sine of {test.frequency_hz:g} Hz", "frequency", MOST_OF_IT
    drive = samples[inputs].mean(axis=0)
    level = (drive - drive.mean())[np.newaxis]
    frequency, (power,) = periodogram(level, recording.sample_rate)
    inside = float(power[(frequency >= low) & (frequency <= high)].sum() / power.sum())
    if inside < least:
        name = recording.channels[inputs[0]].name
        raise NotMeasuredError(
            f"{recording.run} is left out: the log says {said}, "
            f"but {name} has most power at {numeral(frequency[power.argmax()])} Hz, and "
            f"{numeral(inside, 2)} of it from {numeral(low)} to {numeral(high)} Hz. Correct "
            f"{wrong} in the log."
        )
