"""Normal equations of least squares, with the starts of windows eliminated.

References
----------
.. [1] H. G. Bock, "Recent advances in parameter identification techniques for ODE", in
   "Numerical Treatment of Inverse Problems in Differential and Integral Equations",
   Birkhaeuser, 1983 (multiple shooting, elimination of local variables).
"""

from collections.abc import Iterator
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.point import Linearised, Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.scatter import Cluster

LONGEST_STEP: Final = 0.7
"""Largest change of a coordinate in one step: a factor of two of a logarithm [-]."""

GAINS: Final = (0.2, 5.0)
"""Between which the gain of a sensor is sought: factors beyond are wrong units [-]."""


@final
class NormalEquations:
    """Normal equations of one linearisation, with the starts of windows eliminated.

    Parameters
    ----------
    linearisation : Linearisation
        What is fitted to what.
    at : Point
        Where it was linearised.
    slopes : Linearised
        Residual and slopes there.
    spread : (n,) array, optional
        What all numbers are known to beforehand, as standard deviations; that of the
        linearisation, which has none of the numbers of effects.

    Attributes
    ----------
    prior : (n,) array
        The part of the information that is known beforehand [-].
    information : (n, n) array
        Of x, gains, delays and numbers of tests, starts eliminated [-].
    """

    def __init__(
        self,
        linearisation: Linearisation,
        at: Point,
        slopes: Linearised,
        spread: FloatArray | None = None,
    ) -> None:
        self.linearisation, self.at = linearisation, at
        spread = linearisation.spread if spread is None else spread
        known = np.isfinite(spread)
        self.prior: FloatArray = np.where(known, linearisation.correlation / spread**2, 0.0)
        self.normal: FloatArray = np.diag(self.prior)
        self.score: FloatArray = self.prior * linearisation.values(at)
        self.kept: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        eliminated = np.zeros_like(self.normal)
        for i in range(len(slopes.residual)):
            r, p, s = self._weighted(slopes, i)
            flat = p.reshape(-1, spread.size)
            self.normal += flat.T @ flat
            self.score += flat.T @ r.ravel()
            turned = s.transpose(0, 2, 1)
            own, mixed = turned @ s, turned @ p
            self.kept.append((own, mixed, np.einsum("msr,mr->ms", turned, r)))
            inner = mixed.transpose(0, 2, 1) @ _inverse(own) @ mixed
            eliminated += np.sum(inner, axis=0)
        self.information: FloatArray = self.normal - eliminated

    def _weighted(
        self, slopes: Linearised, index: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return residual and slopes of a stack, by the scales of its blocks."""
        root = self.linearisation.weights(slopes.residual[index])
        wide = root[..., None]
        return (
            root * slopes.residual[index],
            wide * slopes.slopes[index],
            wide * slopes.own[index],
        )

    def taken(self, damping: float) -> tuple[Point, float]:
        """Return where a damped step leads, within bounds, and by how much the cost may fall.

        Were the residual as straight as its slopes, it would fall by as much at least, but for
        what is cut of the longest steps [-].
        """
        normal, score, fall = self.normal.copy(), self.score.copy(), 0.0
        inverses: list[FloatArray] = []
        for own, mixed, left in self.kept:
            diagonal = np.diagonal(own, axis1=1, axis2=2)
            most = diagonal.max(axis=1, initial=0.0, keepdims=True)
            held = damping * diagonal + 1e-12 * np.where(most > 0.0, most, 1.0)
            damped = own + held[:, :, None] * np.eye(own.shape[1])
            inverse: FloatArray = np.asarray(np.linalg.inv(damped), np.float64)
            inverses.append(inverse)
            turned = mixed.transpose(0, 2, 1) @ inverse
            normal -= np.sum(turned @ mixed, axis=0)
            score -= np.einsum("mns,ms->n", turned, left)
            fall += float(np.einsum("ms,mst,mt->", left, inverse, left))
        step = self._solved(normal, score, damping)
        fall -= float(score @ step)
        n_x, n_s = self.at.x.size, self.at.gain.size
        change = np.clip(step[:n_x], -LONGEST_STEP, LONGEST_STEP)
        x = np.clip(self.at.x + change, self.linearisation.low, self.linearisation.high)
        moved = np.concatenate([x - self.at.x, step[n_x:]])
        gain = np.clip(self.at.gain + moved[n_x : n_x + n_s], *GAINS)
        delay = self.at.delay + moved[n_x + n_s : n_x + 2 * n_s]
        own = moved[n_x + 2 * n_s :].reshape(self.at.of_tests.shape)
        of_tests, starts = self.at.of_tests + own, self._starts(moved, inverses)
        there = Point(x, gain, delay, of_tests, starts)
        return there, fall / self.linearisation.correlation

    def clusters(self, slopes: Linearised) -> Iterator[Cluster]:
        """Yield the information of every block of every window, starts included."""
        size = self.linearisation.cluster
        for i, stack in enumerate(self.linearisation.stacks):
            test = int(self.linearisation.windows.table[stack.members[0], 0])
            left, columns = self._without_starts(slopes, i)
            parts = max(1, round(left.shape[1] / min(size, left.shape[1])))
            edges = np.linspace(0, left.shape[1], parts + 1).astype(int)
            for rows, short in zip(columns, left, strict=True):
                for block in map(slice, edges[:-1], edges[1:]):
                    own = rows[block]
                    yield Cluster(test, own.T @ own, own.T @ short[block])

    def pulled_by(self, slopes: Linearised, change: list[FloatArray]) -> FloatArray:
        """Return how a change of the residual pulls at all numbers but the starts, (n,) array.

        Parameters
        ----------
        slopes : Linearised
            Those of these equations.
        change : list of (n_members, n_residuals) array
            What the residual of each stack changes by.
        """
        pull = np.zeros(len(self.information))
        for i in range(len(self.kept)):
            root = self.linearisation.weights(slopes.residual[i])
            _, columns = self._without_starts(slopes, i)
            pull += np.einsum("mrn,mr->n", columns, root * change[i])
        return -pull

    def _without_starts(self, slopes: Linearised, index: int) -> tuple[FloatArray, FloatArray]:
        """Return residual and slopes of a stack, the starts going along with each change."""
        own, mixed, _ = self.kept[index]
        left, columns, by_start = self._weighted(slopes, index)
        return left, columns - by_start @ (_inverse(own) @ mixed)

    def inverted(self) -> FloatArray:
        r"""Return the inverse of the information, (n, n) array.

        .. math:: A^{-1} = S V (I + \Lambda)^{-1} V^T S, \qquad S D S = V \Lambda V^T

        with the information :math:`D` of the tests and the spreads :math:`S` that are known
        beforehand of every number. A direction that no test tells has :math:`\lambda = 0`:
        there all that is known was known before.
        """
        size = 1.0 / np.sqrt(self.prior)
        tests = (self.information - np.diag(self.prior)) * np.outer(size, size)
        told, directions = np.linalg.eigh(0.5 * (tests + tests.T))
        turned = size[:, None] * directions
        return np.asarray((turned / (1.0 + np.maximum(told, 0.0))) @ turned.T)

    def starts_alone(self, damping: float) -> FloatArray | None:
        """Return where a step of the starts leads, all else standing, (n_windows, n_motions).

        Damped by a share of what the number says most that is told best: one that the window
        hardly tells stays while the others move.
        """
        inverses = []
        for own, _, _ in self.kept:
            most = np.max(np.diagonal(own, axis1=1, axis2=2), axis=1, initial=0.0)
            held = damping * most[:, None, None] * np.eye(own.shape[1])
            inverses.append(_inverse(own + held))
        still = np.zeros(self.normal.shape[0])
        return self._starts(still, inverses)

    def _solved(self, normal: FloatArray, score: FloatArray, damping: float) -> FloatArray:
        """Return the damped step; what stands at a bound and is pushed out stays."""
        n_x = self.at.x.size
        free = np.ones(score.size, bool)
        at_low = (self.at.x <= self.linearisation.low) & (score[:n_x] > 0.0)
        at_high = (self.at.x >= self.linearisation.high) & (score[:n_x] < 0.0)
        free[:n_x] = ~(at_low | at_high)
        size = np.sqrt(np.maximum(np.diag(self.normal), 1e-300))
        scaled = normal / np.outer(size, size) + damping * np.eye(size.size)
        step = np.zeros(score.size)
        part = np.ix_(free, free)
        solution = np.linalg.lstsq(scaled[part], -(score / size)[free], rcond=1e-12)[0]
        step[free] = solution / size[free]
        return step

    def _starts(self, moved: FloatArray, inverses: list[FloatArray]) -> FloatArray | None:
        if self.at.starts is None:
            return None
        scales = self.linearisation.sizes_of_starts(self.at)
        starts = self.at.starts.copy()
        stacks = self.linearisation.stacks
        for stack, inverse, (_, mixed, left) in zip(stacks, inverses, self.kept, strict=True):
            change = np.einsum("mst,mt->ms", inverse, left + mixed @ moved)
            starts[stack.members] -= scales * np.clip(change, -1.0, 1.0)
        return starts


def _inverse(own: FloatArray) -> FloatArray:
    """Return the pseudo-inverse of every window's part, (n_members, n_starts, n_starts)."""
    return np.asarray(np.linalg.pinv(own, hermitian=True), np.float64) if own.size else own
