"""How far the numbers of a fit may be from the truth, on tests of a known truth."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import added, data_of, one_mass

from shakerproc.diagnosis.estimation.form import Form, arrived, carried
from shakerproc.diagnosis.estimation.intervals import estimates, linear_estimates
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.spread import WIDEST, Spread
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.models import EFFECTS

CUBIC = {"coefficient": 3e11}


@pytest.fixture(scope="module")
def cubic():
    """Return a cubic spring fitted to whole tests."""
    data = data_of(one_mass(effect=EFFECTS["cubic_stiffness"](**CUBIC)))
    hypothesis, x = added(data, "cubic_stiffness", **CUBIC)
    return fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=20)


def spread_of(found, x):
    linearisation = Linearisation(found.data, found.hypothesis, found.windows)
    return Spread(linearisation, Point(x, *found.channels, found.starts))


def test_next_to_the_least_cost_of_a_smooth_motion_it_is_surely_higher_at_once(cubic):
    assert spread_of(cubic, cubic.x).reach() == 1.0
    np.testing.assert_array_equal(cubic.widened_covariance.shape, cubic.covariance.shape)


def test_away_from_the_least_cost_one_standard_error_tells_nothing(cubic):
    away = cubic.x.copy()
    away[-1] += 12.0 * np.sqrt(cubic.covariance[away.size - 1, away.size - 1])
    assert 1.0 < spread_of(cubic, away).reach() <= WIDEST


def test_sensors_that_disagree_leave_open_what_the_input_is_by_their_spread(cubic):
    """Were the input louder by a share, all motions were, and forces: k3 has the unit N/m^3."""
    tests = [replace(test, responses=0.98 * test.responses) for test in cubic.data.tests]
    data = replace(cubic.data, tests=tuple(tests))
    found = fit(data, cubic.hypothesis, cubic.x, cubic.windows, rounds=20)
    np.testing.assert_allclose(found.gain, 0.98, atol=2e-3)
    number = estimates(found, 0)["coefficient"]
    np.testing.assert_allclose(np.log(number.high / number.value), 1.96 * 2 * 0.02, rtol=0.05)
    of_spring, before = (linear_estimates(one) for one in (found, cubic))
    for name, own in of_spring.items():  # no length in its unit
        np.testing.assert_allclose(own.high, before[name].high, rtol=1e-3)


def test_a_force_that_jumps_makes_the_bound_no_narrower_than_the_slopes_say():
    forces = {"sliding_force": 0.8, "breakaway_force": 1.1, "stribeck_velocity": 5e-3}
    data = data_of(one_mass(effect=EFFECTS["stribeck_friction"](**forces)), seconds=1.5)
    hypothesis, x = added(data, "stribeck_friction", excess=0.375, **forces)
    found = fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=10)
    widened = np.sqrt(np.diag(found.widened_covariance))
    assert np.all(widened >= np.sqrt(np.diag(found.covariance)))
    apart = np.abs(found.x[-3:] - x[-3:])
    assert np.all(apart < 3.0 * widened[x.size - 3 : x.size])


def test_plain_squares_lead_to_what_only_a_few_blocks_exercise():
    """Sliders that all slip in the loud test alone tell how their stiffness is spread."""
    numbers = {"stiffness": 3e4, "slip_displacement": 2.5e-4, "chi": 1.3}
    truth = one_mass(effect=EFFECTS["power_iwan"](**numbers))
    data = data_of(truth, levels=(1.0, 3.5), seconds=6.0)
    windows = whole_tests(data, held_out=False)
    hypothesis, x = added(data, "power_iwan", spread=2.3, **numbers)
    near = x + np.array([0.1, 0.0, -0.4, -0.2, 0.0])
    form = Form(None, windows, windows, whole_tests(data, held_out=True))
    begun = fit(data, hypothesis, near, windows, rounds=0)
    alone = carried(data, begun, [form], rounds=20)
    both = arrived(data, begun, form, rounds=20)
    assert alone.follows_most
    assert both.level < alone.level
    assert np.linalg.norm(both.x - x) < 0.5 * np.linalg.norm(alone.x - x)
