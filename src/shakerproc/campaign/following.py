r"""One mode of a channel through the runs: which peak of each spectrum is its.

A peak continues the mode that it is most like,

.. math:: c = 1 - MAC(\phi, \psi) + |\ln(f / f')|,

with the operating shapes :math:`\phi, \psi` of all responses at both peaks, and f' the
frequency of the mode in another run. Without three sensors in common the shapes tell nothing:
c is the second term alone, continuity.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.modal.shapes import mac
from shakerproc.modal.tracking import LEAST_MAC, TELLING
from shakerproc.runs.summary import PeakSummary

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
        if not any(_alike(peak, taller) >= SAME_MAC for taller in peaks[:rank])
    ]


def _cost(one: PeakSummary, other: PeakSummary) -> float:
    """Return how unlike two peaks are [-]; `NEVER` where they are not one mode."""
    shift = abs(math.log(one.frequency_hz / other.frequency_hz))
    if shift > OCTAVE:
        return NEVER
    alike = _alike(one, other)
    if math.isnan(alike):
        return shift
    return NEVER if alike < LEAST_MAC else 1.0 - alike + shift


def _alike(one: PeakSummary, other: PeakSummary) -> float:
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
