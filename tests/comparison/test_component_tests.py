"""Component tests: the displacement is imposed, and the force of the model is compared."""

import numpy as np
import pytest

from shakerproc import comparison
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

RATE, SECONDS, STIFFNESS, DAMPING, SLIDING = 1000.0, 6.0, 3e4, 50.0, 7.0
LOG = """
testlog: 1
title: component
recordings: .
channels:
  stroke: {role: displacement, at: rod, unit: m}
  load: {role: force, name: force, unit: N}
processing: {crop: none}
tests:
  - {id: 1, recording: run.csv, joint: damper, excitation: random, from: 2 Hz, to: 40 Hz}
"""
MODEL = """
model: 1
title: component
masses: {rod: 1 g}
elements:
  - {kind: spring, between: [base, rod], stiffness: 3e4 N/m}
  - {kind: damper, between: [base, rod], damping: 50 N s/m}
excitation: {displacement of: rod}
sensors: {force: {at: rod, measures: force}}
"""
FRICTION = "  - {kind: coulomb_friction, between: [base, rod], sliding_force: 7 N}\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("component")
    rng = np.random.default_rng(3)
    t = np.arange(round(RATE * SECONDS)) / RATE
    f = np.arange(3.0, 30.0, 1.0 / SECONDS)
    phase = rng.uniform(0.0, 2.0 * np.pi, (f.size, 1))
    angle = 2.0 * np.pi * f[:, None] * t + phase
    size = 1e-3 / np.sqrt(f.size)
    x = size * np.sin(angle).sum(axis=0)
    v = size * (2.0 * np.pi * f[:, None] * np.cos(angle)).sum(axis=0)
    force = STIFFNESS * x + DAMPING * v + SLIDING * np.sign(v)
    force = force + 0.05 * rng.standard_normal(t.size)
    table = np.column_stack([t, x, force])
    np.savetxt(
        path / "run.csv", table, delimiter=",", header="time [s],stroke [m],load [N]",
        comments="", fmt="%.9g",
    )  # fmt: skip
    (path / "log.yaml").write_text(LOG)
    (path / "linear.yaml").write_text(MODEL)
    (path / "rubbing.yaml").write_text(MODEL.replace("excitation:", FRICTION + "excitation:"))
    return path


def test_the_force_of_the_true_model_is_that_measured_and_friction_is_missed_without(folder):
    log = read_testlog(folder / "log.yaml")
    linear, rubbing = (
        comparison.compare(read_model(folder / f"{name}.yaml"), log)
        for name in ("linear", "rubbing")
    )
    assert rubbing.error < 0.02
    assert linear.error > 10.0 * rubbing.error
    # friction has harmonics in the band above, which is no floor then: the true model beats it
    assert rubbing.tests[0].floor.refuted.responses == ("band above the excitation",)
    assert rubbing.tests[0].floor.source == "unknown"
    assert comparison.document_of(rubbing)["tests"][0]["noise_floor"] is None


def test_a_drive_that_is_another_sine_than_the_log_says_is_left_out(folder, tmp_path):
    t = np.arange(round(RATE * SECONDS)) / RATE
    x = 1e-3 * np.sin(2.0 * np.pi * 8.4 * t)
    force = STIFFNESS * x + DAMPING * np.gradient(x, t)
    np.savetxt(
        tmp_path / "run.csv", np.column_stack([t, x, force]), delimiter=",",
        header="time [s],stroke [m],load [N]", comments="", fmt="%.9g",
    )  # fmt: skip
    said = "excitation: random, from: 2 Hz, to: 40 Hz"
    log = tmp_path / "log.yaml"
    model = read_model(folder / "linear.yaml")
    log.write_text(LOG.replace(said, "excitation: sine, frequency: 15 Hz"))
    with pytest.raises(
        DiagnosisError, match=r"left out: .* 15 Hz, but stroke has most power at 8\.33 Hz"
    ):
        comparison.compare(model, read_testlog(log))
    log.write_text(LOG.replace(said, "excitation: sine, frequency: 8.4 Hz"))
    assert comparison.compare(model, read_testlog(log)).error < 1e-3
