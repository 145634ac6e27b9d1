"""The spectra of a run, averaged as the log wants it, and the band they are good for."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.result import lone_force
from shakerproc.runs.roles import is_called
from shakerproc.spectra import Crop, CrossSpectra
from shakerproc.spectra.blows import (
    LEAST_QUIET,
    BlockCut,
    Blow,
    Blows,
    Setup,
    Strikes,
    find_strikes,
    impulse_share,
    incomplete,
    judge,
    noise_before,
    usual_length,
    windowed,
)
from shakerproc.spectra.welch.blocks import range_ends
from shakerproc.testlog import Hammer, Test

PRETRIGGER: Final = (0.01, 16)
"""Usual length before the trigger: share of the block, and samples at least; of a first blow
that comes sooner, what lies before that."""

PULSE: Final = 64
"""Samples of the force after the trigger that are noted at least."""

BRIEF: Final = 0.9
"""Share of a block's energy around its largest value from which on a channel strikes [-]."""

STEADY: Final = (None, "random", "sine on random", "measured")
"""Kinds of excitation of which longer segments show the same spectrum, finer."""

FINER: Final = 16
"""How many times longer the segments may be where damping is not resolved otherwise."""

SEGMENTS: Final = 8
"""Segments without overlap that must remain then."""

LINES_APART: Final = 4
"""Distance that excited lines of a multisine may have, so that segments do not resolve them
[lines]; whole periods are read by an analysis of their own."""

ALL_PAIRS: Final = 1e8
"""Cross spectra of all pairs are kept up to this size, for the shapes at peaks [byte]: as much
as samples are; of more channels, only those that response functions need."""

_DEFAULT_BAND: Final = (1.5, 0.45)  # bins, and share of the sample rate


def averaged_blows(
    recording: Recording, crop: Crop, test: Test, inputs: Sequence[int] | None = None
) -> tuple[CrossSpectra, Blows]:
    """Return the spectra of a hammer test, averaged over its blows, and these.

    Parameters
    ----------
    recording : Recording
        With one channel of the role force.
    crop : Crop
        The part of it in which blows are looked for.
    test : Test
        How they are cut and windowed.
    inputs : sequence of int, optional
        Rows of the channels whose spectra with the others are kept, by default all.

    Raises
    ------
    SpectrumError
        If there is no force or no blow, or none can be used.
    """
    setup = _setup(recording, crop, test.processing.hammer)
    cut, blows = setup.cut, []
    for sample in setup.strikes.samples:
        reason = incomplete(sample, cut, crop.n_samples)
        if reason:
            blows.append(Blow(sample, float("nan"), float("nan"), reason, 0.0))
        else:
            blows.append(judge(_block(recording, crop, sample, cut), sample, setup))
    kept = [blow.sample for blow in blows if blow.kept]
    if not kept:
        raise SpectrumError(_no_blow_reason(recording, crop, setup, blows))
    blocks = (_block(recording, crop, sample, cut) for sample in kept)
    pulses: list[FloatArray] = []
    quiet: list[FloatArray] = []
    cross = spectra.cross_spectra(
        _windowed(blocks, setup, pulses, quiet),
        recording.sample_rate,
        segment=cut.length,
        overlap=0,
        window=cut.window,
        inputs=inputs,
    )
    absolute = tuple(replace(blow, sample=blow.sample + crop.start) for blow in blows)
    return (
        replace(cross, window_name="blows", decay_rate=cut.decay_rate),
        Blows(setup, absolute, np.array(pulses), noise_before(quiet)),
    )


