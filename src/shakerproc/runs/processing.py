"""From an open recording to everything that is known of the run."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import ArraySource, Channel, FloatArray, Recording, UnusedChannel
from shakerproc.errors import LogError, SpectrumError
from shakerproc.runs import flags as flagging
from shakerproc.runs import levels
from shakerproc.runs.analyses import analyses_of
from shakerproc.runs.analyses.orders import shaft_of
from shakerproc.runs.blows import averaged_blows
from shakerproc.runs.envelope import envelope
from shakerproc.runs.opening import open_test
from shakerproc.runs.result import (
    BoolArray,
    NotchResult,
    ResonancePeak,
    Responses,
    RunResult,
    lone_force,
    shown_unit,
)
from shakerproc.runs.roles import is_called, row_named, without_tachometers
from shakerproc.runs.tracking import density_against_time, swept_readings, tracked
from shakerproc.spectra import Crop, CrossSpectra, Damping, Line, Peak, masks
from shakerproc.spectra.blows import Blows
from shakerproc.spectra.lines import told
from shakerproc.testlog import Test, TestLog, ThresholdCrop, TimeCrop

IN_MEMORY: Final = 3.2e7
"""Recordings up to this size are read once and kept [byte]; longer ones are read in passes."""

FILTERED: Final = 2**20
"""Samples of each channel that a notch is cut into at most, from the middle."""

SINGLE_FREQUENCY: Final = ("sine",)
"""Kinds of excitation that reach one frequency only."""

STILL: Final = (None, "random")
"""Kinds of excitation, or none said, in which a steady tone of the control is odd."""

FINER: Final = 16
"""How many times longer the segments may be where damping is not resolved otherwise."""

SEGMENTS: Final = 8
"""Segments without overlap that must remain then."""

LINES_APART: Final = 4
"""Distance that excited lines of a multisine may have, so that segments do not resolve them
[lines]; whole periods are read by an analysis of their own."""

_DEFAULT_BAND: Final = (1.5, 0.45)  # bins, and share of the sample rate


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


def process_recording(recording: Recording, test: Test) -> RunResult:
    """Return everything that is known of a run.

    Parameters
    ----------
    recording : Recording
        Open, its channels with roles.
    test : Test
        What the log says of it, and how to work it through.

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
        return _process(held(recording), test)
    except SpectrumError as error:
        raise SpectrumError(f"{recording.run}: {error}") from error


def held(recording: Recording) -> Recording:
    """Return the recording with its samples in memory, where they are few enough."""
    if recording.n_samples * len(recording.channels) * 8 > IN_MEMORY:
        return recording
    rows = tuple(range(len(recording.channels)))
    return replace(recording, source=ArraySource(recording.samples()), rows=rows)


