"""Windows of a test, where no model predicts its motion as a whole; their starts fitted."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models import Model
from shakerproc.simulation import SENSITIVE_GROWTH, Input, Runs, free_runs, motions_of

RUN_IN_PERIODS: Final = 2.0
"""Periods at the start of a window to which its start is fitted; they are not scored [-]."""

SHORTEST: Final = 4
"""Length of a window over its run-in, at least: else little is scored [-]."""

_PROBES: Final = 8  # starts along the test from which the growth of a disturbance is seen
_DISTURBANCE: Final = 1e-6  # share of the motion, far above what the simulation rounds
_EXACT: Final = 1e-12  # tolerance with which it is followed
_ROUNDS: Final = 8  # Gauss-Newton steps
_STEP: Final = 1e-4  # of a motion's size, for slopes
_SHORTENED: Final = (1.0, 0.25, 0.0625)  # steps that are tried


@final
@dataclass(frozen=True, slots=True, eq=False)
class EvenWindows:
    """Windows of one length.

    Attributes
    ----------
    first : (n_windows,) array of int
        First sample of each.
    n_samples : int
        Length: the horizon.
    run_in : int
        Samples at the start of each that its start is fitted to.
    """

    first: NDArray[np.int64]
    n_samples: int
    run_in: int

    def counted(self, n: int) -> NDArray[np.bool_]:
        """Return which of n samples of the test are scored."""
        inside = np.zeros(n, bool)
        for first in self.first:
            inside[first + self.run_in : first + self.n_samples] = True
        return inside


def windows_of(start: int, stop: int, horizon: int, run_in: int) -> EvenWindows:
    """Return the windows of samples `start` to `stop`, none of which is cut short."""
    length = min(max(horizon, SHORTEST * run_in), stop - start)
    count = max(1, (stop - start) // length)
    return EvenWindows(start + length * np.arange(count), length, min(run_in, length // 2))


def period_of_response(
    responses: FloatArray, sample_rate: float, band: tuple[float, float]
) -> float:
    """Return the period at which a response is largest within a band [s]."""
    n = responses.shape[1]
    frequency = scipy.fft.rfftfreq(n, 1.0 / sample_rate)
    size = np.sqrt(np.sum(responses**2, axis=1, keepdims=True))
    power = np.sum(
        np.abs(scipy.fft.rfft(responses, axis=1) / np.where(size > 0, size, 1)) ** 2, 0
    )
    inside = (frequency >= band[0]) & (frequency <= band[1]) & (frequency > 0.0)
    if not inside.any():
        return 1.0 / band[0]
    return 1.0 / float(frequency[np.argmax(np.where(inside, power, 0.0))])


def horizon_of(model: Model, given: Input, motion: FloatArray, start: int) -> int:
    """Return the samples over which a disturbance of the motion grows `SENSITIVE_GROWTH` times.

    Seen from several places along the test; the lower quartile of them, so that the motion of
    most windows is predictable.

    Parameters
    ----------
    model : Model
        A model whose motion cannot be predicted for the whole test.
    given : Input
        What shakes it.
    motion : (n_motions, n) array
        Its motion from rest: displacements, velocities, states [m, m/s and as the law has it].
    start : int
        First sample that is judged.
    """
    n = motion.shape[1]
    firsts = np.linspace(start, start + 0.75 * (n - start), _PROBES).astype(int)
    windows = np.array([(0, first, n - first) for first in firsts])
    starts = motion[:, firsts].T
    size = np.sqrt(np.mean(motion**2, axis=1))
    moving = _moving(model)
    nudge = np.zeros_like(size)
    nudge[moving] = _DISTURBANCE * size[moving]
    as_is, moved = (
        free_runs(model, Runs((given,), windows, begin), tolerance=_EXACT, means=False)
        for begin in (starts, starts + nudge)
    )
    reached = []
    for one, other in zip(as_is.outputs, moved.outputs, strict=True):
        rms = np.sqrt(np.mean(one**2, axis=1, keepdims=True))
        apart = np.abs(other - one) > SENSITIVE_GROWTH * _DISTURBANCE * rms
        far = apart.any(axis=0)
        reached.append(int(np.argmax(far)) if far.any() else one.shape[1])
    return int(np.quantile(reached, 0.25))


def run_windows(
    model: Model,
    given: Input,
    measured: FloatArray,
    windows: EvenWindows,
    motion_sizes: FloatArray,
) -> FloatArray:
    """Return signals of the sensors in windows, each from a start fitted to its run-in.

    Starts are displacement and velocity of everything that moves; laws with memory run in.

    Parameters
    ----------
    model : Model
        What is shaken.
    given : Input
        What shakes it in this test.
    measured : (n_sensors, n) array
        What the sensors measured [SI].
    windows : EvenWindows
        The windows.
    motion_sizes : (n_motions,) array
        Usual size of every motion, in the order of `motions_of` [SI].

    Returns
    -------
    (n_sensors, n) array
        Joined; 0 outside the windows. Accelerations are means over the interval to the next
        sample, as those of `free_runs` are, and `measured` must be.
    """
    starts = fitted_starts(model, given, measured, windows, motion_sizes)
    sizes = _rms(measured)
    rows = np.column_stack([
        np.zeros_like(windows.first),
        windows.first,
        np.full_like(windows.first, windows.n_samples),
    ])
    found = free_runs(model, Runs((given,), rows, starts, sizes))
    joined = np.zeros_like(measured)
    for first, output in zip(windows.first, found.outputs, strict=True):
        joined[:, first : first + windows.n_samples] = output
    return joined


def fitted_starts(
    model: Model,
    given: Input,
    measured: FloatArray,
    windows: EvenWindows,
    motion_sizes: FloatArray,
) -> FloatArray:
    """Return the motion with which each window of `run_windows` begins.

    `measured` is in the units of the sensors, `motion_sizes` in those of the motion [m, m/s].

    Returns
    -------
    (n_windows, n_motions) array
        In the order of `motions_of` [SI].
    """
    return _Starts(model, given, measured, windows, motion_sizes).solved()


def _moving(model: Model) -> NDArray[np.bool_]:
    """Return which motions are displacements or velocities, (n_motions,) array."""
    return np.array([not name.startswith("state") for name in motions_of(model)])


def _rms(rows: FloatArray) -> FloatArray:
    sizes: FloatArray = np.sqrt(np.mean(rows**2, axis=1))
    return sizes


@final
class _Starts:
    """Least squares for the starts of all windows at once, each for itself."""

    def __init__(
        self,
        model: Model,
        given: Input,
        measured: FloatArray,
        windows: EvenWindows,
        motion_sizes: FloatArray,
    ) -> None:
        self.model, self.given = model, given
        n = len(windows.first)
        self.rows = np.column_stack([
            np.zeros(n, np.int64), windows.first, np.full(n, windows.run_in)
        ])  # fmt: skip
        self.sizes = _rms(measured)
        scale = np.where(self.sizes > 0.0, self.sizes, 1.0)[:, None]
        self.scale = scale
        self.wanted = [
            (measured[:, first : first + windows.run_in] / scale).ravel()
            for first in windows.first
        ]
        moving = _moving(model)
        usual = np.where(motion_sizes > 0.0, motion_sizes, np.max(motion_sizes, initial=1e-12))
        self.steps = np.diag(_STEP * usual)[moving]

    def residuals(self, starts: FloatArray) -> FloatArray:
        """Return measured less simulated over the run-ins, (n_windows, n) array [-]."""
        found = free_runs(self.model, Runs((self.given,), self.rows, starts, self.sizes))
        return np.array([
            want - (output / self.scale).ravel()
            for want, output in zip(self.wanted, found.outputs, strict=True)
        ])

    def solved(self) -> FloatArray:
        """Return the starts, (n_windows, n_motions) array."""
        steps = self.steps
        starts = np.zeros((len(self.rows), steps.shape[1]))
        residual = self.residuals(starts)
        for _ in range(_ROUNDS):
            slopes = np.stack([
                (self.residuals(starts + step) - residual) / _STEP for step in steps
            ], axis=-1)  # fmt: skip
            moves = np.array([
                np.linalg.lstsq(-slope, rest, rcond=1e-8)[0]
                for slope, rest in zip(slopes, residual, strict=True)
            ])
            trial, left = self._best(starts, residual, moves @ steps / _STEP)
            gained = np.sum(residual**2) - np.sum(left**2)
            starts, residual = trial, left
            if gained <= 1e-4 * np.sum(residual**2):
                break
        return starts

    def _best(
        self, starts: FloatArray, residual: FloatArray, moves: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the starts and residuals after the best share of a step, by window."""
        best, least = starts, residual
        for share in _SHORTENED:
            trial = starts + share * moves
            left = self.residuals(trial)
            better = np.sum(left**2, axis=1) < np.sum(least**2, axis=1)
            best = np.where(better[:, None], trial, best)
            least = np.where(better[:, None], left, least)
        return best, least
