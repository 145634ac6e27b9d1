"""Free runs of one model: whole tests or windows of them, all in one call."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models.model import Model
from shakerproc.simulate.assembly import assemble
from shakerproc.simulate.inputs import Input
from shakerproc.simulate.response import run_window
from shakerproc.simulate.window_sensing import base_motion, sense

RUNAWAY: Final = 1e3
"""Size of a failed window as a multiple of the usual size of its sensor [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Runs:
    """What to simulate.

    Attributes
    ----------
    inputs : tuple of Input
        What shakes the model in each test.
    windows : (n_windows, 3) array of int
        Test, first sample and number of samples of each window.
    starts : (n_windows, n_motions) array, optional
        Displacements [m] and velocities [m/s] relative to the base of every mass and attached
        mode, then the states of the laws, at the first sample of each window; None is rest.
    sizes : (n_sensors,) array, optional
        Usual size of what each sensor records [SI], against which the filling of failed
        windows is measured; by default the largest of the windows that did not fail.
    """

    inputs: tuple[Input, ...]
    windows: NDArray[np.int64]
    starts: FloatArray | None = None
    sizes: FloatArray | None = None


@final
@dataclass(frozen=True, slots=True, eq=False)
class FreeRuns:
    """What the sensors of a model record in free runs.

    Attributes
    ----------
    outputs : tuple of (n_sensors, n_samples) array
        What each sensor records in each window [SI], in the order of the model's sensors.
    failed : (n_windows,) array of bool
        Whether the motion ran away or could not be computed; such a window is held at
        `RUNAWAY` times the usual size.
    """

    outputs: tuple[FloatArray, ...]
    failed: NDArray[np.bool_]


def motions_of(model: Model) -> tuple[str, ...]:
    """Return the names of the motions of a model, in the order of `Runs.starts`.

    A displacement is called ``x`` and a velocity ``v`` of its mass, a state by its number.
    """
    system = assemble(model)
    x, v = ([f"{kind} {name}" for name in system.names] for kind in "xv")
    return (*x, *v, *(f"state {i + 1}" for i in range(system.n_states)))


def free_runs(
    model: Model, runs: Runs, *, tolerance: float = 1e-6, means: bool = True
) -> FreeRuns:
    """Return what the sensors of a model record in windows of tests, without an error raised.

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
    """
    system = assemble(model)
    bases = tuple(base_motion(model, given) for given in runs.inputs)
    outputs, failed = [], []
    for i, (test, first, count) in enumerate(runs.windows):
        last = min(first + count - (not means), runs.inputs[test].n_samples - 1)
        start = np.zeros(system.n_motions) if runs.starts is None else runs.starts[i]
        base = bases[test].part(first, last)
        try:
            motion = run_window(
                model, runs.inputs[test], (first, last), start, tolerance=tolerance
            )
        except SimulationError:
            failed.append(True)
            outputs.append(None)
            continue
        found = sense(model, system, *motion, base, means=means)
        failed.append(False)
        outputs.append(found[:, :count])
    return _filled(model, runs, outputs, np.array(failed, bool))


def _filled(
    model: Model, runs: Runs, outputs: list[FloatArray | None], failed: NDArray[np.bool_]
) -> FreeRuns:
    """Return the runs, failed windows filled with a large finite motion."""
    sizes = runs.sizes
    if sizes is None:
        good = [np.max(np.abs(o), axis=1) for o in outputs if o is not None]
        sizes = np.max(good, axis=0) if good else np.ones(len(model.sensors))
    held = np.where(sizes > 0.0, RUNAWAY * sizes, RUNAWAY)[:, None]
    whole = tuple(
        np.repeat(held, count, axis=1) if found is None else found
        for found, count in zip(outputs, runs.windows[:, 2], strict=True)
    )
    return FreeRuns(whole, failed)
