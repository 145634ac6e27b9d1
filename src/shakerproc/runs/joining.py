"""One recording of several: parts in sequence, and recorders side by side."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from itertools import pairwise
from pathlib import Path
from typing import Final, final

import numpy as np

from shakerproc.data import (
    Channel,
    FloatArray,
    Recording,
    SampleSource,
    SourceFile,
    UnusedChannel,
)
from shakerproc.errors import RecordingError, SpectrumError
from shakerproc.interpolation import TAPS, interpolated
from shakerproc.numerals import numeral
from shakerproc.recordings import ANOTHER_GROUP, WatchedFile
from shakerproc.recordings.source_files import FileHash
from shakerproc.recordings.time_base import CLOCKS
from shakerproc.runs.roles import row_named
from shakerproc.spectra.clocks import RecorderClock, clock_against

CLOSE: Final = 2e-3
"""How far the clock that stamps files may be off at the start of a part [s]."""


def combined(digests: Sequence[str]) -> str:
    """Return one SHA-256 for several files: that of their hashes; of one file its own."""
    different = list(dict.fromkeys(digests))
    if len(different) == 1:
        return different[0]
    return hashlib.sha256("".join(different).encode()).hexdigest()


def seen_files(paths: Sequence[Path]) -> tuple[FileHash, ...]:
    """Return the SHA-256 of each file of a test, with the stamp that it had.

    Raises
    ------
    RecordingError
        If one cannot be read.
    """
    file_hashes = []
    for path in paths:
        with WatchedFile(path, path.name, hashed=True) as file:
            file_hashes.append(file.fingerprint())
    return tuple(file_hashes)


@final
@dataclass(frozen=True, slots=True)
class SourceFiles(SourceFile):
    """The files behind a recording, watched together."""

    files: tuple[SourceFile, ...]

    def first_sha256(self) -> str:
        return combined([file.first_sha256() for file in self.files])

    def sha256(self) -> str:
        return combined([file.sha256() for file in self.files])

    def check(self) -> None:
        for file in self.files:
            file.check()

    def close(self) -> None:
        """Close all."""
        for file in self.files:
            file.close()


@final
@dataclass(frozen=True, slots=True, eq=False)
class SequenceSource(SampleSource):
    """Samples of recordings that follow each other."""

    parts: tuple[Recording, ...]

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        parts, first = [], 0
        for part in self.parts:
            low, high = max(start - first, 0), min(stop - first, part.n_samples)
            if low < high:
                parts.append(part.select(list(rows)).samples(low, high))
            first += part.n_samples
        return np.concatenate(parts, axis=1) if parts else np.empty((len(rows), 0))

    def close(self) -> None:
        """Close all."""
        for part in self.parts:
            part.source.close()


def in_sequence(run: str, parts: Sequence[Recording]) -> Recording:
    """Return recordings that follow each other as one.

    Raises
    ------
    RecordingError
        If they have other channels or rates, overlap, leave a gap, or one is cut short.
    """
    first, done = parts[0], 0
    for before, part in pairwise(parts):
        done += before.n_samples
        _check_next(run, first, before, part, done)
    dated = all(part.start_time is not None for part in parts)
    text = "each begins where the one before ends" if dated else "the files say no time"
    last = parts[-1]
    missing = (last.expected_samples or last.n_samples) - last.n_samples
    n_samples = done + last.n_samples
    return replace(
        first,
        run=run,
        n_samples=n_samples,
        expected_samples=n_samples + missing if missing > 0 else None,
        source=SequenceSource(tuple(parts)),
        rows=tuple(range(len(first.channels))),
        file=_files(parts),
        notes=(
            f"{len(parts)} files in sequence: {', '.join(_name(part) for part in parts)}; "
            f"{text}.",
            *dict.fromkeys(note for part in parts for note in part.notes),
        ),
    )


def _check_next(
    run: str, first: Recording, before: Recording, part: Recording, done: int
) -> None:
    """Pass a part that follows the one before it, `done` samples after the first began.

    Raises
    ------
    RecordingError
        If it does not.
    """
    channels = [[(c.name, c.unit) for c in one.channels] for one in (first, part)]
    if channels[0] != channels[1]:
        there = [", ".join(name for name, _ in one) for one in channels]
        raise RecordingError(
            f"{run}: {_name(part)} has the channels {there[1]}, {_name(first)} {there[0]}. "
            "Parts of one test need the same: name them under channels, or make two tests."
        )
    if abs(part.sample_rate / first.sample_rate - 1.0) > CLOCKS:
        raise RecordingError(
            f"{run}: {_name(part)} has {part.sample_rate:.9g} samples per second, "
            f"{_name(first)} {first.sample_rate:.9g}. Parts of one test need one rate."
        )
    if before.incomplete:
        missing = (before.expected_samples or 0) - before.n_samples
        raise RecordingError(
            f"{run}: {_name(before)} is cut short by {missing} samples before {_name(part)} "
            "follows. Copy the file again, or make two tests."
        )
    if part.start_time is None or first.start_time is None:
        return
    elapsed = done / first.sample_rate
    late = (part.start_time - first.start_time).total_seconds() - elapsed
    if abs(late) > CLOSE + CLOCKS * elapsed:
        how = f"{numeral(late, 4)} s after" if late > 0.0 else f"{numeral(-late, 4)} s before"
        what = "a gap" if late > 0.0 else "an overlap"
        raise RecordingError(
            f"{run}: {what}: {_name(part)} begins {how} {_name(before)} ends. Correct the "
            "order under continued, add the file that is missing, or make two tests."
        )


@final
@dataclass(frozen=True, slots=True, eq=False)
class BesideSource(SampleSource):
    """Samples of one recorder from a sample on, and of another at the same times."""

    main: Recording
    other: Recording
    clock: RecorderClock
    first: int

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        n = len(self.main.channels)
        out = np.empty((len(rows), max(0, stop - start)))
        here = [i for i, row in enumerate(rows) if row < n]
        theirs = [i for i, row in enumerate(rows) if row >= n]
        low, high = self.first + start, self.first + stop
        if here:
            out[here] = self.main.select([rows[i] for i in here]).samples(low, high)
        if theirs:
            chosen = self.other.select([rows[i] - n for i in theirs])
            times = self.clock.at(np.arange(low, high) / self.main.sample_rate)
            out[theirs] = interpolated(
                chosen.samples, chosen.n_samples, chosen.sample_rate, times,
                self.main.sample_rate,
            )  # fmt: skip
        return out

    def close(self) -> None:
        """Close both."""
        self.main.source.close()
        self.other.source.close()


def side_by_side(
    main: Recording,
    other: Recording,
    common: tuple[str | int, str | int] | None,
    *,
    stamped: bool = True,
) -> Recording:
    """Return the channels of two recorders as one recording, at the times of the first.

    Parameters
    ----------
    main, other : Recording
        Open recordings.
    common : (str or int, str or int), optional
        A channel of each that measured the same motion; it gives the clock of the other.
        Without it both have one clock.
    stamped : bool
        Whether that clock says when each begins; else they begin together.

    Raises
    ------
    RecordingError
        If there is no such channel, they have nothing in common, or no time.
    """
    clock, how = RecorderClock(0.0), "they begin together (starts: ignore)"
    if stamped:
        clock, how = RecorderClock(_by_stamps(main, other)), "they have one clock"
    if common is not None:
        clock, how = _clock(main, other, common)
    names = {channel.name for channel in main.channels}
    twice = [channel.name for channel in other.channels if channel.name in names]
    if twice:
        raise RecordingError(
            f"{main.run}: {_name(main)} and {_name(other)} both have a channel {twice[0]}. "
            "Give one another name under beside, or the role ignore."
        )
    exact = clock == RecorderClock(0.0) and other.sample_rate == main.sample_rate
    edge = 0.0 if exact else TAPS / min(other.sample_rate, main.sample_rate)
    until = clock.offset + other.duration / (1.0 + clock.drift) - edge
    first = max(0, int(np.ceil((clock.offset + edge) * main.sample_rate)))
    last = min(main.n_samples, round(until * main.sample_rate))
    if last - first < 2:
        raise RecordingError(
            f"{main.run}: {_name(main)} and {_name(other)} have no time in common: {how}."
        )
    rate = main.sample_rate
    note = (
        f"{_name(other)} beside {_name(main)}: {how}; its {other.sample_rate:.6g} Hz were "
        f"brought to {rate:.6g} Hz. Used is what both cover, {first / rate:.6g} to "
        f"{last / rate:.6g} s."
    )
    return replace(
        main,
        channels=(*main.channels, *_slower(other, rate)),
        rows=tuple(range(len(main.channels) + len(other.channels))),
        n_samples=last - first,
        start_time=main.start_time and main.start_time + timedelta(seconds=first / rate),
        expected_samples=(
            (main.expected_samples or 0) - first
            if main.incomplete and last == main.n_samples
            else None
        ),
        source=BesideSource(main, other, clock, first),
        file=_files([main, other]),
        notes=(note, *main.notes, *other.notes),
        unused=_unused_channels(main, other),
        in_file=None,
    )


def _slower(recording: Recording, rate: float) -> tuple[Channel, ...]:
    """Return the channels of a recording, with their own rate where it is the lower one."""
    if recording.sample_rate >= rate:
        return recording.channels
    own = recording.sample_rate
    return tuple(replace(c, own_rate=c.own_rate or own) for c in recording.channels)


def _unused_channels(main: Recording, other: Recording) -> tuple[UnusedChannel, ...]:
    """Return the channels that neither uses; of groups of one file, those both leave."""
    unused_channels = dict.fromkeys((*main.unused, *other.unused))
    if main.path != other.path:
        return tuple(unused_channels)
    both = set(main.unused) & set(other.unused)
    return tuple(one for one in unused_channels if one.why != ANOTHER_GROUP or one in both)


def _by_stamps(main: Recording, other: Recording) -> float:
    """Return how much later a recording of the same clock began, where both say when [s]."""
    if main.start_time is None or other.start_time is None:
        return 0.0
    return (other.start_time - main.start_time).total_seconds()


def _clock(
    main: Recording, other: Recording, common: tuple[str | int, str | int]
) -> tuple[RecorderClock, str]:
    """Return the clock of a recorder against that of another, and the notes on it.

    Raises
    ------
    RecordingError
        If there is no such channel, or they did not measure the same motion.
    """
    pair = []
    for recording, name in zip((main, other), common, strict=True):
        row = row_named(recording.channels, name)
        if row is None:
            there = ", ".join(channel.name for channel in recording.channels)
            raise RecordingError(
                f"{main.run}: common: no channel {name!r} in use in {_name(recording)}, which "
                f"has {there}. Name a channel that both recorders have, with a role."
            )
        pair.append(np.nan_to_num(recording.select([row]).samples()[0]))
    try:
        clock = clock_against(pair[0], main.sample_rate, pair[1], other.sample_rate)
    except SpectrumError as error:
        raise RecordingError(
            f"{main.run}: common: {common[0]} of {_name(main)} and {common[1]} of "
            f"{_name(other)}: {error}. Name channels that measured the same motion."
        ) from error
    late = "later" if clock.offset >= 0.0 else "earlier"
    fast = "fast" if clock.drift >= 0.0 else "slow"
    return clock, (
        f"it began {abs(clock.offset):.6g} s {late} and its clock is "
        f"{numeral(abs(clock.drift) * 1e6)} parts in a million {fast}, by {common[0]} and "
        f"{common[1]} (correlation {clock.correlation:.2f}); both are corrected"
    )


def _name(recording: Recording) -> str:
    return recording.run if recording.path is None else recording.path.name


def _files(parts: Sequence[Recording]) -> SourceFile | None:
    files: list[SourceFile] = []
    for part in parts:
        if isinstance(part.file, SourceFiles):
            files += part.file.files
        elif part.file is not None:
            files.append(part.file)
    return SourceFiles(tuple(files)) if files else None
