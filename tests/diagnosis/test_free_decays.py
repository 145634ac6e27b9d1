"""Free decays, which nothing drives, against decays that scipy integrates."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from shakerproc.comparison import compare
from shakerproc.comparison.measured import usable_tests
from shakerproc.diagnosis import TestArrays
from shakerproc.diagnosis.adding import add_to_arrays
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.errors import DiagnosisError
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper, Spring
from shakerproc.testlog import read_testlog

RATE, SECONDS = 1024.0, 1.5
MASS, STIFFNESS, DAMPING = 0.2, 1.25e4, 0.4
CUBIC = 9e8
JOINT = ("base", "tip")
PULLED = (0.8e-3, 1.6e-3, 2.4e-3)
HELD = 300
"""Samples for which the mass is held away from rest before it is let go [-]."""


def decay(pulled):
    """Return the acceleration after the mass is let go at a displacement [m/s^2]."""

    def motion(_time, state):
        z, v = state
        return [v, -(DAMPING * v + STIFFNESS * z + CUBIC * z**3) / MASS]

    times = np.arange(0.0, SECONDS, 1.0 / RATE)
    found = solve_ivp(
        motion, (0.0, SECONDS), [pulled, 0.0], t_eval=times, rtol=1e-9, atol=1e-13
    )
    acceleration = np.array([motion(0.0, state)[1] for state in found.y.T])
    noise = np.random.default_rng(round(1e6 * pulled)).standard_normal(times.size)
    return acceleration + 1e-3 * acceleration.std() * noise


@pytest.fixture(scope="module")
def decays():
    return [decay(pulled) for pulled in PULLED]


def beam(excitation="free decay"):
    elements = (Element(Spring(1.02 * STIFFNESS), JOINT), Element(Damper(0.44), JOINT))
    return Model(
        "beam", {"tip": MASS}, elements, Excitation(excitation), {"beam": Sensor("tip")}
    )


def test_the_missing_law_is_fitted_to_decays(decays):
    tests = [
        TestArrays(f"test {i}", RATE, np.zeros((1, row.size)), row[None], band=(10.0, 200.0))
        for i, row in enumerate(decays)
    ]
    found = add_to_arrays(Wanted("cubic_stiffness"), beam(), tests)
    assert found.parameters["coefficient"].value == pytest.approx(CUBIC, rel=5e-3)
    assert found.linear["stiffness base-tip"].value == pytest.approx(STIFFNESS, rel=2e-3)
    assert found.errors.held_out.after < 0.01 < found.errors.held_out.before


def slipping_decay(sample_rate, slip):
    """Return the acceleration of a mass on a spring and a slider after a release [m/s^2]."""
    spring = 0.05 * STIFFNESS  # of the slider

    def motion(_time, state):
        z, v, force = state
        rate = spring * v * (1.0 - (abs(force) / slip) * (force * v > 0.0))
        return [v, -(DAMPING * v + STIFFNESS * z + force) / MASS, rate]

    times = np.arange(0.0, SECONDS, 1.0 / sample_rate)
    found = solve_ivp(
        motion, (0.0, SECONDS), [2e-3, 0.0, slip], t_eval=times, rtol=1e-8, atol=1e-12
    )
    acceleration = np.array([motion(0.0, state)[1] for state in found.y.T])
    noise = np.random.default_rng(3).standard_normal(times.size)
    return acceleration + 1e-3 * acceleration.std() * noise


def test_a_decay_far_above_its_rms_begins_where_it_did():
    rate, slip = 256.0, 0.3
    row = slipping_decay(rate, slip)
    test = TestArrays("test", rate, np.zeros((1, row.size)), row[None], band=(10.0, 100.0))
    found = add_to_arrays(Wanted("bouc_wen"), beam(), [test])
    numbers = {name: one.value for name, one in found.parameters.items()}
    assert numbers["stiffness"] == pytest.approx(0.05 * STIFFNESS, rel=0.02)
    assert numbers["yield_displacement"] == pytest.approx(slip / (0.05 * STIFFNESS), rel=0.02)
    assert found.errors.fitted.after < 0.01
    assert found.errors.held_out.after < 0.01 < found.errors.held_out.before


@pytest.fixture
def log(tmp_path, decays):
    """Return a log of one decay that begins with the mass held, and who says what it is."""

    def of(excitation):
        row = np.concatenate([np.zeros(HELD), decays[1]])
        np.savez(tmp_path / "decay.npz", fs=RATE, beam=row)
        (tmp_path / "testlog.yaml").write_text(
            "testlog: 1\nrecordings: .\nprocessing: {crop: none}\n"
            "channels:\n  beam: {role: response, at: tip, unit: m/s^2}\n"
            f"tests:\n  - {{id: 1, recording: decay.npz, excitation: {excitation}, "
            "from: 10 Hz, to: 200 Hz}\n"
        )
        return read_testlog(tmp_path / "testlog.yaml")

    return of


def test_what_is_before_the_mass_is_let_go_takes_no_part(log, decays):
    (test,) = usable_tests(log("free decay"), beam()).tests
    first = int(np.argmax(np.abs(decays[1])))
    assert test.responses.shape == (1, decays[1].size - first - 1)
    assert_allclose(np.ptp(test.responses), np.ptp(decays[1][first + 1 :]))
    assert not test.controls.any()


def test_a_driven_test_is_no_decay(log):
    with pytest.raises(DiagnosisError, match="excitation is random, but nothing excites"):
        usable_tests(log("random"), beam())


def test_a_whole_decay_has_no_free_run_error(log):
    with pytest.raises(DiagnosisError, match="a free decay has no input"):
        compare(beam(), log("free decay"))
