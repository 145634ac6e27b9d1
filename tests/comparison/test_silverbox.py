"""The Silverbox, an electronic Duffing oscillator: the cubic spring is what its model lacks."""

import pytest

from shakerproc import comparison
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

LOG = """
testlog: 1
title: Silverbox
recordings: .
channels:
  V1: {role: force, unit: N}
  V2: {role: displacement, name: y, unit: m}
processing: {sample_rate: 610.35 Hz}
tests:
  - {id: 1, recording: SNLS80mV.mat, joint: none, excitation: random, from: 0.5 Hz, to: 200 Hz,
     processing: {crop: {from: 100 s, to: 130 s}}}
  - {id: 2, recording: SNLS80mV.mat, joint: none, excitation: random, from: 0.5 Hz, to: 200 Hz,
     processing: {crop: {from: 0 s, to: 65 s}}, hold_out: true}
"""
MODEL = """
model: 1
title: Silverbox
masses: {y: 5.2e-6 kg}
elements:
  - {kind: spring, between: [base, y], stiffness: 0.9585 N/m}
  - {kind: damper, between: [base, y], damping: 2.253e-4 N s/m}
excitation: {force on: y}
sensors: {y: {at: y, measures: displacement}}
"""
CUBIC = "  - {kind: cubic_stiffness, between: [base, y], coefficient: 3.667 N/m^3}\n"


@pytest.mark.shared
@pytest.mark.slow
@pytest.mark.long
def test_the_cubic_spring_explains_what_the_linear_model_leaves(shared, tmp_path):
    name = "SNLS80mV.mat"
    (tmp_path / name).write_bytes((shared / "data" / "silverbox" / name).read_bytes())
    (tmp_path / "log.yaml").write_text(LOG)
    (tmp_path / "linear.yaml").write_text(MODEL)
    (tmp_path / "cubic.yaml").write_text(MODEL.replace("excitation:", CUBIC + "excitation:", 1))
    log = read_testlog(tmp_path / "log.yaml")
    linear, cubic = (
        comparison.compare(read_model(tmp_path / f"{kind}.yaml"), log)
        for kind in ("linear", "cubic")
    )
    assert cubic.held_out < 0.03
    for one, other in zip(linear.tests, cubic.tests, strict=True):
        assert one.noise == pytest.approx(other.noise, rel=0.05)  # whatever the model
        assert 0.0005 < one.noise < other.error  # 0.05 mV: harmonics of the cube are no noise
    assert linear.held_out > 8.0 * cubic.held_out
    assert "most beyond a displacement of" in comparison.sentence(linear)
