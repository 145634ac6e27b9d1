"""The curves of a run that figures are made of, in the units that people see."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.runs.flags import control_sweep
from shakerproc.runs.result import Responses, RunResult, shown_ratio, shown_unit
from shakerproc.runs.summary import CurveKind
from shakerproc.testlog import ThresholdCrop

RANGE_DB: Final = 80.0
"""How far below its highest value a spectrogram is drawn [dB]."""

BEYOND: Final = 1.25
"""How far above the excited band the curves go, as a multiple of its upper end."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class RunCurve:
    """One curve.

    Attributes
    ----------
    kind : CurveKind
        What it is.
    channel : str
        Whose it is.
    x, y : (n,) arrays
        Points, in shown units; not a number breaks the line.
    low : (n,) array, optional
        Lower edge, where the curve is an envelope and `y` its upper edge.
    part : str
        Which of several of one channel: ``up``, ``down``, ``before``, ``after``.
    """

    kind: CurveKind
    channel: str
    x: FloatArray
    y: FloatArray
    low: FloatArray | None = None
    part: str = ""


@final
@dataclass(frozen=True, slots=True, eq=False)
class RunSurface:
    """The density of a channel against time and frequency.

    Attributes
    ----------
    channel, unit : str
        Whose it is, and the unit of the density.
    time, frequency : (n,), (m,) arrays
        Where [s] [Hz].
    level : (m, n) array
        Density [dB re 1 unit].
    """

    channel: str
    unit: str
    time: FloatArray
    frequency: FloatArray
    level: FloatArray


def surface_of(result: RunResult) -> RunSurface | None:
    """Return the spectrogram of a run, None where there is none."""
    found = result.spectrogram
    if found is None or found.time.size < 2:
        return None
    channel = result.channels[result.pictured]
    unit, factor = shown_unit(channel.unit)
    part = found.frequency <= result.spectra.frequency[shown_part(result)][-1]
    level = 10.0 * np.log10(np.maximum(found.density[0, part] * factor**2, 1e-30))
    time = result.crop.start / result.sample_rate + found.time
    return RunSurface(channel.name, f"{unit}²/Hz", time, found.frequency[part], level)


def curves_of(result: RunResult) -> list[RunCurve]:
    """Return every curve of a run with all of its points."""
    curves = [*_in_time(result), *_densities(result), *_along_sweeps(result)]
    curves += [*_tones(result), *_notched(result)]
    if result.against is not None and result.test.excitation != "sine":
        curves += _over_control(result, result.against)
    return curves


def shown_part(result: RunResult) -> slice:
    """Return which frequencies are drawn: from the first bin to a little above the band."""
    cross = result.spectra
    single = result.test.excitation == "sine"
    high = cross.sample_rate / 2.0 if single else BEYOND * result.band[1]
    return slice(1, max(3, int(np.searchsorted(cross.frequency, high, side="right"))))


def unbroken_phase(response: ComplexArray) -> FloatArray:
    """Return the phase from -270 to 90 degrees, with the line broken where it wraps.

    `response` may be in any unit.
    """
    phase = np.degrees(np.angle(response))
    phase = np.where(phase > 90.0, phase - 360.0, phase)
    jump = np.abs(np.diff(phase, prepend=phase[:1])) > 180.0
    return np.where(jump, np.nan, phase)


def _in_time(result: RunResult) -> Iterator[RunCurve]:
    """Yield the envelope of every channel, and the threshold of the crop."""
    e = result.envelope
    for i, channel in enumerate(result.channels):
        factor = shown_unit(channel.unit)[1]
        yield RunCurve("time", channel.name, e.time, e.high[i] * factor, e.low[i] * factor)
    crop, row = result.test.processing.crop, result.crop_channel
    if isinstance(crop, ThresholdCrop) and row is not None:
        channel = result.channels[row]
        level = crop.threshold * shown_unit(channel.unit)[1]
        ends = np.array([0.0, result.promised_duration])
        for sign in (1.0, -1.0) if crop.absolute else (1.0,):
            yield RunCurve("threshold", channel.name, ends, np.full(2, sign * level))


