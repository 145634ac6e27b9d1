"""Least squares on the free-run residual, against simulated truths."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import DAMPING, RATE, STIFFNESS, added, data_of, one_mass

from shakerproc.diagnosis.estimation.hidden_motion import completed, hidden_motions
from shakerproc.diagnosis.estimation.intervals import estimates, linear_estimates
from shakerproc.diagnosis.estimation.least_squares import fit, perfect
from shakerproc.diagnosis.estimation.levels import predicted_rows
from shakerproc.diagnosis.estimation.passed_noise import with_passed_noise
from shakerproc.diagnosis.estimation.point import Point
from shakerproc.diagnosis.estimation.residual_slopes import STEP, Linearisation
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.diagnosis.estimation.windows import whole_tests, windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.models import EFFECTS
from shakerproc.simulation import simulate

GAP = {"stiffness": 8e4, "clearance": 1.5e-4}
COULOMB = {"sliding_force": 0.4}


@pytest.fixture(scope="module")
def linear():
    return data_of(one_mass(1.1 * STIFFNESS, 0.8 * DAMPING))


def hidden(kind, values):
    return data_of(one_mass(effect=EFFECTS[kind](**values)))


@pytest.fixture(scope="module")
def with_gap():
    return hidden("gap", GAP)


@pytest.fixture(scope="module")
def with_coulomb():
    return hidden("coulomb_friction", COULOMB)


def both(data):
    """Return whole tests, and windows of five periods with a start of their own."""
    whole = whole_tests(data, held_out=False)
    return whole, windows_of(data, 220, held_out=False, most=16)


def errors_over_spread(found, truth):
    """Return errors of x in standard errors, these never below a thousandth.

    To a thousandth a response is calibrated; a dozen blocks do not tell less.
    """
    spread = np.sqrt(np.diag(found.covariance))[: found.x.size]
    return np.abs(found.x - truth) / np.maximum(spread, 1e-3)


@pytest.mark.parametrize("which", [0, 1], ids=["whole tests", "windows"])
def test_linear_numbers_are_found(linear, which):
    hypothesis = hypothesis_of(one_mass())
    found = fit(linear, hypothesis, np.zeros(2), both(linear)[which], rounds=10)
    assert found.converged
    assert np.exp(found.x) == pytest.approx([1.1, 0.8], rel=0.02)
    assert np.all(errors_over_spread(found, np.log([1.1, 0.8])) < 3.0)
    assert linear_estimates(found)["stiffness base-mass"].value == pytest.approx(
        1.1e5, rel=5e-3
    )


@pytest.mark.parametrize(
    ("which", "away"), [(0, 0.05), (1, 1.0)], ids=["whole tests, from nearby", "windows"]
)
@pytest.mark.parametrize(
    ("campaign", "kind", "values"),
    [("with_gap", "gap", GAP), ("with_coulomb", "coulomb_friction", COULOMB)],
)
def test_an_effect_is_found_with_its_numbers(campaign, kind, values, which, away, request):
    data = request.getfixturevalue(campaign)
    hypothesis, truth = added(data, kind, **values)
    start = truth + away * np.array([0.05, -0.1, *([0.08] * (truth.size - 2))])
    found = fit(data, hypothesis, start, both(data)[which], rounds=12)
    assert np.all(errors_over_spread(found, truth) < 3.0)
    for name, estimate in estimates(found, 0).items():
        assert estimate.value == pytest.approx(values[name], rel=0.05)
        assert estimate.low < estimate.value < estimate.high


@pytest.mark.parametrize("force", [2.0, 5.0])
def test_jumps_of_friction_that_a_recorder_took_as_values_tell_the_numbers(force):
    means = hidden("coulomb_friction", {"sliding_force": force})
    left = []
    for data in (means, replace(means, points=True)):
        hypothesis, truth = added(data, "coulomb_friction", sliding_force=force)
        start = truth + np.array([0.03, -0.2, 0.05])
        found = fit(data, hypothesis, start, whole_tests(data, held_out=False), rounds=12)
        left.append(np.abs(found.x - truth))
    assert np.all(left[1] < [5e-4, 1e-2, 1e-3])
    # both tell the stiffness; what jumps tell is damping and force
    assert np.all(left[1][1:] < 0.5 * left[0][1:])


def test_a_window_that_runs_away_does_not_rule_the_fit(linear):
    windows = both(linear)[1]
    starts = completed(linear, linear.model, windows.table, perfect(linear)[2])
    starts[3] = np.inf
    found = fit(
        linear, hypothesis_of(one_mass()), np.zeros(2), windows, rounds=10, starts=starts
    )
    assert found.failed == 1
    assert np.exp(found.x) == pytest.approx([1.1, 0.8], rel=0.02)
    assert np.all(errors_over_spread(found, np.log([1.1, 0.8])) < 3.0)
    assert np.all(np.isfinite(found.covariance))


def test_where_all_windows_run_away_there_is_no_fit(linear):
    windows = both(linear)[1]
    starts = np.full((len(windows), 2), np.inf)
    nothing = fit(
        linear, hypothesis_of(one_mass()), np.zeros(2), windows, rounds=2, starts=starts
    )
    assert nothing is None


def test_slopes_are_those_of_the_residual(with_gap):
    hypothesis, x = added(with_gap, "gap", **GAP)
    windows = both(with_gap)[1]
    search = Linearisation(with_gap, hypothesis, windows)
    starts = completed(with_gap, with_gap.model, windows.table, perfect(with_gap)[2])
    here = Point(x, np.array([1.02]), np.zeros(1), np.zeros((0, 0)), starts)
    state = search.residual(here)
    residual, slopes = state[0], search.linearise(here, state)
    for k, change in enumerate(STEP * np.eye(x.size)):
        there = search.residual(replace(here, x=x + change))[0]
        assert slopes.slopes[0][..., k] == pytest.approx(
            (there[0] - residual[0]) / STEP, rel=1e-7, abs=1e-9
        )
    louder = search.residual(replace(here, gain=here.gain + 0.1))[0]
    later = search.residual(replace(here, delay=here.delay + 1e-5))[0]
    by_channel = [(louder[0] - residual[0]) / 0.1, (later[0] - residual[0]) / 1e-5]
    found = np.moveaxis(slopes.slopes[0][..., -2:], -1, 0)
    assert found == pytest.approx(np.array(by_channel), rel=1e-6, abs=1e-9)
    for k, scale in enumerate(with_gap.motion_sizes):
        moved = starts.copy()
        moved[:, k] += 1e-3 * scale
        there = search.residual(replace(here, starts=moved))[0]
        change = (there[0] - residual[0]) / 1e-3
        assert np.linalg.norm(slopes.own[0][..., k] - change) < 0.02 * np.linalg.norm(change)


def test_chords_of_a_smooth_law_are_its_slopes(linear):
    hypothesis, x = added(linear, "cubic_stiffness", coefficient=1e12)
    search = Linearisation(linear, hypothesis, both(linear)[1])
    here = search.point(x, (np.ones(1), np.zeros(1), np.zeros(0)))
    state = search.residual(here)
    slopes = search.linearise(here, state).slopes[0][..., : x.size]
    chords = search.linearise(here, state, steps=np.full(x.size, 1e-3)).slopes[0][..., : x.size]
    assert not np.array_equal(slopes, chords)
    assert np.linalg.norm(chords - slopes) < 0.01 * np.linalg.norm(slopes)


def test_values_keep_what_does_not_depend_on_how_accelerations_are_compared(with_gap):
    inputs, noise, means = with_gap.inputs, with_gap.noise, with_gap.measured
    values = with_gap.as_values()
    assert values.points
    assert values.inputs is inputs
    assert values.noise is noise
    assert values.measured is not means
    assert np.array_equal(values.measured[0], with_gap.tests[0].responses)


def test_starts_are_fitted_where_the_numbers_stand(linear):
    true_numbers = fit(
        linear, hypothesis_of(one_mass()), np.log([1.1, 0.8]), both(linear)[0], rounds=0
    )
    windows = windows_of(linear, 400, held_out=True, most=6, run_in=100)
    as_measured = replace(
        true_numbers, starts=completed(linear, linear.model, windows.table, perfect(linear)[2])
    )
    fitted = with_starts_fitted(linear, true_numbers, windows)
    assert np.array_equal(fitted.x, true_numbers.x)
    after = predicted_rows(linear, fitted, windows)
    assert after.mean() < predicted_rows(linear, as_measured, windows).mean()
    assert np.median(after) < 3.0  # the noise of the control is amplified by the resonance


def test_where_a_stiff_law_hides_the_start_of_a_window_it_is_found():
    values = {"force": 8.0, "reference_displacement": 1e-4, "exponent": 3.5}
    data = data_of(one_mass(effect=EFFECTS["power_law"](**values)), levels=(4.0, 8.0))
    windows = windows_of(data, 500, held_out=True, most=40, run_in=200)
    right = fit(data, *added(data, "power_law", **values), windows, rounds=0)
    left = predicted_rows(data, with_starts_fitted(data, right, windows), windows.run_in)
    assert left.max() < 2.0  # one was thousands, from what was measured alone


def test_the_motion_of_a_mode_that_no_sensor_tells_is_driven_by_that_of_its_place():
    truth = one_mass(effect=EFFECTS["attached_mode"](0.08, 61.0, 0.01))
    data = data_of(truth, levels=(4.0,))
    exact = simulate(truth, data.tests[0].input, RATE, growth=False).displacement[1]
    moved = hidden_motions(data, truth)[0][0]
    assert np.std(moved - exact) < 0.1 * np.std(exact)  # its place hardly moves where it does


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        ("bouc_wen", {"stiffness": 6e4, "yield_displacement": 1e-4, "exponent": 2.0}),
        ("jenkins", {"stiffness": 6e4, "slip_force": 6.0}),
        ("iwan", {"stiffness": 6e4, "slip_displacement": 4e-4}),
        ("attached_mode", {"mass": 0.08, "frequency": 61.0, "damping_ratio": 0.01}),
    ],
)
def test_what_no_sensor_tells_of_a_start_is_fitted_too(kind, values):
    """At the true numbers a window is predicted to the noise, whatever went before it."""
    truth = EFFECTS[kind](**values)
    data = replace(data_of(one_mass(effect=truth), levels=(6.0,)), model=one_mass(effect=truth))
    own = hypothesis_of(data.model)
    right = fit(data, own, np.zeros(own.size), both(data)[0], rounds=0)
    windows = windows_of(data, 500, held_out=False, most=12, run_in=120)
    rows = predicted_rows(data, with_starts_fitted(data, right, windows), windows)
    assert np.median(rows) < 3.0  # a few have too little in their run-in that tells a loop


def test_from_rest_no_starts_are_fitted(linear):
    whole = both(linear)[0]
    found = fit(linear, hypothesis_of(one_mass()), np.zeros(2), whole, rounds=0)
    assert with_starts_fitted(linear, found, whole).starts is None


def test_numbers_at_a_bound_have_no_interval_on_that_side(linear):
    hypothesis, x = added(linear, "gap", stiffness=1e4, clearance=1e3)  # never touched
    found = fit(linear, hypothesis, x, both(linear)[0], rounds=3)
    assert estimates(found, 0)["clearance"].high is None


def test_windows_are_taken_from_small_and_from_large_responses(linear):
    every = windows_of(linear, 220, held_out=False, most=1000)
    some = windows_of(linear, 220, held_out=False, most=10)
    sizes = {
        tuple(row): np.std(linear.tests[row[0]].responses[0, row[1] : row[1] + row[2]])
        for row in every.table
    }
    for test in (0, 1):
        mine = sorted(size for row, size in sizes.items() if row[0] == test)
        taken = [sizes[tuple(row)] for row in some.table if row[0] == test]
        assert max(taken) > np.percentile(mine, 85)
        assert min(taken) < np.percentile(mine, 60)


def test_where_noise_parts_two_motions_it_counts_as_noise(with_gap, linear):
    """A linear motion forgets noise; one that rattles near its clearance keeps it."""
    hypothesis, x = added(with_gap, "gap", **GAP)
    shares = []
    for data, model, numbers in (
        (with_gap, hypothesis, x),
        (linear, hypothesis_of(one_mass()), np.log([1.1, 0.8])),
    ):
        whole = whole_tests(data, held_out=False)
        found = fit(data, model, numbers, whole, rounds=0)
        passed = with_passed_noise(data, found, whole).passed
        shares.append(np.mean(passed[1]) / np.std(data.tests[1].responses))
    assert shares[0] > 2.0 * shares[1] > 0.0
