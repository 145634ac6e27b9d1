"""How far the numbers of a fit may be from the truth, on tests of a known truth."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import JOINT, STIFFNESS, added, data_of, one_mass

from shakerproc.diagnosis.data import TestArrays
from shakerproc.diagnosis.estimation.form import Form, arrived, carried
from shakerproc.diagnosis.estimation.intervals import estimates, known_of, linear_estimates
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
    linearisation = Linearisation(found.data, found.hypothesis, found.windows, fine=True)
    return Spread(linearisation, Point(x, *found.channels, found.starts))


def test_next_to_the_least_cost_of_a_smooth_motion_it_is_surely_higher_at_once(cubic):
    assert spread_of(cubic, cubic.x).reach() == 1.0
    np.testing.assert_array_equal(cubic.uncertainty.total.shape, cubic.covariance.shape)


def test_away_from_the_least_cost_one_standard_error_tells_nothing(cubic):
    away = cubic.x.copy()
    away[-1] += 16.0 * np.sqrt(cubic.covariance[away.size - 1, away.size - 1])
    assert 1.0 < spread_of(cubic, away).reach() <= WIDEST


def test_calibration_moves_numbers_by_their_units_and_the_tests_by_none_of_it(cubic):
    """Were all channels louder by e, motions were: k3, in N/m^3, would be smaller by 2 e.

    A spring and a damper on a moving base have no length in what the response tells of them.
    """
    number = estimates(cubic, 0)["coefficient"]
    np.testing.assert_allclose(number.by_calibration, 1.96 * 2.0 * 0.01, rtol=0.02)
    both = np.hypot(number.by_tests, number.by_calibration)
    np.testing.assert_allclose(np.log(number.high / number.value), both)
    np.testing.assert_allclose(np.log(number.value / number.low), both)
    assert number.by_tests < 0.1 * number.by_calibration
    for own in linear_estimates(cubic).values():
        assert own.by_calibration < 0.05 * 1.96 * 0.01


@pytest.mark.parametrize(
    ("spreads", "of_input"), [((0.004, 0.02), 0.004), ((0.02, 4e-4), 0.02)]
)
def test_the_sheet_says_how_far_calibration_leaves_a_number_open(cubic, spreads, of_input):
    """Of the input: the gain of the response beside it is told by the tests."""
    tests = [
        replace(t, arrays=replace(t.arrays, gain_spread=spreads)) for t in cubic.data.tests
    ]
    found = replace(cubic, data=replace(cubic.data, tests=tuple(tests)))
    by_calibration = estimates(found, 0)["coefficient"].by_calibration
    np.testing.assert_allclose(by_calibration, 1.96 * 2.0 * of_input, rtol=0.05)


def test_two_controls_leave_their_mean_open_by_less():
    """Each of its own sensor: variances add, the mean halves."""
    of_input, of_sensors = TestArrays(
        "1", 1.0, np.zeros((2, 4)), np.zeros((1, 4)), gain_spread=(0.003, 0.004, 0.01)
    ).gain_spreads
    assert of_input == pytest.approx(0.0025)
    assert of_sensors == pytest.approx([0.01])


def test_channels_that_are_all_off_lead_away_by_no_more_than_calibration_says(cubic):
    """The oracle is the fit itself, to tests of which every channel reads 0.1 % too much."""
    tests = [
        replace(test, input=1.001 * test.input, responses=1.001 * test.responses)
        for test in cubic.data.tests
    ]
    louder = replace(cubic.data, tests=tuple(tests))
    found = fit(louder, cubic.hypothesis, cubic.x, cubic.windows, rounds=20)
    one, other = (estimates(fitted, 0)["coefficient"] for fitted in (cubic, found))
    moved = abs(np.log(other.value / one.value))
    np.testing.assert_allclose(moved, 2.0 * 1e-3, rtol=0.05)
    np.testing.assert_allclose(1.96 * 10.0 * moved, one.by_calibration, rtol=0.05)  # of 1 %


def test_of_a_joint_that_never_slips_fully_only_sums_and_ratios_are_told():
    """First loading is k z - k z^2 / (2 z_s): beside a spring, k + K and k / z_s are told."""
    numbers = {"stiffness": 4e4, "slip_displacement": 3e-3}
    data = data_of(one_mass(effect=EFFECTS["iwan"](**numbers)), levels=(3.0, 6.0), seconds=1.5)
    assert data.largest_across(JOINT) < 0.5 * numbers["slip_displacement"]
    hypothesis, x = added(data, "iwan", **numbers)
    found = fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=10)
    for number in estimates(found, 0).values():
        assert number.low is None
        assert number.high is None
    known = {(one.combination, one.numbers): one.estimate for one in known_of(found)}
    stiffness = known["sum", ("stiffness base-mass", "stiffness of the iwan")]
    slip = known["ratio", ("stiffness of the iwan", "slip displacement of the iwan")]
    assert stiffness.low < STIFFNESS + 4e4 < stiffness.high
    assert slip.low < 4e4 / 3e-3 < slip.high
    assert max(stiffness.by_tests, slip.by_tests) < 0.1
    assert len(known) == 2  # of three numbers, one direction is open


def test_a_force_that_jumps_makes_the_bound_no_narrower_than_the_slopes_say():
    forces = {"sliding_force": 0.8, "breakaway_force": 1.1, "stribeck_velocity": 5e-3}
    data = data_of(one_mass(effect=EFFECTS["stribeck_friction"](**forces)), seconds=1.5)
    hypothesis, x = added(data, "stribeck_friction", excess=0.375, **forces)
    found = fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=10)
    widened = np.sqrt(np.diag(found.uncertainty.total))
    assert np.all(widened >= np.sqrt(np.diag(found.covariance)))
    apart = np.abs(found.x[-3:] - x[-3:])
    assert np.all(apart < 3.0 * widened[x.size - 3 : x.size])


@pytest.mark.long
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
