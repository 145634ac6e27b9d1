"""Analyses along the excitation: swept, stepped and steady sines, density against time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray, Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.spectra import Crop, Spectrogram, Sweep, Tone
from shakerproc.spectra.tones.passing import ENOUGH, SweptMode
from shakerproc.spectra.tones.swept import Direction
from shakerproc.testlog import Test

N_HARMONICS: Final = 5

LONGEST_TONE: Final = 20.0
"""How much of a steady sine is looked at, from its start [s]."""

LONGEST_STEPS: Final = 300.0
"""How much of a stepped sine is looked at, from its start [s]."""

MOST_TIMES: Final = 400
"""Columns of a spectrogram."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """The response along the excitation, as far as it has a frequency.

    Attributes
    ----------
    sweeps : tuple of Sweep
        Of a sweep, one for each way.
    tones : tuple of Tone
        Of a steady sine, or of each dwell of a stepped one.
    problem : str
        Why there is neither although there should be.
    """

    sweeps: tuple[Sweep, ...] = ()
    tones: tuple[Tone, ...] = ()
    problem: str = ""


def tracked(
    recording: Recording,
    crop: Crop,
    test: Test,
    controls: Sequence[int],
    band: tuple[float, float],
) -> Tracking:
    """Return the response along the excitation of a sine test, nothing for other tests.

    Parameters
    ----------
    recording : Recording
        The recording.
    crop : Crop
        The run in it.
    test : Test
        What the log says of its excitation.
    controls : sequence of int
        Rows of the controls, from 0.
    band : (float, float)
        Excited band [Hz].

    Returns
    -------
    Tracking
        Sweeps or tones, or why there are none.
    """
    kind, rate = test.excitation, recording.sample_rate
    if not controls or kind not in {"sine sweep", "sine", "stepped sine"}:
        return Tracking()
    try:
        if kind == "sine sweep":

            def read(start: int, stop: int) -> FloatArray:
                return recording.samples(crop.start + start, crop.start + stop)

            sweeps = spectra.swept_response(
                read, rate, controls, band, n_samples=crop.n_samples, n_harmonics=N_HARMONICS
            )
            return Tracking(sweeps=joined(sweeps) if test.processing.stitch else sweeps)
        steady = kind == "sine" and test.frequency_hz is not None
        longest = LONGEST_TONE if steady else LONGEST_STEPS
        stop = min(crop.stop, crop.start + round(longest * rate))
        samples = recording.samples(crop.start, stop)
        if kind == "sine" and test.frequency_hz is not None:
            tone = spectra.tone_response(
                samples, rate, controls, frequency=test.frequency_hz, n_harmonics=N_HARMONICS
            )
            return Tracking(tones=(tone,))
        tones = spectra.stepped_response(samples, rate, controls, band, n_harmonics=N_HARMONICS)
        cut = f"only the first {longest:g} s were looked at" if stop < crop.stop else ""
        return Tracking(tones=tones, problem=cut)
    except SpectrumError as error:
        return Tracking(problem=str(error))


def joined(sweeps: Sequence[Sweep]) -> tuple[Sweep, ...]:
    """Return the sweeps of each direction as one, upwards first."""
    there = {sweep.direction for sweep in sweeps}
    ways: tuple[Direction, ...] = ("up", "down")
    return tuple(spectra.stitched(sweeps, way) for way in ways if way in there)


def swept_peak(frequency: FloatArray, gain: FloatArray) -> tuple[float, float]:
    """Return frequency and height of the tallest point of a swept gain, between points.

    Parameters
    ----------
    frequency : (n,) array
        Frequencies, rising or falling [Hz].
    gain : (n,) array
        Fundamental over control [-].

    Returns
    -------
    float, float
        Place and height of the parabola through the three points about the tallest.
    """
    k = int(np.nanargmax(gain))
    if not 0 < k < gain.size - 1 or not np.isfinite(gain[k - 1 : k + 2]).all():
        return float(frequency[k]), float(gain[k])
    curve = np.polyfit(frequency[k - 1 : k + 2] - frequency[k], gain[k - 1 : k + 2], 2)
    if not curve[0] < 0.0:
        return float(frequency[k]), float(gain[k])
    place = -curve[1] / (2.0 * curve[0])
    return float(frequency[k] + place), float(np.polyval(curve, place))


@final
@dataclass(frozen=True, slots=True)
class SweptReading:
    """The tallest point of a response along one sweep, and the mode behind it.

    Attributes
    ----------
    channel : int
        Row of the response.
    direction : str
        ``up`` or ``down``.
    frequency, gain : float
        Where it is [Hz], and fundamental over control there, in SI.
    mode : SweptMode, optional
        None where no linear mode fits.
    """

    channel: int
    direction: Direction
    frequency: float
    gain: float
    mode: SweptMode | None

    @property
    def reached(self) -> float | None:
        """Share of the steady resonance that the sweep shows [-]."""
        return None if self.mode is None else self.gain / self.mode.steady_gain


def swept_readings(
    sweeps: Sequence[Sweep], responses: Sequence[int]
) -> tuple[SweptReading, ...]:
    """Return the tallest point of every response along every sweep."""
    return tuple(
        SweptReading(
            channel,
            sweep.direction,
            *swept_peak(sweep.frequency, np.abs(sweep.gain[channel])),
            spectra.swept_mode(sweep, channel),
        )
        for channel in responses
        for sweep in sweeps
    )


def too_fast(reading: SweptReading, *, in_octaves: bool) -> str:
    """Return by how much a sweep lowers and shifts a peak, where it matters; else nothing.

    Parameters
    ----------
    reading : SweptReading
        The peak.
    in_octaves : bool
        Whether the rate is told in octaves per minute.
    """
    mode, reached = reading.mode, reading.reached
    if mode is None or reached is None or reached >= ENOUGH:
        return ""
    off = reading.frequency - mode.steady_frequency
    fastest = spectra.fastest_rate(mode.frequency, mode.ratio)
    text = (
        f"the peak at {numeral(reading.frequency, 4)} Hz is low by {1.0 - reached:.0%} and "
        f"{numeral(abs(off), 2)} Hz too {'high' if off > 0.0 else 'low'}"
    )
    behind = f"(zeta {mode.ratio:.2%})"
    if abs(mode.rate) <= fastest:
        return f"the tracking's windows are too long for its damping {behind}: {text}"
    shown = f"{numeral(fastest, 2)} Hz/s"
    if in_octaves:
        shown = f"{numeral(60.0 * fastest / (np.log(2.0) * mode.frequency), 2)} oct/min"
    return (
        f"the sweep {reading.direction} is too fast for its damping {behind}: {text}; sweep at "
        f"{shown} or slower for {1.0 - ENOUGH:.0%}"
    )


def density_against_time(
    recording: Recording, crop: Crop, row: int, segment: int
) -> Spectrogram | None:
    """Return the spectrogram of one channel over the crop; None where it is too short."""
    only = recording.select([row])
    if crop.n_samples < 2 * segment:
        return None

    def read(start: int, stop: int) -> FloatArray:
        return only.samples(crop.start + start, crop.start + stop)

    return spectra.spectrogram(
        read,
        recording.sample_rate,
        n_samples=crop.n_samples,
        segment=segment,
        most_times=MOST_TIMES,
    )
