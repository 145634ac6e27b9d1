"""Parts of tests that are simulated."""

from dataclasses import dataclass, replace
from typing import final

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
