"""Laws fitted to the force of an imposed motion, and scored on swings that took no part."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.diagnose.candidates import Candidate, Motion, Values
from shakerproc.diagnose.imposed_laws import Law, along, forces
from shakerproc.diagnose.imposed_motion import Loop

FOLDS = 3
"""Every third swing is kept out in turn, where the log marks no test to be held out."""
STARTS = 3
"""Points of a grid from which a fit sets out."""


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
    """All judged samples of all tests, one behind the other.

    Attributes
    ----------
    loops : tuple of Loop
        The tests.
    motion : Motion
        Their scales.
    judged : tuple of (n,) arrays
        Whether a sample is judged, for each test.
    test, swing : (n_judged,) array
        Test and running swing of every judged sample.
    displacement, velocity, force : (n_judged,) array
        [m], [m/s], [N].
    hold_out : (n_judged,) array
        Whether the log keeps the sample out of every fit.
    """

    loops: tuple[Loop, ...]
    motion: Motion
    judged: tuple[NDArray[np.bool_], ...]
    test: NDArray[np.int64]
    swing: NDArray[np.int64]
    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    hold_out: NDArray[np.bool_]

    @property
    def rms(self) -> float:
        """Rms of the judged force [N]."""
        return float(np.sqrt(np.mean(self.force**2)))

    def law(self, law: Law, values: Sequence[float]) -> FloatArray:
        """Return the force of a law at the judged samples [N]."""
        return np.concatenate([
            forces(law, values, loop, self.motion)[kept]
            for loop, kept in zip(self.loops, self.judged, strict=True)
        ])

    def folds(self) -> list[tuple[NDArray[np.bool_], NDArray[np.bool_]]]:
        """Return which samples are fitted and which scored, once for each fold."""
        if np.any(self.hold_out):
            return [(~self.hold_out, self.hold_out)]
        return [(self.swing % FOLDS != i, self.swing % FOLDS == i) for i in range(FOLDS)]


def bench(found: Sequence[Loop], motion: Motion) -> Bench:
    """Return the judged samples of these tests."""
    judged = tuple(loop.swing >= 0 for loop in found)
    first = np.cumsum([0, *(loop.turns.size for loop in found)])

    def joined(rows: Sequence[NDArray[np.float64]]) -> FloatArray:
        return np.concatenate([row[kept] for row, kept in zip(rows, judged, strict=True)])

    sizes = [int(np.sum(kept)) for kept in judged]
    return Bench(
        tuple(found), motion, judged,
        np.repeat(np.arange(len(found)), sizes),
        np.concatenate([
            loop.swing[kept] + first[i]
            for i, (loop, kept) in enumerate(zip(found, judged, strict=True))
        ]),
        joined([loop.displacement for loop in found]),
        joined([loop.velocity for loop in found]),
        joined([loop.force for loop in found]),
        np.repeat([loop.hold_out for loop in found], sizes),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """A law fitted to the swings of a bench.

    Attributes
    ----------
    law : Law
        What acts beside spring and damper.
    values : tuple of float
        Its numbers.
    stiffness, damping : float
        Of the linear joint [N/m], [N s/m].
    left : (n_judged,) array
        Force that is not explained at every judged sample, fitted or not [N].
    scored : (n_judged,) array
        The same by the fits that had not seen the sample [N]; NaN where none scores it.
    """

    law: Law
    values: Values
    stiffness: float
    damping: float
    left: FloatArray
    scored: FloatArray


def fit(at: Bench, law: Law, starts: Sequence[Values]) -> Fitted:
    """Return a law fitted to all that may be fitted, from the best start, and scored."""
    ends = [refined(at, law, start) for start in starts]
    best = min(ends, key=lambda one: float(np.sum(one.left[~at.hold_out] ** 2)))
    return score(at, best)


def refined(at: Bench, law: Law, start: Values) -> Fitted:
    """Return a law fitted to all that may be fitted, from one start; not scored."""
    used = ~at.hold_out
    values = _refined(at, law, start, used)
    left, stiffness, damping = _residual(at, at.law(law, values), used)
    return Fitted(law, values, stiffness, damping, left, np.full(at.force.size, np.nan))


def score(at: Bench, one: Fitted) -> Fitted:
    """Return the same, scored on swings by fits that have not seen them."""
    scored = np.full(at.force.size, np.nan)
    for part, kept in at.folds():
        own = _refined(at, one.law, one.values, part)
        scored[kept] = _residual(at, at.law(one.law, own), part)[0][kept]
    return replace(one, scored=scored)


def starts_of(at: Bench, part: Candidate, beside: FloatArray) -> list[Values]:
    """Return where to start a part from, the most promising first.

    `beside` (n_judged,) is the force of what acts already [N].
    """
    found = []
    for inner in part.grid(at.motion):
        columns = [
            np.concatenate([
                along(op, row, loop, at.motion)[kept]
                for loop, kept in zip(at.loops, at.judged, strict=True)
            ])
            for op, row in part.columns(inner, at.motion.stiffness)
        ]  # fmt: skip
        design = np.stack([*columns, at.displacement, at.velocity], axis=1)
        used = ~at.hold_out
        centred = _centred(at, design, used)[used]
        target = _centred(at, at.force - beside, used)[used]
        weights, *_ = np.linalg.lstsq(centred, target, rcond=None)
        own = np.asarray(weights[: len(columns)], dtype=np.float64)
        values = part.combine(inner, own, at.motion)
        if values is None:
            continue
        found.append(tuple(float(x) for x in values))
    found += [tuple(float(x) for x in guess) for guess in part.guesses(at.motion)]
    cost = {v: _cost(at, beside + at.law(Law((part,)), v), ~at.hold_out) for v in found}
    return sorted(cost, key=lambda values: cost[values])[:STARTS]


def _centred(at: Bench, rows: FloatArray, used: NDArray[np.bool_]) -> FloatArray:
    """Return rows less their mean over the used samples of each test: sensors have offsets."""
    out = rows.copy()
    for i in range(len(at.loops)):
        own = at.test == i
        if np.any(own & used):
            out[own] -= rows[own & used].mean(axis=0)
        else:
            out[own] -= rows[own].mean(axis=0)
    return out


def _residual(
    at: Bench, explained: FloatArray, used: NDArray[np.bool_]
) -> tuple[FloatArray, float, float]:
    """Return what spring and damper beside a law leave, and their two numbers, neither < 0."""
    design = np.stack([at.displacement / at.motion.rms, at.velocity / at.motion.fast], axis=1)
    columns = _centred(at, design, used)
    rest = _centred(at, at.force - explained, used)
    weights, _ = scipy.optimize.nnls(
        columns[used].T @ columns[used], columns[used].T @ rest[used]
    )
    left: FloatArray = rest - columns @ weights
    return left, float(weights[0] / at.motion.rms), float(weights[1] / at.motion.fast)


def _cost(at: Bench, explained: FloatArray, used: NDArray[np.bool_]) -> float:
    return float(np.sum(_residual(at, explained, used)[0][used] ** 2))


def _refined(at: Bench, law: Law, start: Values, used: NDArray[np.bool_]) -> Values:
    """Return the numbers of least squares, from a start."""
    if not law.parts:
        return ()
    to, back = _scaling(law, start)

    def left(theta: FloatArray) -> FloatArray:
        return _residual(at, at.law(law, back(theta)), used)[0][used] / at.rms

    found = scipy.optimize.least_squares(
        left, to, x_scale=0.1, diff_step=[1e-4] * to.size, max_nfev=40,
        bounds=(to - 6.0, to + 6.0), ftol=1e-6, xtol=1e-6,
    )  # fmt: skip
    return back(found.x)


def _scaling(law: Law, values: Values) -> tuple[FloatArray, Callable[[FloatArray], Values]]:
    """Return scaled numbers (logarithms of what is above 0), and the way back."""
    scale = np.array([abs(v) or 1.0 for v in values])
    sign = np.array(law.positive, dtype=bool)
    to = np.where(sign, np.log(scale), np.array(values) / scale)

    def back(theta: FloatArray) -> Values:
        grown = np.exp(np.where(sign, theta, 0.0))
        return tuple(float(x) for x in np.where(sign, grown, theta * scale))

    return to, back


def spread(at: Bench, fitted: Fitted) -> tuple[FloatArray, FloatArray]:
    """Return half 95 % intervals: of the scaled numbers of the law, and of k and c.

    From the scatter of the slope of least squares between swings, which are taken as
    independent of each other, widened to Student's t of as many swings.
    """
    to, back = _scaling(fitted.law, fitted.values)
    used = ~at.hold_out
    slopes = []
    for i in range(to.size):
        step = np.zeros(to.size)
        step[i] = 1e-3
        up, down = (at.law(fitted.law, back(to + s)) for s in (step, -step))
        slopes.append((up - down) / 2e-3)
    scale = np.array([at.motion.rms, at.motion.fast])
    design = np.stack([*slopes, at.displacement / scale[0], at.velocity / scale[1]], axis=1)
    rows = _centred(at, design, used)[used]
    swings = np.unique(at.swing[used])
    pushes = np.stack([
        rows[at.swing[used] == s].T @ fitted.left[used][at.swing[used] == s] for s in swings
    ])
    inverse = np.linalg.pinv(rows.T @ rows, rcond=1e-12, hermitian=True)
    free = max(swings.size - design.shape[1], 1)
    cov = inverse @ (pushes.T @ pushes) @ inverse * (swings.size / free)
    half = float(scipy.stats.t.ppf(0.975, free)) * np.sqrt(np.maximum(np.diag(cov), 0.0))
    return half[: to.size], half[to.size :] / scale
