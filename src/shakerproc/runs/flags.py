"""Flags of a run: oddities of its recording, departures from its log, expired calibrations."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Final, final

import numpy as np

from shakerproc.data import ChannelUse, FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.recordings import MOST_CLIPPED, health, unusable, within
from shakerproc.recordings import Flag as HealthFlag
from shakerproc.runs import levels
from shakerproc.runs.levels import BEYOND_ALARM, control_text
from shakerproc.runs.result import BoolArray, RunFlag, RunResult
from shakerproc.runs.summary import ControlSummary
from shakerproc.runs.tracking import too_fast
from shakerproc.spectra import Sweep
from shakerproc.spectra.profiles import profile_at, surely_beyond
from shakerproc.testlog import Profile, Test, ThresholdCrop, nominal_duration

HALF_OCTAVE: Final = 2.0**0.5
"""Reach of the surroundings of a resonance, over and under its frequency [-]."""

_RANDOM: Final = ("random", "sine on random")


@final
@dataclass(frozen=True, slots=True)
class ControlDrop:
    """A drop of the control.

    Attributes
    ----------
    channel : int
        Row of the response whose resonance it is.
    frequency : float
        [Hz].
    decibels : float
        Control over its surroundings, below 0 [dB].
    """

    channel: int
    frequency: float
    decibels: float


def drop_sentence(drop: ControlDrop, result: RunResult) -> str:
    """Return a drop in words, with advice."""
    name, at = result.channels[drop.channel].name, numeral(drop.frequency, 4)
    return (
        f"the control drops by {-drop.decibels:.1f} dB at {at} Hz, a resonance of {name}. The "
        f"specimen pulls at the shaker there, and the controller does not make up for it. The "
        f"level at this resonance is not that of the log. Control finer and slower there, or "
        f"state a notch that is meant in the profile"
    )


def control_drops(result: RunResult) -> list[ControlDrop]:
    r"""Return where the control drops by more than its alarm limit, the deepest first.

    A specimen of mass :math:`m` on a table of mass :math:`M` that a force drives lowers the
    acceleration of the table to

    .. math:: \left|\frac{\ddot y}{\ddot y_0}\right| = \left|1 + \frac{m}{M} A(f)\right|^{-1},
        \qquad A(f_0) \approx \frac{1}{2 i \zeta}

    with the transmissibility A of the specimen. It is lowest at the resonance :math:`f_0` that
    the specimen has on a table that stands still, which is that of its response over the
    control. A controller that does not keep up leaves the drop, whatever the level beside it.

    Against its surroundings, an octave wide, in terms of the profile where there is one: the
    whole band may be too low, which is told as the level. Of a density a drop counts that
    chance does not make; of blows, shocks, decays and measured motions none is looked for.
    """
    if not result.controls or not result.responses:
        return []
    drops = _of_density(result) if result.test.excitation in _RANDOM else _of_sweeps(result)
    kept: list[ControlDrop] = []
    for one in sorted(drops, key=lambda drop: drop.decibels):
        if all(max(one.frequency, k.frequency) > HALF_OCTAVE * min(one.frequency, k.frequency)
               for k in kept):  # fmt: skip
            kept.append(one)
    return kept


def _of_density(result: RunResult) -> Iterator[ControlDrop]:
    lines = result.spectra.frequency
    wanted = _shape(result.test.profile, lines, density=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        level = result.averages.psd[list(result.controls)].mean(axis=0) / wanted
    inside = np.isfinite(level) & (level > 0.0) & (lines > 0.0)
    inside &= (lines >= result.band[0]) & (lines <= result.band[1])
    lines, level = lines[inside], level[inside]
    limit = 10.0 ** (-result.test.processing.tolerance.alarm / 10.0)
    for row in result.responses:
        for one in result.averages.response_peaks[row]:
            around = _surroundings(lines, np.log(level), one.peak.frequency)
            if around is None:
                continue
            part, smooth = around
            ratio = level[part] / np.exp(smooth)
            sure = surely_beyond(ratio / limit, result.spectra, above=False, anywhere=True)
            at = int(np.argmin(np.abs(lines[part] - one.peak.frequency)))
            if sure[at]:
                mean = float(np.mean(ratio[max(at - 1, 0) : at + 2]))
                yield ControlDrop(row, one.peak.frequency, 10.0 * np.log10(mean))


def _of_sweeps(result: RunResult) -> Iterator[ControlDrop]:
    for sweep in result.over_time.tracking.sweeps:
        order = np.argsort(sweep.frequency)
        lines, control = sweep.frequency[order], sweep.control[order]
        wanted = _shape(result.test.profile, lines, density=False)
        level = control / wanted
        known = np.isfinite(level) & (level > 0.0)
        lines, level = lines[known], level[known]
        for reading in result.over_time.swept:
            if reading.direction != sweep.direction:
                continue
            around = _surroundings(lines, np.log(level), reading.frequency)
            if around is None:
                continue
            part, smooth = around
            at = int(np.argmin(np.abs(lines[part] - reading.frequency)))
            drop = 20.0 * float(np.log10(level[part][at]) - smooth[at] / np.log(10.0))
            if drop < -result.test.processing.tolerance.alarm:
                yield ControlDrop(reading.channel, reading.frequency, drop)


def _shape(profile: Profile | None, lines: FloatArray, *, density: bool) -> FloatArray:
    """Return the profile at some frequencies, lowered by its notches; else 1 everywhere.

    `lines` are frequencies [Hz]; not a number beyond the profile.
    """
    if profile is None or profile.unit.endswith("/Hz") is not density:
        return np.ones(lines.shape)
    wanted = profile_at(lines, np.array(profile.frequency_hz), np.array(profile.level))
    for notch in profile.notches:
        meant = (lines >= notch.low) & (lines <= notch.high)
        wanted[meant] *= 10.0 ** (-notch.depth / (10.0 if density else 20.0))
    return wanted


def _surroundings(
    lines: FloatArray, level: FloatArray, frequency: float
) -> tuple[slice, FloatArray] | None:
    """Return the lines around a resonance, and the smooth level there.

    It is straight over the logarithm of the frequency, through the medians of both sides.

    Parameters
    ----------
    lines, level : (n,) arrays
        Rising frequencies [Hz], and the logarithm of the level [-].
    frequency : float
        Of the resonance [Hz].

    Returns
    -------
    part : slice
        Lines as far above as below: half an octave, or to the nearer end of the band.
    smooth : (n_part,) array
        Logarithm of the level [-].
        None where there are not two lines on each side of the resonance and its neighbours.
    """
    if lines.size < 2 or not lines[0] < frequency < lines[-1]:
        return None
    reach = min(HALF_OCTAVE, frequency / lines[0], lines[-1] / frequency)
    first, stop = np.searchsorted(lines, [frequency / reach, frequency * reach])
    at = int(np.argmin(np.abs(lines - frequency)))
    below, above = slice(first, at - 1), slice(at + 2, stop)
    if below.stop - below.start < 2 or above.stop - above.start < 2:
        return None
    octaves = np.log(lines)
    (x0, y0), (x1, y1) = (
        (float(np.mean(octaves[side])), float(np.median(level[side])))
        for side in (below, above)
    )
    part = slice(int(first), int(stop))
    return part, y0 + (octaves[part] - x0) * (y1 - y0) / (x1 - x0)


EXPIRED: Final = "calibration"
"""Kind of the flags of what was used after its calibration had ended."""

DURATION_TOLERANCE: Final = 0.05
"""How far a sweep may miss the time that its rate asks for [-]."""

EDGE_OF_SWEEP: Final = 0.02
"""Share of a sweep at each end in which its controller comes up and goes down [-]."""

EDGE_BINS: Final = 3
"""Bins at each end of the band where a window smears what the controller did."""


def _calibrated(test: Test) -> list[ChannelUse]:
    every = [*test.channels, *(use for one in test.beside for use in one.channels)]
    return [use for use in every if use.calibration is not None and use.role != "ignore"]


def calibration_sentences(test: Test) -> list[str]:
    """Return a sentence for each channel whose sensor is known."""
    return [
        f"Channel {use.name or use.key}: {use.calibration.sentence}."
        for use in _calibrated(test)
        if use.calibration is not None
    ]


def expired(test: Test, start: datetime | None) -> list[RunFlag]:
    """Return a flag for each sensor and instrument whose calibration ended before the test."""
    if start is None:
        return []
    day = start.date().isoformat()
    sensors = [(str(use.name or use.key), use.calibration) for use in _calibrated(test)]
    instruments = [("", one) for one in test.instruments]
    return [
        RunFlag(
            EXPIRED,
            channel,
            f"{one.sentence}: it had expired on {day}, the day of the test; calibrate it, or "
            "correct the day.",
        )
        for channel, one in (*sensors, *instruments)
        if one is not None and "" < one.valid_until < day
    ]


def flags_of(recording: Recording, result: RunResult) -> tuple[RunFlag, ...]:
    """Return all flags: those of the samples first, then those of the test."""
    start, stop = (
        at / result.recorded.sample_rate for at in (result.crop.start, result.crop.stop)
    )
    found_in_samples = health(recording)
    lost = unusable(found_in_samples, start, stop)
    seen = [
        RunFlag(
            f.kind,
            f.channel,
            _with_remedy(f, start, stop) if f in lost else f.message,
            f in lost,
        )
        for f in within(found_in_samples, start, stop)
    ]
    flags = [
        _crop(result),
        _controls(result),
        _level(result),
        _control_density(result),
        _control_sweep(result),
        _sweep_duration(result),
        _nyquist(result),
        _events(result),
        _problem("sweep", result.over_time.tracking.problem),
        _problem("notch", result.over_time.notch_problem),
    ]
    flags += expired(result.test, recording.start_time)
    flags += [
        RunFlag("sweep rate", result.channels[reading.channel].name, text)
        for reading in result.over_time.swept
        if (text := too_fast(reading, in_octaves=result.test.rate_hz_per_s is None))
    ]
    flags += [
        RunFlag(
            "control at resonance",
            result.channels[drop.channel].name,
            drop_sentence(drop, result),
        )
        for drop in control_drops(result)
    ]
    flags += [RunFlag(one.kind, "", text) for one in result.analyses for text in one.problems]
    known = {flag.kind for flag in seen}
    return (*seen, *(flag for flag in flags if flag is not None and flag.kind not in known))


def _with_remedy(flag: HealthFlag, start: float, stop: float) -> str:
    """Return the message of a flag, and the remedy where a channel did not measure."""
    without = "trends, compare, diagnose and add"
    if flag.kind == "clipping" and not unusable([flag], start, stop, most=MOST_CLIPPED):
        without = "trends and compare (diagnose and add leave the clipped samples out)"
    return (
        f"{flag.message} The test takes no part in {without}; to use its other channels, give "
        f"{flag.channel} the role ignore in this test."
    )


def _events(result: RunResult) -> RunFlag | None:
    """Return a flag where an event lies beyond the recording."""
    late = [
        event for event in result.test.events if event.time > result.recorded.promised_duration
    ]
    if not late:
        return None
    return RunFlag(
        "event",
        "",
        f"{late[0].note} at {late[0].time:g} s: the recording ends at "
        f"{numeral(result.recorded.promised_duration, 4)} s; correct the time in the log.",
    )


def _crop(result: RunResult) -> RunFlag | None:
    if result.crop.warning is None:
        return None
    crop = result.test.processing.crop
    channel = str(crop.channel) if isinstance(crop, ThresholdCrop) else ""
    return RunFlag("crop", channel, result.crop.warning)


def _controls(result: RunResult) -> RunFlag | None:
    if result.averages.imbalance is None or result.averages.imbalance.warning is None:
        return None
    return RunFlag("controls differ", "", result.averages.imbalance.warning)


def _level(result: RunResult) -> RunFlag | None:
    """Return whether the table kept the level of the log."""
    message = levels.mismatch(result.test, result.averages.measured_level)
    return RunFlag("level", "", message) if message else None


def _control_density(result: RunResult) -> RunFlag | None:
    """Return whether the density of the mean control keeps its limits at every frequency."""
    seen = control_density(result)
    if seen is None or seen.kept:
        return None
    return RunFlag("control density", "", f"the controls are {control_text(seen, 'band')}")


def control_density(result: RunResult) -> ControlSummary | None:
    """Return how well the density of the mean control keeps to the one demanded, if one is."""
    wanted, rows = levels.demanded(result.test), levels.watched(result.test, result.channels)
    if wanted is None or wanted.kind != "density" or not rows:
        return None
    frequency, width = result.spectra.frequency, EDGE_BINS * result.spectra.bin_width
    inside = (frequency > result.band[0] + width) & (frequency < result.band[1] - width)
    density = result.averages.psd[list(rows)].mean(axis=0)[inside]
    if not density.size or not (density > 0.0).all():
        return None
    off = 10.0 * np.log10(density / wanted.value)

    def beyond(limit: float, *, anywhere: bool) -> BoolArray:
        """Return the lines beyond a tolerance [dB] by more than chance."""
        factor = wanted.value * 10.0 ** (limit / 10.0), wanted.value * 10.0 ** (-limit / 10.0)
        high, low = (
            surely_beyond(density / edge, result.spectra, above=above, anywhere=anywhere)
            for edge, above in zip(factor, (True, False), strict=True)
        )
        return np.asarray(high | low)

    return _judged(result, wanted, off, beyond, frequency[inside])


def _control_sweep(result: RunResult) -> RunFlag | None:
    """Return whether the control kept its amplitude along a sweep."""
    seen = control_sweep(result)
    if seen is None or seen.kept:
        return None
    return RunFlag("control level", "", f"the control is {control_text(seen, 'sweep')}")


def control_sweep(result: RunResult) -> ControlSummary | None:
    """Return how well the mean control keeps its amplitude along a sweep, if that is asked."""
    wanted = levels.demanded(result.test)
    if wanted is None or wanted.kind != "amplitude" or result.test.excitation != "sine sweep":
        return None
    if levels.watched(result.test, result.channels) != result.controls:
        return None  # what is tracked along a sweep is the controls
    parts = []
    for sweep in result.over_time.tracking.sweeps:
        inner = inner_part(sweep)
        parts.append((sweep.frequency[inner], sweep.control[inner]))
    frequency, control = (
        np.concatenate([part[k] for part in parts] or [np.zeros(0)]) for k in (0, 1)
    )
    known = np.isfinite(control) & (control > 0.0)
    if not known.any():
        return None
    off = 20.0 * np.log10(control[known] / wanted.value)
    return _judged(
        result, wanted, off, lambda limit, **_: np.abs(off) > limit, frequency[known]
    )


def inner_part(sweep: Sweep) -> slice:
    """Return the points of a sweep between which its controller has come up."""
    edge = int(np.ceil(EDGE_OF_SWEEP * sweep.frequency.size))
    return slice(edge, sweep.frequency.size - edge)


def _judged(
    result: RunResult, wanted: levels.Level, off: FloatArray,
    sure: Callable[..., BoolArray], frequency: FloatArray,
) -> ControlSummary:  # fmt: skip
    """Return how a control that is `off` [dB] keeps its limits; `sure` tells where not."""
    tolerance = result.test.processing.tolerance
    beyond = float(np.mean(sure(tolerance.alarm, anywhere=False)))
    worst = int(np.argmax(np.abs(off)))
    return ControlSummary(
        demanded=wanted.shown[0],
        alarm_db=tolerance.alarm,
        abort_db=tolerance.abort,
        beyond_alarm=beyond,
        worst_db=float(off[worst]),
        worst_hz=float(frequency[worst]),
        kept=not sure(tolerance.abort, anywhere=True).any() and beyond <= BEYOND_ALARM,
    )


def _sweep_duration(result: RunResult) -> RunFlag | None:
    wanted = nominal_duration(result.test)
    there = result.crop.n_samples / result.recorded.sample_rate
    if not wanted or abs(there / wanted - 1.0) <= DURATION_TOLERANCE:
        return None
    return RunFlag(
        "duration",
        "",
        f"the sweep takes {numeral(wanted, 4)} s at the rate of the log, the crop holds "
        f"{numeral(there, 4)} s",
    )


def _problem(kind: str, message: str) -> RunFlag | None:
    """Return a flag for something that the log asks for and the samples do not give."""
    return RunFlag(kind, "", message) if message else None


def _nyquist(result: RunResult) -> RunFlag | None:
    band, nyquist = result.test.band, result.recorded.sample_rate / 2.0
    if band is None or band[1] <= nyquist:
        return None
    return RunFlag(
        "sample rate",
        "",
        f"the excitation reaches {band[1]:g} Hz, half the sample rate is {nyquist:g} Hz: what "
        "lies above is folded down",
    )
