"""The modes of a free decay: lines of its spectrum, from where nothing drives it any more."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.decays.isolation import PASS_EDGE, DecayLine, never_grows
from shakerproc.spectra.responses.masks import excited
from shakerproc.spectra.strikes import LOUD, NORMAL

DRIVE_FLOOR: Final = 0.05
"""Share of the largest input below which it drives no more [-]: what a hammer or a table rings
with after a pulse."""

LEAST_FREE_PART: Final = 0.05
"""Share of a run that its free part lasts at least [-]: less is the end of a test, no decay."""

LEAST_PROMINENCE: Final = 2.0
"""How far a line stands above the spectrum on both its sides, as a factor, 6 dB [-]: a
resonance that is no shoulder of another."""

ABOVE_NOISE: Final = 6.0
"""Multiples of the rms of a line of noise by which a line stands above both its sides at least
[-]: of 10^6 lines of white noise, whose magnitudes follow Rayleigh's law, none is as tall."""

LEAST_HEIGHT: Final = 1e-3
"""Share of the tallest line of its channel in the band below which a line is left out, 60 dB
[-]."""

MOST_SHIFT: Final = 0.3
"""Share of its frequency over which the lines of one mode may spread [-]: a gap or a cubic
spring shifts a mode as far in one decay."""

NOISE_TAIL: Final = 0.1
"""Share of a decay at its end that tells its noise, where nothing lies before it [-]."""


def free_start(samples: FloatArray, inputs: FloatArray) -> int:
    """Return the first sample of the free part of a run.

    Parameters
    ----------
    samples : (n_responses, n_samples) array
        The responses [unit of the channel].
    inputs : (n_inputs, n_samples) array
        Forces or controls, if any: the free part begins when the last of them is at rest.
        Without any it begins at the largest motion of all responses [unit of the channel].

    Raises
    ------
    SpectrumError
        If less than `LEAST_FREE_PART` of the run is left.
    """
    n_samples = samples.shape[1]
    if inputs.shape[0]:
        starts = [_at_rest(row) for row in inputs]
        why = "the input moves to its end"
    else:
        rest = samples - np.median(samples, axis=1, keepdims=True)
        power = np.mean(rest**2, axis=1, keepdims=True)
        shares = np.divide(rest**2, power, out=np.zeros_like(rest), where=power > 0.0)
        starts = [int(np.argmax(shares.sum(axis=0))) + 1]
        why = "the largest motion is at its end, and no channel is an input"
    start = max(starts)
    if start > (1.0 - LEAST_FREE_PART) * n_samples:
        raise SpectrumError(
            f"no free part: {why}; record until the motion has died away, give the input the "
            "role force or control and what is none another, or crop: {from: ..., to: ...}"
        )
    return start


def _at_rest(row: FloatArray) -> int:
    """Return the sample after the last at which an input drives, the end if it never rests."""
    size = np.abs(row - np.median(row))
    noise = LOUD * NORMAL * float(np.median(size))
    largest = float(size.max())
    if largest <= noise:
        return row.size
    return int(np.flatnonzero(size > max(DRIVE_FLOOR * largest, noise))[-1]) + 1


