"""Runs of a study in time: the excitation as a function, the motion of the first mass."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ModelError
from shakerproc.models import Model
from shakerproc.simulation import SimulatedResponse, simulate
from shakerproc.studies.study import Quantity, StudyRun

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
        found: FloatArray = getattr(self, quantity)
        return found


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
    found = simulate(
        model,
        driving,
        run.sample_rate,
        duration=None if run.excitation == "random" else run.duration,
        start=_start(model, run),
        growth=growth,
    )
    return _motion(found, run)


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
        found = newmark(model, samples, run.sample_rate, start=start)
    elif run.method == "exact":
        raise ValueError("the exact method is no method of the thesis")
    else:
        found = general_solver(
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
        displacement=found.displacement[0, skip:],
        velocity=found.velocity[0, skip:],
        acceleration=(found.acceleration[0] + moving)[skip:],
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
    found = simulate(
        model,
        signal_of(run),
        per_period * run.frequency,
        duration=(settle + periods) / run.frequency,
        start=_start(model, run),
    )
    first, step = settle * per_period, per_period // phases
    shape = (periods, phases)
    x = found.displacement[0, first : first + periods * per_period : step].reshape(shape)
    v = found.velocity[0, first : first + periods * per_period : step].reshape(shape)
    return x.T, v.T, float("nan") if found.growth is None else found.growth


def _motion(found: SimulatedResponse, run: StudyRun) -> SimulatedMotion:
    skip = int(run.settle * found.excitation.size)
    return SimulatedMotion(
        sample_rate=found.sample_rate,
        time=found.time[skip:],
        displacement=found.displacement[0, skip:],
        velocity=found.velocity[0, skip:],
        acceleration=found.acceleration[0, skip:],
        growth=float("nan") if found.growth is None else found.growth,
        chaotic=found.chaotic,
    )
