"""Runs of a study in time, and readings of them: spectral peak, cycles, decay, periods."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError
from shakerproc.models import Model
from shakerproc.simulation import SimulatedResponse, simulate
from shakerproc.simulation.response import CHAOTIC_GROWTH
from shakerproc.spectra import cross_spectra, periodogram, psd
from shakerproc.spectra.peaks.finding import local_maxima
from shakerproc.studies.study import Measure, Quantity, StudyRun

NEIGHBOUR = 1e-9
"""How far apart the neighbouring runs of an ensemble begin, over the displacement there is."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SimulatedMotion:
    """The motion of the first mass relative to the base, once it has settled.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    time : (n,) array
        Instants [s].
    displacement, velocity : (n,) array
        Relative to the base [m], [m/s].
    acceleration : (n,) array
        Absolute [m/s²].
    growth : float
        How much a small disturbance grew [-].
    chaotic : bool
        Whether the trajectory cannot be trusted to the end.
    """

    sample_rate: float
    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    growth: float
    chaotic: bool

    def of(self, quantity: Quantity) -> FloatArray:
        """Return displacement, velocity or acceleration."""
        values: FloatArray = getattr(self, quantity)
        return values


def signal_of(run: StudyRun) -> Callable[[FloatArray], FloatArray]:
    """Return the excitation as a function of time [s], in its SI unit.

    A sweep begins as a cosine, as MATLAB's chirp; its phase is the integral of its frequency
    (eq. 5.1 taken literally would sweep at twice the rate).

    Raises
    ------
    ValueError
        If the excitation is random: it has samples, not a function.
    """
    if run.excitation == "free":
        return np.zeros_like
    if run.excitation == "sine":
        return lambda t: run.level * np.sin(2.0 * np.pi * run.frequency * t + run.phase)
    if run.excitation == "sine sweep":
        first, last = (run.to_hz, run.from_hz) if run.down else (run.from_hz, run.to_hz)
        if run.octaves:
            rate = np.log(last / first) / run.duration
            return lambda t: (
                run.level * np.cos(2.0 * np.pi * first * (np.exp(rate * t) - 1.0) / rate)
            )
        slope = (last - first) / run.duration
        return lambda t: run.level * np.cos(2.0 * np.pi * (first + 0.5 * slope * t) * t)
    raise ValueError("random excitation is no function of time")


