"""The length and the sample rate that the chosen channels have in common."""

import math
from collections.abc import Sequence
from typing import Final

from shakerproc.errors import RecordingError
from shakerproc.recordings.choosing import Chosen
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel

SAME_RATE: Final = 1e-7
"""How far the rates of channels may part, relative: 2 samples in 20 million."""

SAME_AS_LOG: Final = 1e-4
"""How far the log may round the sample rate, relative."""


def common_length(chosen: Sequence[Chosen], run: str) -> tuple[int, int | None, str]:
    """Return how many complete rows there are, how many there should be if more, and a note.

    A row is complete where every channel holds its sample: a program that is stopped between
    two writes leaves some channels longer than others.

    Raises
    ------
    RecordingError
        If there is no complete row.
    """
    channels = [channel for channel, _ in chosen]
    long = max(channels, key=lambda channel: channel.promised)
    short = min(channels, key=lambda channel: channel.n_samples)
    if not short.n_samples:
        raise RecordingError(
            f"{run}: there is not one complete row of samples: channel {shown(short.name)} "
            f"holds none of its {short.promised}. Copy the file again, or leave the channel "
            "out of the log."
        )
    note = ""
    if short.promised < long.promised:
        note = (
            f"Channel {shown(long.name)} holds {long.n_samples} samples, {shown(short.name)} "
            f"{short.n_samples}: the {short.n_samples} rows that all channels have are used."
        )
    return short.n_samples, long.promised if long.promised > short.n_samples else None, note


def common_rate(chosen: Sequence[Chosen], logged: float | None, run: str) -> tuple[float, str]:
    """Return the sample rate [Hz] and what had to be decided about it.

    The log's where the file resolves no difference to it, else the file's.

    Raises
    ------
    RecordingError
        If the file does not say it and the log neither, or they contradict each other.
    ValueError
        If `logged` is no rate.
    """
    said = {c.sample_rate: c.name for c, _ in reversed(chosen) if c.sample_rate is not None}
    silent = [c for c, _ in chosen if c.sample_rate is None]
    rates = sorted(said)
    if rates and rates[-1] / rates[0] - 1.0 > SAME_RATE:
        raise RecordingError(
            f"{run}: channel {shown(said[rates[-1]])} has {rates[-1]:.9g} samples per second, "
            f"{shown(said[rates[0]])} {rates[0]:.9g}. Use only channels of one rate: leave the "
            "others out of the log, or give them role: ignore."
        )
    if logged is None:
        if silent:
            raise RecordingError(_no_rate(silent[0], said, run))
        return rates[0], ""
    if not math.isfinite(logged) or logged <= 0.0:
        raise ValueError(f"sample_rate must be above 0 Hz, not {logged:g}")
    if rates and abs(rates[0] / logged - 1.0) > SAME_AS_LOG:
        raise RecordingError(
            f"{run}: the file says {rates[0]:.9g} samples per second, the log {logged:.9g}. "
            "Take sample_rate out of the log, or correct it."
        )
    if rates and not silent:
        doubt = max(c.rate_doubt for c, _ in chosen)
        return (logged if abs(rates[0] / logged - 1.0) <= doubt else rates[0]), ""
    return (
        rates[0] if rates else logged,
        f"The sample rate of {logged:.9g} Hz is taken as given: {silent[0].rate_problem}.",
    )


def _no_rate(channel: RawChannel, said: dict[float, str], run: str) -> str:
    guess = next(iter(said), channel.rate_hint)
    example = f"{guess:.6g} Hz" if guess else "5688.9 Hz"
    return (
        f"{run}: no sample rate for channel {shown(channel.name)}: {channel.rate_problem}. Put "
        "the right one in the log, for all tests or in this one, such as "
        f"processing: {{sample_rate: {example}}} (or --sample-rate-hz)."
    )
