"""Where the model as it was fails most: bands, motions and tests."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, final

import numpy as np

from shakerproc.comparison.free_run_error import Scored, relative_errors, relative_residuals
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import RelativeMotion
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.result import Where

PER_OCTAVE: Final = 3
"""Bands in an octave: third octaves, as in every other table."""

MOST: Final = 0.5
"""Share of the squared error that the bands hold together: the larger half of it [-]."""

PARTS: Final = 20
"""Parts with equally many samples that a motion is cut into, by its size [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Failed:
    """One test as the model as it was simulates it.

    Attributes
    ----------
    name : str
        Name of the test.
    scored : Scored
        Measured and simulated.
    motion : RelativeMotion
        Of the joint in question, at the samples of the test.
    """

    name: str
    scored: Scored
    motion: RelativeMotion


def failed_tests(
    data: DataSet, joint: tuple[str, str], parts: Sequence[Mapping[int, Scored] | None]
) -> tuple[Failed, ...]:
    """Return the tests as a model simulates them, what was fitted and what was held out.

    Parameters
    ----------
    data : DataSet
        The tests.
    joint : (str, str)
        The joint in question.
    parts : sequence of mapping of int to Scored
        Disjoint samples of the tests, as `selection.errors.scored_tests` returns them; None
        where the motion ran away.
    """
    known = [part for part in parts if part is not None]
    motions = data.across(joint)
    out = []
    for i, test in enumerate(data.tests):
        own = [part[i] for part in known if i in part]
        if own:
            out.append(Failed(test.name, _together(own), motions[i]))
    return tuple(out)


def _together(parts: Sequence[Scored]) -> Scored:
    """Return one test of which disjoint samples were simulated apart."""
    first, *others = parts
    for other in others:
        simulated = np.where(other.counted, other.simulated, first.simulated)
        first = replace(first, simulated=simulated, counted=first.counted | other.counted)
    return first


def where_it_fails(tests: Sequence[Failed]) -> Where:
    """Return where a model fails most, by its free-run error; nothing of no tests.

    Bands are the fewest third octaves that hold half of the squared error, joined where they
    touch; ranges of motion those over which more is left than on average; tests those with
    more than the error of all.
    """
    if not tests:
        return Where()
    squared = [relative_residuals(one.scored) for one in tests]
    left = np.concatenate([
        np.sum(rows**2, axis=0)[one.scored.counted]
        for rows, one in zip(squared, tests, strict=True)
    ])
    displacement, velocity = (
        np.concatenate([np.abs(getattr(one.motion, name))[one.scored.counted] for one in tests])
        for name in ("displacement", "velocity")
    )
    return Where(
        _bands(tests, squared),
        _range(displacement, left),
        _range(velocity, left),
        _worst(tests),
    )


def _worst(tests: Sequence[Failed]) -> tuple[str, ...]:
    """Return the tests with more than the error of all; of equal ones all."""
    squares = np.array([float(np.mean(relative_errors(one.scored) ** 2)) for one in tests])
    average = float(np.mean(squares))
    return tuple(
        one.name
        for one, value in zip(tests, squares, strict=True)
        if value > average or np.isclose(value, average)
    )


def _bands(
    tests: Sequence[Failed], residuals: Sequence[FloatArray]
) -> tuple[tuple[float, float], ...]:
    """Return the fewest third octaves that hold half of the squared error [Hz]."""
    low = min(one.scored.band[0] for one in tests)
    high = max(one.scored.band[1] for one in tests)
    count = max(1, int(np.ceil(np.log2(high / low) * PER_OCTAVE)))
    edges = low * 2.0 ** (np.arange(count + 1) / PER_OCTAVE)
    power = np.zeros(count)
    for one, rows in zip(tests, residuals, strict=True):
        frequency = np.fft.rfftfreq(rows.shape[1], 1.0 / one.scored.sample_rate)
        density = np.sum(np.abs(np.fft.rfft(rows)) ** 2, axis=0) / rows.shape[1]
        which = np.clip(np.searchsorted(edges, frequency, side="right") - 1, 0, count - 1)
        power += np.bincount(which, density, count)
    order = np.argsort(power)[::-1]
    needed = int(np.searchsorted(np.cumsum(power[order]), MOST * power.sum())) + 1
    chosen = set(order[:needed].tolist()) if power.any() else set()
    return _joined([pair for i, pair in enumerate(pairwise(edges.tolist())) if i in chosen])


def _joined(bands: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Return bands, rising, joined where one ends at the start of the next."""
    out: list[tuple[float, float]] = []
    for low, high in bands:
        if out and out[-1][1] == low:
            out[-1] = (out[-1][0], high)
        else:
            out.append((low, high))
    return tuple(out)


def _range(size: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Return the range of a motion over which more than the average is left.

    Parameters
    ----------
    size : (n,) array
        Magnitude of the motion [m or m/s].
    left : (n,) array
        Square of what is left [-].
    """
    parts = [part for part in np.array_split(np.argsort(size), PARTS) if part.size]
    bad = [part for part in parts if np.mean(left[part]) > np.mean(left)] or parts
    return float(np.min(size[bad[0]])), float(np.max(size[bad[-1]]))
