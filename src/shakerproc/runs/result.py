"""Result of one recording: arrays and numbers, all in SI."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import STANDARD_GRAVITY, Channel, ComplexArray, FloatArray, UnusedChannel
from shakerproc.runs.levels import Level
from shakerproc.runs.panels import Analysis, Envelope
from shakerproc.runs.tracking import SweptReading, Tracking
from shakerproc.spectra import (
    Bounds,
    Crop,
    CrossSpectra,
    Damping,
    Imbalance,
    Peak,
    Spectrogram,
    Statistics,
)
from shakerproc.spectra.blows import Blows
from shakerproc.spectra.tones.lines import MixedTones
from shakerproc.spectra.tones.orders import Rotation
from shakerproc.testlog import Test

BoolArray = NDArray[np.bool_]

SHOWN: Final = {"m/s^2": ("g", 1.0 / STANDARD_GRAVITY), "1": ("µm/m", 1e6)}
"""Units that people want to see instead of SI, and how many of them are one SI unit."""


def shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit that tables and figures have for an SI unit, and the factor to it."""
    return SHOWN.get(unit, (unit, 1.0))


def shown_ratio(output: str, over: str) -> tuple[str, float]:
    """Return the unit of one SI unit over another as it is shown, and the factor to it.

    Empty where both are the same.
    """
    (out_unit, out_factor), (in_unit, in_factor) = shown_unit(output), shown_unit(over)
    return ("", 1.0) if output == over else (f"{out_unit}/{in_unit}", out_factor / in_factor)


@final
@dataclass(frozen=True, slots=True)
class RunFlag:
    """Something odd about a run.

    Attributes
    ----------
    kind : str
        What kind of thing, such as ``clipping``.
    channel : str
        Channel it concerns; empty for the run as a whole.
    message : str
        What was seen and what it may mean.
    unusable : bool
        Whether the channel did not measure, so that the run takes no part in trends.
    """

    kind: str
    channel: str
    message: str
    unusable: bool = False


@final
@dataclass(frozen=True, slots=True)
class ResonancePeak:
    """A peak with the quantities read from it.

    Attributes
    ----------
    peak : Peak
        Where it is and how tall.
    damping : Damping, optional
        What the shape of the peak says; None where it is not read, as of a single tone.
    coherence : float, optional
        With the control, in the bin of the peak [-].
    resolved : bool
        Whether the bins resolve its width, so that its height is what fine bins would show.
    """

    peak: Peak
    damping: Damping | None = None
    coherence: float | None = None
    resolved: bool = True


@final
@dataclass(frozen=True, slots=True, eq=False)
class Responses:
    """Every response against the controls, (n_responses, n_frequencies) arrays.

    Attributes
    ----------
    h1, h2, hv : complex arrays
        Response functions against the mean control, not a number where it has no power to
        divide by [response unit/control unit].
    psd_ratio : array
        Response density over the mean control density; what the thesis calls FRF.
    coherence, multiple_coherence : arrays
        With the mean control, and with all controls together [-].
    valid : (n_frequencies,) array of bool
        Where the excitation reaches and no notch has emptied the band.
    """

    h1: ComplexArray
    h2: ComplexArray
    hv: ComplexArray
    psd_ratio: FloatArray
    coherence: FloatArray
    multiple_coherence: FloatArray
    valid: BoolArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class NotchResult:
    """Two periods before and after the tone was taken out of the responses.

    Attributes
    ----------
    frequency : float
        Of the tone [Hz].
    time : (n,) array
        From the start of the recording [s].
    before, after : (n_responses, n) arrays
        Samples [unit of the channel].
    psd : (n_responses, n_frequencies) array
        Densities of the filtered responses [unit²/Hz].
    """

    frequency: float
    time: FloatArray
    before: FloatArray
    after: FloatArray
    psd: FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class RecordingFacts:
    """A recording as it was opened.

    Attributes
    ----------
    run : str
        Name of the run.
    sample_rate : float
        Samples per second [Hz].
    n_samples : int
        Complete rows in the recording.
    expected_samples : int, optional
        How many it promised, where it holds fewer.
    start_time : datetime, optional
        Of the first sample.
    unused : tuple of UnusedChannel
        Channels of the file that nothing is made of.
    envelope : Envelope
        Extremes over the whole recording.
    """

    run: str
    sample_rate: float
    n_samples: int
    expected_samples: int | None
    start_time: datetime | None
    unused: tuple[UnusedChannel, ...]
    envelope: Envelope

    @property
    def incomplete(self) -> bool:
        """Whether the recording was cut short."""
        return self.expected_samples is not None

    @property
    def duration(self) -> float:
        """Length of the recording [s]."""
        return self.n_samples / self.sample_rate

    @property
    def promised_duration(self) -> float:
        """Length that the recording should have [s]."""
        return (self.expected_samples or self.n_samples) / self.sample_rate

    @property
    def length_text(self) -> str:
        """How much of the recording is there, in words."""
        return f"{self.duration:.2f} of {self.promised_duration:.2f} s"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Averages:
    """Means over the crop, and the peaks of its densities and response functions.

    Attributes
    ----------
    psd : (n_channels, n_frequencies) array
        Densities [unit²/Hz].
    bounds : Bounds, optional
        Their 95 % limits; None of blows, which are no random signal.
    band_rms : (n_channels,) array
        Rms within the band [unit].
    statistics : Statistics
        Of the crop.
    loudest : int
        Row of the largest response.
    against : Responses, optional
        Responses against controls; None without a control.
    psd_peaks, response_peaks : tuple of tuple of ResonancePeak
        For each channel, tallest first; of the density and of |H1|. Of the density there are
        none in a hammer test: it is that of the blows as much as of the structure.
    imbalance : Imbalance, optional
        How far the controls differ.
    measured_level : Level, optional
        What the controls saw in the mean.
    """

    psd: FloatArray
    bounds: Bounds | None
    band_rms: FloatArray
    statistics: Statistics
    loudest: int
    against: Responses | None
    psd_peaks: tuple[tuple[ResonancePeak, ...], ...]
    response_peaks: tuple[tuple[ResonancePeak, ...], ...]
    imbalance: Imbalance | None
    measured_level: Level | None


