"""Columns of slopes: those of gains and delays, and how columns stand side by side."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.stacks import Stack

DELAY_SPREAD: Final = 20e-6
"""Standard deviation of the delay of a channel: a tenth of a sample at 5 kHz [s]."""

FINE_STEP: Final = 3e-5
"""Change of a coordinate, forth and back, whose slopes are straight where a motion of hundreds
of periods is out of step at `STEP`: what bends or scatters passes for knowledge of what no test
tells [-]."""

FINE: Final = 1e-9
"""Truncation of a simulation of which these hold no more than 0.003 % [-]."""


def by_channels(at: Point, stack: Stack, outputs: FloatArray) -> list[FloatArray]:
    """Return the slopes of windows by the gain, then by the delay, of each sensor."""
    found = []
    for rows in (-outputs, at.gain[:, None] * stack.slope_in_time(outputs)):
        weighted = stack.weighted(rows)
        for s in range(at.gain.size):
            alone = np.zeros_like(weighted)
            alone[:, s] = weighted[:, s]
            found.append(flat(alone))
    return found


def flat(rows: FloatArray) -> FloatArray:
    """Return counted residuals of all sensors one after the other, (n_members, n_residuals)."""
    return rows.reshape(len(rows), -1)


def append(columns: list[list[FloatArray]], one: list[FloatArray]) -> None:
    """Add a column to those of every stack."""
    for own, column in zip(columns, one, strict=True):
        own.append(column)


def table(columns: list[FloatArray], rows: FloatArray, count: int) -> FloatArray:
    """Return columns side by side; zeros where there are none."""
    return np.stack(columns, axis=-1) if columns else np.zeros((*rows.shape, count))
