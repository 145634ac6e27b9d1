"""The model without an effect, held to the motion, and how far its numbers move for one."""

from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError


@final
class Known:
    """The model without an effect, and how its residual follows its own numbers.

    What an effect leaves depends on numbers that stood in for it: so starts of an effect are
    compared with the model's own numbers moved, which held runs follow along straight lines.
    """

    def __init__(self, base: Fit, windows: Windows) -> None:
        self.fit, self._windows = base, windows
        own = Linearisation(base.data, base.hypothesis, windows)
        at = own.point(base.x, base.channels)
        state = own.residual(at)
        slopes = [] if state is None else own.linearise(at, state).slopes
        table = np.concatenate([s.reshape(-1, s.shape[-1]) for s in slopes])
        self._slopes = table[:, : base.x.size]
        prior = np.diag(own.spread[: base.x.size] ** -2.0)
        self._solved = np.linalg.solve(self._slopes.T @ self._slopes + prior, self._slopes.T)

    def moved(self, hypothesis: Hypothesis, x: FloatArray) -> tuple[float, FloatArray]:
        """Return the level of a start, the model's own numbers moved, and where it is then."""
        own = Linearisation(self.fit.data, hypothesis, self._windows)
        try:
            state = own.residual(own.point(x, self.fit.channels))
        except ModelError:
            return np.inf, x
        if state is None or state[1].failed.any():
            return np.inf, x
        rows = np.concatenate([r.ravel() for r in state[0]])
        change = np.clip(-self._solved @ rows, -1.0, 1.0)
        left = rows + self._slopes @ change
        there = x.copy()
        there[: change.size] += change
        blocks = np.array_split(left**2, max(1, round(left.size / own.block)))
        return float(np.mean([np.log1p(np.mean(b)) for b in blocks])), there
