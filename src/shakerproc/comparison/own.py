r"""Numbers of each test alone: the constant of its force, its start, how it was sampled.

The mean of a recording is the constant of an amplifier or of a force sensor only to the mean
of the force itself, and a recording that is cut in motion begins in motion. Neither is the
model's: both are fitted to each test, held out or not, before it is compared,

.. math:: \min_u \; \lVert r(u) \rVert^2 + \frac{\lVert r \rVert^2}{n} \lVert u \rVert^2

by steps of Gauss and Newton. :math:`r` is what a free run leaves, :math:`u` are the numbers
over what they are known to.
"""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.free_run_error import Scored, relative_residuals
from shakerproc.comparison.measured import Measured
from shakerproc.comparison.noise_sources import Quiet, offset_errors
from shakerproc.data import FloatArray
from shakerproc.errors import SimulationError
from shakerproc.models import Model
from shakerproc.simulation import Input, Runs, free_runs, is_smooth, motions_of, simulate
from shakerproc.simulation.inputs import prepare_measured, with_constant

CONSTANT_SPREAD: Final = 0.1
"""Standard deviation of the constant of a force over its rms: what amplifiers and force sensors
drift by (starting value) [-]."""

TOLERANCE: Final = 1e-9
"""Of a simulation that is compared with a measurement, as a share of the motion [-]."""

STARTED: Final = 2**22
"""Samples of a test times the square of the numbers of its start up to which that is fitted:
some seconds."""

_ROUNDS: Final = 4  # Gauss-Newton steps
_STEP: Final = 0.01  # of a number, for slopes
_SHORTENED: Final = (1.0, 0.25, 0.0625)  # steps that are tried
_ENOUGH: Final = 1e-3  # gain of a step over what is left, from which on none follows


@final
@dataclass(frozen=True, slots=True, eq=False)
class Own:
    """Numbers of one test alone under a model.

    Attributes
    ----------
    constant : float
        What is added to the input [N].
    start : (n_motions,) array, optional
        The motion at sample 0, in the order of `motions_of`; None is rest [SI].
    values : bool
        Whether the recorder took accelerations as values at the samples, in which jumps fold
        back; else it filtered them.
    """

    constant: float = 0.0
    start: FloatArray | None = None
    values: bool = False


def constant_spread(rows: FloatArray, quiet: Quiet | None) -> float:
    """Return the standard deviation of the constant of a force, (n,) samples of it [N].

    What amplifiers drift by, and, where no rest tells the offset of the sensor, how well the
    mean of the recording is known: that of a push is most of it.
    """
    drift = CONSTANT_SPREAD * float(np.sqrt(np.mean(rows**2)))
    return float(np.hypot(drift, 0.0 if quiet else offset_errors(rows[np.newaxis])[0]))


def run(model: Model, given: Input, own: Own) -> tuple[FloatArray, bool]:
    """Return signals of a free run, (n_sensors, n), and whether it ran away [SI].

    `given` is the input with the constant of the test.
    """
    whole = np.array([(0, 0, given.n_samples)])
    start = None if own.start is None else own.start[np.newaxis]
    found = free_runs(model, Runs((given,), whole, start), means=not own.values)
    rows = found.outputs[0] if own.values else at_samples(model, found.outputs[0])
    return rows, bool(found.failed[0])


def scored_whole(measured: Measured, simulated: FloatArray) -> Scored:
    """Return a test and its simulation, all that is judged counted, (n_sensors, n) [SI]."""
    counted = np.zeros(simulated.shape[1], bool)
    counted[measured.start : measured.stop] = True
    return Scored(
        measured.responses, simulated, measured.sample_rate, measured.error_band, counted
    )


def own_of(model: Model, measured: Measured) -> tuple[Own, Input]:
    """Return the numbers of a test alone, fitted to it under a model, and its input with them.

    Nothing where a displacement is imposed; a start where the recording does not begin at rest,
    but of a large model in a long test (see `STARTED`). The input is prepared for the engine
    [m/s^2, N or m].
    """
    model = model.under(measured.conditions)
    imposed = model.excitation.imposed
    given = prepare_measured(measured.input, measured.sample_rate, imposed=imposed)
    if imposed:
        return Own(), given
    problem = _OwnNumbers(model, measured, given)
    own = problem.solved()
    if not is_smooth(model):
        as_values = replace(own, values=True)
        means, values = (problem.left(one) for one in (own, as_values))
        better = values is not None and (means is None or values @ values < means @ means)
        own = as_values if better else own
    return own, with_constant(given, own.constant)