def excitation_of(run: StudyRun) -> FloatArray:
    """Return the samples of the excitation, (n,) array in its SI unit.

    Random excitation is a multisine with random phases, flat between its frequencies, of the
    rms that the level says.
    """
    n_samples = round(run.duration * run.sample_rate) + 1
    time = np.arange(n_samples) / run.sample_rate
    if run.excitation != "random":
        return signal_of(run)(time)
    rng = np.random.default_rng(run.seed)
    lines = np.arange(1, n_samples // 2) / run.duration
    lines = lines[(lines >= run.from_hz) & (lines <= run.to_hz)]
    spectrum = np.zeros(n_samples // 2 + 1, np.complex128)
    places = np.round(lines * run.duration).astype(int)
    spectrum[places] = np.exp(2j * np.pi * rng.random(lines.size))
    samples = np.fft.irfft(spectrum, n_samples - 1)
    samples = np.append(samples, samples[0])
    return np.asarray(run.level * samples / np.sqrt(np.mean(samples**2)))


def simulated(model: Model, run: StudyRun, *, growth: bool = True) -> SimulatedMotion:
    """Return the motion of the first mass in one run."""
    if run.method != "exact":
        return _by_thesis_method(model, run)
    driving = excitation_of(run) if run.excitation == "random" else signal_of(run)
    response = simulate(
        model,
        driving,
        run.sample_rate,
        duration=None if run.excitation == "random" else run.duration,
        start=_start(model, run),
        growth=growth,
    )
    return _motion(response, run)


def _start(model: Model, run: StudyRun) -> dict[str, tuple[float, float]]:
    """Return displacement [m] and velocity [m/s] of the first mass, if it does not rest.

    Raises
    ------
    ModelError
        If the model has structures alone.
    """
    if not (run.initial_displacement or run.initial_velocity):
        return {}
    if not model.masses:
        raise ModelError(
            f"{model.title}: a start away from rest is that of the first mass, and the model "
            f"has structures alone. Leave initial_displacement and initial_velocity out."
        )
    return {next(iter(model.masses)): (run.initial_displacement, run.initial_velocity)}


def _by_thesis_method(model: Model, run: StudyRun) -> SimulatedMotion:
    """Return the motion by one of the methods that the thesis used; no growth is known.

    Raises
    ------
    ValueError
        If the run asks for the exact method.
    """
    from shakerproc.simulation.comparison import general_solver, newmark

    samples = excitation_of(run)
    time = np.arange(samples.size) / run.sample_rate
    start = np.zeros((2, len(model.masses)))
    start[:, 0] = run.initial_displacement, run.initial_velocity
    if run.method == "Newmark":
        response = newmark(model, samples, run.sample_rate, start=start)
    elif run.method == "exact":
        raise ValueError("the exact method is no method of the thesis")
    else:
        response = general_solver(
            model,
            _at_a_time(run, time, samples),
            time,
            method=run.method,
            relative_tolerance=run.tolerance,
            start=start,
        )
    skip = int(run.settle * samples.size)
    moving = 0.0 if model.excitation.on is not None else samples
    return SimulatedMotion(
        sample_rate=run.sample_rate,
        time=time[skip:],
        displacement=response.displacement[0, skip:],
        velocity=response.velocity[0, skip:],
        acceleration=(response.acceleration[0] + moving)[skip:],
        growth=float("nan"),
        chaotic=False,
    )


def _at_a_time(
    run: StudyRun, time: FloatArray, samples: FloatArray
) -> Callable[[float], float]:
    """Return the excitation at one time [s]; straight lines between samples of random ones."""
    if run.excitation == "random":
        return lambda t: float(np.interp(t, time, samples))
    signal = signal_of(run)
    return lambda t: float(signal(np.array([t]))[0])


def ensemble(model: Model, run: StudyRun, count: int) -> list[SimulatedMotion]:
    """Return neighbouring runs, whose initial displacements differ by next to nothing.

    Parameters
    ----------
    model : Model
        What is shaken.
    run : StudyRun
        How.
    count : int
        Number of runs.
    """
    size = float(np.max(np.abs(simulated(model, run, growth=False).displacement)))
    starts = run.initial_displacement + NEIGHBOUR * size * np.arange(1, count + 1)
    return [
        simulated(model, replace(run, initial_displacement=float(x)), growth=False)
        for x in starts
    ]


def strobe(
    model: Model, run: StudyRun, *, periods: int, settle: int, phases: int
) -> tuple[FloatArray, FloatArray, float]:
    """Return displacement and velocity once a period, at each of several phases.

    Parameters
    ----------
    model : Model
        What is shaken by a sine.
    run : StudyRun
        Its level, frequency and initial state.
    periods : int
        Periods that are looked at.
    settle : int
        Periods before.
    phases : int
        Phases of the excitation, equally spaced.

    Returns
    -------
    two (phases, periods) arrays, float
        Displacement [m] and velocity [m/s]; how much a small disturbance grew on the way [-].

    Raises
    ------
    ValueError
        If the excitation is no sine.
    """
    if run.excitation != "sine" or run.frequency <= 0.0:
        raise ValueError("looking once a period needs a sine with a frequency")
    per_period = phases * max(1, -(-16 // phases))
    response = simulate(
        model,
        signal_of(run),
        per_period * run.frequency,
        duration=(settle + periods) / run.frequency,
        start=_start(model, run),
    )
    first, step = settle * per_period, per_period // phases
    shape = (periods, phases)
    x = response.displacement[0, first : first + periods * per_period : step].reshape(shape)
    v = response.velocity[0, first : first + periods * per_period : step].reshape(shape)
    return x.T, v.T, float("nan") if response.growth is None else response.growth


def _motion(response: SimulatedResponse, run: StudyRun) -> SimulatedMotion:
    skip = int(run.settle * response.excitation.size)
    return SimulatedMotion(
        sample_rate=response.sample_rate,
        time=response.time[skip:],
        displacement=response.displacement[0, skip:],
        velocity=response.velocity[0, skip:],
        acceleration=response.acceleration[0, skip:],
        growth=float("nan") if response.growth is None else response.growth,
        chaotic=response.chaotic,
    )


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
    cross = cross_spectra(samples[None], sample_rate, segment=measure.segment)
    return Spectrum(cross.frequency, psd(cross)[0], cross.bin_width)


def peak_frequency(lines: Spectrum, measure: Measure) -> float:
    """Return the frequency of the tallest, or first, peak [Hz]; NaN where there is none.

    The first peak is the lowest local maximum of at least a thousandth of the tallest.
    """
    high = measure.to_hz or np.inf
    inside = (lines.frequency >= measure.from_hz) & (lines.frequency <= high)
    inside &= lines.frequency > 0.0
    frequency, density = lines.frequency[inside], lines.density[inside]
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
    quantities = {"growth": motion.growth, "chaotic": float(motion.chaotic)}
    if not motion.chaotic or several < 2:
        return motion, {**read(motion), **quantities}, {}
    rows = [read(one) for one in ensemble(model, run, several)]
    values = {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
    errors = {
        name: 2.0 * float(np.std([row[name] for row in rows]) / np.sqrt(several))
        for name in rows[0]
    }
    return motion, {**values, **quantities}, errors


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
    values: FloatArray = time[at] + (time[at + 1] - time[at]) * before / (before - after)
    return values


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
    residual = cycle - shapes @ fitted
    return float(np.sqrt(np.mean(residual**2) / np.mean((cycle - fitted[0]) ** 2)))


def share_at(lines: Spectrum, frequency: float) -> float:
    """Return the share of the energy nearer to a frequency than to its other multiples [-].

    Parameters
    ----------
    lines : Spectrum
        Density of the motion.
    frequency : float
        Frequency of the forcing [Hz]; NaN comes back where there is none.
    """
    total = float(np.sum(lines.density))
    if not (frequency > 0.0 < total):
        return float("nan")
    near = np.round(lines.frequency / frequency) == 1.0
    return float(np.sum(lines.density[near])) / total


def half_energy_bins(lines: Spectrum) -> float:
    """Return how many bins, the tallest first, hold half of the energy [-]."""
    total = float(np.sum(lines.density))
    if not total > 0.0:
        return float("nan")
    tallest_first = np.cumsum(np.sort(lines.density)[::-1])
    return float(np.searchsorted(tallest_first, 0.5 * total) + 1)


def period_of(displacement: FloatArray, velocity: FloatArray) -> float:
    """Return after how many periods motion seen once a period comes back; inf if it does not.

    Parameters
    ----------
    displacement, velocity : (n,) array
        Motion once a period of the excitation [m], [m/s].
    """
    for period in range(1, displacement.size // 2 + 1):
        repeats = (
            np.max(np.abs(one[period:] - one[:-period])) <= SETTLED * np.max(np.abs(one))
            for one in (displacement, velocity)
        )
        if all(repeats):
            return float(period)
    return float("inf")


def chaotic_in_steady_state(growth: float, period: float) -> bool:
    """Return whether motion once a period is chaotic: disturbed much, and not repeating.

    `growth` is a ratio [-], `period` counts periods of the drive [-].
    """
    return growth > CHAOTIC_GROWTH and not np.isfinite(period)
