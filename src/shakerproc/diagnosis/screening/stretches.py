"""Which samples are looked at: a bounded number, where the tests tell most."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest

MOST_SAMPLES: Final = 2**16
"""Samples of all stretches and sensors together: what bounds the cost of a screening [-]."""

FEWEST_SAMPLES: Final = 2**14
"""Samples of all stretches together, however many the sensors: three seconds [-]."""

LONGEST_BLOCK: Final = 2**12
"""Samples of a block: 0.7 s at 5.7 kHz, ten periods of the slowest joints there are [-]."""

SHORTEST_BLOCK: Final = 2**7
"""Samples of the smallest block that still has a spectrum worth the name [-]."""

FEWEST_BINS: Final = 8
"""Bins of the compared band that a block tells apart, at least: what is left over from before
the block takes two for each mass [-]."""

FEWEST_BLOCKS: Final = 12
"""Blocks wanted for a cross-validation [-]."""


EDGE: Final = 0.125
"""Share of a test at either end that is left out of it, at most [-]."""


@final
@dataclass(frozen=True, slots=True)
class Stretch:
    """Consecutive blocks of one test.

    Attributes
    ----------
    test : int
        Which test.
    start : int
        First sample.
    n_blocks, block : int
        How many blocks, and samples of each.
    """

    test: int
    start: int
    n_blocks: int
    block: int

    @property
    def stop(self) -> int:
        """First sample that no longer belongs to it."""
        return self.start + self.n_blocks * self.block

    def cut(self, samples: FloatArray) -> FloatArray:
        """Return samples [any unit] of the test as blocks, (..., n_blocks, block) array."""
        return self.folded(samples[..., self.start : self.stop])

    def folded(self, samples: FloatArray) -> FloatArray:
        """Return samples [any unit] of the stretch as blocks, (..., n_blocks, block) array."""
        return samples.reshape(*samples.shape[:-1], self.n_blocks, self.block)


def stretches_of(
    tests: Sequence[PreparedTest], motion: Sequence[FloatArray], n_sensors: int
) -> tuple[Stretch, ...]:
    """Return the stretches to look at: half of all in the test that moves most.

    Parameters
    ----------
    tests : sequence of PreparedTest
        The tests.
    motion : sequence of (n,) array
        How much the joints move in each, at every sample, in one unit.
    n_sensors : int
        Sensors of each test.
    """
    lengths = [test.stop - test.start for test in tests]
    total = min(max(MOST_SAMPLES // n_sensors, FEWEST_SAMPLES), sum(lengths))
    bins = max(FEWEST_BINS * test.sample_rate / np.ptp(test.band) for test in tests)
    block = block_length(total, min(lengths), round(bins))
    parts = [_inner_part(test, block) for test in tests]
    moves = [float(np.mean(m[p] ** 2)) for p, m in zip(parts, motion, strict=True)]
    order = sorted(range(len(tests)), key=lambda i: -moves[i])
    left = total // block
    wanted = dict.fromkeys(order, 0)
    for place, i in enumerate(order):
        others = len(order) - place - 1
        share = left // 2 if place == 0 and others else left // (others + 1)
        most = (parts[i].stop - parts[i].start) // block
        wanted[i] = min(most, max(share, 1))
        left -= wanted[i]
    return tuple(
        _strongest(Stretch(i, parts[i].start, n, block), motion[i][parts[i]])
        for i, n in wanted.items()
        if n > 0
    )


def block_length(total: int, shortest: int, resolving: int) -> int:
    """Return the samples of a block, of which `total` holds enough, and the shortest test one.

    `resolving` are the samples that tell enough of its bins apart.
    """
    wanted = max(SHORTEST_BLOCK, resolving, total // FEWEST_BLOCKS)
    block = LONGEST_BLOCK
    while block > min(wanted, (1.0 - 2.0 * EDGE) * shortest):
        block //= 2
    return block


def _inner_part(test: PreparedTest, block: int) -> slice:
    """Return the part of a test that is half a block away from where it breaks off."""
    edge = min(block // 2, int(EDGE * (test.stop - test.start)))
    return slice(test.start + (0 if test.at_rest else edge), test.stop - edge)


def _strongest(stretch: Stretch, motion: FloatArray) -> Stretch:
    """Return the stretch as long as this one that moves most, `motion` beginning with it."""
    power = np.concatenate([[0.0], np.cumsum(motion**2)])
    size = stretch.n_blocks * stretch.block
    first = int(np.argmax(power[size:] - power[:-size]))
    return replace(stretch, start=stretch.start + first)
