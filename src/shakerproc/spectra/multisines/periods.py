"""The periods and realisations of a multisine in a run, and which of them repeat."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError

WHOLE: Final = 0.01
"""By how many samples a period may miss a whole number: it is written in so many digits [-]."""

SHORTEST: Final = 8
"""Samples that a period has at least [-]."""

TRANSIENT: Final = 2.0
"""Power of the difference of two periods over that of later ones from which on the first of
the two is taken for a transient [-]: noise over a hundred lines rarely varies by as much."""

ROUNDING: Final = 1e-16
"""Power of a difference over that of the signal below which it is that of numbers [-]."""

DIFFERENT: Final = 0.1
"""Power of the noise of the input over its own from which on its periods do not repeat [-]."""

ALIKE: Final = 0.99
"""Correlation from which on two stretches of an input are the same [-]."""


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
            f"{needed / sample_rate:.6g} s, and the run has {n_samples / sample_rate:.6g} s; "
            "correct period, periods or realisations under multisine, or the crop"
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
    if abs(exact - n_period) > WHOLE or n_period < SHORTEST:
        raise SpectrumError(
            f"a period of {period:.9g} s is {exact:.9g} samples at {sample_rate:.9g} Hz, and a "
            f"whole number from {SHORTEST} on is needed; write "
            f"{max(n_period, SHORTEST) / sample_rate:.9g} s if it was that, else record with "
            "the clock of the generator, or resample"
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


def settled(lines: ComplexArray) -> int:
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
    limit = TRANSIENT * usual + ROUNDING * power
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
        if noise > DIFFERENT * power:
            raise SpectrumError(
                f"the periods do not repeat: successive ones of the input differ by "
                f"{100.0 * np.sqrt(2.0 * noise / power):.0f} % of its rms; "
                + _repeats(samples[: layout.periods * layout.n_period], sample_rate)
            )
    means = periods.mean(axis=1)
    size = np.sqrt(np.sum(means**2, axis=1))
    for m in range(1, len(means)):
        if means[m] @ means[m - 1] > ALIKE * size[m] * size[m - 1]:
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
    alike = products[: 2 * n // 3] > (1.0 - DIFFERENT) * common[: 2 * n // 3]
    apart = np.flatnonzero(~alike)
    again = np.flatnonzero(alike[apart[0] :]) if apart.size else np.zeros(0, int)
    if not again.size:
        return "nothing in it repeats: correct the crop, or record the multisine again"
    start = int(apart[0] + again[0])
    end = start + int(np.argmin(np.append(alike[start:], False)))
    lag = start + int(np.argmax(products[start:end]))
    return f"it repeats after {lag / sample_rate:.9g} s: correct period under multisine"
