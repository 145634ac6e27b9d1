"""Forecasts of sweeps of a spring that hardens, against the method of harmonic balance."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from shakerproc.diagnosis.fitted_numbers import FittedNumbers
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.forecasts.ensemble import Drives, Planned, ensemble
from shakerproc.forecasts.forecast import swept_back
from shakerproc.forecasts.quantities import densities, spread_of
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

RATE = 1000.0
FREQUENCY, RATIO, LEVEL = 20.0, 0.02, 1.0  # [Hz], [-], [m/s^2]
OMEGA = 2.0 * np.pi * FREQUENCY
CUBIC = 2.4e9  # coefficient over mass [1/(m^2 s^2)]
MODEL = f"""\
model: 1
title: a spring that hardens
masses: {{coupon: 1 kg}}
elements:
  - {{kind: spring, between: [base, coupon], stiffness: {OMEGA**2} N/m}}
  - {{kind: damper, between: [base, coupon], damping: {2.0 * RATIO * OMEGA} N s/m}}
  - {{kind: cubic_stiffness, between: [base, coupon], coefficient: {CUBIC} N/m^3}}
excitation: {{base: acceleration}}
sensors: {{ch3: {{at: coupon, measures: acceleration}}}}
"""
LOG = """\
testlog: 1
tests:
  - {{id: 1, planned: true, excitation: sine sweep, level: 1 m/s^2, from: {0} Hz, to: {1} Hz,
     rate: 1 oct/min}}
"""


def largest_on_the_branch():
    """Return the largest displacement: inertia and springs in balance, damping at the drive."""

    def left(size):
        omega = np.sqrt(OMEGA**2 + 0.75 * CUBIC * size**2)
        return 2.0 * RATIO * OMEGA * omega * size - LEVEL

    return brentq(left, 1e-6, 0.1)


def forecast(folder, first, last):
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    (folder / "log.yaml").write_text(LOG.format(first, last), encoding="utf-8")
    model = read_model(folder / "model.yaml")
    (test,) = read_testlog(folder / "log.yaml").planned
    hypothesis = hypothesis_of(model)
    n = hypothesis.size
    numbers = FittedNumbers(hypothesis, np.zeros(n), np.ones(1), np.zeros((n + 1, n + 1)), ())
    seconds = 60.0 * abs(np.log2(last / first))
    planned = Planned(test, seconds, RATE, test.band, (1.0, 400.0), (0.0, np.zeros(1)))
    made = ensemble(numbers, Drives(planned, 0), 2)
    spreads = {q: spread_of(one, 0.1, 5.0) for q, one in made.values.items()}
    return made, swept_back(numbers, planned, spreads, 0)


def test_a_sweep_reaches_what_harmonic_balance_says_on_the_branch_that_it_follows(tmp_path):
    made, back = forecast(tmp_path, 15.0, 40.0)
    (moved,) = (q for q in made.values if q.what == "displacement")
    assert_allclose(made.values[moved], largest_on_the_branch(), rtol=0.02)
    (other,) = back.items()
    assert other[0].what == "peak"
    (up,) = (one for q, one in made.values.items() if q == other[0])
    assert other[1] < 0.9 * up[0]


def test_downwards_the_other_branch_is_told(tmp_path):
    made, back = forecast(tmp_path, 40.0, 15.0)
    ((quantity, there),) = back.items()
    assert there > 1.1 * made.values[quantity][0]


@pytest.mark.parametrize("half_width", [4.0, 12.0])
def test_the_peak_of_a_sweep_does_not_hang_on_where_its_record_begins(half_width):
    """A chirp under a resonance curve: its density is that curve over the time at each f."""
    rate, seconds, low, high, at = 5000.0, 20.0, 20.0, 1000.0, 321.0
    time = np.arange(int(rate * seconds)) / rate
    growth = np.log(high / low) / seconds
    f = low * np.exp(growth * time)
    row = np.sin(2.0 * np.pi * (f - low) / growth) / np.hypot(f - at, half_width)
    found = [
        densities(row[None, start:], rate, (low, high))[0].peak_frequency
        for start in range(0, 2048, 256)
    ]
    assert_allclose(found, at, rtol=5e-3)
    assert np.ptp(found) < 2e-3 * at
