"""Free runs of one model: whole tests or windows of them, all in one call."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.model import Model
from shakerproc.models.validation import check_unscaled
from shakerproc.simulation.assembly import System, assemble
from shakerproc.simulation.inputs import Input
from shakerproc.simulation.kernels.windows import Nudges
from shakerproc.simulation.response import impose
from shakerproc.simulation.walking import Placed, Walk

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