def _process(whole: Recording, test: Test) -> RunResult:
    crop, recording = find_crop(whole, test), without_tachometers(whole)
    channels = recording.channels
    controls = tuple(i for i, c in enumerate(channels) if c.role == "control")
    responses = tuple(i for i, c in enumerate(channels) if c.role != "control")
    cross, blows = _averaged(recording, crop, test)
    band = excited_band(test, cross)
    still = test.excitation in STILL
    lines = spectra.steady_lines(cross, controls, (0.0, band[1])) if still else ()
    search = _Search(cross, test, band, _finer(recording, crop, test), lines)
    against = _against(search, controls, responses)
    density = spectra.psd(cross)
    notch, problem = _notch(recording, crop, test)
    described = spectra.statistics(recording.blocks(crop.start, crop.stop))
    loudest = max(responses or controls, key=lambda i: float(described.rms[i]))
    tracking = tracked(recording, crop, test, controls, band)
    result = RunResult(
        run=recording.run,
        test=test,
        channels=channels,
        controls=controls,
        responses=responses,
        sample_rate=recording.sample_rate,
        n_samples=recording.n_samples,
        expected_samples=recording.expected_samples if recording.incomplete else None,
        start_time=recording.start_time,
        notes=(
            *recording.notes,
            *_why_not(test, channels, controls),
            *([told(lines)] if lines else []),
        ),
        unused=(*recording.unused, *_unread_tachometers(whole, test)),
        crop=crop,
        crop_channel=_crop_channel(whole, test),
        band=band,
        spectra=cross,
        psd=density,
        bounds=None if test.rings else spectra.psd_bounds(cross),
        band_rms=spectra.rms_in_band(cross, band),
        statistics=described,
        against=against,
        psd_peaks=((),) * len(channels)
        if test.rings
        else _psd_peaks(search, density, against, responses),
        response_peaks=_response_peaks(search, against, controls, responses),
        imbalance=spectra.control_imbalance(cross, controls, search.judged),
        measured_level=levels.measured(test, cross, channels, band),
        tracking=tracking,
        spectrogram=density_against_time(recording, crop, loudest, cross.segment),
        loudest=loudest,
        notch=notch,
        notch_problem=problem,
        envelope=envelope(recording.blocks(), recording.n_samples, recording.sample_rate),
        flags=(),
        swept=swept_readings(tracking.sweeps, responses),
        blows=blows,
        shaft=shaft_of(whole, crop, test.processing.orders),
    )
    result = replace(result, analyses=analyses_of(recording, result))
    return replace(result, flags=flagging.flags_of(recording, result))


def _unread_tachometers(recording: Recording, test: Test) -> list[UnusedChannel]:
    """Return the tachometers from which no speed is taken."""
    asked = test.processing.orders
    return [
        UnusedChannel(channel.name, "a tachometer, of which no orders are asked for")
        for channel in recording.channels
        if channel.role == "tachometer"
        and (asked is None or not is_called(channel, asked.tachometer))
    ]


def _why_not(test: Test, channels: Sequence[Channel], controls: Sequence[int]) -> list[str]:
    """Return why the level is not checked and why there is no response function, if so."""
    why = "" if test.rings else _why_no_response(channels, controls)
    told = (levels.unseen(test, channels), why)
    return [sentence for sentence in told if sentence]


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
            f"No channel has the role control: the response functions are those against the "
            f"force {forces[0]}, where it moves; spectra and peaks are those of each channel "
            "alone."
        )
    return (
        "No response function: no channel has the role control, and none is computed against "
        f"several forces ({', '.join(forces)}); spectra and peaks are those of each channel "
        "alone. "
        "processing: {response_functions: [{input: FORCE, output: RESPONSE}]} in the log asks "
        "for one, and compare and diagnose take the force as the input (excitation: {force on: "
        "...})."
    )


