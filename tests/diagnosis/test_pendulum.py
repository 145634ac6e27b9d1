"""A pendulum before a camera, integrated by scipy: softer at large swings."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from shakerproc.diagnosis.api import diagnose
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

LENGTH, MASS, NOISE = 0.35, 0.2, 5e-4
SOFTER = -MASS * 9.81 / (6.0 * LENGTH**3)
"""Coefficient of the cube in the force of small swings, sin(a) = a - a^3 / 6 + ... [N/m^3]."""

MODEL = """model: 1
title: small swings
masses: {bob: 0.2 kg}
elements:
  - {kind: spring, between: [base, bob], stiffness: 5.44 N/m}
  - {kind: damper, between: [base, bob], damping: 0.01 N s/m}
excitation: {free: decay}
sensors:
  x: {at: bob, measures: displacement}
"""
LOG = """testlog: 1
title: a pendulum
recordings: .
channels:
  x: {role: displacement, at: bob, unit: m}
processing: {crop: none}
tests:
  - {id: 1, recording: d.npz, excitation: free decay}
"""


@pytest.mark.slow
def test_its_softening_is_named_and_what_a_cube_leaves_far_ahead_is_said(tmp_path):
    t = np.arange(1200) / 30.0

    def falls(_t, y):
        return [y[1], -9.81 / LENGTH * np.sin(y[0]) - 0.06 * y[1]]

    swung = solve_ivp(falls, (0.0, 40.0), [1.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-11).y[0]
    seen = LENGTH * swung + NOISE * np.random.default_rng(1).standard_normal(t.size)
    np.savez(tmp_path / "d.npz", fs=np.array([30.0]), x=seen)
    (tmp_path / "model.yaml").write_text(MODEL)
    (tmp_path / "testlog.yaml").write_text(LOG)
    found = diagnose(
        read_model(tmp_path / "model.yaml"), read_testlog(tmp_path / "testlog.yaml")
    )
    assert [one.kind for one in found.effects] == ["cubic_stiffness"]
    assert found.effects[0].parameters["coefficient"].value == pytest.approx(SOFTER, rel=0.08)
    assert found.errors.held_out.after < 0.1 * found.errors.held_out.before
    # the fifth power that a cube lacks is felt further ahead
    assert not found.complete
    assert found.confidence is None
    assert "ahead more is missing" in found.sentence
