"""Parts of tests that are simulated."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Parts of tests that are simulated, and what counts of them.

    Attributes
    ----------
    table : (n_windows, 3) array of int
        Test, first sample, and number of samples.
    counted : tuple of (n_samples,) array of bool
        Which samples of each window count.
    from_rest : bool
        Whether all begin at rest; else the motion where they begin is to be fitted.
    run_in : Windows, optional
        The same windows, of which only what starts are fitted to counts.
    passed : tuple of (n_sensors, n_samples) array, optional
        What noise of the input becomes in each window, standard deviation [unit of the
        sensor]; none where nothing is known of the motion yet.
    rate : float, optional
        Nudging rate at which all are held to the measured motion, with which they begin [1/s].
    lead : int, optional
        Samples after which they are let go; held throughout by default.
    """

    table: NDArray[np.int64]
    counted: tuple[NDArray[np.bool_], ...]
    from_rest: bool = True
    run_in: "Windows | None" = None
    passed: tuple[FloatArray, ...] | None = None
    rate: float | None = None
    lead: int | None = None

    def __len__(self) -> int:
        return len(self.table)

    def beginning(self, share: float, least: int) -> "Windows":
        """Return the first part of each window, of so many samples at least."""
        table = self.table.copy()
        sizes = np.maximum(np.ceil(share * table[:, 2]), least)
        table[:, 2] = np.minimum(table[:, 2], sizes.astype(int))
        counted = tuple(c[:size] for c, size in zip(self.counted, table[:, 2], strict=True))
        return Windows(table, counted, self.from_rest)

    def some(self, count: int) -> "Windows":
        """Return so many of the windows, evenly over all tests; all where there are no more."""
        if len(self) <= count:
            return self
        return self.chosen(np.linspace(0, len(self) - 1, count).round().astype(int))

    def chosen(self, which: NDArray[np.int64]) -> "Windows":
        """Return windows by their indices."""
        return replace(
            self,
            table=self.table[which],
            counted=tuple(self.counted[i] for i in which),
            run_in=None if self.run_in is None else self.run_in.chosen(which),
            passed=None if self.passed is None else tuple(self.passed[i] for i in which),
        )


BLOCK_S: Final = 0.5
"""Longest block in which the residual of a whole test has one scale [s]."""

HORIZON: Final = 15.0
"""Horizon that the tests have to hold, in periods of the joint's motion: the length of windows
follows from it where that is slow [-]."""

RUN_IN: Final = 2.0
"""Periods that tell the start of a window (DESIGN.md) [-]."""

FEWEST_BLOCKS: Final = 3
"""Blocks at least in which hypotheses are scored: of fewer no spread is known [-]."""

LEAST_WINDOWS: Final = 12
"""Windows of this horizon that the tests hold, of those fitted to and of those held out:
enough of them for the scatter of a difference (see `compare.free_run_error.BLOCKS`) [-]."""

BLOCK_PERIODS: Final = 30.0
"""Length of the blocks in which the residual of a whole test has one scale, in periods of the
joint's motion: what passes in a resonance of half a per cent of damping before the motion is
another [-]."""


@final
@dataclass(frozen=True, slots=True)
class Lengths:
    """Lengths of windows and blocks.

    Attributes
    ----------
    frequency : float
        Frequency of the motion of the joint that moves fastest [Hz].
    fitted, held_out : tuple of float
        Length of each stretch of the tests that is fitted to, and of each held out [s].
    filter_s : float
        What the filter of the residual takes of a window [s].
    """

    frequency: float
    fitted: tuple[float, ...]
    held_out: tuple[float, ...]
    filter_s: float

    @property
    def unit_s(self) -> float:
        """Unit of the lengths of windows [s].

        A period of the joint's motion; but where that is so slow that the tests hold too few
        windows to judge by, as of a drive that nothing pulls back, a part of the tests.
        """
        rooms = []
        for stretches in (self.fitted, self.held_out):
            lengths = [length - self.filter_s for length in stretches]
            rooms.append(min(max(lengths, default=0.0), sum(lengths) / LEAST_WINDOWS))
        return min(1.0 / self.frequency, min(rooms) / (HORIZON + RUN_IN))

    def run_in_s(self, length_s: float) -> float:
        """Return how much of a window tells its start, half of it at most [s].

        A motion that does not come back within a window tells its velocity the better the
        longer it is looked at.
        """
        return min(RUN_IN / self.frequency, length_s / 2.0)

    @property
    def block_s(self) -> float:
        """Length of the blocks in which the residual of a whole test has one scale [s].

        Of short tests so little that a spread is known of what is held out.
        """
        held_s = sum(self.held_out) or np.inf
        return min(BLOCK_S, BLOCK_PERIODS / self.frequency, held_s / FEWEST_BLOCKS)

    @property
    def cluster_s(self) -> float:
        """Length of the blocks whose scatter tells the intervals of numbers [s]."""
        return min(BLOCK_S, sum(self.fitted) / LEAST_WINDOWS)
