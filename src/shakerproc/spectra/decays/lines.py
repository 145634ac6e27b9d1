"""The modes of a free decay: lines of its spectrum that stand out of their surroundings."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra.masks import excited

PROMINENT: Final = 2.0
"""How far a line stands above the spectrum on both its sides, as a factor, 6 dB [-]: a
resonance that is no shoulder of another."""

ABOVE_NOISE: Final = 6.0
"""Multiples of the rms of a line of noise by which a line stands above both its sides at least
[-]: of 10^6 lines of white noise, whose magnitudes follow Rayleigh's law, none is as tall."""

FAINT: Final = 1e-3
"""Share of the tallest line of its channel in the band below which a line is left out, 60 dB
[-]."""

TAIL: Final = 0.1
"""Share of a decay at its end that tells its noise, where nothing lies before it [-]."""


@final
@dataclass(frozen=True, slots=True)
class DecayLine:
    """A line of the spectrum of a decay.

    Attributes
    ----------
    frequency : float
        Of the line [Hz].
    row : int
        Channel in which it stands out of the noise most.
    apart : float
        How far away the next other line, rest (0 Hz) or half the sample rate is [Hz].
    ratio : float
        Height of that line over its own, 1 at least [-].
    """

    frequency: float
    row: int
    apart: float
    ratio: float


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
    rest = samples - samples[:, -max(int(TAIL * n_samples), 1) :].mean(axis=1, keepdims=True)
    if noise is None:
        noise = rest[:, -max(int(TAIL * n_samples), 2) :].std(axis=1)
    taper = 0.5 + 0.5 * np.cos(np.pi * np.arange(n_samples) / n_samples)
    n_fft = 2 * scipy.fft.next_fast_len(n_samples)
    magnitude: FloatArray = np.abs(np.fft.rfft(rest * taper, n_fft))
    frequency = np.asarray(np.fft.rfftfreq(n_fft, 1.0 / sample_rate), dtype=np.float64)
    of_noise = noise[:, np.newaxis] * np.sqrt(np.sum(taper**2))
    over = magnitude / np.where(of_noise > 0.0, of_noise, magnitude.max() * 1e-12)
    score = over.max(axis=0)
    level = 20.0 * np.log10(np.maximum(score, 1e-300))
    places, _ = scipy.signal.find_peaks(level, prominence=20.0 * np.log10(PROMINENT))
    beside, *_ = scipy.signal.peak_prominences(score, places)
    places = places[beside > ABOVE_NOISE]
    inside = excited(frequency, band)
    tallest = np.where(inside, magnitude, 0.0).max(axis=1, keepdims=True)
    seen = inside & (magnitude > FAINT * tallest).any(axis=0)
    kept = places[seen[places]]
    if count is not None:
        kept = np.sort(kept[np.argsort(-score[kept])][:count])
    return tuple(_line(int(at), places, frequency, magnitude, over) for at in kept)


def _line(
    at: int, places: FloatArray, frequency: FloatArray, magnitude: FloatArray, over: FloatArray
) -> DecayLine:
    row = int(np.argmax(over[:, at]))
    others = [(0.0, 1.0), (float(frequency[-1]), 1.0)] + [
        (float(frequency[i]), float(magnitude[row, i] / magnitude[row, at]))
        for i in places
        if i != at and magnitude[row, i] > FAINT * magnitude[row, at]
    ]
    own = float(frequency[at])
    apart = min(abs(place - own) for place, _ in others)
    ratio = max(tall * apart / abs(place - own) for place, tall in others)
    return DecayLine(own, row, apart, max(ratio, 1.0))
