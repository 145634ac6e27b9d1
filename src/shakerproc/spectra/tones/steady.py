"""Steady and stepped sine: amplitude and phase of the tone and its harmonics."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.spectra.welch.spectrograms import periodogram, reader_of, ridge_of

STEADY: Final = 0.01
"""Relative change of frequency within a dwell [-]."""

DRIFT: Final = 0.003
"""Relative change from the first to the last third of a stretch that makes it a sweep [-]."""

FIRST_PART: Final = 0.3
"""Share of a dwell that is left for the response to settle [-]."""

FEWEST: Final = 12.0
"""Periods that a dwell must hold."""

MOST_APART: Final = 0.7
"""Share of the rms of the control that a tone may leave: half of the power [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Tone:
    """Response to a steady sine.

    Attributes
    ----------
    frequency : float
        Frequency of the control [Hz].
    start, stop : int
        Samples used.
    control : float
        Amplitude of the fundamental of the mean control [unit].
    harmonics : (n_channels, n_harmonics) complex array
        Amplitude and phase of harmonic 1, 2, ... of each channel, phase against as many times
        the phase of the control [unit]; not a number above half the sample rate.
    residual : (n_channels,) array
        Rms of what neither the mean nor the harmonics explain [unit].
    """

    frequency: float
    start: int
    stop: int
    control: float
    harmonics: ComplexArray
    residual: FloatArray

    @property
    def gain(self) -> ComplexArray:
        """Fundamental of each channel over that of the control, (n_channels,) [-]."""
        return self.harmonics[:, 0] / self.control


def tone_response(
    samples: FloatArray,
    sample_rate: float,
    controls: Sequence[int],
    *,
    frequency: float,
    n_harmonics: int = 5,
    start: int = 0,
) -> Tone:
    """Return amplitude and phase at a steady tone, its frequency taken from the control.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        Samples while the tone is steady [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    controls : sequence of int
        Rows of the control channels, from 0.
    frequency : float
        Frequency of the tone, within a few parts in a thousand [Hz].
    n_harmonics : int
        Harmonics, the fundamental included.
    start : int
        Number of the first sample, for the result.

    Returns
    -------
    Tone
        Least-squares amplitudes, over the whole stretch.

    Raises
    ------
    SpectrumError
        If there are fewer than three periods, the tone lies above half the sample rate, or
        less than half of the control's power is that of the tone and its harmonics.

    References
    ----------
    .. [1] IEEE Std 1057, "Digitizing waveform recorders", four-parameter sine fit.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    n_samples = samples.shape[1]
    if not 0.0 < frequency < sample_rate / 2.0 or n_samples * frequency < 3.0 * sample_rate:
        raise SpectrumError(
            f"a tone of {frequency:g} Hz cannot be measured in {n_samples} samples at "
            f"{sample_rate:g} Hz"
        )
    control = samples[list(controls)].mean(axis=0)
    exact = _exact_frequency(control, frequency / sample_rate)
    # at half the sample rate itself sine and cosine of the samples depend on each other
    below = int(np.floor(0.5 / exact * (1.0 - 1e-9)))
    number = min(n_harmonics, max(1, below))
    waves = _waves(exact, n_samples, number)
    every = np.concatenate([samples, control[np.newaxis]])
    weights = np.linalg.solve(waves @ waves.T, waves @ every.T)
    residual = np.sqrt(np.mean((every - weights.T @ waves) ** 2, axis=1))
    if residual[-1] > MOST_APART * np.std(control):
        places, power = periodogram((control - control.mean())[np.newaxis], sample_rate)
        raise SpectrumError(
            f"the control is no sine of {frequency:g} Hz: it has most power at "
            f"{numeral(places[power[0].argmax()], 4)} Hz"
        )
    amplitude = weights[1::2].T - 1j * weights[2::2].T
    turn = np.exp(-1j * np.angle(amplitude[-1, 0]))
    harmonics = np.full((samples.shape[0], n_harmonics), np.nan, dtype=np.complex128)
    harmonics[:, :number] = amplitude[:-1] * turn ** np.arange(1, number + 1)
    return Tone(
        frequency=exact * sample_rate,
        start=start,
        stop=start + n_samples,
        control=float(np.abs(amplitude[-1, 0])),
        harmonics=harmonics,
        residual=residual[:-1],
    )


def stepped_response(
    samples: FloatArray,
    sample_rate: float,
    controls: Sequence[int],
    band: tuple[float, float],
    *,
    n_harmonics: int = 5,
) -> tuple[Tone, ...]:
    """Return the response at each steady tone of a stepped sine (or at a single one).

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        The crop [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    controls : sequence of int
        Rows of the control channels, from 0.
    band : (float, float)
        Lowest and highest frequency of the tones [Hz].
    n_harmonics : int
        Harmonics, the fundamental included.

    Returns
    -------
    tuple of Tone
        One for each dwell, in the order of time; the first 30 % of each are left out.

    Raises
    ------
    SpectrumError
        If the control dwells nowhere.
    """
    read, n_samples = reader_of(samples[list(controls)].mean(axis=0, keepdims=True))
    ridge = ridge_of(read, n_samples, sample_rate, band)
    tones = []
    for first, last in _dwells(ridge.frequency):
        start, stop = int(ridge.position[first]), int(ridge.position[last]) + 1
        frequency = float(np.median(ridge.frequency[first : last + 1]))
        steady = start + round(FIRST_PART * (stop - start))
        if (stop - start) * frequency >= FEWEST * sample_rate:
            part = samples[:, steady:stop]
            tones.append(
                tone_response(
                    part,
                    sample_rate,
                    controls,
                    frequency=frequency,
                    n_harmonics=n_harmonics,
                    start=steady,
                )
            )
    if not tones:
        raise SpectrumError(
            f"the control dwells at no frequency between {band[0]:g} and {band[1]:g} Hz for "
            f"{FEWEST:g} periods"
        )
    return tuple(tones)


def _waves(cycles: float, n_samples: int, n_harmonics: int) -> FloatArray:
    """Return 1 and cosine and sine of each harmonic, (2 n_harmonics + 1, n_samples)."""
    phase = 2.0 * np.pi * cycles * np.arange(n_samples)
    rows = [np.ones(n_samples)]
    for harmonic in range(1, n_harmonics + 1):
        rows += [np.cos(harmonic * phase), np.sin(harmonic * phase)]
    return np.array(rows)


def _exact_frequency(control: FloatArray, cycles: float) -> float:
    """Return the periods per sample for which a sine fits best, by Gauss and Newton."""
    for _ in range(12):
        parts = min(16, max(2, int(control.size * cycles / 3.0)))
        length = control.size // parts
        blocks = (control[: parts * length] - control.mean()).reshape(parts, length)
        time = np.arange(parts * length).reshape(parts, length)
        window = 1.0 - np.cos(2.0 * np.pi * (np.arange(length) + 0.5) / length)
        turns = np.sum(blocks * window * np.exp(-2j * np.pi * cycles * time), axis=1)
        phase = np.unwrap(np.angle(turns))
        share = np.abs(turns) ** 2
        if not share.any():
            return cycles
        middle = np.arange(parts) * float(length)
        centred = middle - np.average(middle, weights=share)
        slope = float(np.sum(share * centred * phase) / np.sum(share * centred**2))
        cycles += slope / (2.0 * np.pi)
        if abs(slope) * control.size < 1e-9:
            break
    return cycles


def _dwells(frequency: FloatArray) -> list[tuple[int, int]]:
    """Return the stretches of places within which the frequency stays and does not drift."""
    dwells, first = [], 0
    low = high = float(frequency[0])
    for k in range(1, frequency.size + 1):
        if k < frequency.size:
            low, high = min(low, frequency[k]), max(high, frequency[k])
            if high <= low * (1.0 + STEADY):
                continue
            low = high = float(frequency[k])
        third = (k - first) // 3
        if third > 0:
            begin, end = frequency[first : first + third], frequency[k - third : k]
            if abs(np.median(end) / np.median(begin) - 1.0) < DRIFT:
                dwells.append((first, k - 1))
        first = k
    return dwells
