"""The blows of a hammer test: found, judged, windowed and averaged."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.result import lone_force
from shakerproc.spectra import Crop, CrossSpectra
from shakerproc.spectra.blows import (
    LEAST_QUIET,
    BlockCut,
    Blow,
    Blows,
    Setup,
    impulse_share,
    incomplete,
    judge,
    noise_before,
    windowed,
)
from shakerproc.spectra.range_ends import range_ends
from shakerproc.spectra.strikes import Strikes, find_strikes, usual_length
from shakerproc.testlog import Hammer, Test

PRETRIGGER: Final = (0.01, 16)
"""Usual length before the trigger: share of the block, and samples at least; of a first blow
that comes sooner, what lies before that."""

PULSE: Final = 64
"""Samples of the force after the trigger that are noted at least."""

BRIEF: Final = 0.9
"""Share of a block's energy around its largest value from which on a channel strikes [-]."""


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
    cut, found = setup.cut, []
    for sample in setup.strikes.samples:
        reason = incomplete(sample, cut, crop.n_samples)
        if reason:
            found.append(Blow(sample, float("nan"), float("nan"), reason, 0.0))
        else:
            found.append(judge(_block(recording, crop, sample, cut), sample, setup))
    kept = [blow.sample for blow in found if blow.kept]
    if not kept:
        raise SpectrumError(_none_left(recording, crop, setup, found))
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
    absolute = tuple(replace(blow, sample=blow.sample + crop.start) for blow in found)
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
        f"respond, and no control; there are {there}; correct the roles under channels: in "
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
    """Yield blocks windowed; note what lies before each blow, and its force as it is used."""
    around = 3 * setup.cut.before + PULSE
    for raw in blocks:
        quiet.append(raw[:, : setup.cut.quiet].copy())
        block = windowed(raw, setup)
        pulses.append(block[setup.force, :around].copy())
        yield block


def _none_left(recording: Recording, crop: Crop, setup: Setup, blows: Sequence[Blow]) -> str:
    """Return why no blow can be used, and what may help."""
    counts = Counter(blow.reason.partition(":")[0] for blow in blows)
    told = ", ".join(f"{reason} ({count})" for reason, count in counts.items())
    return (
        f"none of {len(blows)} blows can be used: {told}. Blocks last "
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
