"""FRAC of measured and predicted response functions: closed forms, and sdypy-EMA's MAC."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.comparison.small_campaigns import (
    JOINT,
    MASS,
    ONE_MASS,
    campaign,
    drive,
    off,
    written,
)

from shakerproc import comparison
from shakerproc.comparison.errors import frac
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

DAMPED = off(ONE_MASS, damping=5.0)
"""120 Hz with a half-power width of 24 Hz, of many bins."""


def resonance(lines, frequency, half_width):
    """A single pole on lines [Hz], by its frequency and half the half-power width [Hz]."""
    return 1.0 / (half_width + 1j * (lines - frequency))


def test_functions_that_differ_by_a_factor_have_a_frac_of_one():
    measured = resonance(np.linspace(50.0, 150.0, 400), 100.0, 2.0)
    assert frac(measured, (0.3 - 2.0j) * measured) == pytest.approx(1.0, abs=1e-12)
    assert frac(measured, np.zeros(400, complex)) == 0.0


@pytest.mark.parametrize("shift", [0.0, 1.0, 2.0, 6.0])
def test_a_shifted_resonance_has_the_frac_of_its_closed_form(shift):
    """By residues over all lines: FRAC = 1 / (1 + (shift / half-power width)^2)."""
    lines = np.arange(-3e4, 3e4, 0.05)
    width = 2.0
    found = frac(resonance(lines, 0.0, width / 2.0), resonance(lines, shift, width / 2.0))
    assert found == pytest.approx(1.0 / (1.0 + (shift / width) ** 2), rel=1e-3)


@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_frac_is_the_mac_of_another_program_along_frequency():
    tools = pytest.importorskip("sdypy.EMA.tools", reason="needs sdypy-EMA")
    rng = np.random.default_rng(1)
    first, second = rng.standard_normal((2, 50)) + 1j * rng.standard_normal((2, 50))
    assert frac(first, second) == pytest.approx(float(tools.MAC(first, second).real), rel=1e-9)


def test_compare_tells_a_wrong_gain_from_a_wrong_stiffness_by_frac(tmp_path):
    """A response at 1.2 times its size is a sixth off; its form is that of the model."""
    made = campaign(DAMPED, drives=(drive(),), seconds=4.0, noise=1e-4)
    for test in made.tests:
        test.response[:] *= 1.2
    log, model = written(made, tmp_path)
    louder = comparison.compare(read_model(model), read_testlog(log)).tests[0].errors[0]
    assert_allclose(louder.error, 1.0 / 6.0, rtol=0.01)
    assert louder.frac > 0.9999
    log, model = written(made, tmp_path / "soft", off(DAMPED, stiffness=1.1))
    found = comparison.compare(read_model(model), read_testlog(log))
    stiffer = found.tests[0].errors[0]
    lit = found.tests[0].pair.excited
    omega = 2.0 * np.pi * found.tests[0].pair.frequency[lit]
    viscous = 1j * omega * DAMPED.joints[0].damping
    true, said = (
        (k + viscous) / (k - MASS * omega**2 + viscous)
        for k in (JOINT.stiffness, 1.1 * JOINT.stiffness)
    )
    shared = np.abs(np.vdot(true, said)) / (np.linalg.norm(true) * np.linalg.norm(said))
    assert stiffer.frac == pytest.approx(shared**2, abs=0.03)
    assert stiffer.frac < 0.97 < louder.frac
    document = comparison.document_of(found)["tests"][0]["sensors"][0]
    assert document["frac"] == stiffer.frac
    assert "frac" in comparison.COLUMNS
