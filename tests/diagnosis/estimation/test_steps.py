"""Steps of least squares on one arc tangent, whose full step is known in closed form."""

from types import SimpleNamespace

import pytest
from numpy import arctan

from shakerproc.diagnosis.estimation.steps import SETTLED, better

SCALE = 10.0


def cost_of(x):
    """Return the square of a residual that bends."""
    return SCALE * arctan(x) ** 2


class OneArc:
    """Equations of that residual at a place: a full step leads to x - (1 + x^2) atan x."""

    def __init__(self, x):
        self.x = x
        self.at = SimpleNamespace(starts=None)
        self.linearisation = SimpleNamespace(residual=lambda x: (None, None, cost_of(x)))

    def taken(self, damping):
        """Return where a damped step leads, and the fall that the slope foretells."""
        there = self.x - (1.0 + self.x**2) * arctan(self.x) / (1.0 + damping)
        return there, cost_of(self.x) / (1.0 + damping)


def test_a_step_that_slopes_foretell_is_taken_at_once():
    there, (*_, cost), damping = better(OneArc(0.5), cost_of(0.5), 1e-3)
    assert there == pytest.approx(0.5 - 1.25 * arctan(0.5) / 1.001, rel=1e-9)
    assert cost < 0.05 * cost_of(0.5)
    assert damping == pytest.approx(1e-4)


def test_a_step_that_overshoots_is_damped_though_it_gains_a_little():
    x = 1.3915  # a full step leads from 1.39175 as far to the other side
    full, foretold = OneArc(x).taken(0.0)
    assert 0.0 < cost_of(x) - cost_of(full) < SETTLED < foretold
    _, (*_, cost), damping = better(OneArc(x), cost_of(x), 1e-4)
    assert cost_of(x) - cost >= SETTLED
    assert damping > 1e-4


def test_a_small_gain_is_taken_where_no_damped_step_gains_more():
    """A valley whose wall rises again: one place alone is lower, by less than what matters."""
    arc = OneArc(1.3915)
    low, _ = arc.taken(1e-3)
    arc.linearisation.residual = lambda x: (None, None, 9.99 if x == low else 10.0)
    there, (*_, cost), _ = better(arc, 10.0, 1e-3)
    assert (there, cost) == (low, 9.99)


def test_no_step_is_taken_where_none_gains():
    assert better(OneArc(3.0), 0.0, 1e-3) is None
