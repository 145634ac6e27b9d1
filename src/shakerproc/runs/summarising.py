"""From the arrays of a run to its summary: numbers and curves in the units shown."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.runs import levels
from shakerproc.runs.flags import control_density, control_sweep
from shakerproc.runs.panels import Analysis, PanelLine, thinned
from shakerproc.runs.result import ResonancePeak, Responses, RunResult, shown_ratio, shown_unit
from shakerproc.runs.summary import (
    SURFACE_STEPS,
    AnalysisSummary,
    ChannelSummary,
    CurveKind,
    CurveSummary,
    FlagSummary,
    LineSummary,
    PanelSummary,
    PeakSummary,
    RunSummary,
    SpectrumSummary,
    SurfaceSummary,
    SweptPeak,
    Value,
)
from shakerproc.runs.tracking import SweptReading
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
    surface = result.over_time.spectrogram
    if surface is None or surface.time.size < 2:
        return None
    channel = result.channels[result.over_time.pictured]
    unit, factor = shown_unit(channel.unit)
    part = surface.frequency <= result.spectra.frequency[shown_part(result)][-1]
    level = 10.0 * np.log10(np.maximum(surface.density[0, part] * factor**2, 1e-30))
    time = result.crop.start / result.recorded.sample_rate + surface.time
    return RunSurface(channel.name, f"{unit}²/Hz", time, surface.frequency[part], level)


def curves_of(result: RunResult) -> list[RunCurve]:
    """Return every curve of a run with all of its points."""
    curves = [*_in_time(result), *_densities(result), *_along_sweeps(result)]
    curves += [*_tones(result), *_notched(result)]
    if result.averages.against is not None and result.test.excitation != "sine":
        curves += _over_control(result, result.averages.against)
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
    e = result.recorded.envelope
    for i, channel in enumerate(result.channels):
        factor = shown_unit(channel.unit)[1]
        yield RunCurve("time", channel.name, e.time, e.high[i] * factor, e.low[i] * factor)
    crop, row = result.test.processing.crop, result.crop_channel
    if isinstance(crop, ThresholdCrop) and row is not None:
        channel = result.channels[row]
        level = crop.threshold * shown_unit(channel.unit)[1]
        ends = np.array([0.0, result.recorded.promised_duration])
        for sign in (1.0, -1.0) if crop.absolute else (1.0,):
            yield RunCurve("threshold", channel.name, ends, np.full(2, sign * level))


def _densities(result: RunResult) -> Iterator[RunCurve]:
    shown = shown_part(result)
    frequency = result.spectra.frequency[shown]
    for i, channel in enumerate(result.channels):
        factor = shown_unit(channel.unit)[1] ** 2
        yield RunCurve("psd", channel.name, frequency, result.averages.psd[i, shown] * factor)


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
    name_of, loudest = [c.name for c in result.channels], result.averages.loudest
    for s in result.over_time.tracking.sweeps:
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
        for s in result.over_time.tracking.sweeps:
            yield RunCurve("level", name, s.frequency, s.control * factor, part=s.direction)


def _tones(result: RunResult) -> Iterator[RunCurve]:
    """Yield the amplitude of a steady sine and its harmonics in each channel."""
    if result.test.excitation != "sine" or not result.over_time.tracking.tones:
        return
    tone = result.over_time.tracking.tones[0]
    frequency = tone.frequency * np.arange(1.0, tone.harmonics.shape[1] + 1.0)
    for i, channel in enumerate(result.channels):
        amplitude = np.abs(tone.harmonics[i]) * shown_unit(channel.unit)[1]
        yield RunCurve("harmonics", channel.name, frequency, amplitude)


def _notched(result: RunResult) -> Iterator[RunCurve]:
    """Yield two periods and the density of each response with and without the tone."""
    notch = result.over_time.notch
    if notch is None:
        return
    shown = shown_part(result)
    frequency = result.spectra.frequency[shown]
    for row, i in enumerate(result.responses):
        name, factor = result.channels[i].name, shown_unit(result.channels[i].unit)[1]
        for part, samples, psd in (
            ("before", notch.before, result.averages.psd[i]),
            ("after", notch.after, notch.psd[row]),
        ):
            yield RunCurve("notch", name, notch.time, samples[row] * factor, part=part)
            density = psd[shown] * factor**2
            yield RunCurve("notch_psd", name, frequency, density, part=part)


MOST_POINTS: Final = 360
"""Points of a curve on the page; of a longer one the extremes of each slice stay."""

TIME_SLICES: Final = 320
"""Slices of the envelopes on the page, of all channels of a run together."""

SURFACE_CELLS: Final = (80, 160)
"""Frequencies and times of a spectrogram on the page, at most."""

KEPT: Final = frozenset({
    "psd", "gain", "coherence", "sweep", "level", "harmonics", "notch",
})  # fmt: skip
"""Kinds of curves that a page of hundreds of runs has room for, beside those in time."""


def summary_of(
    result: RunResult, test: str, facts: Mapping[str, Value], recording: str, sha256: str
) -> RunSummary:
    """Return the summary of a run: its numbers, and its curves thinned."""
    numbers = numbers_of(result, test, facts)
    return replace(
        numbers,
        recording=recording,
        sha256=sha256,
        curves=_kept_curves(result),
        surface=_kept_surface(result),
    )


def numbers_of(result: RunResult, test: str, facts: Mapping[str, Value]) -> RunSummary:
    """Return the numbers of a run, without its curves and where it comes from."""
    level, level_unit = (
        result.averages.measured_level.shown if result.averages.measured_level else (None, "")
    )
    return RunSummary(
        test=test,
        status="done",
        facts=dict(facts),
        sample_rate_hz=result.recorded.sample_rate,
        duration_s=result.recorded.duration,
        events=tuple((event.time, event.note) for event in result.test.events),
        promised_s=result.recorded.promised_duration if result.recorded.incomplete else None,
        start_time=""
        if result.recorded.start_time is None
        else f"{result.recorded.start_time:%Y-%m-%d %H:%M:%S}",
        crop_s=(
            result.crop.start / result.recorded.sample_rate,
            result.crop.stop / result.recorded.sample_rate,
        ),
        measured_level=level,
        level_unit=level_unit,
        alarm=_alarm(result),
        control=control_density(result) or control_sweep(result),
        spectrum=_spectrum(result),
        channels=tuple(_channel(result, i) for i in range(len(result.channels))),
        flags=tuple(
            FlagSummary(f.kind, f.channel, f.message, f.unusable) for f in result.flags
        ),
        notes=result.notes,
        unused=result.recorded.unused,
        analyses=tuple(_analysis(one) for one in result.analyses),
    )


def _analysis(one: Analysis) -> AnalysisSummary:
    return AnalysisSummary(
        one.kind,
        one.title,
        tuple(
            {k: finite(v) if isinstance(v, float) else v for k, v in row.items()}
            for row in one.summary
        ),
        one.sentences,
        tuple(
            PanelSummary(
                p.title, p.caption, p.x, p.y, tuple(_line(line) for line in p.lines), p.equal
            )
            for p in one.panels
        ),
    )


def _line(line: PanelLine) -> LineSummary:
    x, y = thinned(line.x, line.y, MOST_POINTS)
    values = tuple(finite(v) for v in _rounded(y, 4))
    return LineSummary(line.label, _rounded(x, 6), values, line.channel, line.look, line.style)


def _alarm(result: RunResult) -> tuple[float, float] | None:
    """Return the alarm limits of the control density, in the shown unit."""
    level = levels.demanded(result.test)
    if level is None or level.kind != "density":
        return None
    if levels.watched(result.test, result.channels) != result.controls:
        return None  # the limits are drawn at the densities of the controls
    factor = 10.0 ** (result.test.processing.tolerance.alarm / 10.0)
    return level.shown[0] / factor, level.shown[0] * factor


def _spectrum(result: RunResult) -> SpectrumSummary:
    cross = result.spectra
    middle = len(cross.frequency) // 2
    density = result.averages.psd[0, middle]
    factors = (math.nan, math.nan)
    if result.averages.bounds is not None and density > 0.0:
        low, high = (
            result.averages.bounds.low[0, middle],
            result.averages.bounds.high[0, middle],
        )
        factors = (low / density, high / density)
    return SpectrumSummary(
        segment=cross.segment,
        overlap=cross.overlap,
        n_segments=cross.n_segments,
        window=cross.window_name,
        detrend=cross.detrend,
        bin_width_hz=cross.bin_width,
        resolution_hz=cross.resolution,
        degrees_of_freedom=cross.degrees_of_freedom,
        low_factor=finite(factors[0]),
        high_factor=finite(factors[1]),
        band_hz=result.band,
    )


def finite(value: float, factor: float = 1.0) -> float | None:
    """Return a number in a shown unit, None where there is none."""
    return float(value) * factor if math.isfinite(value) else None


def _channel(result: RunResult, i: int) -> ChannelSummary:
    channel, s = result.channels[i], result.averages.statistics
    unit, factor = shown_unit(channel.unit)
    _, gain = shown_ratio(*result.units_of_response(i))
    return ChannelSummary(
        name=channel.name,
        role=channel.role or "response",
        unit=unit,
        at=channel.at or "",
        mean=finite(s.mean[i], factor),
        rms=finite(s.rms[i], factor),
        minimum=finite(s.minimum[i], factor),
        maximum=finite(s.maximum[i], factor),
        crest_factor=finite(s.crest_factor[i]),
        kurtosis=finite(s.kurtosis[i]),
        band_rms=finite(result.averages.band_rms[i], factor),
        coherence=_mean_coherence(result, i),
        psd_peaks=tuple(
            replace(_peak(p, factor**2), shape=_shape(result, i, p))
            for p in result.averages.psd_peaks[i]
        ),
        response_peaks=tuple(_peak(p, gain) for p in result.averages.response_peaks[i]),
        swept_peaks=_swept_peaks(result, i),
    )


def _swept_peaks(result: RunResult, i: int) -> tuple[SweptPeak, ...]:
    ratio = shown_ratio(*result.units_of_response(i))[1]
    return tuple(
        _swept_peak(reading, ratio)
        for reading in result.over_time.swept
        if reading.channel == i
    )


def _swept_peak(reading: SweptReading, ratio: float) -> SweptPeak:
    mode = reading.mode
    peak = SweptPeak(reading.direction, reading.frequency, reading.gain * ratio)
    if mode is None:
        return peak
    return replace(
        peak,
        natural_frequency_hz=mode.frequency,
        damping_ratio=mode.ratio,
        steady_hz=mode.steady_frequency,
        steady_gain=mode.steady_gain * ratio,
        damping_low=mode.ratio * (1.0 - mode.half),
        damping_high=mode.ratio * (1.0 + mode.half),
    )


def _mean_coherence(result: RunResult, i: int) -> float | None:
    if result.averages.against is None or i not in result.responses:
        return None
    values = result.averages.against.coherence[
        result.responses.index(i), result.averages.against.valid
    ]
    values = values[np.isfinite(values)]
    return float(values.mean()) if values.size else None


def _shape(result: RunResult, i: int, peak: ResonancePeak) -> Mapping[str, tuple[float, float]]:
    """Return how the responses of a channel's quantity move at a peak of it, over it [-]."""
    if i not in result.responses or i not in result.spectra.inputs:
        return {}
    column = result.spectra.between([i], range(len(result.channels)))[0, :, peak.peak.index]
    if not column[i].real > 0.0:
        return {}
    unit = result.channels[i].unit
    same_unit = [j for j in result.responses if result.channels[j].unit == unit]
    over = {result.channels[j].name: complex(column[j] / column[i].real) for j in same_unit}
    return {name: (round(v.real, 5), round(v.imag, 5)) for name, v in over.items()}


