"""A multisine is planned: what its lines do not tell, and one that a diagnosis asks for."""

import json

import pytest
from tests.in_process import run

MODEL = """\
model: 1
masses: {coupon: 1 kg}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 1e5 N/m}
  - {kind: damper, between: [base, coupon], damping: 12 N s/m}
excitation: {force on: coupon}
sensors:
  x: {at: coupon, measures: acceleration}
"""
LOG = """\
testlog: 1
channels:
  f: {role: force, at: coupon, unit: N}
  x: {role: response, at: coupon, unit: m/s^2}
processing: {crop: none, sample_rate: 1024 Hz}
tests:
  - {id: 1, recording: one.tdms, excitation: multisine, level: 20 N rms, from: 5 Hz, to: 150 Hz,
     multisine: {PERIODS}}
"""


@pytest.fixture
def planned(tmp_path, capsys):
    def plan(said, *options):
        (tmp_path / "model.yaml").write_text(MODEL)
        (tmp_path / "log.yaml").write_text(LOG.replace("PERIODS", said))
        options = (*options, "--model", tmp_path / "model.yaml", "--no-figures")
        assert run("plan", tmp_path / "log.yaml", *options, "--out", tmp_path / "out") == 0
        return capsys.readouterr().out

    return plan


@pytest.mark.parametrize(
    ("said", "tells"),
    [
        ("period: 1 s, periods: 5", "lines 1 Hz apart are coarse for the 1.91 Hz half-power"),
        ("period: 4 s, periods: 2", "periods: 2 leaves no two that repeat after a transient"),
        ("period: 4 s, periods: 5, lines: all", "does not tell odd distortion"),
    ],
)
def test_what_a_multisine_would_not_tell_is_said_before_it(planned, said, tells):
    assert tells in planned(said)
    assert tells not in planned("period: 4 s, periods: 5")


def test_a_diagnosis_asks_for_a_multisine_at_another_level(planned, tmp_path):
    wanted = {"excitation": "multisine", "level": "40 N rms", "like": "test 1"}
    document = {"schema": "shakerproc-diagnosis/1", "next_test": [wanted]}
    (tmp_path / "d.json").write_text(json.dumps(document))
    told = planned(
        "period: 4 s, periods: 5, realisations: 2", "--diagnosis", tmp_path / "d.json"
    )
    (line,) = [one for one in told.splitlines() if one.startswith("next 1")]
    assert line.split()[2:8] == ["multisine", "40", "N", "rms", "5", "150"]
    assert line.split()[8] == "40"  # s: two realisations of five periods
