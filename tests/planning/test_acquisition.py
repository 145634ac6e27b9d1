"""Sweeps against simulated sweeps, averages against their definition."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.models import Element, Excitation, Model
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.spring import Spring
from shakerproc.planning import averaging, fastest_rate, swept_peak
from shakerproc.simulation import simulate
from shakerproc.simulation.excitations import linear_sweep
from shakerproc.testlog import Welch


@pytest.mark.slow
@pytest.mark.parametrize("kappa", [0.3, 2.0, 10.0])
@pytest.mark.parametrize("downwards", [False, True])
def test_a_sweep_reaches_the_peak_of_the_simulated_one(kappa, downwards):
    natural, ratio, mass = 200.0, 0.01, 0.1
    omega = 2.0 * np.pi * natural
    model = Model(
        "one mass",
        {"coupon": mass},
        (
            Element(Spring(mass * omega**2), ("base", "coupon")),
            Element(Damper(2.0 * ratio * omega * mass), ("base", "coupon")),
        ),
        Excitation("base acceleration"),
    )
    rate = kappa * 2.0 * np.pi * (ratio * natural) ** 2
    ends = (150.0, 250.0) if not downwards else (250.0, 150.0)
    duration = 100.0 / rate
    run = simulate(
        model, linear_sweep(*ends, duration, 1.0), 4000.0, duration=duration, growth=False
    )
    reached = np.max(np.abs(run.displacement[0])) * 2.0 * ratio * omega**2
    # The envelope is the first order in the share of its frequency that it changes within.
    order = ratio * (1.0 + np.sqrt(kappa))
    assert_allclose(swept_peak(rate, natural, ratio), reached, rtol=order)


def test_a_slow_sweep_reaches_all_of_it_and_a_fast_one_little():
    assert_allclose(swept_peak(1e-3, 200.0, 0.01), 1.0, atol=1e-6)
    # Far above: |int exp(i kappa s^2 / 2)| over a Cornu spiral, at most 1.17 of its limit.
    kappa = 1e6
    rate = kappa * 2.0 * np.pi * 2.0**2
    spiral = 1.1706 * np.sqrt(np.pi * 2.0 / kappa)
    assert_allclose(swept_peak(rate, 200.0, 0.01), spiral, rtol=0.01)


def test_the_fastest_rate_is_the_one_that_reaches_the_share():
    for share in (0.9, 0.95, 0.99):
        rate = fastest_rate(367.0, 0.02, share)
        assert_allclose(swept_peak(rate, 367.0, 0.02), share, rtol=1e-5)


def test_the_fastest_rate_grows_with_the_square_of_the_width():
    assert_allclose(fastest_rate(200.0, 0.04), 16.0 * fastest_rate(100.0, 0.02), rtol=1e-4)


def test_segments_that_do_not_overlap_are_as_many_averages():
    welch = Welch(segment=1000, overlap=0, window="hamming")
    found = averaging(welch, 10.0, 2000.0, coherence=0.8)
    assert_allclose(found.averages, 20.0)
    assert_allclose(found.density_error, 20.0**-0.5)
    assert_allclose(found.gain_error, np.sqrt(0.2 / (2.0 * 0.8 * 19.0)))


def test_too_short_a_run_has_no_averages():
    assert averaging(Welch(), 0.25, 5688.9) is None
