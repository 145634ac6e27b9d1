"""Which lines of a multisine are excited, and which only listen."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

REACH: Final = 10
"""Lines to each side among which an excited one is looked for [-]: of four odd lines one is
left out at random, so that eight lines hold some."""

STANDS: Final = 0.2
"""Amplitude of an excited line over the largest near it, at least [-]: a force falls less than
that within a few lines, and what is not excited lies below in a shaker that is fit for this."""

LOWEST: Final = 0.01
"""The same over the largest of all lines [-]."""

STRAY: Final = 0.05
"""Share of even lines among those that seem excited up to which they are disturbances, such as
mains hum, and the multisine is odd [-]."""

NOISES: Final = 5.0
"""Amplitude of an excited line over the deviation of its mean, at least [-]."""

FEWEST: Final = 4
"""Excited lines of a realisation, at least [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """The lines of a multisine, from the first excited one to the last.

    Each realisation may excite lines of its own: a line that carries the input in one then
    shows distortion in another.

    Attributes
    ----------
    number : (n_lines,) array
        Which multiple of one over the period each is.
    frequency : (n_lines,) array
        [Hz].
    excited_in : (n_realisations, n_lines) array
        Whether the input moves there.
    """

    number: NDArray[np.int_]
    frequency: FloatArray
    excited_in: NDArray[np.bool_]

    @property
    def excited(self) -> NDArray[np.bool_]:
        """Lines at which the input moves in one realisation at least."""
        return np.asarray(self.excited_in.any(axis=0))

    @property
    def carried(self) -> NDArray[np.int_]:
        """Number of realisations in which the input moves at a line."""
        return np.asarray(self.excited_in.sum(axis=0))

    @property
    def common(self) -> bool:
        """Whether all realisations excite the same lines."""
        return bool(np.all(self.excited_in == self.excited_in[0]))

    @property
    def even(self) -> NDArray[np.bool_]:
        """Lines that show even distortion alone: even ones, none of them excited."""
        return self._detecting(0)

    @property
    def odd(self) -> NDArray[np.bool_]:
        """Odd lines that are not excited in one realisation at least."""
        return self._detecting(1)

    def _detecting(self, parity: int) -> NDArray[np.bool_]:
        """Return lines of a parity that detect: sums of even lines are even and odd alike."""
        odd_only = bool(np.all(self.number[self.excited] % 2 == 1))
        silent = ~self.excited_in.all(axis=0)
        result: NDArray[np.bool_] = silent & (self.number % 2 == parity) & odd_only
        return result


def grid_of(
    lines: ComplexArray, spacing: float, band: tuple[float, float], first: int = 0
) -> Grid:
    """Return which lines an input excites in each realisation.

    A line of which an input is suspected stands out of its neighbours in one realisation; it is
    excited in those in which it reaches a share of its own largest amplitude, so that neither a
    dip of the force nor a line that another realisation leaves out is mistaken.

    Parameters
    ----------
    lines : (n_realisations, n_periods, n_lines) array
        Spectrum of the input in every period, in any unit.
    spacing : float
        Distance of the lines [Hz].
    band : (float, float)
        Where excited ones are looked for [Hz].
    first : int
        Number of the first line.

    Raises
    ------
    SpectrumError
        If a realisation has not four.
    """
    number = first + np.arange(lines.shape[-1])
    inside = (number * spacing >= band[0] * (1.0 - 1e-9)) & (number > 0)
    inside &= number * spacing <= band[1] * (1.0 + 1e-9)
    each = np.abs(lines.mean(axis=1)) * inside
    largest = each.max(axis=0)
    around = scipy.ndimage.maximum_filter1d(largest, 2 * REACH + 1, mode="constant")
    suspected = inside & (largest > STANDS * around)
    suspected &= largest > LOWEST * largest.max(initial=0.0)
    excited = suspected & (each > STANDS * largest)
    if lines.shape[1] > 1:
        power = np.mean(np.var(lines, axis=1, ddof=1), axis=0)
        excited &= each > NOISES * np.sqrt(power / lines.shape[1])
    somewhere = excited.any(axis=0)
    if np.sum(somewhere & (number % 2 == 0)) <= STRAY * np.sum(somewhere):
        excited &= number % 2 == 1
    fewest = int(np.argmin(excited.sum(axis=1)))
    found = int(excited[fewest].sum())
    if found < FEWEST:
        whose = f" in realisation {fewest + 1}" if len(excited) > 1 else ""
        raise SpectrumError(
            f"only {found} lines of the input are excited{whose} from {numeral(band[0], 4)} to "
            f"{numeral(band[1], 4)} Hz; correct from, to, period or the role of the input"
        )
    chosen = np.flatnonzero(excited.any(axis=0))
    part = slice(int(chosen[0]), int(chosen[-1]) + 1)
    return Grid(number[part], np.asarray(number[part] * spacing, float), excited[:, part])
