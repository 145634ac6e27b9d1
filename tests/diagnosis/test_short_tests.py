"""A carriage that a motor drives for half a second, three periods, integrated by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from shakerproc.diagnosis import diagnose
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

RATE, SECONDS, MASS, FORCE = 1000.0, 0.5, 3.0, 40.0
MODEL = """model: 1
title: carriage
masses: {carriage: 3 kg}
elements:
  - {kind: damper, between: [base, carriage], damping: 40 N s/m}
excitation: {force on: carriage}
sensors:
  position: {at: carriage, measures: displacement}
"""
LOG = """testlog: 1
title: half a second
recordings: .
channels:
  force: {role: force, at: carriage, unit: N}
  position: {role: displacement, at: carriage, unit: m}
processing: {crop: none}
tests:
  - {id: 1, recording: run.npz, excitation: random, from: 2 Hz, to: 100 Hz}
"""


def diagnosed(folder, law):
    """Return the diagnosis of a carriage on which a law acts, steps of 10 um read."""
    times = np.arange(0.0, SECONDS, 1.0 / RATE)
    force = FORCE * np.sin(2.0 * np.pi * (2.0 * times + 20.0 * times**2))
    force += 0.3 * FORCE * np.sign(np.sin(10.0 * np.pi * times))

    def slopes(time, state):
        return [state[1], (np.interp(time, times, force) - law(state[1])) / MASS]

    found = solve_ivp(slopes, (0.0, SECONDS), [0.0, 0.0], t_eval=times, rtol=1e-8,
                      atol=1e-10, max_step=2e-4)  # fmt: skip
    noise = np.random.default_rng(2).normal(size=times.size)
    position = np.round(found.y[0] / 1e-5) * 1e-5
    np.savez(folder / "run.npz", fs=RATE, force=force + 0.01 * FORCE * noise, position=position)
    (folder / "log.yaml").write_text(LOG)
    (folder / "model.yaml").write_text(MODEL)
    return diagnose(read_model(folder / "model.yaml"), read_testlog(folder / "log.yaml"))


@pytest.mark.slow
def test_drag_is_named_with_its_number(tmp_path):
    found = diagnosed(tmp_path, lambda v: 12.0 * v + 150.0 * v * abs(v))
    (drag,) = found.effects
    assert drag.kind == "quadratic_damping"
    coefficient = drag.parameters["coefficient"]
    assert coefficient.low <= 150.0 <= coefficient.high
    assert found.errors.held_out.after < 0.1 * found.errors.held_out.before


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "kinds"),
    [
        (lambda v: 33.0 * v, []),
        (lambda v: 25.0 * v + 9.0 * np.tanh(v / 1e-3), ["coulomb_friction"]),
    ],
)
def test_dry_friction_is_told_from_a_damper_that_is_off(tmp_path, law, kinds):
    found = diagnosed(tmp_path, law)
    assert [effect.kind for effect in found.effects] == kinds
    assert not found.locked