def _peak(peak: ResonancePeak, factor: float) -> PeakSummary:
    damping = peak.damping
    return PeakSummary(
        frequency_hz=peak.peak.frequency,
        bin_hz=peak.peak.bin_frequency,
        height=peak.peak.value * factor,
        natural_frequency_hz=damping.frequency if damping else None,
        damping_ratio=damping.ratio if damping else None,
        damping_low=damping.ratio_low if damping else None,
        damping_high=damping.ratio_high if damping else None,
        quality=damping.quality_factor if damping else None,
        damping_bin_hz=damping.bin_width if damping else None,
        why_not=(damping.reason or "") if damping else "",
        coherence=peak.coherence,
        fitted_height=None
        if damping is None or damping.height is None
        else damping.height * factor,
        resolved=peak.resolved,
    )


def _kept_curves(result: RunResult) -> tuple[CurveSummary, ...]:
    """Return the curves that the page draws, thinned: of one kind, channel by channel."""
    loudest = result.channels[result.averages.loudest].name
    kept: list[CurveSummary] = []
    for curve in curves_of(result):
        if curve.kind in {"time", "threshold"}:
            kept.append(_time_curve(curve, max(1, TIME_SLICES // len(result.channels))))
        elif curve.kind in KEPT and (curve.kind != "notch" or curve.channel == loudest):
            kept.append(_thinned_curve(curve))
    return tuple(kept)


def _kept_surface(result: RunResult) -> SurfaceSummary | None:
    """Return the spectrogram in as many cells as the page draws, where the log asks for it."""
    surface = surface_of(result) if result.test.processing.spectrogram is not None else None
    if surface is None:
        return None
    level = surface.level
    for axis, most in enumerate(SURFACE_CELLS):
        cells = min(most, level.shape[axis])
        starts = np.arange(cells) * level.shape[axis] // cells
        level = np.maximum.reduceat(level, starts, axis=axis)
    high = float(level.max())
    share = np.clip((level - high) / RANGE_DB + 1.0, 0.0, 1.0)
    letters = (ord("A") + np.rint(share * (SURFACE_STEPS - 1))).astype(np.uint8)
    return SurfaceSummary(
        surface.channel,
        surface.unit,
        (float(surface.time[0]), float(surface.time[-1])),
        (float(surface.frequency[0]), float(surface.frequency[-1])),
        high - RANGE_DB,
        high,
        tuple(str(row.tobytes(), "ascii") for row in letters),
    )


def _time_curve(curve: RunCurve, slices: int) -> CurveSummary:
    """Return an envelope in fewer slices; a line in time as it is."""
    if curve.low is None:
        return _thinned_curve(curve)
    every = max(1, math.ceil(curve.x.size / slices))
    starts = np.arange(0, curve.x.size, every)
    return CurveSummary(
        curve.kind,
        curve.channel,
        _rounded(curve.x[starts], 6),
        _rounded(np.maximum.reduceat(curve.y, starts), 4),
        _rounded(np.minimum.reduceat(curve.low, starts), 4),
    )


def _thinned_curve(curve: RunCurve) -> CurveSummary:
    x, y = thinned(curve.x, curve.y, MOST_POINTS)
    digits = 4 if curve.kind != "coherence" else 3
    values = tuple(finite(v) for v in _rounded(y, digits))
    return CurveSummary(curve.kind, curve.channel, _rounded(x, 6), values, part=curve.part)


def _rounded(values: Sequence[float] | FloatArray, digits: int) -> tuple[float, ...]:
    return tuple(float(f"{v:.{digits}g}") for v in values)
