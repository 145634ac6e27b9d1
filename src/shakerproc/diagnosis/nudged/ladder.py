"""The ladder of a race: nudging rates, and the pieces of tests fitted to at each."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.nudged.pieces import pieces

RATES: Final = ((1.0, 0.03), (0.3, 0.04), (0.1, 0.06), (0.03, 0.1), (0.01, 0.15), (0.003, 0.2))
"""Nudging rates over the angular frequency of the joint's motion, each a third of the last, and
the share of the tests that is fitted to at each [-]. Then runs are free."""

JUDGED: Final = 0.03
"""Rate over that angular frequency from which on a larger error ends a race: over less than
five periods everything looks linear [-]."""

LAST: Final = 0.03
"""The last of these rates of a structure whose tests begin at rest: its modes forget as soon by
their own damping, 1 % and more on feet, and whole tests come next [-]."""

FEWEST: Final = 4
"""Pieces at least that are fitted to at a rate [-]."""


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
