"""Where the force of a hammer strikes: blows by a trigger, and how far they lie apart."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

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
            f"its noise of {numeral(noise)} N rms; is the role force at the hammer, and its "
            "unit right?"
        )
    level = max(share * largest, LOUD * noise) if trigger is None else trigger
    if level < LOUD * noise:
        raise SpectrumError(
            f"the trigger of {numeral(level, 4)} N lies within the noise of the force, "
            f"{numeral(noise)} N "
            "rms, and would list noise as blows; give processing: {hammer: {trigger: "
            f"{rounded_up(LOUD * noise)} N}}}} or more, or leave it out for a tenth of the "
            "largest force"
        )
    above = struck >= level
    if not above.any():
        raise SpectrumError(
            f"no blow found: the force never reaches the trigger of {numeral(level, 4)} N, its "
            f"largest value is {numeral(largest, 4)} N; lower processing: {{hammer: {{trigger: "
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
