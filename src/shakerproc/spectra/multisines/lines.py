"""Which lines of a multisine are excited, and which only listen."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError

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


@final
@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """The lines of a multisine, from the first excited one to the last.

    Attributes
    ----------
    number : (n_lines,) array
        Which multiple of one over the period each is.
    frequency : (n_lines,) array
        [Hz].
    excited : (n_lines,) array
        Whether the input moves there.
    """

    number: NDArray[np.int_]
    frequency: FloatArray
    excited: NDArray[np.bool_]

    @property
    def even(self) -> NDArray[np.bool_]:
        """Lines that show even distortion alone: even ones, none of them excited."""
        return self._detecting(0)

    @property
    def odd(self) -> NDArray[np.bool_]:
        """Odd lines that are not excited."""
        return self._detecting(1)

    def _detecting(self, parity: int) -> NDArray[np.bool_]:
        """Return lines of a parity that detect: sums of even lines are even and odd alike."""
        odd_only = bool(np.all(self.number[self.excited] % 2 == 1))
        result: NDArray[np.bool_] = ~self.excited & (self.number % 2 == parity) & odd_only
        return result


def grid_of(
    lines: ComplexArray, spacing: float, band: tuple[float, float], first: int = 0
) -> Grid:
    """Return which lines an input excites.

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
        If there are not four.
    """
    number = first + np.arange(lines.shape[-1])
    inside = (number * spacing >= band[0] * (1.0 - 1e-9)) & (number > 0)
    inside &= number * spacing <= band[1] * (1.0 + 1e-9)
    mean = np.sqrt(np.mean(np.abs(lines.mean(axis=1)) ** 2, axis=0)) * inside
    around = scipy.ndimage.maximum_filter1d(mean, 2 * REACH + 1, mode="constant")
    excited = inside & (mean > STANDS * around) & (mean > LOWEST * mean.max(initial=0.0))
    if lines.shape[1] > 1:
        count = lines.shape[0] * lines.shape[1]
        power = np.mean(np.var(lines, axis=1, ddof=1), axis=0)
        excited &= mean > NOISES * np.sqrt(power / count)
    if np.sum(excited & (number % 2 == 0)) <= STRAY * np.sum(excited):
        excited &= number % 2 == 1
    chosen = np.flatnonzero(excited)
    if chosen.size < 4:
        raise SpectrumError(
            f"only {chosen.size} lines of the input are excited from {band[0]:.4g} to "
            f"{band[1]:.4g} Hz; correct from, to, period or the role of the input"
        )
    part = slice(int(chosen[0]), int(chosen[-1]) + 1)
    return Grid(number[part], np.asarray(number[part] * spacing, float), excited[part])