@final
@dataclass(frozen=True, slots=True, eq=False)
class OverTime:
    """Sines, blows and rotation, which are followed over time.

    Attributes
    ----------
    tracking : Tracking
        The response along a sweep or at a tone.
    swept : tuple of SweptReading
        The tallest point of every response along every sweep.
    notch : NotchResult, optional
        The responses without the tone.
    notch_problem : str
        Why there is none although the log asks for it.
    blows : Blows, optional
        Of a hammer test: the segments that the spectra are averages of.
    tones : MixedTones, optional
        Of a sine on random: taken out of the samples before `spectra` and all that is read
        from them.
    shaft : Rotation, optional
        From the tachometer, times from the start of the crop; None where no orders are asked.
    spectrogram : Spectrogram, optional
        Density against time of one channel.
    pictured : int
        Row of that channel: the one that the log names, else the largest response.
    """

    tracking: Tracking
    swept: tuple[SweptReading, ...]
    notch: NotchResult | None
    notch_problem: str
    blows: Blows | None
    tones: MixedTones | None
    shaft: Rotation | None
    spectrogram: Spectrogram | None
    pictured: int


@final
@dataclass(frozen=True, slots=True, eq=False)
class RunResult:
    """One recording processed.

    Attributes
    ----------
    recorded : RecordingFacts
        The recording as it was opened.
    test : Test
        What the log says of it, and how it was processed.
    channels : tuple of Channel
        Rows of every array.
    controls, responses : tuple of int
        Which rows are controls, and which are set against them.
    crop : Crop
        The part that was processed.
    crop_channel : int, optional
        Row of the channel that the threshold was compared with.
    band : (float, float)
        Excited band [Hz].
    spectra : CrossSpectra
        Of the crop.
    averages : Averages
        Densities, response functions and peaks of the crop.
    over_time : OverTime
        Sweeps, tones, blows and rotation within the crop.
    notes : tuple of str
        What the reader had to decide, and what cannot be computed, a sentence each.
    analyses : tuple of Analysis
        What else the log asks for.
    flags : tuple of RunFlag
        What is odd.
    """

    recorded: RecordingFacts
    test: Test
    channels: tuple[Channel, ...]
    controls: tuple[int, ...]
    responses: tuple[int, ...]
    crop: Crop
    crop_channel: int | None
    band: tuple[float, float]
    spectra: CrossSpectra
    averages: Averages
    over_time: OverTime
    notes: tuple[str, ...]
    analyses: tuple[Analysis, ...] = ()
    flags: tuple[RunFlag, ...] = ()

    def units_of_response(self, row: int) -> tuple[str, str]:
        """Return the SI units of a channel and of the controls that it is set against."""
        over = self.controls[0] if self.controls else row
        return self.channels[row].unit, self.channels[over].unit


def forces_of(channels: Sequence[Channel]) -> tuple[int, ...]:
    """Return the rows of the forces that drive a run without a control, none with one."""
    roles = [channel.role for channel in channels]
    return () if "control" in roles else tuple(i for i, r in enumerate(roles) if r == "force")


def lone_force(channels: Sequence[Channel]) -> int | None:
    """Return the row of the one force that drives a run without a control, None without it."""
    forces = forces_of(channels)
    return forces[0] if len(forces) == 1 else None
