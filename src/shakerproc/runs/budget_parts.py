"""Contributions that budgets of levels, peaks and modes share."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from shakerproc.runs.averaging import STEADY
from shakerproc.runs.budget import Budget, Contribution, normal, unknown
from shakerproc.runs.result import RunResult
from shakerproc.spectra import Damping
from shakerproc.spectra.peaks.damping import NORMAL

NOT_QUIET: Final = "no quiet segment before or after the run"
NO_SHEET: Final = "no calibration sheet states it"
BY_FIT: Final = "95 % interval of the fit"


def is_random(result: RunResult) -> bool:
    """Return whether chance of a density means anything: the run is random vibration."""
    return result.test.excitation in STEADY and result.bounds is not None


def over_mean(row: int, inputs: Sequence[int]) -> dict[int, float]:
    """Return the powers of the gains in a response function over the mean of its inputs."""
    return {row: 1.0} | {i: 1.0 / len(inputs) for i in inputs}


def calibration(result: RunResult, value: float, powers: Mapping[int, float]) -> Contribution:
    """Return what the calibration of channels does to a product of powers of their gains.

    `value` is the product [any unit], `powers` are by row of the channel [-].
    """
    channels = [result.channels[i] for i in powers]
    missing = [c.name for c in channels if c.uncertainty is None]
    if missing:
        return unknown("calibration", f"{NO_SHEET} of {', '.join(missing)}")
    parts = [p * (c.uncertainty or 0.0) for p, c in zip(powers.values(), channels, strict=True)]
    source = f"calibration sheet, {', '.join(c.name for c in channels)}"
    return normal("calibration", abs(value) * float(np.hypot.reduce(parts)), 2.0, source)


def of_mode(channel: str, quantity: str, at: float | None, read: Damping) -> Iterator[Budget]:
    """Yield natural frequency and damping ratio of a fit, as far as it tells them.

    `at` is the frequency of the peak [Hz].
    """
    if read.frequency is not None and read.frequency_low is not None:
        line = normal("random", read.frequency - read.frequency_low, NORMAL, BY_FIT)
        yield Budget(
            channel, f"{quantity} natural frequency", at, read.frequency, "Hz", (line,)
        )
    if read.ratio is not None and read.ratio_low is not None and read.ratio_high is not None:
        half = 0.5 * (read.ratio_high - read.ratio_low)
        yield damping(channel, quantity, at, read.ratio, half)


def damping(channel: str, quantity: str, at: float | None, ratio: float, half: float) -> Budget:
    """Return the budget of a damping ratio [-] from half its 95 % interval [-].

    `at` is the frequency of the peak [Hz].
    """
    line = normal("random", 100.0 * half, NORMAL, BY_FIT)
    return Budget(channel, f"{quantity} damping ratio", at, 100.0 * ratio, "%", (line,))