def decay_lines(
    samples: FloatArray,
    sample_rate: float,
    band: tuple[float, float],
    *,
    noise: FloatArray | None = None,
    count: int | None = None,
) -> tuple[DecayLine, ...]:
    """Return the lines of a free decay, lowest first.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        The free decay, from its start [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Where they are looked for [Hz].
    noise : (n_channels,) array, optional
        Rms of the noise [unit of the channel]; by default that of the end of the decay.
    count : int, optional
        How many at most, the tallest over the noise; by default all.
    """
    n_samples = samples.shape[1]
    rest = samples - samples[:, -max(int(NOISE_TAIL * n_samples), 1) :].mean(
        axis=1, keepdims=True
    )
    if noise is None:
        noise = rest[:, -max(int(NOISE_TAIL * n_samples), 2) :].std(axis=1)
    taper = 0.5 + 0.5 * np.cos(np.pi * np.arange(n_samples) / n_samples)
    n_fft = 2 * scipy.fft.next_fast_len(n_samples)
    magnitude: FloatArray = np.abs(np.fft.rfft(rest * taper, n_fft))
    frequency = np.asarray(np.fft.rfftfreq(n_fft, 1.0 / sample_rate), dtype=np.float64)
    of_noise = noise[:, np.newaxis] * np.sqrt(np.sum(taper**2))
    over = magnitude / np.where(of_noise > 0.0, of_noise, magnitude.max() * 1e-12)
    score = over.max(axis=0)
    level = 20.0 * np.log10(np.maximum(score, 1e-300))
    places, _ = scipy.signal.find_peaks(level, prominence=20.0 * np.log10(LEAST_PROMINENCE))
    beside, *_ = scipy.signal.peak_prominences(score, places)
    places = places[beside > ABOVE_NOISE]
    alone = [
        _ModeLines(float(frequency[i]), 0.0, magnitude[:, i], over[:, i])
        for i in places.tolist()
    ]
    groups = _groups(rest, sample_rate, alone)
    tallest = np.where(excited(frequency, band), magnitude, 0.0).max(axis=1)
    kept = [
        one
        for one in groups
        if band[0] <= one.frequency <= band[1] and (one.heights > LEAST_HEIGHT * tallest).any()
    ]
    if count is not None:
        strongest = sorted(kept, key=lambda one: -float(one.over.max()))[:count]
        kept = sorted(strongest, key=lambda one: one.frequency)
    return tuple(_line(one, groups, 0.5 * sample_rate) for one in kept)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _ModeLines:
    """Lines of one mode: several where its frequency shifts. Heights by channel, over noise."""

    frequency: float
    span: float
    heights: FloatArray
    over: FloatArray


def _groups(rest: FloatArray, sample_rate: float, alone: list[_ModeLines]) -> list[_ModeLines]:
    """Return the modes that lines make, lowest first.

    A mode whose frequency shifts while it decays has a spectrum of several lines, which one by
    one look like modes. They are one where their sum never grows: two modes beat.
    """
    found: list[_ModeLines] = []
    while alone:
        last = max(
            i for i, one in enumerate(alone)
            if one.frequency - alone[0].frequency <= MOST_SHIFT * alone[0].frequency
        )  # fmt: skip
        while last > 0:
            joined = _joined(alone[: last + 1])
            row = int(np.argmax(joined.over))
            line = _line(joined, [*found, joined, *alone[last + 1 :]], 0.5 * sample_rate)
            if joined.span <= 2.0 * PASS_EDGE * line.apart and never_grows(
                rest[row], sample_rate, line
            ):
                break
            last -= 1
        found.append(_joined(alone[: last + 1]))
        alone = alone[last + 1 :]
    return found


def _joined(lines: Sequence[_ModeLines]) -> _ModeLines:
    low, high = lines[0].frequency, lines[-1].frequency
    return _ModeLines(
        0.5 * (low + high),
        high - low,
        np.max([one.heights for one in lines], axis=0),
        np.max([one.over for one in lines], axis=0),
    )


def _line(own: _ModeLines, groups: Sequence[_ModeLines], highest: float) -> DecayLine:
    """Return a mode among all others; their own width is no part of the distance."""
    row = int(np.argmax(own.over))
    others = [(own.frequency, 1.0), (highest - own.frequency, 1.0)] + [
        (
            abs(one.frequency - own.frequency) - 0.5 * one.span,
            float(one.heights[row] / own.heights[row]),
        )
        for one in groups
        if one is not own and one.heights[row] > LEAST_HEIGHT * own.heights[row]
    ]
    apart = min(distance for distance, _ in others)
    ratio = max(tall * apart / distance for distance, tall in others)
    return DecayLine(own.frequency, row, apart, max(ratio, 1.0))
