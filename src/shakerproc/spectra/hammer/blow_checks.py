"""Which blows of a hammer can be used, and why others cannot."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.hammer.blows import LEAST_QUIET, BlockCut, Blow, Setup
from shakerproc.spectra.hammer.strikes import LOUD, SAME_BLOW

RISE: Final = 6.0
"""Standard deviations of the motion before a blow above which a channel responds [-]."""

SECOND: Final = 0.05
"""Share of the largest force of a blow from which on a second pulse is a double hit [-]."""

SOON: Final = 0.25
"""Share of a block after a blow in which a channel responds, if it does [-]."""

LAST: Final = 0.05
"""Share of a block at its end in which is read how far the response has decayed [-]."""


ALARMS: Final = 1000
"""Blows of which one quiet part is said to ring although it holds noise alone [-]."""


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
        name: _left(row, pulse.start, setup.cut.quiet, float(setup.rest[i]))
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
        left=max(heard, default=0.0),
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

    It lasts while the force is above `SECOND` of its largest value and above the noise.
    """
    trigger = setup.cut.before
    under = np.flatnonzero(force[trigger:] < 0.5 * setup.strikes.level)
    end = trigger + int(under[0]) if under.size else force.size
    top = trigger + int(np.argmax(force[trigger:end]))
    below = np.flatnonzero(force <= max(SECOND * float(force[top]), LOUD * setup.strikes.noise))
    place = int(np.searchsorted(below, top))
    first = int(below[place - 1]) + 1 if place else 0
    return slice(first, int(below[place]) if place < below.size else force.size)


def _double(force: FloatArray, pulse: slice, setup: Setup) -> str:
    """Return the message on a second strike within a block; empty where there is none."""
    peak = float(force[pulse].max())
    low = max(SECOND * peak, LOUD * setup.strikes.noise)
    for part, start in ((force[pulse.stop :], pulse.stop), (force[: pulse.start], 0)):
        if part.size and part.max() > low:
            at = start + int(np.argmax(part))
            apart = (at - setup.cut.before) / setup.cut.sample_rate
            kind = "double hit" if abs(apart) < SAME_BLOW else "another blow in the block"
            side = "after" if apart > 0.0 else "before"
            share = float(part.max()) / peak
            return f"{kind}: {share:.0%} of its force {_time(abs(apart))} {side} it"
    return ""


def _time(seconds: float) -> str:
    return f"{numeral(1e3 * seconds)} ms" if seconds < 1.0 else f"{numeral(seconds)} s"


def _overload(block: FloatArray, setup: Setup) -> str:
    """Return which channels stand at the end of their range; empty where none does."""
    at_ends = (block == setup.ends[:, :, np.newaxis]).any(axis=(0, 2))
    hit = [name for name, at in zip(setup.names, at_ends, strict=True) if at]
    return f"overload of {', '.join(hit)}: samples stand at the end of the range" if hit else ""


def _left(row: FloatArray, begins: int, quiet: int, rest: float) -> float | None:
    """Return the share of a response left at the end [-]; None where it does not respond.

    It responds where it rises above its motion before the blow. It may where that is more than
    its noise at rest (F test of two variances): what rings of earlier blows hides the answer to
    this one, but no broken cable. Where too little lies before the blow to tell its noise, it
    responds, and what is left has the noise in it.
    """
    off = row - row[: max(quiet, 1)].mean()
    before = float(row[:quiet].std(ddof=1)) if quiet >= LEAST_QUIET else 0.0
    soon = begins + max(int(SOON * row.size), 1)
    rings = quiet >= LEAST_QUIET and before**2 > _most(quiet) * rest**2
    if float(np.abs(off[begins:soon]).max()) <= RISE * before and not rings:
        return None
    end = off[-max(int(LAST * row.size), 1) :]
    power = float(np.mean(end**2)) - rest**2
    return float(np.sqrt(max(power, 0.0))) / float(np.abs(off[begins:]).max())


def _most(n: int) -> float:
    """Return the ratio of variances of n samples each that chance makes once in `ALARMS`."""
    return float(scipy.special.fdtri(n - 1, n - 1, 1.0 - 1.0 / ALARMS))
