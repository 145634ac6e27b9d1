"""The ladder of a race: nudging rates, and the pieces of tests fitted to at each."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.stacks import TAPS
from shakerproc.diagnosis.hypotheses.joints import joints_of
from shakerproc.diagnosis.nudged.motion import slowest_decay

FORGOTTEN: Final = 3.0
"""Decay of the energy of an error, as a logarithm, after which a start is forgotten: to e^-3 =
5 %. Of a mass with a sensor that is one over the rate, times this [-]."""

LEAD: Final = 0.25
"""Share of a stretch that its lead-in takes at most: a push of half a second begins as its
sensors tell [-]."""

PERIODS: Final = 2.0
"""Periods of the joint's motion that the place of a joint takes to find itself [-]."""


FEWEST: Final = 8
"""Pieces at least that are fitted to at a rate, where tests hold as many [-]."""


def pieces(data: DataSet, rate: float, share: float, *, held_out: bool) -> Windows:
    """Return pieces of tests with as much of the energy of the responses in each step.

    With even steps in time, what a sweep passes in a moment would be lost. Each has a lead-in
    in which the start is forgotten, and which does not count; those that are to run freely are
    held in it alone, at the angular frequency of the joint's motion.

    Parameters
    ----------
    data : DataSet
        The tests.
    rate : float
        Nudging rate; 0 where the pieces run freely [1/s].
    share : float
        Share of the samples that counts; 1 is all [-].
    held_out : bool
        Whether to take what is held out, or what is fitted to.
    """
    held_at = rate or 2.0 * np.pi * data.frequency
    lead_s = max(
        FORGOTTEN / (2.0 * slowest_decay(data.model, held_at)), PERIODS / data.frequency
    )
    stretches = data.stretches(held_out=held_out)
    shortest = min((b - a for runs in stretches for a, b in runs), default=0)
    lead = min(round(lead_s * data.tests[0].sample_rate), round(LEAD * shortest)) + TAPS
    table, counted = [], []
    for i, (test, runs) in enumerate(zip(data.tests, stretches, strict=True)):
        length = max(lead, round(data.lengths.block_s * test.sample_rate))
        whole = max((b - a for a, b in runs), default=1)
        places = [
            (a, b)
            for run in runs
            for a, b in pairwise(_edges(*run, length if share < 1.0 else whole))
            if b > max(a, lead) + TAPS
        ]
        away = _away(data, i)
        for first, last in _chosen(data, i, places, share):
            earliest = max(0, first - lead)
            begin = max(0, earliest - round(test.sample_rate / data.frequency))
            begin += int(np.argmin(away[begin : earliest + 1]))
            table.append((i, begin, last - begin))
            counted.append(np.arange(begin, last) >= max(first, begin + lead))
    return Windows(
        np.array(table, np.int64).reshape(-1, 3), tuple(counted), rate=held_at,
        lead=None if rate else lead,
    )  # fmt: skip


def _away(data: DataSet, test: int) -> FloatArray:
    """Return how far joints are from their middle in each sample of a test, squared [-].

    Near it a law that follows one curve and forgets nothing, as one that saturates, is where a
    piece begins: without force. Of one that dissipates the start is forgotten.
    """
    away = np.zeros(data.tests[test].n_samples)
    for joint in joints_of(data.model):
        moved = data.across(joint)[test].displacement / (data.largest_across(joint) or 1.0)
        away += moved[: away.size] ** 2
    return away


def _edges(first: int, last: int, length: int) -> list[int]:
    """Return where equal parts of a stretch meet, of about a length."""
    count = max(1, (last - first) // length)
    return [int(v) for v in np.linspace(first, last, count + 1).round()]


def _chosen(
    data: DataSet, test: int, pieces_of: Sequence[tuple[int, int]], share: float
) -> Sequence[tuple[int, int]]:
    """Return a share of the pieces of a test, by their first sample and end."""
    if share >= 1.0:
        return pieces_of
    places = np.array(pieces_of).reshape(-1, 2)
    if not len(places):
        return []
    energy = np.cumsum(np.sum((data.tests[test].responses / data.noise[test]) ** 2, axis=0))
    own = np.maximum(energy[places[:, 1] - 1] - energy[places[:, 0]], 1e-300)
    least = math.ceil(FEWEST / len(data.tests))
    count = max(least, round(share * len(places)))
    if count >= len(places):
        return pieces_of
    steps = (np.arange(count) + 0.5) / count
    which = np.unique(np.searchsorted(np.cumsum(own) / own.sum(), steps))
    return [(int(a), int(b)) for a, b in places[np.minimum(which, len(places) - 1)]]


RATES: Final = ((1.0, 0.03), (0.3, 0.04), (0.1, 0.06), (0.03, 0.1), (0.01, 0.15), (0.003, 0.2))
"""Nudging rates over the angular frequency of the joint's motion, each a third of the last, and
the share of the tests that is fitted to at each [-]. Then runs are free."""

JUDGED: Final = 0.03
"""Rate over that angular frequency from which on a larger error ends a race: over less than
five periods everything looks linear [-]."""

LAST: Final = 0.03
"""The last of these rates of a structure whose tests begin at rest: its modes forget as soon by
their own damping, 1 % and more on feet, and whole tests come next [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Rung:
    """Data that are fitted at one nudging rate.

    Attributes
    ----------
    rate : float
        Nudging rate [1/s].
    windows : Windows
        Pieces of tests.
    rounds : int
        Steps of a fit.
    judged : bool
        Whether a larger error than before ends the race.
    """

    rate: float
    windows: Windows
    rounds: int
    judged: bool = False


ROUNDS: Final = 3
"""Steps of a fit at each rate: the next one goes on [-]."""


def ladder_of(data: DataSet) -> tuple[Rung, ...]:
    """Return the rungs of a data set, as far down as its tests are long enough and need it."""
    rungs: list[Rung] = []
    last = LAST if data.model.structures and all(t.at_rest for t in data.tests) else 0.0
    for share, part in (one for one in RATES if one[0] >= last):
        rate = share * 2.0 * np.pi * data.frequency
        windows = pieces(data, rate, part, held_out=False)
        if rungs and len(windows) < min(FEWEST, len(rungs[0].windows)):
            break
        rounds = ROUNDS - bool(data.model.structures)  # which go on along the same slopes
        rungs.append(Rung(rate, windows, rounds, share <= JUDGED))
    return tuple(rungs)
