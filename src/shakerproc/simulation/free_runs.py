"""Free runs of one model: whole tests or windows of them, all in one call.

The compiled stepper carries the windows of one test piece by piece.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias, final
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models.model import Model
from shakerproc.models.validation import check_unscaled
from shakerproc.simulation.assembly import System, assemble, build_store
from shakerproc.simulation.inputs import Input
from shakerproc.simulation.kernels.carried_forces import CarriedForces, room_to_carry
from shakerproc.simulation.kernels.dop853 import WORK_ROWS
from shakerproc.simulation.kernels.table import MotionSeries, Store, room_for_series
from shakerproc.simulation.kernels.windows import Nudges, walk_windows
from shakerproc.simulation.response import (
    free,
    impose,
    least_sizes,
    room_for_steps,
    tableau_of,
)
from shakerproc.simulation.window_sensing import WindowMotion, base_motion, has_jumps, sense

ROWS: Final = 2**15
"""Samples after which the stepper returns, so that memory is bounded and Ctrl-C is heard."""

PATIENCE: Final = 3e4
"""Steps around switchings after which it returns in any case; so many take 0.1 s or so."""

MOST_STEPS: Final = 10.0
"""Steps around switchings for each sample of a window, on average, past which it has failed: a
hundred times what chattering friction takes, and seconds for a test."""

MOST_PARTS: Final = 300
"""Parts of a sample, by the fastest rate of a linear branch, past which a run has failed: such
a model takes a hundred times as long as any that a measurement tells from a rigid one."""

Whole: TypeAlias = NDArray[np.int64]
Places: TypeAlias = Whole | slice

_LARGEST: Final[WeakKeyDictionary[Input, float]] = WeakKeyDictionary()


@final
@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """Windows of one test, and where they stand among the samples of all.

    Attributes
    ----------
    first, count, offset : (n,) array of int
        First sample in the test, number of samples, and place of the first in the results.
    rows : (n,) array of int
        Samples that are simulated: one more than wanted, for means over intervals, if the test
        goes on.
    """

    first: Whole
    count: Whole
    offset: Whole
    rows: Whole

    def place_of(self, begin: int, stop: int) -> Whole:
        """Return how far into their windows the rows from begin to stop are [samples]."""
        rows = np.arange(begin, stop)
        ends = np.cumsum(self.rows)
        which = np.searchsorted(ends, rows, "right")
        return np.asarray(rows - (ends - self.rows)[which])

    def between(self, begin: int, stop: int, ready: int) -> tuple[Places, Places, Places]:
        """Return samples and places of the rows from begin to stop of all windows together.

        Parameters
        ----------
        ready : int
            How many of them are not to be kept for the next time.

        Returns
        -------
        samples : slice or (stop - begin,) array of int
            The sample of the test that each is.
        wanted, places : slice or (n,) array of int
            Which of them are results, and where these go.
        """
        ends = np.cumsum(self.rows)
        low = int(np.searchsorted(ends, begin, "right"))
        high = int(np.searchsorted(ends, stop, "left")) + 1
        begins = ends[low:high] - self.rows[low:high]
        if high == low + 1:
            place = begin - int(begins[0])
            sample, at = int(self.first[low]) + place, int(self.offset[low]) + place
            kept = max(0, min(ready, int(self.count[low]) - place))
            return slice(sample, sample + stop - begin), slice(0, kept), slice(at, at + kept)
        counts = np.minimum(ends[low:high], stop) - np.maximum(begins, begin)
        which = np.repeat(np.arange(low, high), counts)
        place_of = np.arange(begin, stop) - np.repeat(begins, counts)
        wanted = np.flatnonzero(place_of[:ready] < self.count[which[:ready]])
        return (
            self.first[which] + place_of, wanted,
            self.offset[which[wanted]] + place_of[wanted],
        )  # fmt: skip


@final
class Walk:
    """A model, ready to be carried through windows of tests.

    Parameters
    ----------
    model, system : Model, System
        What is shaken, and the same assembled.
    tolerance : float
        Error of a step as a share of the largest motion so far [-].
    plain : bool
        Whether mean accelerations keep what folds back of jumps.
    """

    def __init__(
        self, model: Model, system: System, tolerance: float, *, plain: bool = False
    ) -> None:
        self._model, self._system, self._tolerance = model, system, tolerance
        self._jumps = not plain and has_jumps(model)
        self._rooms: dict[tuple[float, int], _Room | None] = {}

    def fill(
        self, given: Input, placed: Placed, starts: FloatArray, flat: FloatArray, *,
        means: bool, nudges: Nudges | None = None, nudged: FloatArray | None = None,
    ) -> NDArray[np.bool_]:  # fmt: skip
        """Set the signals of sensors in windows of one test; return which of them failed.

        Parameters
        ----------
        given : Input
            What shakes the model in that test.
        placed : Placed
            The windows.
        starts : (n, n_motions) array
            WindowMotion at the first sample of each [m, m/s].
        flat : (n_sensors, any) array
            Set, where the windows stand in it [units of the sensors].
        means : bool
            Whether accelerations are means over intervals.
        nudges : Nudges, optional
            What the motion is held to.
        nudged : (2 n, any) array, optional
            Set to how far each displacement [m] and velocity [m/s] is nudged.
        """
        held = free(len(self._system.names)) if nudges is None else nudges
        room = self._room(given)
        if room is None:
            return np.ones(placed.first.size, np.bool_)
        base, rate = base_motion(self._model, given), given.sample_rate
        windows = np.stack((placed.first, placed.rows), axis=1)
        cursor, failed = np.zeros(4, np.int64), np.zeros(len(windows), np.bool_)
        done, seen, total = 0, 0, int(np.sum(placed.rows))
        while done < total:
            kept = min(seen, 1)
            new = self._advance(
                room, given, windows, starts, cursor=cursor, failed=failed, kept=kept,
                nudges=held,
            )  # fmt: skip
            done, seen = done + new, kept + new
            ready = seen - (done < total)  # a mean needs the next sample as well
            samples, wanted, places = placed.between(done - seen, done, ready)
            moved = None
            if nudges is not None:
                moved = _moved(nudges, room.motion[:seen], samples)
                place = placed.place_of(done - seen, done)
                moved[(place == 0) | (place > nudges.lead)] = 0.0
            motion = WindowMotion(
                room.motion[:seen], room.acceleration[:seen], samples, base, self._jumps,
                moved, rate,
            )  # fmt: skip
            recorded = sense(self._model, self._system, motion, rate, means=means)
            flat[:, places] = recorded[:, wanted]
            if nudged is not None and moved is not None:
                nudged[:, places] = moved[wanted].T
            room.motion[0] = room.motion[seen - 1]
            room.acceleration[0] = room.acceleration[seen - 1]
        return failed

    def _room(self, given: Input) -> "_Room | None":
        """Return the room for tests of this sample rate; None for a model that is too stiff."""
        degree = given.pieces.shape[1] - 1
        if (given.part, degree) not in self._rooms:
            store = _store(self._system, given.part, degree)
            room = None if store is None else _room_for(self._system, store, degree)
            self._rooms[given.part, degree] = room
        return self._rooms[given.part, degree]

    def _advance(
        self, room: "_Room", given: Input, windows: Whole, starts: FloatArray, *,
        cursor: Whole, failed: NDArray[np.bool_], kept: int, nudges: Nudges,
    ) -> int:  # fmt: skip
        """Carry the windows on by as many rows as there is room, or fewer; return how many."""
        system = self._system
        least = np.zeros(system.n_motions)
        own = least_sizes(system.machine, given, _largest(given))
        least[: own.size] = own
        return walk_windows(
            system.machine, room.store, system.analytic, tableau_of(system), given.pieces,
            given.part, given.stride, 1, windows, starts, least, self._tolerance,
            room.series, room.steps, room.carried, room.work, cursor, failed,
            room.motion[kept:], room.acceleration[kept:], np.zeros(7),
            PATIENCE / len(system.names) ** 2, MOST_STEPS, nudges,
        )  # fmt: skip


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Room:
    """Propagators of a model, and the arrays that the compiled stepper writes to."""

    store: Store
    series: MotionSeries
    steps: FloatArray
    carried: CarriedForces
    work: FloatArray
    motion: FloatArray
    acceleration: FloatArray


def _moved(nudges: Nudges, rows: FloatArray, samples: Places) -> FloatArray:
    """Return how far each row of a motion is nudged, (n_rows, 2 n) array."""
    seen = rows[:, : nudges.sees.shape[1]] @ nudges.sees.T
    moved: FloatArray = (nudges.measured[samples] - seen) @ nudges.gain.T
    return moved


def _room_for(system: System, store: Store, degree: int) -> _Room:
    n, n_lines, n_y = system.machine.mass.size, len(system.machine.lines), system.n_motions
    return _Room(
        store,
        room_for_series(system.machine, system.n_states),
        room_for_steps(system.machine, n_y, degree),
        room_to_carry(n_y, store.push.shape[2], degree),
        np.zeros((WORK_ROWS, n_y + 2 * n_lines + 1)),
        np.zeros((ROWS + 1, n_y)),
        np.zeros((ROWS + 1, n + len(system.machine.reading))),
    )


def _store(system: System, part: float, degree: int) -> Store | None:
    """Return the propagators of a model, or None for one that is too stiff to be carried."""
    try:
        store = build_store(system.machine, part, degree, carry=True)
    except (SimulationError, np.linalg.LinAlgError):
        return None
    return store if np.max(store.parts, initial=1) <= MOST_PARTS else None


def _largest(given: Input) -> float:
    """Return the largest input [m/s^2 or N]."""
    if given not in _LARGEST:
        _LARGEST[given] = float(np.max(np.abs(given.pieces[:, 0])))
    return _LARGEST[given]


TOLD_APART: Final = 0.01
"""Share of the best told motion below which a combination of sensors tells none: gains are
known to a per cent [-]."""

RUNAWAY: Final = 1e3
"""Size of a failed window as a multiple of the usual size of its sensor [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Held:
    """Measured motions towards which runs are nudged, and the rate [1/s].

    After every sample the displacements and velocities that were measured pull the model's to
    them by 1 - exp(-rate h), h being the time between samples (nudging).

    Attributes
    ----------
    rate : float
        Above 0; one over the time after which the model forgets where it was [1/s].
    measured : tuple of (m, n_samples) array
        In each test, what sensors tell of displacements [m] and velocities [m/s].
    sees : (m, 2 n_motions) array
        Which displacements and velocities of what moves these are.
    lead : int, optional
        Samples after which a window is let go, to run freely; held throughout by default.

    References
    ----------
    .. [1] H. D. I. Abarbanel, D. R. Creveling, R. Farsian, M. Kostuk, "Dynamical state and
       parameter estimation", SIAM Journal on Applied Dynamical Systems 8, 1341-1381, 2009.
    """

    rate: float
    measured: tuple[FloatArray, ...]
    sees: FloatArray
    lead: int | None = None

    def nudges(self, test: int, sample_rate: float, mass: FloatArray) -> Nudges:
        """Return the nudges of a test that has so many samples per second [Hz].

        Parameters
        ----------
        test : int
            Which.
        sample_rate : float
            Samples per second [Hz].
        mass : (n,) array
            Of what moves [kg].
        """
        share = -np.expm1(-self.rate / sample_rate)
        return Nudges(
            np.ascontiguousarray(self.measured[test].T),
            np.ascontiguousarray(self.sees),
            np.ascontiguousarray(share * led_by(self.sees, mass)),
            len(self.measured[test][0]) if self.lead is None else self.lead,
            np.zeros(len(self.sees)),
        )


def led_by(sees: FloatArray, mass: FloatArray) -> FloatArray:
    r"""Return the motion of least kinetic energy that sensors see, (2 n, m) array.

    .. math:: L = M^{-1/2} (S M^{-1/2})^+

    A correction along it takes energy out of an error and puts none in: :math:`M L S` is
    symmetric and nowhere negative, as the matrix of a dashpot is.

    Parameters
    ----------
    sees : (m, 2 n) array
        Displacements and velocities that sensors see, :math:`S` [-].
    mass : (n,) array
        Of what moves, :math:`M` [kg].
    """
    root = np.sqrt(np.concatenate([mass, mass]))
    found: FloatArray = np.linalg.pinv(sees / root, rcond=TOLD_APART) / root[:, None]
    return found


@final
@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """Inputs, windows and starts of the runs to simulate.

    Attributes
    ----------
    inputs : tuple of Input
        What shakes the model in each test.
    windows : (n_windows, 3) array of int
        Test, first sample and number of samples of each window.
    starts : (n_windows, n_motions) array, optional
        Displacements [m] and velocities [m/s] relative to the base of every mass and attached
        mode, then the states of the laws, at the first sample of each window; None is rest. A
        state larger than its law allows is cut to what it allows; a mass whose displacement is
        imposed starts as its input says, whatever stands here.
    sizes : (n_sensors,) array, optional
        Usual size of what each sensor records [SI], against which the filling of failed
        windows is measured; by default the largest of the windows that did not fail.
    held : Held, optional
        What the motions are held to; free by default.
    """

    inputs: tuple[Input, ...]
    windows: NDArray[np.int64]
    starts: FloatArray | None = None
    sizes: FloatArray | None = None
    held: Held | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class FreeRuns:
    """Signals of the sensors of a model in free runs.

    Attributes
    ----------
    outputs : tuple of (n_sensors, n_samples) array
        What each sensor records in each window [SI], in the order of the model's sensors.
    failed : (n_windows,) array of bool
        Whether the motion ran away or could not be computed; such a window is held at
        `RUNAWAY` times the usual size.
    nudged : tuple of (2 n_masses, n_samples) array
        By how much each displacement [m] and velocity [m/s] is moved after each sample; none
        where motions are free.
    """

    outputs: tuple[FloatArray, ...]
    failed: NDArray[np.bool_]
    nudged: tuple[FloatArray, ...] = ()


def motions_of(model: Model) -> tuple[str, ...]:
    """Return the names of the motions of a model, in the order of `Runs.starts`.

    A displacement is called ``x`` and a velocity ``v`` of its mass, a state by its number.
    """
    system = assemble(model)
    x, v = ([f"{kind} {name}" for name in system.names] for kind in "xv")
    return (*x, *v, *(f"state {i + 1}" for i in range(system.n_states)))


def largest_states(model: Model) -> FloatArray:
    """Return the size of each state of the laws and its limit, (n_states, 2) array.

    What a change of it is compared with, and what it cannot exceed; in the unit of the state,
    in the order of `motions_of`.
    """
    return assemble(model).largest_states


def free_runs(
    model: Model,
    runs: Runs,
    *,
    tolerance: float = 1e-6,
    means: bool = True,
    plain: bool = False,
) -> FreeRuns:
    """Return the signals of a model's sensors in windows of tests, without an error raised.

    Parameters
    ----------
    model : Model
        What is shaken.
    runs : Runs
        Inputs, windows and starts.
    tolerance : float
        Error of a step as a share of the largest motion so far [-].
    means : bool
        Whether accelerations are means over the interval from each sample to the next, as a
        measurement through the same box has them: jumps of stick and slip then do not alias.
        At the very end of a test, where there is no next sample, the last mean is repeated.
        All else are values at the samples.
    plain : bool
        Whether means keep what folds back of jumps (see `band_limited`).
    """
    check_unscaled(model, "a simulation")
    system = assemble(model)
    counts = runs.windows[:, 2]
    offsets = np.concatenate(([0], np.cumsum(counts)))
    flat = np.zeros((len(model.sensors), offsets[-1]))
    held = runs.held
    nudged = None if held is None else np.zeros((2 * len(system.names), offsets[-1]))
    failed = np.zeros(len(runs.windows), np.bool_)
    walk = Walk(model, system, tolerance, plain=plain)
    for test, given in enumerate(runs.inputs):
        members = np.flatnonzero(runs.windows[:, 0] == test)
        if members.size:
            starts = np.zeros((members.size, system.n_motions))
            if runs.starts is not None:
                starts[:] = runs.starts[members]
                _within_limits(starts, system)
            first, count = runs.windows[members, 1], counts[members]
            impose(starts, model, system, given, first)
            rows = np.minimum(count + means, given.n_samples - first)
            placed = Placed(first, count, offsets[members], rows)
            nudges = (
                None
                if held is None
                else held.nudges(test, given.sample_rate, system.machine.mass)
            )
            failed[members] = walk.fill(
                given, placed, starts, flat, means=means, nudges=nudges, nudged=nudged
            )
            if means:
                _repeat_last(model, placed, flat)
    outputs = tuple(flat[:, a:b] for a, b in pairwise(offsets))
    if not np.isfinite(flat).all():
        failed |= [not np.isfinite(found).all() for found in outputs]
    _apply_faults(model, runs, outputs)
    _hold_failed(runs, outputs, failed)
    moved = () if nudged is None else tuple(nudged[:, a:b] for a, b in pairwise(offsets))
    return FreeRuns(outputs, failed, moved)


def _within_limits(starts: FloatArray, system: System) -> None:
    """Let no state of a law begin larger than it can be."""
    if system.n_states:
        limit = system.largest_states[:, 1]
        np.clip(starts[:, -len(limit) :], -limit, limit, out=starts[:, -len(limit) :])


def _repeat_last(model: Model, placed: Placed, flat: FloatArray) -> None:
    """Give windows that end with their test a last mean, the one before."""
    last = placed.offset + placed.count - 1
    last = last[(placed.rows == placed.count) & (placed.count > 1)]
    for i, sensor in enumerate(model.sensors.values()):
        if sensor.measures == "acceleration":
            flat[i, last] = flat[i, last - 1]


def _apply_faults(model: Model, runs: Runs, outputs: tuple[FloatArray, ...]) -> None:
    """Apply the faults of sensors to their signals."""
    for i, sensor in enumerate(model.sensors.values()):
        for fault in sensor.faults:
            for (test, *_), found in zip(runs.windows, outputs, strict=True):
                found[i] = fault.apply(found[i], runs.inputs[test].sample_rate)


def _hold_failed(
    runs: Runs, outputs: tuple[FloatArray, ...], failed: NDArray[np.bool_]
) -> None:
    """Fill failed windows with a large finite motion."""
    if not failed.any():
        return
    sizes = runs.sizes
    if sizes is None:
        good = [
            np.max(np.abs(found), axis=1)
            for found, no in zip(outputs, failed, strict=True)
            if not no
        ]
        sizes = np.max(good, axis=0) if good else np.ones(len(outputs[0]))
    held = np.where(sizes > 0.0, RUNAWAY * sizes, RUNAWAY)[:, None]
    for i in np.flatnonzero(failed):
        outputs[i][:] = held
