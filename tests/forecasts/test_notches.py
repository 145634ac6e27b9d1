"""Notches against the same problem solved by scipy, by brute force and in closed form."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import minimize

from shakerproc.forecasts.notches import (
    C_SQUARED,
    Bound,
    corners_of,
    force_limited,
    notched_test,
    profile_csv,
    profile_yaml,
    reduction_of,
    with_edges,
)
from shakerproc.testlog import read_testlog

OCTAVES = np.linspace(5.0, 8.0, 25)
STEEP = 1e4  # no edge at all [dB/oct]


def resonance(centre, ratio=0.1):
    """Return the mean square of the gain of an oscillator, centre in octaves."""
    x = 2.0 ** (OCTAVES - centre)
    return 1.0 / ((1.0 - x**2) ** 2 + (2.0 * ratio * x) ** 2)


def least_by_scipy(bounds):
    """Return the least sum of decibels that keeps the bounds, by sequential programming."""

    def left(reduction, bound):
        return 1.0 - np.sum(bound.power * 10.0 ** (-reduction / 10.0)) / bound.allowed

    found = minimize(
        np.sum,
        np.full(OCTAVES.size, 3.0),
        jac=np.ones_like,
        bounds=[(0.0, 60.0)] * OCTAVES.size,
        constraints=[{"type": "ineq", "fun": left, "args": (bound,)} for bound in bounds],
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-10},
    )
    assert found.success, found.message
    return found.fun


@pytest.mark.parametrize("shares", [(0.3,), (0.1,), (0.4, 0.3), (0.5, 0.05)])
def test_no_smaller_reduction_keeps_limits_of_mean_squares(shares):
    powers = [resonance(6.0), 4.0 * resonance(6.7, 0.05)]
    bounds = [Bound(p, s * p.sum()) for p, s in zip(powers, shares, strict=False)]
    found = reduction_of(OCTAVES, bounds, np.zeros_like(OCTAVES), STEEP)
    for bound in bounds:
        assert np.sum(bound.power * 10.0 ** (-found / 10.0)) <= bound.allowed * (1.0 + 1e-6)
    assert_allclose(found.sum(), least_by_scipy(bounds), rtol=2e-3)


def test_a_limit_that_is_kept_takes_nothing_away():
    bound = Bound(resonance(6.0), 1.01 * resonance(6.0).sum())
    assert not np.any(reduction_of(OCTAVES, [bound], np.zeros_like(OCTAVES), STEEP))


def test_edges_are_the_least_that_is_nowhere_steeper():
    reduction = 20.0 * np.random.default_rng(1).random(OCTAVES.size)
    found = with_edges(OCTAVES, reduction, 24.0)
    brute = [
        max(r - 24.0 * abs(here - there) for there, r in zip(OCTAVES, reduction, strict=True))
        for here in OCTAVES
    ]
    assert_allclose(found, brute, atol=1e-9)


def test_breakpoints_are_few_and_miss_no_more_than_a_tenth_of_a_decibel():
    reduction = with_edges(OCTAVES, np.where(np.abs(OCTAVES - 6.4) < 0.05, 17.0, 0.0), 24.0)
    kept = corners_of(OCTAVES, reduction)
    assert len(kept) <= 7
    assert_allclose(np.interp(OCTAVES, OCTAVES[kept], reduction[kept]), reduction, atol=0.1)


def test_a_semi_empirical_force_limit_is_that_of_the_handbook():
    """Apparent mass of an oscillator on its base: M0 at rest, M0 Q at resonance."""
    ratio, mass = 0.02, 0.7
    frequency = np.geomspace(20.0, 800.0, 2001)
    x = frequency / 150.0
    apparent = mass**2 * (1.0 + (2.0 * ratio * x) ** 2) / (
        (1.0 - x**2) ** 2 + (2.0 * ratio * x) ** 2
    )  # fmt: skip
    found = force_limited(frequency, apparent, mass, STEEP)
    at_resonance = 10.0 * np.log10((1.0 + 4.0 * ratio**2) / (4.0 * ratio**2) / C_SQUARED)
    assert_allclose(found.max(), at_resonance, atol=0.02)
    assert_allclose(frequency[np.argmax(found)], 150.0, rtol=2e-3)
    # below resonance the force of amplification 2 is let in: x = 1/sqrt(2)
    start = frequency[np.flatnonzero(found > 0.0)[0]]
    assert_allclose(start, 150.0 / np.sqrt(2.0), rtol=5e-3)


LOG = """\
testlog: 1
{profiles}
tests:
  - {{id: 1, planned: true, excitation: {excitation}}}
"""


@pytest.mark.parametrize(
    ("excitation", "unit"),
    [
        ("random, level: 0.08 g^2/Hz, from: 20 Hz, to: 800 Hz, duration: 60 s", "g^2/Hz"),
        ("sine sweep, level: 2 g, from: 20 Hz, to: 800 Hz, rate: 2 oct/min", "g"),
        ("random, level: 3 N^2/Hz, from: 20 Hz, to: 800 Hz, duration: 60 s", "N^2/Hz"),
    ],
)
def test_a_notched_profile_is_read_as_it_was_written(tmp_path, excitation, unit):
    path = tmp_path / "log.yaml"
    path.write_text(LOG.format(profiles="", excitation=excitation), encoding="utf-8")
    (test,) = read_testlog(path).planned
    frequency = np.geomspace(20.0, 800.0, 256)
    reduction = np.maximum(0.0, 12.0 - 24.0 * np.abs(np.log2(frequency / 150.0)))
    profile = notched_test(test, frequency, reduction).profile
    power = 10.0 if unit.endswith("/Hz") else 20.0
    middle = np.interp(np.log(150.0), np.log(profile.frequency_hz), np.log(profile.level))
    depth = power / np.log(10.0) * (np.log(profile.level[0]) - middle)
    assert_allclose(depth, 12.0, atol=0.25)
    kind = excitation.split(",")[0]
    tail = ", duration: 60 s" if kind == "random" else ", rate: 2 oct/min"
    own = f'{kind}, profile: "{profile.name}"{tail}'
    (tmp_path / "notched.csv").write_text(profile_csv(profile), encoding="utf-8")
    by_file = f'profiles: {{"{profile.name}": {{file: notched.csv}}}}'
    for profiles in (profile_yaml(profile, "a comment"), by_file):
        path.write_text(LOG.format(profiles=profiles, excitation=own), encoding="utf-8")
        (again,) = read_testlog(path).planned
        assert again.profile.unit == profile.unit
        assert_allclose(again.profile.frequency_hz, profile.frequency_hz, rtol=1e-9)
        assert_allclose(again.profile.level, profile.level, rtol=1e-6)
