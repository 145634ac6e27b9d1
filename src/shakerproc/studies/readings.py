"""Readings of a motion: its spectral peak, cycles, decay, periods, shares."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulation.simulation import CHAOTIC_GROWTH
from shakerproc.spectra import cross_spectra, periodogram, psd
from shakerproc.spectra.peaks.finding import local_maxima
from shakerproc.studies.simulated import SimulatedMotion, ensemble, simulated
from shakerproc.studies.study import Measure, StudyRun

SMALLEST = 1e-3
"""How tall the first peak must be, over the tallest [-]."""

SETTLED: Final = 1e-3
"""How near a motion must come back to count as the same, over its largest value [-]."""

Reader = Callable[[SimulatedMotion], Mapping[str, float]]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """A density with the width of its bins.

    Attributes
    ----------
    frequency : (n,) array
        Frequencies [Hz].
    density : (n,) array
        Density [unit²/Hz].
    bin_width : float
        Distance of the bins [Hz].
    """

    frequency: FloatArray
    density: FloatArray
    bin_width: float


def spectrum(samples: FloatArray, sample_rate: float, measure: Measure) -> Spectrum:
    """Return the density of samples by the estimator of a measure.

    Parameters
    ----------
    samples : (n,) array
        What was measured [any unit].
    sample_rate : float
        Samples per second [Hz] [Hz].
    measure : Measure
        How.

    Raises
    ------
    ValueError
        If a Welch segment is longer than the run.
    """
    if measure.estimator == "periodogram":
        frequency, density = periodogram(samples[None], sample_rate)
        return Spectrum(frequency, density[0], sample_rate / samples.size)
    if samples.size < measure.segment:
        raise ValueError(
            f"a run of {samples.size} samples holds no segment of {measure.segment}"
        )
    found = cross_spectra(samples[None], sample_rate, segment=measure.segment)
    return Spectrum(found.frequency, psd(found)[0], found.bin_width)


def peak_frequency(found: Spectrum, measure: Measure) -> float:
    """Return the frequency of the tallest, or first, peak [Hz]; NaN where there is none.

    The first peak is the lowest local maximum of at least a thousandth of the tallest.
    """
    high = measure.to_hz or np.inf
    inside = (found.frequency >= measure.from_hz) & (found.frequency <= high)
    inside &= found.frequency > 0.0
    frequency, density = found.frequency[inside], found.density[inside]
    tops = local_maxima(density)
    if tops.size == 0:
        return float("nan")
    tallest = tops[np.argmax(density[tops])]
    if measure.take == "first":
        tallest = tops[density[tops] >= SMALLEST * density[tallest]][0]
    return float(frequency[tallest])


def in_words(measure: Measure, bin_width: float) -> str:
    """Return how the peak frequency was found, for people. `bin_width` is in [Hz]."""
    how = "periodogram of the whole run"
    if measure.estimator == "welch":
        how = f"Welch density in segments of {measure.segment}"
    which = "tallest peak" if measure.take == "tallest" else "first peak"
    return f"peak frequency: {which} of the {measure.of} {how}, bins {bin_width:.4g} Hz"


def read_run(
    model: Model, run: StudyRun, several: int, read: Reader
) -> tuple[SimulatedMotion, dict[str, float], dict[str, float]]:
    """Return the motion of a run, the readings of it, and their resolution.

    Where the run is chaotic, the values are means over neighbouring runs, and a difference
    counts from twice the standard error of such a mean on.

    Parameters
    ----------
    model : Model
        What is shaken.
    run : StudyRun
        How.
    several : int
        Number of neighbouring runs; below 2 the one run has to do.
    read : function
        What is read from a motion.

    Returns
    -------
    Motion, dict, dict
        The motion of the run itself, the values, their standard errors doubled.
    """
    motion = simulated(model, run)
    told = {"growth": motion.growth, "chaotic": float(motion.chaotic)}
    if not motion.chaotic or several < 2:
        return motion, {**read(motion), **told}, {}
    rows = [read(one) for one in ensemble(model, run, several)]
    values = {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
    errors = {
        name: 2.0 * float(np.std([row[name] for row in rows]) / np.sqrt(several))
        for name in rows[0]
    }
    return motion, {**values, **told}, errors


def half_cycles(time: FloatArray, displacement: FloatArray) -> FloatArray:
    """Return how long each half cycle takes between zero crossings, (n,) array [s].

    Parameters
    ----------
    time : (n,) array
        Instants [s].
    displacement : (n,) array
        Motion about 0 [m].
    """
    return np.diff(_crossings(time, displacement))


def _crossings(time: FloatArray, displacement: FloatArray) -> FloatArray:
    """Return when a motion passes 0, between its samples on straight lines, (n,) array [s]."""
    at = np.flatnonzero(displacement[:-1] * displacement[1:] < 0.0)
    before, after = displacement[at], displacement[at + 1]
    found: FloatArray = time[at] + (time[at + 1] - time[at]) * before / (before - after)
    return found


def half_cycle_scatter(motion: SimulatedMotion) -> float:
    """Return the largest change from one half cycle to the next, over the mean half cycle [-].

    One frequency that glides changes a little from each to the next; several frequencies at
    once beat, and their zero crossings are scattered. NaN with fewer than two half cycles.
    """
    lengths = half_cycles(motion.time, motion.displacement)
    if lengths.size < 2:
        return float("nan")
    return float(np.max(np.abs(np.diff(lengths))) / np.mean(lengths))


def decay(motion: SimulatedMotion) -> float:
    """Return the largest displacement of the last tenth over that of the first [-]."""
    tenth = max(1, motion.displacement.size // 10)
    first = float(np.max(np.abs(motion.displacement[:tenth])))
    last = float(np.max(np.abs(motion.displacement[-tenth:])))
    return last / first if first > 0.0 else float("nan")


def distortion(motion: SimulatedMotion) -> float:
    """Return how far the first cycle is from a sine, rms over rms [-]; NaN without a cycle."""
    ends = _crossings(motion.time, motion.displacement)[:3]
    if ends.size < 3:
        return float("nan")
    inside = (motion.time >= ends[0]) & (motion.time < ends[2])
    cycle = motion.displacement[inside]
    if cycle.size < 8:
        return float("nan")
    phase = 2.0 * np.pi * (motion.time[inside] - ends[0]) / (ends[2] - ends[0])
    shapes = np.column_stack([np.ones(cycle.size), np.cos(phase), np.sin(phase)])
    fitted, *_ = np.linalg.lstsq(shapes, cycle, rcond=None)
    left = cycle - shapes @ fitted
    return float(np.sqrt(np.mean(left**2) / np.mean((cycle - fitted[0]) ** 2)))


def share_at(found: Spectrum, frequency: float) -> float:
    """Return the share of the energy nearer to a frequency than to its other multiples [-].

    Parameters
    ----------
    found : Spectrum
        Density of the motion.
    frequency : float
        Frequency of the forcing [Hz]; NaN comes back where there is none.
    """
    total = float(np.sum(found.density))
    if not (frequency > 0.0 < total):
        return float("nan")
    near = np.round(found.frequency / frequency) == 1.0
    return float(np.sum(found.density[near])) / total


def half_energy_bins(found: Spectrum) -> float:
    """Return how many bins, the tallest first, hold half of the energy [-]."""
    total = float(np.sum(found.density))
    if not total > 0.0:
        return float("nan")
    tallest_first = np.cumsum(np.sort(found.density)[::-1])
    return float(np.searchsorted(tallest_first, 0.5 * total) + 1)


def period_of(displacement: FloatArray, velocity: FloatArray) -> float:
    """Return after how many periods motion seen once a period comes back; inf if it does not.

    Parameters
    ----------
    displacement, velocity : (n,) array
        Motion once a period of the excitation [m], [m/s].
    """
    for period in range(1, displacement.size // 2 + 1):
        apart = (
            np.max(np.abs(one[period:] - one[:-period])) <= SETTLED * np.max(np.abs(one))
            for one in (displacement, velocity)
        )
        if all(apart):
            return float(period)
    return float("inf")


def chaotic_once_settled(growth: float, period: float) -> bool:
    """Return whether motion once a period is chaotic: disturbed much, and not repeating.

    `growth` is a ratio [-], `period` counts periods of the drive [-].
    """
    return growth > CHAOTIC_GROWTH and not np.isfinite(period)
