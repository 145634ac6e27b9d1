"""The spectra of a run, averaged as the log wants it, and the band they are good for."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final, final

from shakerproc import spectra
from shakerproc.data import Channel, FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.runs.blows import averaged_blows
from shakerproc.runs.roles import is_called
from shakerproc.spectra import Crop, CrossSpectra
from shakerproc.spectra.blows import Blows
from shakerproc.testlog import Test

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
        told = "excited band" if test.processing.band is None else "band of processing"
        low, high = wanted or (low, high)
        raise SpectrumError(
            f"the {told} from {low:g} to {high:g} Hz does not lie below half the sample rate "
            f"of {cross.sample_rate:g} Hz, {nyquist:g} Hz; correct its from and to in the log"
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
