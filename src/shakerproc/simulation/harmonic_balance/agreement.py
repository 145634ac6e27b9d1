"""Harmonic balance compared with the exact stepper, which shares nothing with it."""

from typing import Final

import numpy as np

from shakerproc.simulation.harmonic_balance.branch import Branch, samples_of_branch
from shakerproc.simulation.harmonic_balance.polishing import state_of
from shakerproc.simulation.harmonic_balance.response import Response
from shakerproc.simulation.harmonic_balance.shooting import one_round

CLOSE: Final = 256
"""Samples of a round that is compared with the exact stepper's."""


def difference_from_simulation(found: Response) -> float:
    """Return how far the tallest stable motion is from the exact stepper's, over one round.

    The stepper sets out from the state that harmonic balance gives, and is excited alike; the
    largest difference of the first mass over the round counts, as a share of its largest
    displacement [-]. NaN where no motion is stable, or where a law has a memory, whose state
    harmonic balance does not give.
    """
    tallest: tuple[float, Branch, int] | None = None
    for branch in found.branches:
        amplitude = np.max(np.abs(samples_of_branch(branch, 256)[:, 0]), axis=-1)
        steady = np.where(branch.stable, amplitude, 0.0)
        place = int(np.argmax(steady))
        if steady[place] > 0.0 and (tallest is None or steady[place] > tallest[0]):
            tallest = float(steady[place]), branch, place
    if tallest is None or tallest[1].balance.system.remembers:
        return float("nan")
    _, branch, point = tallest
    samples = samples_of_branch(branch, CLOSE)[point, 0]
    frequency = float(branch.frequency[point])
    stepped = one_round(
        found.model,
        found.level,
        frequency,
        state_of(branch, point),
        order=branch.balance.order,
        n_samples=CLOSE // branch.balance.order,
    )
    apart = np.abs(stepped.motion[0, :-1] - samples)
    return float(np.max(apart) / np.max(np.abs(samples)))