def _averaged(
    recording: Recording, crop: Crop, test: Test
) -> tuple[CrossSpectra, Blows | None]:
    """Return the spectra of a run; the segments of a hammer test are its blows."""
    if test.struck:
        return averaged_blows(recording, crop, test)
    if test.rings:
        test = _short_segments(test, crop.n_samples)
    if test.multisine is not None:
        period = round(test.multisine.period * recording.sample_rate)
        test = _short_segments(test, max(period // LINES_APART, 8))
    return welch(recording.blocks(crop.start, crop.stop), recording.sample_rate, test), None


def _short_segments(test: Test, n_samples: int) -> Test:
    """Return a test whose segments are no longer than so many samples.

    That is its run, for a decay may be over soon, or part of the period of a multisine, so that
    its lines are not resolved: between them nothing is excited.
    """
    averaging = test.processing.welch
    segment = min(averaging.segment, n_samples)
    if segment == averaging.segment:
        return test
    shorter = replace(averaging, segment=segment, overlap=segment // 2, n_fft=None)
    return replace(test, processing=replace(test.processing, welch=shorter))


def welch(blocks: Iterable[FloatArray], sample_rate: float, test: Test) -> CrossSpectra:
    """Return the cross-spectral matrix as the log wants it."""
    averaging = test.processing.welch
    return spectra.cross_spectra(
        blocks,
        sample_rate,
        segment=averaging.segment,
        overlap=averaging.overlap,
        n_fft=averaging.n_fft,
        window=averaging.window,
        detrend=test.processing.detrend,
    )


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
    unit, scale = shown_unit(only.channels[0].unit)
    return spectra.crop_by_threshold(
        list(_first(only)) if crop.remove_offset else _first(only),
        crop.threshold,
        recording.sample_rate,
        absolute=crop.absolute,
        hold=crop.hold,
        skip=crop.skip,
        remove_offset=crop.remove_offset,
        unit=unit,
        scale=scale,
    )


def _crop_channel(recording: Recording, test: Test) -> int | None:
    """Return the row that a threshold is held against, None where there is none.

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
    used = [use.key for use in test.channels if use.role != "ignore"]
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


def excited_band(test: Test, cross: CrossSpectra) -> tuple[float, float]:
    """Return the excited band [Hz]: the log's, or nearly everything.

    Raises
    ------
    SpectrumError
        If nothing of it lies below half the sample rate.
    """
    nyquist = cross.sample_rate / 2.0
    low = _DEFAULT_BAND[0] * cross.bin_width
    high = _DEFAULT_BAND[1] * cross.sample_rate
    wanted = test.processing.band or test.band
    if wanted is not None:
        low, high = wanted[0], min(wanted[1], nyquist)
    if not low < high:
        raise SpectrumError(
            f"the excited band from {low:g} to {high:g} Hz does not lie below half the sample "
            f"rate of {cross.sample_rate:g} Hz; correct from and to in the log"
        )
    return low, high


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Where peaks are looked for; `finer` gives spectra of longer segments, if any."""

    spectra: CrossSpectra
    test: Test
    band: tuple[float, float]
    finer: Callable[[], CrossSpectra | None]
    lines: tuple[Line, ...]  # tones of the control, which are no resonances

    @property
    def one_frequency(self) -> bool:
        return self.test.excitation in SINGLE_FREQUENCY

    def valid(self, control: FloatArray) -> BoolArray:
        """Return which frequencies are excited, given the density of the mean control."""
        frequency = self.spectra.frequency
        there = masks.driven(frequency, control, self.judged)
        return there if there.any() else masks.excited(frequency, self.judged)

    @property
    def judged(self) -> tuple[float, float]:
        """Where controls and responses can be compared [Hz]: the band, or near the tone."""
        if self.one_frequency and self.test.frequency_hz is not None:
            reach = masks.NOTCH_BINS * self.spectra.bin_width
            return max(0.0, self.test.frequency_hz - reach), self.test.frequency_hz + reach
        return self.band

    def peaks(self, values: FloatArray, errors: FloatArray | None) -> tuple[Peak, ...]:
        """Return the peaks of a spectrum that chance does not make, tallest first."""
        wanted = self.test.processing.peaks
        return spectra.find_peaks(
            self.spectra.frequency,
            values,
            self.band,
            distance=wanted.distance,
            count=wanted.count if errors is not None else 1,
            errors=errors,
        )


def _against(
    search: _Search, controls: Sequence[int], responses: Sequence[int]
) -> Responses | None:
    if not controls or not responses:
        return None
    cross = search.spectra
    return Responses(
        h1=spectra.h1(cross, controls, responses),
        h2=spectra.h2(cross, controls, responses),
        hv=spectra.hv(cross, controls, responses),
        psd_ratio=spectra.psd_ratio(cross, controls, responses),
        coherence=spectra.coherence(cross, controls, responses),
        multiple_coherence=spectra.multiple_coherence(cross, controls, responses),
        valid=search.valid(spectra.psd(cross)[list(controls)].mean(axis=0)),
    )


def _psd_peaks(
    search: _Search, density: FloatArray, against: Responses | None, responses: Sequence[int]
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of the density of every channel; damping only without an input."""
    row_of = {channel: row for row, channel in enumerate(responses)} if against else {}
    found = []
    for i, values in enumerate(density):
        coherence = against.coherence[row_of[i]] if against and i in row_of else None
        elsewhere = against is not None or search.one_frequency
        read = None if elsewhere else _reader_of_density(search, i)
        chance = np.full(values.shape, search.spectra.effective_averages**-0.5)
        if search.lines and i in responses:
            left = spectra.beside_lines(search.spectra, search.lines, i)
            peaks = search.peaks(spectra.masked(values, left), chance)
        else:
            peaks = search.peaks(values, chance) or search.peaks(values, None)
        found.append(_read(search, values, peaks, coherence, read))
    return tuple(found)


def _response_peaks(
    search: _Search,
    against: Responses | None,
    controls: Sequence[int],
    responses: Sequence[int],
) -> tuple[tuple[ResonancePeak, ...], ...]:
    """Return the peaks of |H1| of every response, none for the controls."""
    found: list[tuple[ResonancePeak, ...]] = [()] * (len(controls) + len(responses))
    if against is not None and not search.one_frequency:
        for row, channel in enumerate(responses):
            apart = spectra.beside_lines(search.spectra, search.lines, channel)
            gain = spectra.masked(np.abs(against.h1[row]), against.valid & apart)
            chance = spectra.gain_random_error(
                np.clip(against.coherence[row], 0.0, 1.0), search.spectra.effective_averages
            )
            read = _reader_of_response(search, controls, channel)
            peaks = search.peaks(gain, chance)
            found[channel] = _read(search, gain**2, peaks, against.coherence[row], read)
    return tuple(found)


Reader: TypeAlias = Callable[[float], Damping]


def _reader_of_density(search: _Search, channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_density(
            cross, channel, frequency, search.band
        ),
    )


def _reader_of_response(search: _Search, controls: Sequence[int], channel: int) -> Reader:
    return _resolved(
        search,
        lambda cross, frequency: spectra.damping_of_response(
            cross, controls, channel, frequency, search.band
        ),
    )


def _resolved(search: _Search, read: Callable[[CrossSpectra, float], Damping]) -> Reader:
    """Return a reader of damping that looks again with longer segments where it is withheld."""

    def reader(frequency: float) -> Damping:
        first = read(search.spectra, frequency)
        if first.ratio is not None:
            return first
        finer = search.finer()
        second = first if finer is None else read(finer, frequency)
        return first if second.ratio is None else second

    return reader


def _finer(recording: Recording, crop: Crop, test: Test) -> Callable[[], CrossSpectra | None]:
    """Return what makes spectra of longer segments, once, for steady excitation only."""

    @cache
    def make() -> CrossSpectra | None:
        averaging = test.processing.welch
        times = 1
        while times < FINER and 2 * times * averaging.segment * SEGMENTS <= crop.n_samples:
            times *= 2
        if times == 1 or averaging.n_fft is not None or test.excitation not in {None, "random"}:
            return None
        return spectra.cross_spectra(
            recording.blocks(crop.start, crop.stop),
            recording.sample_rate,
            segment=times * averaging.segment,
            window=averaging.window,
            detrend=test.processing.detrend,
        )

    return make


def _read(
    search: _Search,
    power: FloatArray,
    peaks: Sequence[Peak],
    coherence: FloatArray | None,
    read: Reader | None,
) -> tuple[ResonancePeak, ...]:
    """Return peaks with the coherence there and their damping."""
    return tuple(
        ResonancePeak(
            peak,
            None if read is None else read(peak.frequency),
            None if coherence is None else float(coherence[peak.index]),
            spectra.is_resolved(search.spectra, power, peak.index),
        )
        for peak in peaks
    )


def _notch(recording: Recording, crop: Crop, test: Test) -> tuple[NotchResult | None, str]:
    """Return the second look that the log asks for, or why it cannot be had."""
    if test.notch_hz is None:
        return None, ""
    longest = FILTERED
    part, problem = crop, ""
    if crop.n_samples > longest:
        first = crop.start + (crop.n_samples - longest) // 2
        part = Crop(first, first + longest)
        problem = f"only {longest / recording.sample_rate:.4g} s from the middle were filtered"
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
