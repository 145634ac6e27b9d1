"""Normal equations of least squares, with the starts of windows eliminated.

References
----------
.. [1] H. G. Bock, "Recent advances in parameter identification techniques for ODE", in
   "Numerical Treatment of Inverse Problems in Differential and Integral Equations",
   Birkhaeuser, 1983 (multiple shooting, elimination of local variables).
"""

from dataclasses import replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation, Linearised, Point

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

    Attributes
    ----------
    information : (n, n) array
        Of x, gains and delays, starts eliminated [-].
    """

    def __init__(self, linearisation: Linearisation, at: Point, slopes: Linearised) -> None:
        self.linearisation, self.at = linearisation, at
        spread = linearisation.spread
        n = spread.size
        prior = np.where(np.isfinite(spread), linearisation.correlation / spread**2, 0.0)
        self.normal: FloatArray = np.diag(prior)
        self.score: FloatArray = prior * linearisation.values(at)
        self.kept: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        eliminated = np.zeros((n, n))
        for i, failed in enumerate(slopes.failed):
            if failed:
                self.kept.append((np.zeros((0, 0)), np.zeros((0, n)), np.zeros(0)))
                continue
            r, p, s = self._weighted(slopes, i)
            self.normal += p.T @ p
            self.score += p.T @ r
            own, mixed = s.T @ s, s.T @ p
            self.kept.append((own, mixed, s.T @ r))
            if own.size:
                eliminated += mixed.T @ np.linalg.pinv(own, hermitian=True) @ mixed
        self.information: FloatArray = self.normal - eliminated

    def _weighted(
        self, slopes: Linearised, index: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return residual and slopes of a window, by the scales of its blocks."""
        root = self.linearisation.weights(slopes.residual[index])
        wide = root[:, None]
        return (
            root * slopes.residual[index],
            wide * slopes.slopes[index],
            wide * slopes.own[index],
        )

    def taken(self, damping: float) -> Point:
        """Return where a damped step leads, within bounds."""
        normal, score = self.normal.copy(), self.score.copy()
        inverses: list[FloatArray] = []
        for own, mixed, left in self.kept:
            if not own.size:
                inverses.append(own)
                continue
            diagonal = np.diag(own)
            held = own + np.diag(damping * diagonal + 1e-12 * (diagonal.max() or 1.0))
            inverse: FloatArray = np.asarray(np.linalg.inv(held), np.float64)
            inverses.append(inverse)
            normal -= mixed.T @ inverse @ mixed
            score -= mixed.T @ inverse @ left
        step = self._solved(normal, score, damping)
        n_x, n_s = self.at.x.size, self.at.gain.size
        change = np.clip(step[:n_x], -LONGEST_STEP, LONGEST_STEP)
        x = np.clip(self.at.x + change, self.linearisation.low, self.linearisation.high)
        moved = np.concatenate([x - self.at.x, step[n_x:]])
        gain = np.clip(self.at.gain + moved[n_x : n_x + n_s], *GAINS)
        return Point(x, gain, self.at.delay + moved[n_x + n_s :], self._starts(moved, inverses))

    def scores(self, slopes: Linearised) -> FloatArray:
        """Return the covariance of the slopes of the cost, from their scatter over blocks."""
        out = np.zeros_like(self.information)
        for i, (own, mixed, _) in enumerate(self.kept):
            if slopes.failed[i]:
                continue
            left, columns, by_start = self._weighted(slopes, i)
            if own.size:
                columns = columns - by_start @ np.linalg.pinv(own, hermitian=True) @ mixed
            parts = max(1, round(left.size / min(self.linearisation.cluster, left.size)))
            first = np.linspace(0, left.size, parts + 1).astype(int)[:-1]
            summed = np.add.reduceat(columns * left[:, None], first, axis=0)
            out += summed.T @ summed
        return out

    def starts_alone(self) -> Point:
        """Return where an undamped step of the starts leads, all else standing."""
        inverses: list[FloatArray] = [
            np.asarray(np.linalg.pinv(own, hermitian=True), np.float64) if own.size else own
            for own, _, _ in self.kept
        ]
        still = np.zeros(self.normal.shape[0])
        return replace(self.at, starts=self._starts(still, inverses))

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
        scales = self.linearisation.windows.scales
        if self.at.starts is None or scales is None:
            return None
        starts = self.at.starts.copy()
        for i, (inverse, (own, mixed, left)) in enumerate(
            zip(inverses, self.kept, strict=True)
        ):
            if own.size:
                starts[i] += scales * np.clip(-inverse @ (left + mixed @ moved), -1.0, 1.0)
        return starts
