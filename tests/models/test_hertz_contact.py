"""Hertz contact with restitution against closed forms of impacts that share no code with it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import beta

from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects import ConstantForce, HertzContact
from shakerproc.simulation import simulate


def moved(effects, mass, rate, n_samples, start):
    """A free body beside the base, which starts away from rest."""
    elements = tuple(Element(effect, ("base", "body")) for effect in effects)
    model = Model("impact", {"body": mass}, elements, Excitation("free decay"))
    still = np.zeros(n_samples)
    return simulate(model, still, rate, start={"body": start}, growth=False)


def restitution(loss, velocity):
    """Root of b - ln(1 + b) = -e b - ln(1 - e b): what m v dv = -F dd leaves, over d.

    By u = -ln(1 - e b), which has no singular end.
    """
    b = 1.5 * loss * velocity
    spent = b - np.log1p(b)
    return -np.expm1(-brentq(lambda u: u + np.expm1(-u) - spent, 0.0, spent + 1.0)) / b


@pytest.mark.parametrize("side", ["positive", "negative"])
@pytest.mark.parametrize(
    ("mass", "stiffness", "loss", "velocity"),
    [(0.03, 1e9, 0.1, 0.5), (2.0, 1e7, 0.3, 1.0), (0.4, 3e8, 2.0, 3.0)],
)
def test_an_impact_rebounds_with_the_restitution_of_the_closed_form(
    mass, stiffness, loss, velocity, side
):
    """Whatever mass and stiffness; the energy lost is half m v^2 (1 - e^2)."""
    wall = HertzContact(stiffness, 1e-3, loss, side)
    sign = 1.0 if side == "positive" else -1.0
    found = moved([wall], mass, 2e4, 1000, (0.0, sign * velocity))
    after = -sign * found.velocity[0, -1]
    wanted = restitution(loss, velocity)
    assert_allclose(after, wanted * velocity, rtol=1e-7)
    assert np.max(found.displacement * sign) > 1e-3
    small = loss * velocity
    assert abs(wanted - (1.0 - small)) < small**2  # Hunt and Crossley, eq. 13


def test_no_impact_rebounds_faster_than_surfaces_recover():
    """However hard it hits: e v stays below 1 / (1.5 alpha)."""
    found = moved([HertzContact(1e8, 1e-4, 1.0, "positive")], 0.1, 5e4, 500, (0.0, 5.0))
    assert -found.velocity[0, -1] == pytest.approx(restitution(1.0, 5.0) * 5.0, rel=1e-6)
    assert -found.velocity[0, -1] < 1.0 / 1.5


def test_a_body_bounces_between_two_walls_with_the_period_of_hertz():
    """Way there and back, and two contacts of 2 D / v B(2/5, 1/2) 2/5 (Johnson, 11.24)."""
    mass, stiffness, play, velocity = 0.05, 2e9, 2e-4, 0.7
    deepest = (5.0 * mass * velocity**2 / (4.0 * stiffness)) ** 0.4
    contact = 2.0 * deepest / velocity * 0.4 * beta(0.4, 0.5)
    period = 4.0 * play / velocity + 2.0 * contact
    wall = HertzContact(stiffness, play, 0.0, "both")
    found = moved([wall], mass, 500.0 / period, 1001, (0.0, velocity))
    for whole in (500, 1000):
        assert_allclose(found.velocity[0, whole], velocity, rtol=1e-7)
        assert_allclose(found.displacement[0, whole], 0.0, atol=1e-7 * play)
    assert_allclose(np.max(found.displacement), play + deepest, rtol=1e-4)  # between samples


def test_under_a_dead_weight_it_sinks_in_and_rings_as_hertz_says():
    """At rest k d^1.5 = F, and d moves on a spring of 1.5 k sqrt(d)."""
    mass, stiffness, weight = 0.2, 5e8, 40.0
    rest = (weight / stiffness) ** (2.0 / 3.0)
    omega = np.sqrt(1.5 * stiffness * np.sqrt(rest) / mass)
    effects = [HertzContact(stiffness, 0.0, 0.0, "positive"), ConstantForce(-weight)]
    still = moved(effects, mass, 2e4, 200, (rest, 0.0))
    assert_allclose(still.displacement[0], rest, rtol=1e-9)
    swing, n = 1e-4 * rest, 64
    found = moved(effects, mass, n * omega / (2.0 * np.pi), 4 * n + 1, (rest + swing, 0.0))
    assert_allclose(found.displacement[0, ::n], rest + swing, atol=1e-5 * swing)


def test_surfaces_that_part_faster_than_they_recover_do_not_pull():
    wall = HertzContact(1e8, 1e-5, 2.0, "both")
    z, v = np.array([3e-5, 3e-5, -3e-5, 0.0]), np.array([-0.5, 0.1, 0.5, 1.0])
    depth = 1e8 * 2e-5**1.5
    assert_allclose(wall.force_at(z, v), [0.0, depth * 1.3, 0.0, 0.0], atol=1e-12 * depth)