def _densities(result: RunResult) -> Iterator[RunCurve]:
    shown = shown_part(result)
    frequency = result.spectra.frequency[shown]
    for i, channel in enumerate(result.channels):
        factor = shown_unit(channel.unit)[1] ** 2
        yield RunCurve("psd", channel.name, frequency, result.psd[i, shown] * factor)


def _over_control(result: RunResult, against: Responses) -> Iterator[RunCurve]:
    """Yield response functions and coherences where the excitation reaches."""
    shown = shown_part(result)
    frequency, valid = result.spectra.frequency[shown], against.valid[shown]
    for row, i in enumerate(result.responses):
        factor = shown_ratio(*result.units_of_response(i))[1]
        h1, ratio = against.h1[row, shown], against.psd_ratio[row, shown]
        drawn: dict[CurveKind, FloatArray] = {
            "gain": factor * np.abs(h1),
            "gain_root": factor * np.sqrt(ratio),
            "psd_ratio": ratio,
            "phase": unbroken_phase(np.where(valid, h1, np.nan)),
            "coherence": against.coherence[row, shown],
        }
        if len(result.controls) > 1:
            drawn["multiple_coherence"] = against.multiple_coherence[row, shown]
        for kind, values in drawn.items():
            name = result.channels[i].name
            yield RunCurve(kind, name, frequency, np.where(valid, values, np.nan))


def _along_sweeps(result: RunResult) -> Iterator[RunCurve]:
    """Yield fundamental and harmonics along each sweep, and the level of the control."""
    name_of, loudest = [c.name for c in result.channels], result.loudest
    for s in result.tracking.sweeps:
        for i in result.responses:
            ratio = shown_ratio(*result.units_of_response(i))[1]
            gain, phase = ratio * np.abs(s.gain[i]), unbroken_phase(s.gain[i])
            yield RunCurve("sweep", name_of[i], s.frequency, gain, part=s.direction)
            yield RunCurve("sweep_phase", name_of[i], s.frequency, phase, part=s.direction)
        fundamental, *harmonics = np.abs(s.harmonics[loudest])
        fundamental = np.where(fundamental > 0.0, fundamental, np.nan)
        for k, harmonic in enumerate(harmonics if loudest in result.responses else (), 2):
            ratio, part = harmonic / fundamental, f"harmonic {k}"
            yield RunCurve("sweep_harmonic", name_of[loudest], s.frequency, ratio, part=part)
    if control_sweep(result) is not None:
        name = " and ".join(name_of[i] for i in result.controls)
        factor = shown_unit(result.channels[result.controls[0]].unit)[1]
        for s in result.tracking.sweeps:
            yield RunCurve("level", name, s.frequency, s.control * factor, part=s.direction)


def _tones(result: RunResult) -> Iterator[RunCurve]:
    """Yield the amplitude of a steady sine and its harmonics in each channel."""
    if result.test.excitation != "sine" or not result.tracking.tones:
        return
    tone = result.tracking.tones[0]
    frequency = tone.frequency * np.arange(1.0, tone.harmonics.shape[1] + 1.0)
    for i, channel in enumerate(result.channels):
        amplitude = np.abs(tone.harmonics[i]) * shown_unit(channel.unit)[1]
        yield RunCurve("harmonics", channel.name, frequency, amplitude)


def _notched(result: RunResult) -> Iterator[RunCurve]:
    """Yield two periods and the density of each response with and without the tone."""
    notch = result.notch
    if notch is None:
        return
    shown = shown_part(result)
    frequency = result.spectra.frequency[shown]
    for row, i in enumerate(result.responses):
        name, factor = result.channels[i].name, shown_unit(result.channels[i].unit)[1]
        for part, samples, psd in (
            ("before", notch.before, result.psd[i]),
            ("after", notch.after, notch.psd[row]),
        ):
            yield RunCurve("notch", name, notch.time, samples[row] * factor, part=part)
            density = psd[shown] * factor**2
            yield RunCurve("notch_psd", name, frequency, density, part=part)
