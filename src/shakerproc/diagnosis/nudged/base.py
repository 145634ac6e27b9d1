"""The hypothesis that an effect is added to, held to the motion, and how its numbers move."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError
from shakerproc.simulation.assembly import assemble

_SCALES: Final = (-0.9, 9.0)
"""Changes of the force of an effect that its start may be given, over that force [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Moved:
    """A start with the base's numbers moved.

    Attributes
    ----------
    hypothesis : Hypothesis
        What is fitted.
    x : (n_x,) array
        Where it is then [-].
    logs : (n_blocks,) array
        Logarithm of 1 + mean square of what it leaves over the noise, in each block [-].
    """

    hypothesis: Hypothesis
    x: FloatArray
    logs: FloatArray

    @property
    def level(self) -> float:
        """Mean over the blocks (see `Fit.level`) [-]."""
        return float(np.mean(self.logs))


@final
class Base:
    """A fit without the effect, and the slopes of its residual by its own numbers.

    What an effect leaves depends on numbers that stood in for it: so starts of an effect are
    compared with the fit's own numbers moved, which held runs follow along straight lines.
    """

    def __init__(self, base: Fit, windows: Windows) -> None:
        self.fit, self._windows = base, windows
        own = Linearisation(base.data, base.hypothesis, windows)
        self._moved_by = _starts_moved(own, base)
        at = self._begun(own, base.hypothesis, base.x)
        state = own.residual(at)
        there = None if state is None else own.linearise(at, state)
        free = windows.rate is None and not windows.from_rest
        self._starts = (
            [] if there is None or not free else [np.linalg.qr(o)[0] for o in there.own]
        )
        count = own.spread.size
        columns = [
            self._without_starts(i, s).reshape(-1, count)
            for i, s in enumerate([] if there is None else there.slopes)
        ]
        table = np.concatenate([*columns, np.zeros((0, count))])
        of_tests = slice(count - at.of_tests.size, count)
        self._tests = table[:, of_tests]
        square = self._tests.T @ self._tests + np.diag(own.spread[of_tests] ** -2.0)
        self._told = np.linalg.solve(square, self._tests.T)
        self._slopes = self._without_tests(table[:, : base.x.size])
        self._rows = np.zeros(0) if state is None else self._flat(state[0])
        self._prior = np.diag(1.0 / own.spread[: base.x.size])

    def _begun(self, own: Linearisation, hypothesis: Hypothesis, x: FloatArray) -> Point:
        """Return where runs begin: masses as in the fit, what no sensor tells as driven."""
        at = own.point(x, self.fit.channels)
        if at.starts is None or self._moved_by is None:
            return at
        n = len(assemble(hypothesis.model_at(x)).names)
        starts, masses = at.starts.copy(), self.fit.data.model.n_coordinates
        for first, moved in zip((0, n), self._moved_by, strict=True):
            starts[:, first : first + masses] += moved
        return replace(at, starts=starts)

    def _without_starts(self, stack: int, rows: FloatArray) -> FloatArray:
        """Return (n_members, n_residuals, n) rows without their part along starts."""
        if not self._starts:
            return rows
        basis = self._starts[stack]
        return np.asarray(rows - basis @ (basis.transpose(0, 2, 1) @ rows))

    def _flat(self, stacks: Sequence[FloatArray]) -> FloatArray:
        each = (self._without_starts(i, rows[..., None]) for i, rows in enumerate(stacks))
        return self._without_tests(np.concatenate([rows.ravel() for rows in each]))

    def _without_tests(self, rows: FloatArray) -> FloatArray:
        """Return (n_residuals, ...) rows without what each test may have of its own.

        A constant of the force, say, that a fit without the effect found to imitate it.
        """
        return np.asarray(rows - self._tests @ (self._told @ rows))

    def best(self, starts: Sequence[tuple[Hypothesis, FloatArray]]) -> list[Moved]:
        """Return starts by what they leave, without those that run away."""
        moved = [one for start in starts if (one := self._moved(*start)) is not None]
        return sorted(moved, key=lambda one: one.level)

    def _residual(self, own: Linearisation, x: FloatArray) -> FloatArray | None:
        """Return the residual at a place; None where it runs away."""
        try:
            state = own.residual(self._begun(own, own.hypothesis, x))
        except ModelError:
            return None
        if state is None or state[1].failed.any():
            return None
        rows = self._flat(state[0])
        return rows if np.isfinite(np.sum(rows**2)) else None

    @staticmethod
    def _logs(own: Linearisation, rows: FloatArray) -> FloatArray:
        blocks = np.array_split(rows**2, max(1, round(rows.size / own.block)))
        return np.log1p([float(np.mean(b)) for b in blocks])

    def _moved(self, hypothesis: Hypothesis, x: FloatArray) -> Moved | None:
        """Return a start with the base's numbers moved; None if it runs away."""
        own = Linearisation(self.fit.data, hypothesis, self._windows)
        rows, there = self._residual(own, x), x
        if rows is None:
            return None
        own_numbers = np.array_equal(x[: self.fit.x.size], self.fit.x)
        if own_numbers and hypothesis.own == self.fit.hypothesis.own:
            rows, there = self._projected(hypothesis, x, rows)
        return Moved(hypothesis, there, self._logs(own, rows))

    def _projected(
        self, hypothesis: Hypothesis, x: FloatArray, rows: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the residual with the base's numbers and the effect's force at their best.

        While it is held the effect adds to the residual what is proportional to its force.
        """
        last = hypothesis.added[-1]
        n, scaled = self.fit.x.size, last.identification.scaled
        force = rows - self._rows if scaled else np.zeros_like(rows)
        table = np.column_stack([self._slopes, force])
        prior = np.column_stack([self._prior, np.zeros(n)])
        wanted = np.concatenate([-rows, np.zeros(n)])
        change = np.linalg.lstsq(np.concatenate([table, prior]), wanted, rcond=None)[0]
        change[:n] = np.clip(change[:n], -1.0, 1.0)
        change[n] = np.clip(change[n], *_SCALES) if scaled else 0.0
        there = x.copy()
        there[:n] += change[:n]
        values = last.values(x[n:])
        for name in scaled:
            values[name] *= 1.0 + change[n]
        there[n:] = last.transformed({**last.fixed, **values})
        return rows + table @ change, there


def _starts_moved(own: Linearisation, base: Fit) -> tuple[FloatArray, FloatArray] | None:
    """Return how a fit moved displacements [m] and velocities [m/s] of masses at the starts.

    (n_windows, n_masses) arrays; None where it is one to other windows.
    """
    at = own.point(base.x, base.channels)
    if at.starts is None or base.starts is None or own.windows is not base.windows:
        return None
    n, masses = (
        len(assemble(base.hypothesis.model_at(base.x)).names),
        base.data.model.n_coordinates,
    )
    moved = base.starts - at.starts
    return moved[:, :masses], moved[:, n : n + masses]
