"""The rate, the start and the common rows of the channels that are used together."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Final, final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.numerals import numeral
from shakerproc.recordings.choosing import Chosen
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, Sampling, TimeAxis
from shakerproc.recordings.resampling import Line
from shakerproc.recordings.time_base import SAME_AS_LOG, SAME_RATE, time_base
from shakerproc.recordings.times import SKEW

STAMP: Final = 1e-6
"""How far a date may be off [s]: it is held to the microsecond."""


@final
@dataclass(frozen=True, slots=True)
class Timing:
    """When the samples of several channels were taken.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    doubt : float
        How far that may be off, relative [-].
    doubtful : str
        What is to be known of it, where it is not simply the file's; sentences.
    begins : tuple of int
        Sample of each channel that is the first of the common rows.
    start_time : datetime, optional
        When that was taken.
    notes : tuple of str
        What had to be decided.
    lines : tuple of Line
        When the samples of each channel were taken, where they are interpolated to this rate;
        else empty.
    start : float
        The first of the interpolated times [s].
    """

    sample_rate: float
    doubt: float
    doubtful: str
    begins: tuple[int, ...]
    start_time: datetime | None
    notes: tuple[str, ...]
    lines: tuple[Line, ...] = ()
    start: float = 0.0

    def of_common(self, sample: int) -> int:
        """Return which common row a sample of the first channel is next to."""
        if not self.lines:
            return max(0, sample - min(self.begins))
        line = self.lines[0]
        seconds = line.start + sample / line.rate - self.start
        return max(0, round(seconds * self.sample_rate))


def with_time_bases(raw: RawFile, said: Sampling) -> RawFile:
    """Return a file whose channels say when their samples were taken.

    Channels that share the statements of their times share what comes of them.
    """
    known: dict[object, RawChannel] = {}

    def decided(channel: RawChannel) -> RawChannel:
        key = (id(channel.axes), channel.sample_rate, channel.start_time)
        if key not in known:
            known[key] = _decided(channel, said)
        one = known[key].time
        problem = channel.problem or (one.problem if one.spectrum else "")
        return replace(
            channel, sample_rate=one.sample_rate, start_time=one.first, problem=problem,
            time=one,
        )  # fmt: skip

    def group_of(group: RawGroup) -> RawGroup:
        return replace(
            group,
            channels=tuple(decided(c) for c in group.channels),
            measurements=tuple(group_of(part) for part in group.measurements),
        )

    return replace(raw, groups=tuple(group_of(group) for group in raw.groups))


def _decided(channel: RawChannel, said: Sampling) -> RawChannel:
    axes = channel.axes
    if channel.sample_rate is not None:
        axes = (*axes, TimeAxis("the file", rate=channel.sample_rate))
    return replace(channel, time=time_base(axes, channel.start_time, said))


def common_timing(chosen: Sequence[Chosen], said: Sampling, run: str) -> Timing:
    """Return when the samples of the chosen channels were taken.

    The rate is the log's where the file resolves no difference to it, else the file's.

    Raises
    ------
    RecordingError
        If the file does not say it and the log neither, they contradict each other, or the
        channels do not begin a whole number of samples after each other.
    """
    channels = [channel for channel, _ in chosen]
    if said.resample is not None:
        return _resampled(channels, said, said.resample, run)
    rate, doubtful, note = _rate(channels, said, run)
    begins, moment, told = _begins(channels, rate, said, run)
    notes = dict.fromkeys([*(c.time.note for c in channels), note, told])
    return Timing(
        sample_rate=rate,
        doubt=0.0 if rate == said.rate else max(c.time.doubt for c in channels),
        doubtful=doubtful,
        begins=begins,
        start_time=moment,
        notes=tuple(text for text in notes if text),
    )


def _resampled(channels: Sequence[RawChannel], said: Sampling, rate: float, run: str) -> Timing:
    """Return even times at a rate [Hz] that all channels cover, and the error of resampling.

    Raises
    ------
    RecordingError
        If the times of a channel are not told, or there is no time that all cover.
    """
    positive_rate(rate, "resample")
    starts, lines = _starts(channels), {}
    if said.ignore_starts:
        starts = [0.0] * len(channels)
    for channel, start in zip(channels, starts, strict=True):
        key = (id(channel.time), channel.n_samples)
        if key not in lines:
            lines[key] = _line(channel, start, said, run)
    of_each = tuple(lines[id(c.time), c.n_samples] for c in channels)
    first = max(line.start + line.edge(rate) for line in of_each)
    last = min(line.end - line.edge(rate) for line in of_each)
    if (last - first) * rate < 1.0:
        raise RecordingError(
            f"{run}: there are no two samples at {rate:.9g} Hz that all channels cover. Use "
            "only channels that were measured at one time, or a higher rate."
        )
    zeros = [c.time.start_time for c in channels if c.time.start_time is not None]
    if said.ignore_starts:
        zeros = [c.start_time for c in channels if c.start_time is not None]
    doubtful, cost = _cost(list(lines.values()), rate)
    ignored = _ignored(channels) if said.ignore_starts else ""
    notes = dict.fromkeys([*(c.time.note for c in channels), ignored, cost])
    return Timing(
        sample_rate=rate,
        doubt=max(c.time.doubt for c in channels),
        doubtful=doubtful,
        begins=(0,) * len(channels),
        start_time=min(zeros) + timedelta(seconds=first) if zeros else None,
        notes=tuple(text for text in notes if text),
        lines=of_each,
        start=first,
    )


def _line(channel: RawChannel, start: float, said: Sampling, run: str) -> Line:
    """Return when the samples of a channel were taken, from its start [s] on.

    Raises
    ------
    RecordingError
        If that is not told.
    """
    base = channel.time
    if base.times is not None:
        way = base.readings[0]
        times = np.asarray(base.times[:], dtype=np.float64)[: channel.n_samples]
        return Line(times.size, way.rate, start, (times - times[0]) * way.seconds)
    rate, _, _ = _rate([channel], said, run)
    return Line(channel.n_samples, rate, start)


def _cost(lines: Sequence[Line], rate: float) -> tuple[str, str]:
    """Return the doubt in interpolated samples, and the cost of the interpolation."""
    band = min(line.band(rate) for line in lines)
    text = (
        f"Every channel is interpolated to {rate:.9g} Hz (resample); that is good to 1 % up to "
        f"{numeral(band, 4)} Hz."
    )
    uneven = [line for line in lines if line.times is not None]
    if uneven:
        worst = max(uneven, key=lambda line: line.jitter)
        text += (
            f" The steps of the times vary by {numeral(100.0 * worst.jitter)} % rms about "
            f"{numeral(1e3 / worst.rate, 4)} ms."
        )
    gaps = np.concatenate([line.gaps for line in uneven]) if uneven else np.empty(0)
    if not gaps.size:
        return "", text
    return (
        f"{gaps.size} step{'s are' if gaps.size > 1 else ' is'} longer than two others, the "
        f"longest {numeral(1e3 * gaps.max(), 4)} ms: samples are missing there, and what is "
        "interpolated is a guess.",
        text,
    )


def _rate(channels: Sequence[RawChannel], said: Sampling, run: str) -> tuple[float, str, str]:
    """Return the sample rate [Hz], the reason to doubt it, and a note.

    Raises
    ------
    RecordingError
        If there is none, or the log contradicts the file.
    ValueError
        If the log's is no rate.
    """
    told = {c.sample_rate: c.name for c in reversed(channels) if c.sample_rate is not None}
    silent = [c for c in channels if c.sample_rate is None]
    rates, logged = sorted(told), said.rate
    if rates and rates[-1] / rates[0] - 1.0 > SAME_RATE:
        raise RecordingError(
            f"{run}: channel {shown(told[rates[-1]])} has {rates[-1]:.9g} samples per second, "
            f"{shown(told[rates[0]])} {rates[0]:.9g}. Use only channels of one rate: leave the "
            "others out of the log, or give them role: ignore; or have all interpolated to "
            f"one: processing: {{resample: {rates[-1]:.9g} Hz}} in the log (or --resample-hz "
            f"{rates[-1]:.9g})."
        )
    if logged is None:
        if silent:
            raise RecordingError(_no_rate(silent[0], said, rates, run))
        return rates[0], "", ""
    positive_rate(logged, "sample_rate")
    doubt = max(c.time.doubt for c in channels)
    away = abs(rates[0] / logged - 1.0) if rates else 0.0
    unclear = next(filter(_is_unclear, silent), None)
    if said.override and (unclear is not None or away > max(SAME_AS_LOG, doubt)):
        stated = f"{rates[0]:.9g} Hz" if rates else channels[0].time.problem
        note = f"The sample rate is {logged:.9g} Hz by override; in the file: {stated}."
        return logged, note, note
    if unclear is not None:
        raise RecordingError(_no_rate(unclear, said, rates, run))
    if away > max(SAME_AS_LOG, doubt):
        raise RecordingError(
            f"{run}: the file says {rates[0]:.9g} samples per second, the log {logged:.9g}. "
            "Take sample_rate out of the log, or correct it; where the file is wrong, write "
            f"sample_rate: {{value: {logged:.9g} Hz, override: true}} (or --override-rate)."
        )
    if rates and not silent:
        return (logged if away <= doubt else rates[0]), "", ""
    note = f"The sample rate of {logged:.9g} Hz is taken as given: {silent[0].time.problem}."
    return (rates[0] if rates else logged), _against(silent, logged), note


def _against(channels: Sequence[RawChannel], logged: float) -> str:
    """Return the objection of a file to an even rate that is taken all the same [Hz]."""
    problem = next((c.time.problem for c in channels if not c.time.is_silent), "")
    if not problem:
        return ""
    return (
        f"The rate of {logged:.9g} Hz is given against the file: {problem}. Where samples are "
        "missing, times, frequencies and damping are wrong: cut the recording there."
    )


def positive_rate(rate: float, name: str) -> None:
    """Pass a rate that is above 0 [Hz].

    Raises
    ------
    ValueError
        If it is not.
    """
    if not math.isfinite(rate) or rate <= 0.0:
        raise ValueError(f"{name} must be above 0 Hz, not {rate:g}")


def _is_unclear(channel: RawChannel) -> bool:
    """Return whether the file leaves the unit of its times open."""
    return len({way.unit for way in channel.time.readings}) > 1


def _no_rate(channel: RawChannel, said: Sampling, rates: Sequence[float], run: str) -> str:
    """Return that there is no rate, and the line of the log that gives it."""
    wrong = f"{run}: no sample rate for channel {shown(channel.name)}: {channel.time.problem}."
    ways = channel.time.readings
    if _is_unclear(channel):
        likely, right = ways[1], said.rate or ways[1].rate
        return (
            f"{wrong} Say which in the log, such as processing: {{time_unit: {likely.unit}}} "
            f"(or --time-unit {likely.unit}); where none is right, processing: {{sample_rate: "
            f"{{value: {right:.9g} Hz, override: true}}}} (or --sample-rate-hz {right:.9g} "
            "--override-rate)."
        )
    guess = next(iter(rates), ways[0].rate if ways else None)
    example = f"{guess:.6g} Hz" if guess else "5688.9 Hz"
    if channel.time.times is not None and guess:
        near = f"{round(guess) or guess:.6g}"
        return (
            f"{wrong} Have all channels interpolated to even times: processing: {{resample: "
            f"{near} Hz}} in the log (or --resample-hz {near}). Where the times are wrong and "
            f"the samples even, give their rate: sample_rate (or --sample-rate-hz)."
        )
    return (
        f"{wrong} Put the right one in the log, for all tests or in this one, such as "
        f"processing: {{sample_rate: {example}}} (or --sample-rate-hz)."
    )


def _begins(
    channels: Sequence[RawChannel], rate: float, said: Sampling, run: str
) -> tuple[tuple[int, ...], datetime | None, str]:
    """Return the sample of each channel that is the first of the common rows [rate in Hz].

    With it, when that was taken, and a note where channels begin one after the other.

    Raises
    ------
    RecordingError
        If they begin a part of a sample after each other.
    """
    dated = [c.start_time for c in channels if c.start_time is not None]
    if dated and len(dated) < len(channels):
        return (0,) * len(channels), min(dated), ""
    starts = _starts(channels)
    if said.ignore_starts:
        return (0,) * len(channels), min(dated, default=None), _ignored(channels)
    last = max(starts)
    begins, latest = [], channels[starts.index(last)]
    for channel, start in zip(channels, starts, strict=True):
        exact = (last - start) * rate
        doubt = channel.time.start_doubt + latest.time.start_doubt + STAMP * bool(dated)
        whole = round(exact)
        if abs(exact - whole) > max(doubt * rate, SKEW):
            raise RecordingError(
                f"{run}: channel {shown(latest.name)} starts {last - start:.9g} s after "
                f"{shown(channel.name)}: {exact:.6g} samples, no whole number. Have all "
                f"interpolated to common times: processing: {{resample: {rate:.9g} Hz}} in the "
                f"log (or --resample-hz {rate:.9g}). Where one clock took them all and only "
                "the stamps differ: processing: {starts: ignore} (or --ignore-starts)."
            )
        begins.append(whole)
    moment = max(dated) if dated else None
    if not any(begins):
        return tuple(begins), min(dated) if dated else None, ""
    most = max(begins)
    first = channels[begins.index(most)]
    return (
        tuple(begins),
        moment,
        (
            f"Channel {shown(latest.name)} starts {most} samples ({most / rate:.6g} s) after "
            f"{shown(first.name)}, as the file states: the rows that all have are used."
        ),
    )


def _ignored(channels: Sequence[RawChannel]) -> str:
    """Return that stated starts are not applied; empty where they are one."""
    starts = _starts(channels)
    late = max(starts) - min(starts)
    if late <= STAMP:
        return ""
    last = channels[starts.index(max(starts))]
    return (
        f"Stated starts are ignored (starts: ignore): channel {shown(last.name)} starts "
        f"{late:.6g} s after others by the file, and with them here."
    )


def _starts(channels: Sequence[RawChannel]) -> list[float]:
    """Return when each channel starts, behind the earliest date among them [s]."""
    zeros = [c.time.start_time for c in channels]
    known = [zero for zero in zeros if zero is not None]
    earliest = min(known) if known else None
    return [
        c.time.start + ((zero - earliest).total_seconds() if zero and earliest else 0.0)
        for c, zero in zip(channels, zeros, strict=True)
    ]
