"""The parts of a long record: shocks, and the vibration between changes of its level."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.spectra.splitting.cells import Cells
from shakerproc.spectra.splitting.levels import MOST, changes, has_trend
from shakerproc.spectra.splitting.shocks import ShockRule, shocks_of

CELL: Final = 0.02
"""Length of a cell [s]."""

STRETCH: Final = 0.5
"""Length of the stretches among which changes of the level are sought, at least [s]."""

Kind: TypeAlias = Literal["shock", "stationary", "not stationary", "transient"]


@final
@dataclass(frozen=True, slots=True)
class RecordPart:
    """One part of a record.

    Attributes
    ----------
    kind : Kind
        A ``shock``; vibration that is ``stationary`` or ``not stationary`` (its level rises or
        falls); or a ``transient``, vibration that is too short to tell.
    first, stop : int
        First cell, and the cell after the last.
    """

    kind: Kind
    first: int
    stop: int


def split(cells: Cells, rule: ShockRule, *, shortest: float, step: float) -> list[RecordPart]:
    """Return the shocks and the parts of vibration of a record, in order of time.

    Shocks lie within parts of vibration, which are told without them.

    Parameters
    ----------
    cells : Cells
        The record.
    rule : ShockRule
        What is a shock.
    shortest : float
        Length of a stationary part at least [s].
    step : float
        By how much the level of two parts differs at least [dB].

    Returns
    -------
    list of RecordPart
        Vibration covers the whole record.
    """
    shocks = shocks_of(cells, rule)
    calm = np.ones(cells.count, dtype=np.bool_)
    for first, stop in shocks:
        calm[first:stop] = False
    ends = _ends(cells, calm, step)
    vibration = [
        RecordPart(_kind(cells, calm, first, stop, shortest), first, stop)
        for first, stop in pairwise(ends)
    ]
    found = [*vibration, *(RecordPart("shock", first, stop) for first, stop in shocks)]
    return sorted(found, key=lambda part: (part.first, -part.stop))


def _kind(
    cells: Cells, calm: NDArray[np.bool_], first: int, stop: int, shortest: float
) -> Kind:
    if (stop - first) * cells.seconds < shortest:
        return "transient"
    trend = has_trend(cells.mean_square[:, first:stop], calm[first:stop])
    return "not stationary" if trend else "stationary"


def _ends(cells: Cells, calm: NDArray[np.bool_], step: float) -> list[int]:
    """Return the cells at which the level changes, with both ends of the record."""
    least = round(STRETCH / cells.seconds)
    together = max(1, least, -(-cells.count // MOST))
    starts = np.arange(0, max(1, cells.count - together + 1), together)
    number = np.add.reduceat(calm.astype(np.float64), starts)
    energy = np.add.reduceat(cells.mean_square * calm, starts, axis=1)
    known = number > 0.0
    level = _decibels(energy[:, known] / number[known])
    ends = changes(level, step)
    fine = _decibels(np.where(calm, cells.mean_square, np.nan))
    places = np.flatnonzero(known)
    inner = [_refined(fine, int(starts[places[end]]), together) for end in ends[1:-1]]
    return [0, *sorted(set(inner) - {0, cells.count}), cells.count]


def _decibels(mean_square: FloatArray) -> FloatArray:
    """Return levels [dB], no more than 200 below the largest of a channel."""
    largest = np.nanmax(mean_square, axis=1, keepdims=True)
    return 10.0 * np.log10(np.maximum(mean_square, 1e-20 * np.where(largest, largest, 1.0)))


def _refined(fine: FloatArray, place: int, together: int) -> int:
    """Return the cell near a change at which the levels of both sides scatter least."""
    first = max(0, place - together)
    seen = fine[:, first : place + together]
    known = np.isfinite(seen).all(axis=0)
    values, at = seen[:, known], first + np.flatnonzero(known)
    if at.size < 2:
        return place
    counts = np.arange(1, at.size)
    sums = np.cumsum(values, axis=1)
    left, right = sums[:, :-1], sums[:, -1:] - sums[:, :-1]
    gain = np.sum(left**2 / counts + right**2 / counts[::-1], axis=0)
    return int(at[int(np.argmax(gain)) + 1])