@final
class _OwnNumbers:
    """Least squares for the numbers of one test."""

    def __init__(self, model: Model, measured: Measured, given: Input) -> None:
        self.model, self.measured, self.given = model, measured, given
        names = motions_of(model)
        moved = np.array([not name.startswith("state") for name in names])
        small = measured.input.size * np.count_nonzero(moved) ** 2 <= STARTED
        started = measured.quiet is None and small
        self.sizes = _usual(model, given)[moved] if started else np.zeros(0)
        self.rest = np.zeros(len(names) - self.sizes.size)
        force = model.excitation.role == "force"
        size = constant_spread(measured.input, measured.quiet)
        self.spread = np.array([size] if force else [])

    def own(self, u: FloatArray) -> Own:
        """Return numbers from what they are over what they are known to."""
        n = self.spread.size
        start = np.concatenate([self.sizes * u[n:], self.rest]) if self.sizes.size else None
        return Own(float(self.spread @ u[:n]), start)

    def left(self, own: Own) -> FloatArray | None:
        """Return the relative residuals of a free run; None where it runs away."""
        given = with_constant(self.given, own.constant)
        simulated, failed = run(self.model, given, own)
        if failed:
            return None
        return relative_residuals(scored_whole(self.measured, simulated)).ravel()

    def solved(self) -> Own:
        """Return the numbers that leave least."""
        u = np.zeros(self.spread.size + self.sizes.size)
        here = self.left(self.own(u)) if u.size else None
        if here is None:
            return Own()
        for _ in range(_ROUNDS):
            step, least = self._step(u, here), float(here @ here)
            tried = ((u + share * step) for share in _SHORTENED)
            ends = ((one, self.left(self.own(one))) for one in tried)
            better = (
                (one, left) for one, left in ends if left is not None and left @ left < least
            )
            there = next(better, None)
            if there is None:
                break
            u, here = there
            if least - float(here @ here) < _ENOUGH * least:
                break
        return self.own(u)

    def _step(self, u: FloatArray, here: FloatArray) -> FloatArray:
        """Return the step of least squares from residuals that are `here`."""
        ends = [self.left(self.own(u + _STEP * one)) for one in np.eye(u.size)]
        slopes = [np.zeros_like(here) if end is None else (end - here) / _STEP for end in ends]
        table, scatter = np.array(slopes), max(float(here @ here) / here.size, 1e-300)
        square = table @ table.T + scatter * np.eye(u.size)
        return np.asarray(-np.linalg.solve(square, table @ here + scatter * u))


def _usual(model: Model, given: Input) -> FloatArray:
    """Return the rms of every motion of a free run from rest, (n_motions,) array [SI].

    0 where it runs away.
    """
    try:
        found = simulate(model, given, growth=False, tolerance=TOLERANCE, solver="quick")
    except SimulationError:
        return np.zeros(len(motions_of(model)))
    return np.asarray(np.sqrt(np.mean(found.motion**2, axis=1)))


def at_samples(model: Model, outputs: FloatArray) -> FloatArray:
    r"""Return accelerations at the samples from means over the interval to the next.

    A mean does not alias where the acceleration jumps. Of a band-limited signal it is
    :math:`\mathrm{sinc}(f / f_s)\, e^{i \pi f / f_s}` times its spectrum, which is undone
    here, so that what was measured is left as it is. Rows of other quantities are returned
    unchanged.

    Parameters
    ----------
    model : Model
        Says what each sensor measures.
    outputs : (n_sensors, n) array
        What `free_runs` returns [SI].
    """
    return _boxed(model, outputs, -1)


def as_means(model: Model, samples: FloatArray) -> FloatArray:
    """Return accelerations as means over the next interval, undone by `at_samples` [SI]."""
    return _boxed(model, samples, 1)


def _boxed(model: Model, rows: FloatArray, power: int) -> FloatArray:
    n = rows.shape[1]
    length = scipy.fft.next_fast_len(n + 2048, real=True)
    share = scipy.fft.rfftfreq(length, 1.0)
    box = (np.sinc(share) * np.exp(1j * np.pi * share)) ** power
    found = rows.copy()
    for i, sensor in enumerate(model.sensors.values()):
        if sensor.measures == "acceleration":
            found[i] = scipy.fft.irfft(scipy.fft.rfft(rows[i], length) * box, length)[:n]
    return found
