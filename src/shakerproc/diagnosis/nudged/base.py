"""The hypothesis that an effect is added to, held to the motion, and how its numbers move."""

from collections.abc import Sequence
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError

_SCALES: Final = (-0.9, 9.0)
"""Changes of the force of an effect that its start may be given, over that force [-]."""

Moved: TypeAlias = tuple[float, Hypothesis, FloatArray]
"""Level of a start with the base's numbers moved, its hypothesis, and where it is then."""


@final
class Base:
    """A fit without the effect, and the slopes of its residual by its own numbers.

    What an effect leaves depends on numbers that stood in for it: so starts of an effect are
    compared with the fit's own numbers moved, which held runs follow along straight lines.
    """

    def __init__(self, base: Fit, windows: Windows) -> None:
        self.fit, self._windows = base, windows
        own = Linearisation(base.data, base.hypothesis, windows)
        at = own.point(base.x, base.channels)
        state = own.residual(at)
        slopes = [] if state is None else own.linearise(at, state).slopes
        columns = [s.reshape(-1, s.shape[-1])[:, : base.x.size] for s in slopes]
        self._slopes = np.concatenate([*columns, np.zeros((0, base.x.size))])
        self._rows = np.zeros(0) if state is None else _flat(state[0])
        self._prior = np.diag(1.0 / own.spread[: base.x.size])

    def best(self, starts: Sequence[tuple[Hypothesis, FloatArray]]) -> list[Moved]:
        """Return starts by what they leave, without those that run away."""
        moved = [self._moved(*start) for start in starts]
        good = [
            (level, hypothesis, x)
            for (hypothesis, _), (level, x) in zip(starts, moved, strict=True)
            if np.isfinite(level)
        ]
        return sorted(good, key=lambda one: one[0])

    def _moved(self, hypothesis: Hypothesis, x: FloatArray) -> tuple[float, FloatArray]:
        """Return the level of a start, the base's numbers moved, and where it is then."""
        own = Linearisation(self.fit.data, hypothesis, self._windows)
        try:
            state = own.residual(own.point(x, self.fit.channels))
        except ModelError:
            return np.inf, x
        if state is None or state[1].failed.any():
            return np.inf, x
        rows, there = _flat(state[0]), x.copy()
        own_numbers = np.array_equal(x[: self.fit.x.size], self.fit.x)
        if own_numbers and hypothesis.own == self.fit.hypothesis.own:
            rows, there = self._projected(hypothesis, x, rows)
        blocks = np.array_split(rows**2, max(1, round(rows.size / own.block)))
        return float(np.mean([np.log1p(np.mean(b)) for b in blocks])), there

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


def _flat(stacks: Sequence[FloatArray]) -> FloatArray:
    return np.concatenate([rows.ravel() for rows in stacks])