def _setup(recording: Recording, crop: Crop, wanted: Hammer) -> Setup:
    """Return how blows are found, cut and judged.

    Raises
    ------
    SpectrumError
        If no single channel is the hammer, nothing strikes, or a length does not fit.
    """
    row = _force(recording)
    rate = recording.sample_rate
    force = recording.select([row]).samples(crop.start, crop.stop)[0]
    value, unit = wanted.trigger
    strikes = find_strikes(force, rate, value if unit == "N" else None, value)
    before = None if wanted.pretrigger is None else round(wanted.pretrigger * rate)
    length = (
        usual_length(strikes, crop.n_samples, PRETRIGGER[1] if before is None else before)
        if wanted.length is None
        else round(wanted.length * rate)
    )
    if before is None:
        usual = max(round(PRETRIGGER[0] * length), PRETRIGGER[1])
        before = min(usual, max(strikes.samples[0], PRETRIGGER[1]))
    if length < 4 * max(before, 1):
        raise SpectrumError(
            f"a block of {numeral(length / rate)} s is too short for {numeral(before / rate)} "
            "s before "
            "the trigger; under processing: {hammer: ...} make length four times the "
            "pretrigger or more"
        )
    cut = BlockCut(
        before,
        length,
        None if wanted.force_window is None else max(round(wanted.force_window * rate), 1),
        _decay_rate(wanted, length / rate),
        rate,
    )
    names = tuple(channel.name for channel in recording.channels)
    ends = range_ends(recording.blocks(crop.start, crop.stop))
    return Setup(row, names, ends, strikes, cut, _at_rest(recording, crop, strikes, cut))


def _at_rest(recording: Recording, crop: Crop, strikes: Strikes, cut: BlockCut) -> FloatArray:
    """Return the standard deviation of channels before the blow where each is quietest."""
    starts = [s - cut.before + crop.start for s in strikes.samples if s >= cut.before]
    if cut.quiet < LEAST_QUIET or not starts:
        return np.zeros(len(recording.channels))
    quiet = np.array([recording.samples(start, start + cut.quiet) for start in starts])
    return np.asarray(quiet.std(axis=-1, ddof=1).min(axis=0))


def _force(recording: Recording) -> int:
    """Return the row of the hammer.

    Raises
    ------
    SpectrumError
        If there is none, or more than one force.
    """
    channels = recording.channels
    row = lone_force(channels)
    if row is not None and len(channels) > 1:
        return row
    there = ", ".join(f"{channel.name} ({channel.role})" for channel in channels)
    raise SpectrumError(
        "a hammer test needs one channel with the role force, the hammer, others that "
        f"respond, and no control. There are {there}; correct the roles under channels: in "
        "the log"
    )


def _decay_rate(wanted: Hammer, duration: float) -> float:
    """Return the rate of the exponential window [1/s], 0 without one."""
    if wanted.exponential is None:
        return 0.0
    value, unit = wanted.exponential
    return 1.0 / value if unit == "s" else -float(np.log(value)) / duration


def _block(recording: Recording, crop: Crop, sample: int, cut: BlockCut) -> FloatArray:
    start = crop.start + sample - cut.before
    return recording.samples(start, start + cut.length)


def _windowed(
    blocks: Iterator[FloatArray],
    setup: Setup,
    pulses: list[FloatArray],
    quiet: list[FloatArray],
) -> Iterator[FloatArray]:
    """Yield blocks windowed; note the samples before each blow, and its force as used."""
    around = 3 * setup.cut.before + PULSE
    for raw in blocks:
        quiet.append(raw[:, : setup.cut.quiet].copy())
        block = windowed(raw, setup)
        pulses.append(block[setup.force, :around].copy())
        yield block


def _no_blow_reason(
    recording: Recording, crop: Crop, setup: Setup, blows: Sequence[Blow]
) -> str:
    """Return why no blow can be used, and a remedy."""
    counts = Counter(blow.reason.partition(":")[0] for blow in blows)
    text = ", ".join(f"{reason} ({count})" for reason, count in counts.items())
    return (
        f"none of {len(blows)} blows can be used: {text}. Blocks last "
        f"{numeral(setup.cut.length / setup.cut.sample_rate)} s, the trigger is "
        f"{numeral(setup.strikes.level)} N; change processing: {{hammer: {{length: ..., "
        f"trigger: ...}}}}, or strike again{_exchanged(recording, crop, setup)}"
    )


