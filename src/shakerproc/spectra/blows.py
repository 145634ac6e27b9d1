"""Blows of a hammer: where they strike, how their blocks are cut, which can be used.

The blocks of all blows that are kept are the segments of which the spectra are averages. An
exponential window multiplies force and responses alike, which is exact: it moves every pole
to the left, so that the response functions are those of the structure with more damping,
known and taken away again where damping is read.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

LOUD: Final = 8.0
"""Standard deviations of the noise above which a force is no noise: in 10^9 samples of a
normal law none is [-]."""

SAME_BLOW: Final = 0.2
"""Time after a blow in which a second pulse is a rebound of the hammer, not the next blow;
nobody strikes five times a second by hand [s]."""

ROUNDING: Final = 1e-9
"""By how much the last digit of a number may be too large by arithmetic [-]."""

NORMAL: Final = 1.4826
"""Standard deviation of a normal law over its median absolute deviation [-]."""


@final
@dataclass(frozen=True, slots=True)
class Strikes:
    """Where a force strikes.

    Attributes
    ----------
    samples : tuple of int
        Where each blow reaches the trigger.
    sign : int
        1 where the pulses are positive, -1 where they are negative.
    level : float
        Of the trigger [N].
    noise : float
        Standard deviation of the force between the blows [N].
    offset : float
        Force at rest [N].
    """

    samples: tuple[int, ...]
    sign: int
    level: float
    noise: float
    offset: float


def find_strikes(
    force: FloatArray, sample_rate: float, trigger: float | None, share: float
) -> Strikes:
    """Return where a force strikes.

    Parameters
    ----------
    force : (n_samples,) array
        The force [N].
    sample_rate : float
        Samples per second [Hz].
    trigger : float, optional
        Force at which a blow begins [N].
    share : float
        Of the largest force, which is the trigger where none is given [-]; not less than
        `LOUD` times the noise.

    Returns
    -------
    Strikes
        A second pulse within `SAME_BLOW` belongs to the blow before.

    Raises
    ------
    SpectrumError
        If the force does not reach the trigger or does not stand out of its noise, or if a
        trigger that is given does not.
    """
    offset = float(np.median(force))
    rest = force - offset
    sign = 1 if rest.max() >= -rest.min() else -1
    struck = sign * rest
    noise = NORMAL * float(np.median(np.abs(rest)))
    largest = float(struck.max())
    if largest <= LOUD * noise:
        raise SpectrumError(
            f"no blow found: the largest force, {numeral(largest, 4)} N, does not stand out of "
            f"its noise of {numeral(noise)} N rms. Is the role force at the hammer, and its "
            "unit right?"
        )
    level = max(share * largest, LOUD * noise) if trigger is None else trigger
    if level < LOUD * noise:
        raise SpectrumError(
            f"the trigger of {numeral(level, 4)} N lies within the noise of the force, "
            f"{numeral(noise)} N "
            "rms, and would list noise as blows. Give processing: {hammer: {trigger: "
            f"{rounded_up(LOUD * noise)} N}}}} or more, or leave it out for a tenth of the "
            "largest force"
        )
    above = struck >= level
    if not above.any():
        raise SpectrumError(
            f"no blow found: the force never reaches the trigger of {numeral(level, 4)} N, its "
            f"largest value is {numeral(largest, 4)} N. Lower processing: {{hammer: {{trigger: "
            f"{numeral(0.1 * largest, 2)} N}}}}, or leave it out for a tenth of the largest"
        )
    rising = np.flatnonzero(above & ~np.concatenate([[False], above[:-1]]))
    kept: list[int] = []
    for at in rising:
        if not kept or at - kept[-1] >= SAME_BLOW * sample_rate:
            kept.append(int(at))
    return Strikes(tuple(kept), sign, level, noise, offset)


def rounded_up(value: float) -> str:
    """Return a number above 0 with two digits, not below it. `value` may be in any unit."""
    step = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return numeral(np.ceil(value / step - ROUNDING) * step)


def usual_length(strikes: Strikes, n_samples: int, before: int) -> int:
    """Return how many samples a block may have so that it ends before the next blow.

    Gaps of less than half the median count as blows too many, not as the length. A single
    blow has all to the end of the recording.

    Parameters
    ----------
    strikes : Strikes
        Where the force strikes.
    n_samples : int
        Of the recording.
    before : int
        Samples of a block before the trigger.
    """
    gaps = np.diff(strikes.samples)
    if not gaps.size:
        return n_samples - max(strikes.samples[0] - before, 0)
    return int(gaps[gaps >= 0.5 * np.median(gaps)].min()) - 1


LEAST_QUIET: Final = 8
"""Samples before a blow from which on their standard deviation is taken for the noise [-]: that
of eight is known to a quarter, 1/sqrt(2 (n - 1)), the one of two to nothing."""

RESPONSE_RISE: Final = 6.0
"""Standard deviations of the motion before a blow above which a channel responds [-]."""

DOUBLE_HIT: Final = 0.05
"""Share of the largest force of a blow from which on a second pulse is a double hit [-]."""

RESPONSE_PART: Final = 0.25
"""Share of a block after a blow in which a channel responds, if it does [-]."""

DECAYED_PART: Final = 0.05
"""Share of a block at its end in which is read how far the response has decayed [-]."""

FALSE_ALARM_BLOWS: Final = 1000
"""Blows of which one quiet part is said to ring although it holds noise alone [-]."""


@final
@dataclass(frozen=True, slots=True)
class BlockCut:
    """How a block is cut around a blow and windowed.

    Attributes
    ----------
    before, length : int
        Samples of a block before the trigger, and all of them.
    force_window : int, optional
        Samples from the trigger on after which the force is set to 0.
    decay_rate : float
        Of the exponential window, the reciprocal of its time constant [1/s]; 0 without one.
    sample_rate : float
        Samples per second [Hz].
    """

    before: int
    length: int
    force_window: int | None
    decay_rate: float
    sample_rate: float

    @property
    def quiet(self) -> int:
        """Samples at the start of a block that the pulse, begun before the trigger, spares."""
        return self.before // 2

    @property
    def force_part(self) -> slice:
        """Samples of a block in which the force is kept."""
        if self.force_window is None:
            return slice(0, self.length)
        return slice(max(self.before - self.force_window, 0), self.before + self.force_window)

    @property
    def window(self) -> FloatArray:
        """Weights of every channel, (length,) array [-]."""
        steps = np.arange(self.length)
        return np.asarray(np.exp(-self.decay_rate / self.sample_rate * steps), dtype=float)


@final
@dataclass(frozen=True, slots=True, eq=False)
class Setup:
    """Facts of a whole hammer test, by which each of its blows is judged.

    Attributes
    ----------
    force : int
        Row of the force.
    names : tuple of str
        Of the channels.
    ends : (2, n_channels) array
        Low and high end of the range of each channel, as `range_ends` [unit of the channel].
    strikes : Strikes
        Where the force strikes.
    cut : BlockCut
        How blocks are cut.
    rest : (n_channels,) array
        Standard deviation of each channel where it is quietest before a blow, 0 where it is not
        known [unit of the channel].
    """

    force: int
    names: tuple[str, ...]
    ends: FloatArray
    strikes: Strikes
    cut: BlockCut
    rest: FloatArray


@final
@dataclass(frozen=True, slots=True)
class Blow:
    """One blow.

    Attributes
    ----------
    sample : int
        Where it reaches the trigger.
    force : float
        Largest force, with its sign [N].
    width : float
        Time for which the force is above half of that [s].
    reason : str
        Why it is rejected; empty where it is kept.
    end_share : float
        Rms of the response at the end of the block over its largest value, the largest of
        all responses [-].
    silent : tuple of str
        Channels that do not respond.
    """

    sample: int
    force: float
    width: float
    reason: str
    end_share: float
    silent: tuple[str, ...] = ()

    @property
    def kept(self) -> bool:
        """Whether it is averaged."""
        return not self.reason


@final
@dataclass(frozen=True, slots=True, eq=False)
class Blows:
    """The blows of a run.

    Attributes
    ----------
    setup : Setup
        How they were found and cut; `setup.force` is the row of the force.
    blows : tuple of Blow
        All of them; samples count from the start of the recording.
    pulses : (n_kept, n) array
        Force of the blows that are kept, around the trigger [N].
    noise : (n_channels,) array
        Rms before these blows, the mean taken away, as it was before any window [unit of the
        channel]; not a number where fewer than `LEAST_QUIET` samples lie there.
    """

    setup: Setup
    blows: tuple[Blow, ...]
    pulses: FloatArray
    noise: FloatArray

    @property
    def kept(self) -> list[Blow]:
        """Those that are averaged."""
        return [blow for blow in self.blows if blow.kept]

    @property
    def end_share(self) -> float:
        """Mean share of a response that is left at the end of the blocks that are kept [-]."""
        return float(np.mean([blow.end_share for blow in self.kept]))

    @property
    def noise_density(self) -> FloatArray:
        """Density of white noise in the windowed blocks, (n_channels,) array [unit²/Hz]."""
        cut, power = self.setup.cut, self.setup.cut.window**2
        density = 2.0 / cut.sample_rate * self.noise**2
        density[self.setup.force] *= power[cut.force_part].sum() / power.sum()
        return np.asarray(density)


def windowed(block: FloatArray, setup: Setup) -> FloatArray:
    """Return a block without offsets, its force windowed; not yet the exponential window.

    Parameters
    ----------
    block : (n_channels, length) array
        Samples of the block [unit of the channel].
    setup : Setup
        How it was cut, and where the force rests.

    Returns
    -------
    (n_channels, length) array
        The mean of the quiet part before the trigger taken away from every channel, where there
        is none the rest from the force alone; the force 0 outside its window.
    """
    cut, force = setup.cut, setup.force
    result = np.array(block, dtype=np.float64)
    if cut.quiet:
        result -= block[:, : cut.quiet].mean(axis=1, keepdims=True)
    else:
        result[force] -= setup.strikes.offset
    result[force, : cut.force_part.start] = 0.0
    result[force, cut.force_part.stop :] = 0.0
    return result


def noise_before(blocks: Sequence[FloatArray]) -> FloatArray:
    """Return the rms of every channel before blows, the mean of each taken away.

    Parameters
    ----------
    blocks : sequence of (n_channels, n_quiet) arrays
        The quiet part before each blow [unit of the channel].

    Returns
    -------
    (n_channels,) array
        Not a number where these are fewer than `LEAST_QUIET` samples each.
    """
    quiet = np.asarray(blocks)
    if quiet.shape[-1] < LEAST_QUIET:
        return np.full(quiet.shape[1], np.nan)
    return np.asarray(np.sqrt(quiet.var(axis=-1, ddof=1).mean(axis=0)))


def judge(block: FloatArray, sample: int, setup: Setup) -> Blow:
    """Return the judgement of a blow, and the reason where it cannot be used.

    Parameters
    ----------
    block : (n_channels, length) array
        Samples of the block [unit of the channel].
    sample : int
        Where the blow reaches the trigger in the recording.
    setup : Setup
        What is known of the whole test.
    """
    strikes, rate = setup.strikes, setup.cut.sample_rate
    force = strikes.sign * (block[setup.force] - strikes.offset)
    pulse = _pulse(force, setup)
    peak = float(force[pulse].max())
    answers = {
        name: _residual_share(row, pulse.start, setup.cut.quiet, float(setup.rest[i]))
        for i, (name, row) in enumerate(zip(setup.names, block, strict=True))
        if i != setup.force
    }
    heard = [left for left in answers.values() if left is not None]
    reasons = (
        _double(force, pulse, setup),
        _overload(block, setup),
        "" if heard else "no response: no channel rises above its motion before",
    )
    return Blow(
        sample=sample,
        force=strikes.sign * peak,
        width=float(np.count_nonzero(force[pulse] >= 0.5 * peak)) / rate,
        reason="; ".join(reason for reason in reasons if reason),
        end_share=max(heard, default=0.0),
        silent=tuple(n for n, left in answers.items() if left is None),
    )


def incomplete(sample: int, cut: BlockCut, n_samples: int) -> str:
    """Return why the recording does not hold the block of a blow; empty where it does."""
    if sample < cut.before:
        there, wanted = sample / cut.sample_rate, cut.before / cut.sample_rate
        return (
            f"the recording begins {numeral(there)} s before it, pretrigger is "
            f"{numeral(wanted)} s"
        )
    if n_samples - sample < cut.length - cut.before:
        lasts = (n_samples - sample) / cut.sample_rate
        return f"the recording ends {numeral(lasts)} s after it, within the block"
    return ""


def impulse_share(row: FloatArray) -> float:
    """Return the share of a block's energy within a fiftieth of it around its largest value.

    Near 1 of a blow, less of what rings.

    `row` may be in any unit.
    """
    rest = row - np.median(row)
    top, half = int(np.argmax(np.abs(rest))), max(row.size // 100, 1)
    total = float(rest @ rest)
    near = rest[max(top - half, 0) : top + half + 1]
    return float(near @ near) / total if total > 0.0 else 0.0


def _pulse(force: FloatArray, setup: Setup) -> slice:
    """Return where the pulse of a blow lies in its block.

    It lasts while the force is above `DOUBLE_HIT` of its largest value and above the noise.
    """
    trigger = setup.cut.before
    under = np.flatnonzero(force[trigger:] < 0.5 * setup.strikes.level)
    end = trigger + int(under[0]) if under.size else force.size
    top = trigger + int(np.argmax(force[trigger:end]))
    below = np.flatnonzero(
        force <= max(DOUBLE_HIT * float(force[top]), LOUD * setup.strikes.noise)
    )
    place = int(np.searchsorted(below, top))
    first = int(below[place - 1]) + 1 if place else 0
    return slice(first, int(below[place]) if place < below.size else force.size)


def _double(force: FloatArray, pulse: slice, setup: Setup) -> str:
    """Return the message on a second strike within a block; empty where there is none."""
    peak = float(force[pulse].max())
    low = max(DOUBLE_HIT * peak, LOUD * setup.strikes.noise)
    for part, start in ((force[pulse.stop :], pulse.stop), (force[: pulse.start], 0)):
        if part.size and part.max() > low:
            at = start + int(np.argmax(part))
            delay = (at - setup.cut.before) / setup.cut.sample_rate
            kind = "double hit" if abs(delay) < SAME_BLOW else "another blow in the block"
            side = "after" if delay > 0.0 else "before"
            share = float(part.max()) / peak
            return f"{kind}: {share:.0%} of its force {_time(abs(delay))} {side} it"
    return ""


def _time(seconds: float) -> str:
    return f"{numeral(1e3 * seconds)} ms" if seconds < 1.0 else f"{numeral(seconds)} s"


def _overload(block: FloatArray, setup: Setup) -> str:
    """Return which channels stand at the end of their range; empty where none does."""
    at_ends = (block == setup.ends[:, :, np.newaxis]).any(axis=(0, 2))
    hit = [name for name, at in zip(setup.names, at_ends, strict=True) if at]
    return f"overload of {', '.join(hit)}: samples stand at the end of the range" if hit else ""


def _residual_share(row: FloatArray, begins: int, quiet: int, rest: float) -> float | None:
    """Return the share of a response left at the end [-]; None where it does not respond.

    It responds where it rises above its motion before the blow. It may where that is more than
    its noise at rest (F test of two variances): what rings of earlier blows hides the answer to
    this one, but no broken cable. Where too little lies before the blow to tell its noise, it
    responds, and what is left has the noise in it.
    """
    off = row - row[: max(quiet, 1)].mean()
    before = float(row[:quiet].std(ddof=1)) if quiet >= LEAST_QUIET else 0.0
    soon = begins + max(int(RESPONSE_PART * row.size), 1)
    rings = quiet >= LEAST_QUIET and before**2 > _most(quiet) * rest**2
    if float(np.abs(off[begins:soon]).max()) <= RESPONSE_RISE * before and not rings:
        return None
    end = off[-max(int(DECAYED_PART * row.size), 1) :]
    power = float(np.mean(end**2)) - rest**2
    return float(np.sqrt(max(power, 0.0))) / float(np.abs(off[begins:]).max())


def _most(n: int) -> float:
    """Return the ratio of variances of n samples that chance makes once in so many blows."""
    return float(scipy.special.fdtri(n - 1, n - 1, 1.0 - 1.0 / FALSE_ALARM_BLOWS))
