"""From an open recording to everything that is known of the run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import Channel, FloatArray, Recording, SampleSource, UnusedChannel
from shakerproc.errors import LogError, SpectrumError
from shakerproc.late import loaded
from shakerproc.numerals import numeral
from shakerproc.runs import flags as flagging
from shakerproc.runs import levels
from shakerproc.runs.analyses import with_analyses
from shakerproc.runs.analyses.tones import notched, tones_taken_out
from shakerproc.runs.averaging import averaged, excited_band, finer_spectra
from shakerproc.runs.opening import open_test
from shakerproc.runs.pairs import Search, against_controls, density_peaks, response_peaks
from shakerproc.runs.panels import envelope
from shakerproc.runs.result import (
    Averages,
    OverTime,
    RecordingFacts,
    RunResult,
    lone_force,
    shown_unit,
)
from shakerproc.runs.roles import (
    is_called,
    row_asked_for,
    row_named,
    uses_of,
    without_tachometers,
)
from shakerproc.runs.tracking import density_against_time, swept_readings, tracked
from shakerproc.spectra import Crop
from shakerproc.spectra.tones.lines import SpectralLine, lines_sentence
from shakerproc.testlog import Test, TestLog, ThresholdCrop, TimeCrop

DECIDES: Final = 0.5
"""Offset over the threshold from which on it decides the crop: more than what is left [-]."""

MEDIAN_OF: Final = 2**17
"""Samples from which a median is taken: to 0.4 % of the standard deviation, of noise."""


def _wanted_crop(test: Test) -> TimeCrop | ThresholdCrop | None:
    """Return how the log crops a test: a decay is never cropped by a threshold."""
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
    found_crop = spectra.crop_by_threshold(
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
        return found_crop
    text = (
        f"{only.channels[0].name} rests at {numeral(scale * rest, 4)} {unit}, against a "
        f"threshold of {numeral(scale * crop.threshold, 4)} {unit}: the crop compares it "
        "without that offset"
    )
    return replace(found_crop, warning="; ".join(filter(None, (text, found_crop.warning))))


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


IN_MEMORY: Final = 1e8
"""Recordings up to this size are read once and kept [byte]; longer ones are read in passes."""

STILL: Final = (None, "random", "sine on random")
"""Kinds of excitation, or none said, in which a steady tone of the control is odd."""


def process_test(log: TestLog, test: Test) -> RunResult:
    """Return everything that is known of one test of a log.

    Parameters
    ----------
    log : TestLog
        The log.
    test : Test
        One of its tests, changed with `dataclasses.replace` where something is to differ.

    Returns
    -------
    RunResult
        Arrays and numbers in SI.

    Raises
    ------
    ShakerprocError
        If the log or the recording does not allow it.
    """
    with open_test(log, test) as recording:
        return process_recording(recording, test)


def process_recording(recording: Recording, test: Test, *, pictured: bool = True) -> RunResult:
    """Return everything that is known of a run.

    Parameters
    ----------
    recording : Recording
        Open, its channels with roles.
    test : Test
        What the log says of it, and how to process it.
    pictured : bool
        Whether the spectrogram is taken where the log does not ask for it: only figures show
        it.

    Returns
    -------
    RunResult
        Arrays and numbers in SI.

    Raises
    ------
    SpectrumError
        If the recording does not allow it; the message opens with the name of the run.
    """
    try:
        return _process(in_memory(recording), test, pictured=pictured)
    except SpectrumError as error:
        raise SpectrumError(f"{recording.run}: {error}") from error


@final
@dataclass(frozen=True, slots=True, eq=False)
class _InMemory(SampleSource):
    """Samples in memory that nobody may change, so that parts of them need no copies."""

    whole: FloatArray

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        together = range(rows[0], rows[0] + len(rows)) if rows else range(0)
        where = slice(together.start, together.stop)
        return self.whole[where if tuple(rows) == tuple(together) else list(rows), start:stop]

    def close(self) -> None:
        """Do nothing: there is no file."""


def in_memory(recording: Recording) -> Recording:
    """Return the recording with its samples in memory, where they are few enough."""
    if recording.n_samples * len(recording.channels) * 8 > IN_MEMORY:
        return recording
    samples = recording.samples()
    samples.flags.writeable = False
    return replace(recording, source=_InMemory(samples), rows=tuple(range(len(samples))))


def _with_shaft(whole: Recording, result: RunResult) -> RunResult:
    """Return a result with the rotation of the shaft, where the log asks for orders of it.

    Raises
    ------
    SpectrumError
        If there is none, and the test itself asks for it.
    """
    asked = result.test.processing.orders
    if asked is None:
        return result
    shaft_of = loaded("shakerproc.runs.analyses.orders:shaft_of")
    try:
        shaft = shaft_of(whole, result.crop, asked)
    except SpectrumError as error:
        if "orders" not in result.test.processing.inherited:
            raise
        return replace(result, notes=(*result.notes, f"Left out: {error}"))
    return replace(result, over_time=replace(result.over_time, shaft=shaft))


def _facts_of(whole: Recording, recording: Recording, test: Test) -> RecordingFacts:
    """Return the facts of a recording; `whole` has the tachometers, too."""
    return RecordingFacts(
        run=recording.run,
        sample_rate=recording.sample_rate,
        n_samples=recording.n_samples,
        expected_samples=recording.expected_samples if recording.incomplete else None,
        start_time=recording.start_time,
        unused=(*recording.unused, *_unread_tachometers(whole, test)),
        envelope=envelope(recording.blocks(), recording.n_samples, recording.sample_rate),
    )


def _process(whole: Recording, test: Test, *, pictured: bool) -> RunResult:
    crop, recording = find_crop(whole, test), without_tachometers(whole)
    channels = recording.channels
    controls = tuple(i for i, c in enumerate(channels) if c.role == "control")
    responses = tuple(i for i, c in enumerate(channels) if c.role != "control")
    tones, floor = tones_taken_out(recording, crop, test)
    cross, blows = averaged(floor, crop, test)
    band = excited_band(test, cross)
    still = test.excitation in STILL
    lines = spectra.steady_lines(cross, controls, (0.0, band[1])) if still else ()
    search = Search(cross, test, band, finer_spectra(floor, crop, test), lines)
    against = against_controls(search, controls, responses)
    density = spectra.psd(cross)
    notch, problem = notched(recording, crop, test)
    described = spectra.statistics(recording.blocks(crop.start, crop.stop))
    moving = tuple(i for i in responses if channels[i].role == "response")
    loudest = max(moving or responses or controls, key=lambda i: float(described.rms[i]))
    tracking = tracked(recording, crop, test, controls, band)
    averages = Averages(
        psd=density,
        bounds=None if test.rings else spectra.psd_bounds(cross),
        band_rms=spectra.rms_in_band(cross, band),
        statistics=described,
        loudest=loudest,
        against=against,
        psd_peaks=((),) * len(channels)
        if test.rings
        else density_peaks(search, density, against, responses),
        response_peaks=response_peaks(search, against, controls, responses),
        imbalance=spectra.control_imbalance(cross, controls, search.judged),
        measured_level=levels.measured(test, cross, channels, band),
    )
    over_time = OverTime(
        tracking=tracking,
        swept=swept_readings(tracking.sweeps, responses),
        notch=notch,
        notch_problem=problem,
        blows=blows,
        tones=tones,
        shaft=None,
        spectrogram=None,
        pictured=loudest,
    )
    result = RunResult(
        recorded=_facts_of(whole, recording, test),
        test=test,
        channels=channels,
        controls=controls,
        responses=responses,
        crop=crop,
        crop_channel=crop_channel(whole, test),
        band=band,
        spectra=cross,
        averages=averages,
        over_time=over_time,
        notes=(*recording.notes, *_why_not(test, cross, channels, controls, lines)),
    )
    return _with_the_rest(whole, recording, _with_averages_note(result), pictured=pictured)


def _with_the_rest(
    whole: Recording, recording: Recording, result: RunResult, *, pictured: bool
) -> RunResult:
    """Return a result with rotation, spectrogram, analyses and flags, in this order."""
    result = _with_shaft(whole, result)
    if pictured or result.test.processing.spectrogram is not None:
        result = _with_spectrogram(recording, result)
    result = with_analyses(recording, result)
    return replace(result, flags=flagging.flags_of(recording, result))


def _with_spectrogram(recording: Recording, result: RunResult) -> RunResult:
    """Return a result with the spectrogram of the channel that the log names, or the loudest.

    A note says where the run has no channel that the log names for every test.

    Raises
    ------
    SpectrumError
        If it has no channel that the test itself names.
    """
    asked, segment = result.test.processing.spectrogram, result.spectra.segment
    notes, row = result.notes, result.averages.loudest
    if asked is not None and asked.channel:
        try:
            row = row_asked_for(result.channels, asked.channel, "spectrogram")
        except SpectrumError as error:
            if "spectrogram" not in result.test.processing.inherited:
                raise
            notes = (*notes, f"{error}; shown is {result.channels[row].name}.")
    surface = density_against_time(recording, result.crop, row, segment)
    if surface is None and asked is not None:
        why = f"the run holds fewer than two segments of {segment} samples."
        notes = (*notes, f"No spectrogram: {why}")
    over_time = replace(result.over_time, spectrogram=surface, pictured=row)
    return replace(result, over_time=over_time, notes=notes)


def _unread_tachometers(recording: Recording, test: Test) -> list[UnusedChannel]:
    """Return the tachometers from which no speed is taken."""
    asked = test.processing.orders
    return [
        UnusedChannel(channel.name, "a tachometer, of which no orders are asked for")
        for channel in recording.channels
        if channel.role == "tachometer"
        and (asked is None or not is_called(channel, asked.tachometer))
    ]


def _no_shapes(cross: spectra.CrossSpectra) -> str:
    """Return why shapes at peaks are missing; empty where there are such, or none are made."""
    n = cross.n_channels
    if len(cross.inputs) == n or cross.window_name == "blows":
        return ""
    return (
        f"No shapes at the peaks: spectra of all pairs of {n} channels are too many to hold. "
        "Shorten the segment (welch: {segment: ...}), or process fewer channels."
    )


def _why_not(
    test: Test,
    cross: spectra.CrossSpectra,
    channels: Sequence[Channel],
    controls: Sequence[int],
    lines: Sequence[SpectralLine],
) -> list[str]:
    """Return why the level is not checked, why no response function is there, and tones."""
    why = "" if test.rings else _why_no_response(channels, controls)
    said = (levels.unseen(test, channels), why, lines_sentence(lines), _no_shapes(cross))
    return [sentence for sentence in said if sentence]


def _with_averages_note(result: RunResult) -> RunResult:
    """Return a result with a note on the limits of one average."""
    cross, n_samples = result.spectra, result.crop.stop - result.crop.start
    if (
        cross.effective_averages > 1.0
        or result.test.rings
        or result.over_time.blows is not None
    ):
        return result
    note = (
        f"The run of {n_samples} samples holds one segment of {cross.segment}: one average has "
        "no coherence and no damping, and nothing tells its peaks from chance. Take shorter "
        f"segments (--segment {max(n_samples // 4, 8)})."
    )
    return replace(result, notes=(*result.notes, note))


def _why_no_response(channels: Sequence[Channel], controls: Sequence[int]) -> str:
    """Return why there is no response function; empty where there is one."""
    if controls or len(channels) < 2:
        return ""
    forces = [channel.name for channel in channels if channel.role == "force"]
    if not forces:
        return (
            "No response function: no channel has the role control. Give it to the channel "
            "that measures the input."
        )
    if lone_force(channels) is not None:
        return (
            f"No channel has the role control. The response functions are those against the "
            f"force {forces[0]}, where it moves. Spectra and peaks are those of each channel "
            "alone."
        )
    return (
        "No channel has the role control. The response functions are those against each of the "
        f"forces {', '.join(forces)}, where it moves, without what the others cause. Spectra "
        "and peaks are those of each channel alone."
    )