def _exchanged(recording: Recording, crop: Crop, setup: Setup) -> str:
    """Return whether another channel strikes and the force rings; empty where it does not."""
    whole = [s for s in setup.strikes.samples if not incomplete(s, setup.cut, crop.n_samples)]
    if not whole:
        return ""
    shares = [impulse_share(row) for row in _block(recording, crop, whole[0], setup.cut)]
    best = int(np.argmax(shares))
    if best == setup.force or shares[best] < BRIEF or shares[setup.force] > 0.5 * BRIEF:
        return ""
    return (
        f". {setup.names[setup.force]} rings like a response and {setup.names[best]} strikes "
        "like a hammer: their roles look exchanged"
    )


def averaged(recording: Recording, crop: Crop, test: Test) -> tuple[CrossSpectra, Blows | None]:
    """Return the spectra of a run; the segments of a hammer test are its blows."""
    inputs = inputs_of(recording.channels, test)
    if test.struck:
        return averaged_blows(recording, crop, test, inputs)
    if test.rings:
        test = _short_segments(test, crop.n_samples)
    if test.multisine is not None:
        period = round(test.multisine.period * recording.sample_rate)
        test = _short_segments(test, max(period // LINES_APART, 8))
    blocks = recording.blocks(crop.start, crop.stop)
    averaging, count = test.processing.welch, len(recording.channels)
    bins = (averaging.n_fft or averaging.segment) // 2 + 1
    kept = None if 16 * count**2 * bins <= ALL_PAIRS else inputs
    return welch(blocks, recording.sample_rate, test, kept), None


def inputs_of(channels: Sequence[Channel], test: Test) -> tuple[int, ...]:
    """Return the rows that response functions are over: controls, forces, those asked for."""
    named = {one.input for one in test.processing.response_functions}
    return tuple(
        i
        for i, channel in enumerate(channels)
        if channel.role in {"control", "force"}
        or any(is_called(channel, name) for name in named)
    )


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


def welch(
    blocks: Iterable[FloatArray],
    sample_rate: float,
    test: Test,
    inputs: Sequence[int] | None = None,
) -> CrossSpectra:
    """Return the cross spectra as the log wants them.

    `blocks` are in the units of the channels, `sample_rate` in [Hz]; `inputs` are the rows
    whose spectra with the others are kept, by default all.
    """
    averaging = test.processing.welch
    return spectra.cross_spectra(
        blocks,
        sample_rate,
        segment=averaging.segment,
        overlap=averaging.overlap,
        n_fft=averaging.n_fft,
        window=averaging.window,
        detrend=test.processing.detrend,
        inputs=inputs,
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
        text = "excited band" if test.processing.band is None else "band of processing"
        low, high = wanted or (low, high)
        raise SpectrumError(
            f"the {text} from {low:g} to {high:g} Hz does not lie below half the sample rate "
            f"of {cross.sample_rate:g} Hz, {nyquist:g} Hz. Correct its from and to in the log"
        )
    return low, high


@final
@dataclass(frozen=True, slots=True)
class FinerSpectra:
    """Spectra of longer segments, for a damping that the bins of a run do not resolve.

    Attributes
    ----------
    bin_width : float
        Distance of their frequencies [Hz].
    make : function
        Returns them, computed at the first call.
    """

    bin_width: float
    make: Callable[[], CrossSpectra]


def finer_spectra(recording: Recording, crop: Crop, test: Test) -> FinerSpectra | None:
    """Return spectra of longer segments; None where the excitation is not steady."""
    averaging = test.processing.welch
    times = 1
    while times < FINER and 2 * times * averaging.segment * SEGMENTS <= crop.n_samples:
        times *= 2
    if times == 1 or averaging.n_fft is not None or test.excitation not in STEADY:
        return None
    segment = times * averaging.segment

    @cache
    def make() -> CrossSpectra:
        return spectra.cross_spectra(
            recording.blocks(crop.start, crop.stop),
            recording.sample_rate,
            segment=segment,
            window=averaging.window,
            detrend=test.processing.detrend,
            inputs=inputs_of(recording.channels, test),
        )

    return FinerSpectra(recording.sample_rate / segment, make)
