r"""Trends: a frequency of each test against a fact of the log; one mode through the runs.

A peak continues the mode that it is most like,

.. math:: c = 1 - MAC(\phi, \psi) + |\ln(f / f')|,

with the operating shapes :math:`\phi, \psi` of all responses at both peaks, and f' the
frequency of the mode in another run. Without three sensors in common the shapes tell nothing:
c is the second term alone, continuity.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.modal.analysis import LEAST_MAC, TELLING
from shakerproc.modal.shapes import mac
from shakerproc.runs.summary import PeakSummary, Value

OCTAVE: Final = math.log(2.0)
"""Logarithm of the ratio of frequencies beyond which two peaks are never one mode [-]: the
stiffness would have to change fourfold."""

SAME_MAC: Final = 0.9
"""MAC from which on two peaks of one run are one mode that rattles or jumps [-]: correlated
modes in D. J. Ewins, "Modal Testing", 2nd ed., Research Studies Press, 2000, ch. 5."""

NEVER: Final = 1e6
"""Cost of what is no choice [-]."""


@final
@dataclass(frozen=True, slots=True)
class PeakSighting:
    """A peak that belongs to a mode.

    Attributes
    ----------
    run : int
        Number of its run, from 0.
    peak : PeakSummary
        The peak.
    """

    run: int
    peak: PeakSummary


@final
@dataclass(frozen=True, slots=True)
class Followed:
    """One mode of a channel through runs.

    Attributes
    ----------
    peaks : tuple of PeakSummary or None
        Its peak in each run; None where the run has none of it.
    others : tuple of tuple of float
        Where the further modes of each run are, those of peaks that other runs have too [Hz].
    by_shape : bool
        Whether three sensors or more tell it from other modes in every run.
    """

    peaks: tuple[PeakSummary | None, ...]
    others: tuple[tuple[float, ...], ...]
    by_shape: bool

    def unsure(self, one: int, other: int) -> bool:
        """Return whether the step between two runs may lead to another mode.

        It may where shapes do not tell, and it is longer than half the way to another mode of
        either run.
        """
        first, second = self.peaks[one], self.peaks[other]
        if self.by_shape or first is None or second is None:
            return False
        step = abs(math.log(second.frequency_hz / first.frequency_hz))
        return any(
            step > 0.5 * abs(math.log(away / peak.frequency_hz))
            for run, peak in ((one, first), (other, second))
            for away in self.others[run]
        )


def followed(runs: Sequence[Sequence[PeakSummary]]) -> Followed:
    """Return the mode that most often makes the tallest peak, through all runs.

    Parameters
    ----------
    runs : sequence of sequence of PeakSummary
        Peaks of one channel in each run, tallest first.
    """
    modes: list[list[PeakSighting]] = []
    # the runs with most peaks come first: they tell modes apart that others show one by one
    for run in sorted(range(len(runs)), key=lambda run: -len(runs[run])):
        peaks = _distinct(runs[run])
        costs = np.array([
            [min(_cost(peak, seen.peak) for seen in mode) for mode in modes] for peak in peaks
        ]).reshape(len(peaks), len(modes))
        some = costs.size > 0  # else the module is not loaded for nothing
        rows, columns = scipy.optimize.linear_sum_assignment(costs) if some else ((), ())
        continued = {
            int(i): modes[j] for i, j in zip(rows, columns, strict=True) if costs[i, j] < NEVER
        }
        for i, peak in enumerate(peaks):
            if i not in continued:
                modes.append([])
            continued.get(i, modes[-1]).append(PeakSighting(run, peak))
    if not modes:
        return Followed((None,) * len(runs), ((),) * len(runs), by_shape=False)
    chosen = max(modes, key=lambda mode: sum(s.peak is runs[s.run][0] for s in mode))
    of_run = {seen.run: seen.peak for seen in chosen}
    others: list[list[float]] = [[] for _ in runs]
    for mode in modes:
        if mode is not chosen and len(mode) > 1:
            for seen in mode:
                others[seen.run].append(seen.peak.frequency_hz)
    first = chosen[0].peak
    return Followed(
        tuple(of_run.get(run) for run in range(len(runs))),
        tuple(map(tuple, others)),
        all(len(_common(first, seen.peak)) >= TELLING for seen in chosen),
    )


def _distinct(peaks: Sequence[PeakSummary]) -> list[PeakSummary]:
    """Return peaks without those of the shape of a taller one."""
    return [
        peak
        for rank, peak in enumerate(peaks)
        if not any(_shape_mac(peak, taller) >= SAME_MAC for taller in peaks[:rank])
    ]


def _cost(one: PeakSummary, other: PeakSummary) -> float:
    """Return how unlike two peaks are [-]; `NEVER` where they are not one mode."""
    shift = abs(math.log(one.frequency_hz / other.frequency_hz))
    if shift > OCTAVE:
        return NEVER
    mac = _shape_mac(one, other)
    if math.isnan(mac):
        return shift
    return NEVER if mac < LEAST_MAC else 1.0 - mac + shift


def _shape_mac(one: PeakSummary, other: PeakSummary) -> float:
    """Return the MAC of the shapes at two peaks [-]; NaN where they tell nothing."""
    names = _common(one, other)
    if len(names) < TELLING:
        return math.nan
    first, second = (
        np.array([complex(*peak.shape[name]) for name in names]) for peak in (one, other)
    )
    return float(mac(first[np.newaxis], second[np.newaxis])[0, 0])


def _common(one: PeakSummary, other: PeakSummary) -> list[str]:
    return [name for name in one.shape if name in other.shape]


@dataclass(frozen=True, slots=True)
class TrendPoint:
    """One run in a trend.

    Attributes
    ----------
    test : str
        Its id.
    x : float or str
        Where it stands: a number, or a category.
    frequency_hz : float
        The peak frequency, interpolated [Hz].
    bin_width_hz : float
        Distance of the bins it was read from [Hz].
    present_s, promised_s : float or None
        How long its recording is, and how long it should be where it was cut short.
    """

    test: str
    x: float | str
    frequency_hz: float
    bin_width_hz: float
    present_s: float | None = None
    promised_s: float | None = None

    @property
    def incomplete(self) -> bool:
        """Whether its recording was cut short."""
        return self.promised_s is not None


@dataclass(frozen=True, slots=True)
class Trend:
    """Peak frequency against one quantity, in series.

    Attributes
    ----------
    name : str
        Name of its files.
    title, caption, x_label : str
        What it shows, and what to look for.
    channel : str
        Whose peak frequency it is.
    series : mapping
        Points by the name of the series, in order of x.
    quantity, bars : str
        What the points are, and how far their bars reach.
    """

    name: str
    title: str
    caption: str
    x_label: str
    channel: str
    series: Mapping[str, tuple[TrendPoint, ...]]
    quantity: str = "peak frequency [Hz]"
    bars: str = "width of a bin"

    def connected(self, name: str) -> bool:
        """Return whether a line through a series says something: one point for each number."""
        places = [p.x for p in self.series[name]]
        return self.numeric and len(places) > 1 and len(set(places)) == len(places)

    @property
    def numeric(self) -> bool:
        """Whether x is a number."""
        return all(isinstance(p.x, float) for points in self.series.values() for p in points)


@dataclass(frozen=True, slots=True)
class TrendValue:
    """Value that one test gives of a quantity of a trend.

    Attributes
    ----------
    test : str
        Its id.
    facts : mapping
        What the log says of the test, by column.
    frequency_hz : float or None
        The value; None where the test does not tell [Hz].
    width_hz : float
        How far its bar reaches, both sides together [Hz].
    present_s, promised_s : float or None
        As of a `TrendPoint`.
    left_out : str
        Why the test takes no part; empty where it does.
    tallest_hz : float or None
        Where the tallest peak is, if it is another one [Hz].
    unsure : frozenset of str
        Tests to which the step from this one may lead to another mode.
    how : str
        How the peak was found among others; empty for by its frequency.
    """

    test: str
    facts: Mapping[str, Value]
    frequency_hz: float | None
    width_hz: float
    present_s: float | None = None
    promised_s: float | None = None
    left_out: str = ""
    tallest_hz: float | None = None
    unsure: frozenset[str] = frozenset()
    how: str = ""


@dataclass(frozen=True, slots=True)
class TrendRequest:
    """Quantities that a trend sets against each other.

    Attributes
    ----------
    name, title, caption : str
        Name of its files, headline, what to look for.
    x : str
        Column along the axis.
    by : tuple of str
        Columns whose values make the series.
    where : tuple of (str, str)
        Columns and the value a run must have there to take part.
    """

    name: str
    title: str
    caption: str
    x: str
    by: tuple[str, ...]
    where: tuple[tuple[str, str], ...] = ()
