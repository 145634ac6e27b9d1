"""A pendulum before a camera, integrated by scipy: softer at large swings."""

import numpy as np
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


def diagnosed(
    path, swing, drag, *, rate=30.0, noise=NOISE, seconds=40.0, held=0.0, offset=0.0, seed=1
):
    """Return what `diagnose` says of a swing [rad] that is let go.

    `drag` gives the angular deceleration at an angular velocity [rad/s^2]; `held` is the time
    for which it is held before [s], `offset` the place of the camera's zero [m].
    """
    t = np.arange(seconds * rate) / rate

    def falls(_t, y):
        return [y[1], -9.81 / LENGTH * np.sin(y[0]) - drag(y[1])]

    swung = solve_ivp(
        falls, (0.0, seconds), [swing, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=0.01
    ).y[0]
    angle = np.concatenate([np.full(round(held * rate), swing), swung])
    random = np.random.default_rng(seed).standard_normal(angle.size)
    seen = LENGTH * angle + offset + noise * random
    np.savez(path / "d.npz", fs=np.array([rate]), x=seen)
    (path / "model.yaml").write_text(MODEL)
    (path / "testlog.yaml").write_text(LOG)
    return diagnose(read_model(path / "model.yaml"), read_testlog(path / "testlog.yaml"))
