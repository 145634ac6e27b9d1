"""A model and its input in, the response out: by which solver, and how far to trust it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models.model import BASE, Measures, Model, Sensor
from shakerproc.models.validation import check_unscaled
from shakerproc.simulation.assembly import System, assemble, branches_of, build_store, no_store
from shakerproc.simulation.inputs import Input, as_input, prepare_long
from shakerproc.simulation.kernels.carried_forces import room_to_carry
from shakerproc.simulation.kernels.dop853 import WORK_ROWS, integrate_dop853
from shakerproc.simulation.kernels.table import Machine, Store, room_for_series
from shakerproc.simulation.kernels.windows import DONE, STUCK, Nudges, walk_windows
from shakerproc.simulation.pieces import ROUNDING, Chirp, InterpolationError, Signal

SENSITIVE_GROWTH: Final = 1e4
"""Past it no measured input is known well enough to predict the motion in time [-]."""

CHAOTIC_GROWTH: Final = 1e8
"""A disturbance of 1e-10 that grows more than this becomes a hundredth of the motion [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SimulatedResponse:
    """The response of a model, and how far it can be trusted.

    Attributes
    ----------
    sample_rate : float
        Samples per second [Hz].
    outputs : mapping of str to (n,) array
        What each sensor of the model records, by its name, faults and all, in SI units.
    excitation : (n,) array
        The input at the samples: acceleration of the base [m/s^2], force [N] or imposed
        displacement [m].
    masses : tuple of str
        What moves, in the order of the rows below: masses, attached and further modes, points
        of structures.
    displacement, velocity : (n_masses, n) array
        Motion relative to the base [m], [m/s].
    acceleration : (n_masses, n) array
        Absolute acceleration [m/s^2].
    states : (n_states, n) array
        Memory of the laws that have any, in the order of the elements.
    solver : str
        How it was computed.
    switchings : int
        Changes of branch: contacts made or lost, joints that stuck or slid.
    error : float, optional
        Estimated error of displacement, as a share of the largest; truncation of the series,
        rounding and the interpolation of a sampled input, times the growth where that is
        known; None of a quick run [-].
    growth : float, optional
        What a disturbance of 1e-10, of the start and of the input all along, made of the
        motion, as a multiple of 1e-10 of the largest; None where it was not asked for [-].
    notes : tuple of str
        What the reader should know, a sentence each.
    interpolation : InterpolationError, optional
        How far a sampled input may be from the band-limited signal through its samples.
    force : (n,) array, optional
        What imposes the displacement of a mass, where one is imposed [N].
    motion : (n_motions, n) array
        Displacements [m], velocities [m/s] and states as the model is carried by, in the order
        of `motions_of`; without rows where they were not kept.
    """

    sample_rate: float
    outputs: Mapping[str, FloatArray]
    excitation: FloatArray
    masses: tuple[str, ...]
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    states: FloatArray
    solver: str
    switchings: int
    error: float | None
    growth: float | None
    notes: tuple[str, ...] = ()
    interpolation: InterpolationError | None = None
    force: FloatArray | None = None
    motion: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def time(self) -> FloatArray:
        """Times of the samples, (n,) array [s]."""
        return np.arange(self.excitation.size) / self.sample_rate

    @property
    def sensitive(self) -> bool:
        """Whether the motion cannot be predicted in time from a measured input."""
        return self.growth is not None and self.growth > SENSITIVE_GROWTH

    @property
    def chaotic(self) -> bool:
        """Whether a disturbance grew so much that only statistics of the response hold.

        Growth in passing, as at the jump of a sweep or after the last contact, stays below:
        it costs digits, which `error` counts, but not the trajectory.
        """
        return self.growth is not None and self.growth > CHAOTIC_GROWTH

    def relative_displacement(self, first: str, second: str) -> FloatArray:
        """Return the displacement of the second place minus that of the first [m]."""
        return self._of(self.displacement, second) - self._of(self.displacement, first)

    def relative_velocity(self, first: str, second: str) -> FloatArray:
        """Return the velocity of the second place minus that of the first [m/s]."""
        return self._of(self.velocity, second) - self._of(self.velocity, first)

    def _of(self, rows: FloatArray, place: str) -> FloatArray:
        if place == BASE:
            return np.zeros(rows.shape[1])
        row: FloatArray = rows[self.masses.index(place)]
        return row


def read_sensors(
    model: Model, simulation: SimulatedResponse, pieces: FloatArray, stride: int
) -> SimulatedResponse:
    """Return the simulation with the signal of each sensor, its faults included.

    Parameters
    ----------
    pieces : (n_pieces, degree + 1) array
        The input over each part of a sample, of which there are `stride`; integrated twice
        from rest, it is the motion of the base where that is what is driven [m/s², N or m].
    """
    wanted = {sensor.measures for sensor in model.sensors.values()}
    base = _Base(simulation.excitation, model.excitation.moves_base, None, None)
    if base.driven and wanted & {"displacement", "velocity"}:
        velocity, displacement = integrated(pieces, stride, simulation.sample_rate)
        base = replace(base, velocity=velocity, displacement=displacement)
    outputs = {
        name: _recorded(sensor, simulation, base) for name, sensor in model.sensors.items()
    }
    return replace(simulation, outputs=MappingProxyType(outputs))


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Base:
    """Motion of the base; displacement and velocity only where they are needed."""

    excitation: FloatArray
    driven: bool
    velocity: FloatArray | None
    displacement: FloatArray | None

    def add(self, base_motion: FloatArray | None, relative: FloatArray) -> FloatArray:
        return relative if base_motion is None else relative + base_motion


def _recorded(sensor: Sensor, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    samples = _MEASURED[sensor.measures](sensor.at, simulation, base)
    for fault in sensor.faults:
        samples = fault.apply(samples, simulation.sample_rate)
    return samples


def _acceleration(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    if at == BASE:
        return base.excitation if base.driven else np.zeros_like(base.excitation)
    row: FloatArray = simulation.acceleration[simulation.masses.index(at)]
    return row


def _displacement(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    return base.add(base.displacement, simulation.relative_displacement(BASE, at))


def _velocity(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:
    return base.add(base.velocity, simulation.relative_velocity(BASE, at))


def _relative_displacement(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_displacement(BASE, at)


def _relative_velocity(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    return simulation.relative_velocity(BASE, at)


def _force(at: str, simulation: SimulatedResponse, base: _Base) -> FloatArray:  # noqa: ARG001
    if simulation.force is None:
        raise ValueError("a force is measured where the displacement is imposed")
    return simulation.force


_MEASURED: Mapping[Measures, Callable[[str, SimulatedResponse, _Base], FloatArray]] = (
    MappingProxyType({
        "acceleration": _acceleration,
        "displacement": _displacement,
        "velocity": _velocity,
        "relative displacement": _relative_displacement,
        "relative velocity": _relative_velocity,
        "force": _force,
    })
)


def integrated(
    pieces: FloatArray, stride: int, sample_rate: float
) -> tuple[FloatArray, FloatArray]:
    """Return velocity and displacement of a base that starts at rest, at the samples.

    `pieces` are in [m/s²], `sample_rate` in [Hz].
    """
    step = 1.0 / (sample_rate * stride)
    k = np.arange(pieces.shape[1])
    velocity = step * np.concatenate(([0.0], np.cumsum(pieces @ (1.0 / (k + 1)))))
    by_acceleration = step**2 * (pieces @ (1.0 / ((k + 1) * (k + 2))))
    displacement = np.concatenate(([0.0], np.cumsum(step * velocity[:-1] + by_acceleration)))
    return velocity[::stride], displacement[::stride]


_DISTURBANCE = 1e-10
_FINEST_DOP853 = 1e-13
_ROUNDING = 1e-13  # what rounding leaves of a trajectory, as a share of it
_FINER = 0.1  # tolerance of the run that tells the error of another, over that one's
_ALLOWED = 1.5  # a run whose error fell to a third only, not to a tenth, is that far from exact

Solver: TypeAlias = Literal["automatic", "exact", "taylor", "dop853", "quick"]


def by_series(system: System, solver: Solver) -> bool:
    """Return whether the model is carried by Taylor series and propagators.

    Raises
    ------
    ValueError
        If that was asked for, and a power law is not analytic at 0.
    """
    if solver == "taylor" and not system.analytic:
        raise ValueError("a power that is not whole has no Taylor series at 0; use dop853")
    return solver != "dop853" and system.analytic


NO_TABLEAU: Final = np.zeros((15, 13))
"""In its place, where no law needs that method."""


@cache
def dop853_tableau() -> FloatArray:
    """Return stages, weights, nodes and error estimates of DOP853, (15, 13) array [-]."""
    from scipy.integrate import DOP853  # a quarter of a second, which few models need

    tableau = np.zeros((15, 13))
    tableau[:12, :12], tableau[12, :12] = DOP853.A, DOP853.B
    tableau[13, :12], tableau[14, :12] = DOP853.E5[:12], DOP853.E3[:12]
    tableau[:12, 12] = DOP853.C
    return tableau


def tableau_of(system: System) -> FloatArray:
    """Return the tableau of DOP853 where some law has no series at 0, else one of zeros."""
    return NO_TABLEAU if system.analytic else dop853_tableau()


def first_motion(
    model: Model, system: System, given: Input, start: Mapping[str, tuple[float, float]] | None
) -> FloatArray:
    """Return displacements and velocities at the first sample, (n_motions,) array [m, m/s].

    Raises
    ------
    ValueError
        If a start is given for a mass that the model does not have.
    """
    first = np.zeros(system.n_motions)
    for name, (displacement, velocity) in (start or {}).items():
        if name not in system.names:
            raise ValueError(f"no mass {name!r}; there are {', '.join(system.names)}")
        index = system.names.index(name)
        first[index], first[len(system.names) + index] = displacement, velocity
    if given.imposed is not None:
        impose(first[None, :], model, system, given, np.zeros(1, np.int64))
    return first


def impose(
    starts: FloatArray, model: Model, system: System, given: Input, first: NDArray[np.int64]
) -> None:
    """Let the mass whose displacement is imposed start with it.

    Parameters
    ----------
    starts : (n, n_motions) array
        Written to [m, m/s].
    first : (n,) array of int
        Sample at which each begins.
    """
    if given.imposed is not None:
        place, n = system.names.index(str(model.excitation.on)), len(system.names)
        starts[:, place], starts[:, n + place] = given.imposed[:, first]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """All that one run of the stepper needs."""

    model: Model
    system: System
    store: Store
    given: Input
    first: FloatArray
    tolerance: float
    by_series: bool
    is_quick: bool

    @property
    def solver(self) -> str:
        """Name of the solver."""
        if not self.by_series:
            return "Taylor series and DOP853" if self.is_quick else "DOP853"
        return "exact propagators" if self.store.parts.size else "Taylor series"


def simulated_case(case: Case, *, growth: bool) -> SimulatedResponse:
    """Return the response of a case."""
    motion, relative, stats = _run(case)
    n = len(case.system.names)
    grown = _growth(case, motion) if growth else None
    truncated = None if case.is_quick else _truncation(case, motion, stats)
    given = case.given
    samples = given.samples if given.imposed is None else given.imposed[0]
    absolute = case.system.displacements(relative[:, :n])
    if case.model.excitation.moves_base:
        absolute = absolute + samples
    error = case.given.missed + _ROUNDING * float(np.sqrt(1.0 + stats[1]))
    simulation = SimulatedResponse(
        sample_rate=given.sample_rate,
        outputs={},
        excitation=samples,
        masses=tuple(case.system.places),
        displacement=case.system.displacements(motion[:, :n]),
        velocity=case.system.displacements(motion[:, n : 2 * n]),
        acceleration=absolute,
        states=motion[:, 2 * n :].T,
        solver=case.solver,
        switchings=int(stats[1]),
        error=None if truncated is None else truncated + error * max(1.0, grown or 1.0),
        growth=grown,
        notes=_notes(grown, stats) + _remarks(case, motion),
        interpolation=given.interpolation,
        force=relative[:, n] if given.imposed is not None else None,
        motion=motion.T,
    )
    return read_sensors(case.model, simulation, case.given.pieces, case.given.stride)


def _run(case: Case) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return motion (n, n_y), accelerations relative to the base (n, n_masses), statistics.

    Raises
    ------
    SimulationError
        If the stepper had to give up.
    """
    given, machine, first = case.given, case.system.machine, case.first
    n_samples = given.n_samples
    n, n_lines = machine.mass.size, len(machine.lines)
    series = room_for_series(machine, first.size - 2 * n)
    series.y[:, 0] = first
    motion, relative = np.empty((n_samples, first.size)), np.empty((n_samples, len(series.a)))
    least = np.zeros(first.size)
    least[: 2 * n] = least_sizes(machine, given, float(np.max(np.abs(given.pieces[:, 0]))))
    work = np.zeros((WORK_ROWS, first.size + 2 * n_lines + 1))
    stats = np.zeros(7)
    fresh = machine._replace(
        mode=np.zeros_like(machine.mode),
        anchor=np.zeros_like(machine.anchor),
        stack=np.zeros_like(machine.stack),
    )
    if case.by_series or case.is_quick:
        degree = given.pieces.shape[1] - 1
        whole = np.array([[0, n_samples]])
        walk_windows(
            fresh, case.store, case.system.analytic, tableau_of(case.system), given.pieces,
            given.part, given.stride, given.span, whole, first[None, :], least,
            case.tolerance, series, room_for_steps(machine, first.size, degree),
            room_to_carry(first.size, 0, degree), work, np.zeros(4, np.int64),
            np.zeros(1, np.bool_), motion, relative, stats, np.inf, np.inf, free(n),
        )  # fmt: skip
    else:
        integrate_dop853(
            fresh, dop853_tableau(), given.pieces, given.part, given.stride,
            max(case.tolerance, _FINEST_DOP853), series, work, least, motion, relative, stats,
        )  # fmt: skip
    if stats[0] != DONE:
        how = "the steps become too small" if stats[0] == STUCK else "the motion runs away"
        raise SimulationError(
            f"{case.model.title}: {how} at {stats[5]:.6g} s. Check the signs and sizes of the "
            f"parameters, and the level of the excitation."
        )
    return motion, relative, stats


def room_for_steps(machine: Machine, n_motions: int, degree: int) -> FloatArray:
    """Return room for numbers in a row, as `walk_windows` needs it."""
    n, n_lines = machine.mass.size, len(machine.lines)
    return np.zeros((4, n_motions + n + 4 * n_lines + degree + 33))


def free(n: int) -> Nudges:
    """Return the nudges of a run of n masses that is free: none."""
    return Nudges(np.zeros((0, 0)), np.zeros((0, 2 * n)), np.zeros((2 * n, 0)), 0, np.zeros(0))


def least_sizes(machine: Machine, given: Input, largest: float) -> FloatArray:
    """Return the displacements and velocities that the input alone gives in one sample.

    Errors are never compared with less: a joint that has just broken away moves by nothing.

    Parameters
    ----------
    largest : float
        Largest input [m/s^2 or N].
    """
    n = machine.mass.size
    pushed = np.max(np.abs(machine.matrix[:, 2 * n])) * largest
    step = given.part / given.span
    return np.repeat((pushed * step**2, pushed * step), n)


def _growth(case: Case, motion: FloatArray) -> float:
    """Return how much a small disturbance of the start and of the whole input grows.

    A disturbance of the start alone would have died out before a shaker that starts later.
    """
    n = len(case.system.names)
    sizes = np.array([np.max(np.abs(motion[:, :n])), np.max(np.abs(motion[:, n : 2 * n]))])
    if not np.all(sizes > 0.0):
        return 0.0
    disturbed = case.first.copy()
    disturbed[:n] += _DISTURBANCE * sizes[0]
    pushed = replace(case.given, pieces=case.given.pieces * (1.0 + _DISTURBANCE))
    other, _, _ = _run(replace(case, first=disturbed, given=pushed))
    return max(_shares(other, motion, n)) / _DISTURBANCE


def _truncation(case: Case, motion: FloatArray, stats: FloatArray) -> float:
    """Return the truncation error of the trajectory, as a share of the largest motion.

    The distance to the same run at a tenth of the tolerance: errors of single steps add up,
    shift the phase and grow with the motion as no sum of theirs tells. Half as much again
    allows for what the finer run misses itself, and for steps that do not shrink in proportion.
    """
    if not stats[2] + stats[6] > 0.0:
        return 0.0
    n = len(case.system.names)
    finer, _, _ = _run(replace(case, tolerance=_FINER * case.tolerance))
    return _ALLOWED * max(_shares(finer, motion, n))


def _shares(other: FloatArray, motion: FloatArray, n: int) -> tuple[float, float]:
    """Return the largest distances of displacements and velocities, over the largest motion."""
    sizes = [float(np.max(np.abs(motion[:, k * n : (k + 1) * n]))) for k in (0, 1)]
    difference = np.abs(other - motion)
    first, second = (
        float(np.max(difference[:, k * n : (k + 1) * n])) / size if size > 0.0 else 0.0
        for k, size in enumerate(sizes)
    )
    return first, second


def _remarks(case: Case, motion: FloatArray) -> tuple[str, ...]:
    """Return the remarks of the effects on the motion between their places."""
    n, names = len(case.system.names), case.system.names
    remarks = []
    for element in case.model.elements:
        z, v = np.zeros((2, motion.shape[0]))
        for place, sign in zip(element.between, (-1.0, 1.0), strict=True):
            if place in names:
                z = z + sign * motion[:, names.index(place)]
                v = v + sign * motion[:, n + names.index(place)]
        remark = element.effect.remark(z, v)
        if remark is not None:
            where = " and ".join(element.between)
            remarks.append(f"{element.effect.kind} between {where}: {remark}")
    return tuple(remarks)


def _notes(growth: float | None, stats: FloatArray) -> tuple[str, ...]:
    notes = []
    if growth is not None and growth > CHAOTIC_GROWTH:
        notes.append(
            f"chaotic: a disturbance of 1e-10 grows {growth:.1e} times; only statistics over "
            f"an ensemble hold, not this time history"
        )
    elif growth is not None and growth > SENSITIVE_GROWTH:
        notes.append(
            f"sensitive: a disturbance of 1e-10 grows {growth:.1e} times; a measured input "
            f"does not predict this time history"
        )
    if stats[4] > 0.0:
        notes.append(f"{int(stats[4])} steps were taken past switchings that follow each other")
    return tuple(notes)


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
    solver : {"automatic", "exact", "taylor", "dop853", "quick"}
        ``exact`` and ``taylor`` insist on propagators or on series, ``dop853`` on the
        Runge-Kutta method that serves powers that are not whole (tolerance 1e-13 at least).
        ``quick`` takes that method near 0 alone, and does not run again to tell the error.

    Raises
    ------
    SimulationError
        If the motion runs away, or the steps become too small to go on.
    ValueError
        If the arguments do not fit together.
    """
    check_unscaled(model, "a simulation")
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
    case = Case(model, system, store, given, first, tolerance, series, solver == "quick")
    return simulated_case(case, growth=growth)


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
