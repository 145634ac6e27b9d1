"""A drive that no spring holds, and the constant of its force."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from shakerproc.comparison import compare
from shakerproc.comparison.measured import usable_tests
from shakerproc.comparison.own import own_of
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

RATE, SECONDS, MASS, DAMPING = 2000.0, 0.5, 5.0, 15.0
OFFSET = 4.0
"""Constant that the amplifier adds to the force [N]."""

MODEL = """model: 1
title: a rack
masses: {{rack: 5 kg}}
elements:
  - {{kind: damper, between: [{between}], damping: 15 N s/m}}
{more}excitation: {{force on: rack}}
sensors:
  position: {{at: rack, measures: displacement}}
"""
LOG = """testlog: 1
title: a rack
recordings: .
processing: {crop: none}
channels:
  force: {role: force, at: rack, unit: N}
  position: {role: displacement, at: rack, unit: m}
tests:
  - {id: 1, recording: a.npz, excitation: random, from: 2 Hz, to: 100 Hz}
"""


@pytest.fixture
def folder(tmp_path):
    t = np.arange(0.0, SECONDS, 1.0 / RATE)
    force = 60.0 * np.sin(2.0 * np.pi * (3.0 * t + 12.0 * t**2)) * np.hanning(t.size) ** 0.3

    def pushed(time, y):
        return [y[1], (np.interp(time, t, force) - DAMPING * y[1]) / MASS]

    moved = solve_ivp(pushed, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, max_step=1e-3).y
    np.savez(
        tmp_path / "a.npz", fs=np.array([RATE]), force=force + OFFSET, position=moved[0] + 0.3
    )
    (tmp_path / "testlog.yaml").write_text(LOG)
    return tmp_path, float(force.mean())


def model_of(folder, between="base, rack", more=""):
    path = folder / "model.yaml"
    path.write_text(MODEL.format(between=between, more=more))
    return read_model(path)


def read(folder, model):
    (test,) = usable_tests(read_testlog(folder / "testlog.yaml"), model).tests
    return test


@pytest.mark.parametrize("between", ["base, rack", "rack, base"])
def test_the_mean_of_the_force_is_told_by_the_motion(folder, between):
    place, mean = folder
    model = model_of(place, between)
    own, _ = own_of(model, read(place, model))
    assert own.constant == pytest.approx(mean, abs=0.02)


def test_the_true_model_of_a_free_drive_leaves_next_to_nothing(folder):
    model = model_of(folder[0])
    found = compare(model, read_testlog(folder[0] / "testlog.yaml"))
    (test,) = found.tests
    assert float(test.errors[0].error) < 0.005


@pytest.mark.parametrize("cut", [0, 700])
def test_a_recording_that_is_cut_in_motion_begins_where_the_mass_was(tmp_path, cut):
    """A pendulum on a spring, driven by a sine from rest: scipy is the oracle."""
    stiffness, t = 3000.0, np.arange(0.0, 2.0, 1.0 / RATE)
    force = 60.0 * np.sin(2.0 * np.pi * 5.0 * t)

    def pushed(time, y):
        drive = 60.0 * np.sin(2.0 * np.pi * 5.0 * time)
        return [y[1], (drive - DAMPING * y[1] - stiffness * y[0]) / MASS]

    moved = solve_ivp(pushed, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9).y
    np.savez(
        tmp_path / "a.npz", fs=np.array([RATE]), force=force[cut:], position=moved[0, cut:]
    )
    (tmp_path / "testlog.yaml").write_text(LOG)
    model = model_of(
        tmp_path, more="  - {kind: spring, between: [base, rack], stiffness: 3000 N/m}\n"
    )
    (test,) = compare(model, read_testlog(tmp_path / "testlog.yaml")).tests
    offset = moved[0, cut:].mean()
    assert test.prediction.own.start == pytest.approx(
        [moved[0, cut] - offset, moved[1, cut]], abs=0.02 * np.abs(moved[1]).max()
    )
    assert test.error < 0.01
