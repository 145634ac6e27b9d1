"""A model and its input in, the response out."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from typing import TypeVar

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.model import Model
from shakerproc.simulation.assembly import System, assemble
from shakerproc.simulation.cases import Case, Solver, by_series, first_motion, simulated_case
from shakerproc.simulation.inputs import Input, as_input, prepare_long
from shakerproc.simulation.kernels.table import Machine, Store
from shakerproc.simulation.pieces import ROUNDING, Chirp, Signal
from shakerproc.simulation.propagators import branches_of, build_store, no_store
from shakerproc.simulation.simulation import SimulatedResponse

Result = TypeVar("Result")


_SPANS = (4, 2)  # samples that a step may take

_LONGEST_STEP = 1.5  # radians of the stiffest spring in a step


def simulate(
    model: Model,
    excitation: FloatArray | Signal | Input,
    sample_rate: float | None = None,
    *,
    duration: float | None = None,
    start: Mapping[str, tuple[float, float]] | None = None,
    tolerance: float = 1e-15,
    growth: bool = True,
    solver: Solver = "automatic",
) -> SimulatedResponse:
    """Return the response of a model.

    Piecewise-linear laws (gaps, stops, Coulomb friction, sliders) are carried by exact
    propagators with located switchings; all others by Taylor series on the branch they are
    on, the order and the steps held to the tolerance, and every switching located. Laws with
    powers that are not whole have no series at 0; they go to DOP853.

    Parameters
    ----------
    model : Model
        What is shaken.
    excitation : (n,) array, function or Input
        Samples of the input, the input as a function of time, or what `prepare` made of it,
        where it is cut finer or does something else between its samples [m/s², N or m].
    sample_rate : float, optional
        Samples per second, of the input and of the response; not with an `Input` [Hz].
    duration : float, optional
        Length of the response to a function of time; not with an `Input` [s].
    start : mapping of str to (float, float), optional
        Displacement [m] and velocity [m/s] of masses relative to the base at the start; the
        others rest.
    tolerance : float
        Last terms of a Taylor series, of the motion as a share of the largest and of a chirp
        as a share of its amplitude; 1e-9 is quick, and ample for a comparison with
        measurements [-].
    growth : bool
        Whether to run once more with a disturbance of 1e-10 of start and input, to tell how
        it grows.
    solver : {"automatic", "exact", "taylor", "dop853"}
        ``exact`` and ``taylor`` insist on propagators or on series, ``dop853`` on the
        Runge-Kutta method that serves powers that are not whole (tolerance 1e-13 at least).

    Raises
    ------
    SimulationError
        If the motion runs away, or the steps become too small to go on.
    ValueError
        If the arguments do not fit together.
    """
    system = assemble(model)
    series = by_series(system, solver)
    given = None
    if series and isinstance(excitation, Chirp):
        given = _long_steps(
            model, system, excitation, sample_rate, duration, tolerance=tolerance
        )
    if given is None:
        given = as_input(
            excitation, sample_rate, duration=duration, tolerance=tolerance,
            imposed=model.excitation.imposed,
        )  # fmt: skip
    store = _store(system.machine, given, solver)
    first = first_motion(model, system, given, start)
    case = Case(model, system, store, given, first, tolerance, series)
    return simulated_case(case, growth=growth)


def simulate_many(
    models: Sequence[Model],
    excitation: FloatArray | Signal | Input,
    sample_rate: float | None = None,
    *,
    reduce: Callable[[SimulatedResponse], Result],
    duration: float | None = None,
    tolerance: float = 1e-15,
    growth: bool = False,
    workers: int | None = None,
) -> list[Result]:
    """Return the response of each of many models, reduced by `reduce`, on all cores.

    Parameters
    ----------
    models : sequence of Model
        What is shaken.
    reduce : function
        Called with each `SimulatedResponse`, so that not all of them are kept.
    excitation, sample_rate, duration, tolerance, growth
        See `simulate` [units as there].
    workers : int, optional
        Threads; by default as many as cores.
    """
    given = as_input(
        excitation, sample_rate, duration=duration, tolerance=tolerance,
        imposed=models[0].excitation.imposed,
    )  # fmt: skip

    def one(model: Model) -> Result:
        system = assemble(model)
        store = _store(system.machine, given, "automatic")
        first = first_motion(model, system, given, None)
        series = by_series(system, "automatic")
        case = Case(model, system, store, given, first, tolerance, series)
        return reduce(simulated_case(case, growth=growth))

    with ThreadPoolExecutor(workers or cpu_count() or 1) as pool:
        return list(pool.map(one, models))


def _long_steps(
    model: Model,
    system: System,
    chirp: Chirp,
    sample_rate: float | None,
    duration: float | None,
    *,
    tolerance: float,
) -> Input | None:
    """Return the input in pieces of several samples, where series may step as far.

    None where propagators serve, whose steps are samples, where a sensor needs the motion of
    the base, or where samples are so long that a series would not reach over several.
    """
    absolute = any(s.measures in {"displacement", "velocity"} for s in model.sensors.values())
    if sample_rate is None or duration is None or branches_of(system.machine) is not None:
        return None
    if (absolute and model.excitation.moves_base) or not (sample_rate > 0.0 < duration):
        return None
    n = len(system.names)
    stiffness = np.max(np.abs(system.machine.matrix[:, :n]), initial=0.0)
    for span in _SPANS:
        if np.sqrt(stiffness) * span / sample_rate < _LONGEST_STEP:
            return prepare_long(chirp, sample_rate, duration, span, max(tolerance, ROUNDING))
    return None


def _store(machine: Machine, given: Input, solver: Solver) -> Store:
    if solver in {"taylor", "dop853"}:
        return no_store()
    store = build_store(machine, given.part, given.pieces.shape[1] - 1)
    if solver == "exact" and not store.parts.size:
        raise ValueError("the model is not piecewise linear, or has too many combinations")
    return store
