"""Layout of a multisine: periods and realisations in a run, and the lines that are excited."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

PERIOD_ROUNDING: Final = 0.01
"""By how many samples a period may miss a whole number: it is written in so many digits [-]."""

SHORTEST_PERIOD: Final = 8
"""Samples that a period has at least [-]."""

TRANSIENT_POWER: Final = 2.0
"""Power of the difference of two periods over that of later ones from which on the first of
the two is taken for a transient [-]: noise over a hundred lines rarely varies by as much."""

ROUNDING_POWER: Final = 1e-16
"""Power of a difference over that of the signal below which it is that of numbers [-]."""

UNREPEATED_POWER: Final = 0.1
"""Power of the noise of the input over its own from which on its periods do not repeat [-]."""

REPEATED_CORRELATION: Final = 0.99
"""Correlation from which on two stretches of an input are the same [-]."""

LINE_REACH: Final = 10
"""Lines to each side among which an excited one is looked for [-]: of four odd lines one is
left out at random, so that eight lines hold some."""

LEAST_OF_NEIGHBOURS: Final = 0.2
"""Amplitude of an excited line over the largest near it, at least [-]: a force falls less than
that within a few lines, and what is not excited lies below in a shaker that is fit for this."""

LEAST_OF_ALL: Final = 0.01
"""The same over the largest of all lines [-]."""

STRAY_EVEN_LINES: Final = 0.05
"""Share of even lines among those that seem excited up to which they are disturbances, such as
mains hum, and the multisine is odd [-]."""

LEAST_OVER_NOISE: Final = 5.0
"""Amplitude of an excited line over the deviation of its mean, at least [-]."""

FEWEST_LINES: Final = 4
"""Excited lines of a realisation, at least [-]."""


@final
@dataclass(frozen=True, slots=True)
class PeriodLayout:
    """Where the periods of a multisine lie in a run.

    Attributes
    ----------
    n_period : int
        Samples of a period.
    periods, realisations : int
        Periods of each realisation, and how many of these there are.
    every : int
        Samples from the beginning of a realisation to that of the next.
    left_out : int
        Periods at the beginning of each realisation that are not used.
    """

    n_period: int
    periods: int
    realisations: int
    every: int
    left_out: int = 0

    def without(self, count: int) -> "PeriodLayout":
        """Return the layout without so many periods at the beginning of each realisation."""
        return replace(self, left_out=count)


def layout_of(
    n_samples: int,
    sample_rate: float,
    period: float,
    *,
    periods: int | None = None,
    realisations: int = 1,
    every: float | None = None,
) -> PeriodLayout:
    """Return where the periods of a run lie.

    Parameters
    ----------
    n_samples : int
        Samples of the run, which begins with the first realisation.
    sample_rate : float
        Samples per second [Hz].
    period : float
        After this time the multisine repeats [s].
    periods, realisations : int
        Of each realisation, by default as many as there is time for; and how many.
    every : float, optional
        From the beginning of one realisation to that of the next [s].

    Raises
    ------
    SpectrumError
        If a period is no whole number of samples, or the run is too short.
    """
    n_period = samples_of_period(period, sample_rate)
    if periods is None:
        periods = n_samples // (n_period * realisations)
    step = periods * n_period if every is None else round(every * sample_rate)
    needed = step * (realisations - 1) + max(periods, 1) * n_period
    if needed > n_samples or periods < 1:
        raise SpectrumError(
            f"{realisations} realisations of {max(periods, 1)} periods of {period:.6g} s need "
            f"{needed / sample_rate:.6g} s, and the run has {n_samples / sample_rate:.6g} s. "
            "Correct period, periods or realisations under multisine, or the crop"
        )
    return PeriodLayout(n_period, periods, realisations, step)


def samples_of_period(period: float, sample_rate: float) -> int:
    """Return how many samples a period [s] has at a sample rate [Hz].

    Raises
    ------
    SpectrumError
        If that is no whole number, or below eight.
    """
    exact = period * sample_rate
    n_period = round(exact)
    if abs(exact - n_period) > PERIOD_ROUNDING or n_period < SHORTEST_PERIOD:
        raise SpectrumError(
            f"a period of {period:.9g} s is {exact:.9g} samples at {sample_rate:.9g} Hz, and a "
            f"whole number from {SHORTEST_PERIOD} on is needed. Write "
            f"{max(n_period, SHORTEST_PERIOD) / sample_rate:.9g} s if it was that, else record "
            "with the clock of the generator, or resample"
        )
    return n_period


def cut(samples: FloatArray, layout: PeriodLayout) -> FloatArray:
    """Return the periods of a run, (n_channels, n_realisations, n_periods, n_period) array.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        The run, in any unit.
    layout : PeriodLayout
        Where its periods lie.
    """
    first = layout.left_out * layout.n_period
    stop = layout.periods * layout.n_period
    each = [
        samples[:, m * layout.every + first : m * layout.every + stop]
        for m in range(layout.realisations)
    ]
    shape = (len(samples), layout.realisations, -1, layout.n_period)
    return np.stack(each, axis=1).reshape(shape)


def transient_periods(lines: ComplexArray) -> int:
    """Return how many periods at the beginning do not repeat; two are always left.

    Parameters
    ----------
    lines : (n_channels, n_realisations, n_periods, n_lines) array
        Spectrum of every period, in any unit.
    """
    if lines.shape[2] < 3:
        return 0
    changes = np.sum(np.abs(np.diff(lines, axis=2)) ** 2, axis=(1, 3))
    power = np.sum(np.abs(lines[:, :, -1]) ** 2, axis=(1, 2))
    usual = np.median(changes[:, changes.shape[1] // 2 :], axis=1)
    limit = TRANSIENT_POWER * usual + ROUNDING_POWER * power
    odd = np.any(changes > limit[:, np.newaxis], axis=0)
    return int(np.argmin(odd)) if not odd.all() else 0


def check_input(samples: FloatArray, layout: PeriodLayout, sample_rate: float) -> None:
    """Pass an input that repeats within a realisation and differs between them.

    Parameters
    ----------
    samples : (n_samples,) array
        The input of the run, in any unit.
    layout : PeriodLayout
        Where its periods lie.
    sample_rate : float
        Samples per second [Hz].

    Raises
    ------
    SpectrumError
        If its periods do not repeat, or two realisations are the same.
    """
    (periods,) = cut(samples[np.newaxis], layout)
    periods = periods - periods.mean()
    power = float(np.mean(periods**2))
    if not power > 0.0:
        raise SpectrumError("the input does not move; correct its role in the log")
    if periods.shape[1] > 1:
        noise = float(np.mean(np.diff(periods, axis=1) ** 2)) / 2.0
        if noise > UNREPEATED_POWER * power:
            raise SpectrumError(
                f"the periods do not repeat: successive ones of the input differ by "
                f"{100.0 * np.sqrt(2.0 * noise / power):.0f} % of its rms; "
                + _repeats(samples[: layout.periods * layout.n_period], sample_rate)
            )
    means = periods.mean(axis=1)
    size = np.sqrt(np.sum(means**2, axis=1))
    for m in range(1, len(means)):
        if means[m] @ means[m - 1] > REPEATED_CORRELATION * size[m] * size[m - 1]:
            raise SpectrumError(
                f"realisations {m} and {m + 1} have the same phases: they are periods of one; "
                "correct periods and realisations under multisine"
            )


def _repeats(samples: FloatArray, sample_rate: float) -> str:
    """Return after which time an input repeats, in words."""
    centred = samples - samples.mean()
    n = centred.size
    spectrum = np.fft.rfft(centred, 2 * n)
    products = np.fft.irfft(np.abs(spectrum) ** 2, 2 * n)[:n]
    energy = np.cumsum(centred**2)
    common = np.sqrt(energy[::-1] * np.maximum(energy[-1] - np.append(0.0, energy[:-1]), 0.0))
    alike = products[: 2 * n // 3] > (1.0 - UNREPEATED_POWER) * common[: 2 * n // 3]
    apart = np.flatnonzero(~alike)
    again = np.flatnonzero(alike[apart[0] :]) if apart.size else np.zeros(0, int)
    if not again.size:
        return "nothing in it repeats: correct the crop, or record the multisine again"
    start = int(apart[0] + again[0])
    end = start + int(np.argmin(np.append(alike[start:], False)))
    lag = start + int(np.argmax(products[start:end]))
    return f"it repeats after {lag / sample_rate:.9g} s: correct period under multisine"


@final
@dataclass(frozen=True, slots=True, eq=False)
class LineGrid:
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
) -> LineGrid:
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
    around = scipy.ndimage.maximum_filter1d(largest, 2 * LINE_REACH + 1, mode="constant")
    suspected = inside & (largest > LEAST_OF_NEIGHBOURS * around)
    suspected &= largest > LEAST_OF_ALL * largest.max(initial=0.0)
    excited = suspected & (each > LEAST_OF_NEIGHBOURS * largest)
    if lines.shape[1] > 1:
        power = np.mean(np.var(lines, axis=1, ddof=1), axis=0)
        excited &= each > LEAST_OVER_NOISE * np.sqrt(power / lines.shape[1])
    somewhere = excited.any(axis=0)
    if np.sum(somewhere & (number % 2 == 0)) <= STRAY_EVEN_LINES * np.sum(somewhere):
        excited &= number % 2 == 1
    fewest = int(np.argmin(excited.sum(axis=1)))
    found = int(excited[fewest].sum())
    if found < FEWEST_LINES:
        whose = f" in realisation {fewest + 1}" if len(excited) > 1 else ""
        raise SpectrumError(
            f"only {found} lines of the input are excited{whose} from {numeral(band[0], 4)} to "
            f"{numeral(band[1], 4)} Hz; correct from, to, period or the role of the input"
        )
    chosen = np.flatnonzero(excited.any(axis=0))
    part = slice(int(chosen[0]), int(chosen[-1]) + 1)
    return LineGrid(number[part], np.asarray(number[part] * spacing, float), excited[:, part])
