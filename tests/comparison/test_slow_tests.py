"""Tests below 0.2 Hz, and tests whose band the log does not state."""

import numpy as np
import pytest

from shakerproc.comparison.measured import measured_tests
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import read_model
from shakerproc.testlog import read_testlog

LOG = """
testlog: 1
title: column
recordings: .
channels:
  stroke: {role: displacement, at: top, unit: m}
  force: {role: force, at: top, unit: N}
processing: {crop: none}
tests:
  - {id: 1, recording: run.csv}
"""
MODEL = """
model: 1
title: column
masses: {top: 1 kg}
elements:
  - {kind: spring, between: [base, top], stiffness: 5 kN/mm}
excitation: {displacement of: top}
sensors: {force: {at: top, measures: force}}
"""
SHAKEN = """
model: 1
title: tower
masses: {top: 1000 kg}
elements:
  - {kind: spring, between: [base, top], stiffness: 4 kN/m}
excitation: {base: acceleration}
sensors: {force: {at: top, measures: acceleration}}
"""


def measured(folder, excitation, model=MODEL, at=0.05, rate=5.0, seconds=240.0):
    """A column pushed to and fro at a frequency [Hz], as the comparison takes it."""
    t = np.arange(0.0, seconds, 1.0 / rate)
    x = 0.01 * np.sin(2.0 * np.pi * at * t)
    log = LOG if not excitation else LOG.replace("run.csv", f"run.csv, {excitation}")
    if model is SHAKEN:
        log = log.replace("displacement, at: top, unit: m", "control, unit: m/s^2")
        log = log.replace("force, at: top, unit: N", "response, at: top, unit: m/s^2")
    np.savetxt(
        folder / "run.csv", np.column_stack([t, x, 5e6 * x]), delimiter=",", fmt="%.9g",
        header="time [s],stroke,force", comments="",
    )  # fmt: skip
    (folder / "log.yaml").write_text(log)
    (folder / "model.yaml").write_text(model)
    (found,) = measured_tests(
        read_testlog(folder / "log.yaml"), read_model(folder / "model.yaml")
    )
    return found


SLOW = [
    "",
    "excitation: sine, frequency: 0.05 Hz",
    "excitation: random, from: 0.03 Hz, to: 1 Hz",
]


@pytest.mark.parametrize("excitation", SLOW)
def test_a_test_below_0p2_hz_is_compared_where_it_moves(tmp_path, excitation):
    found = measured(tmp_path, excitation)
    assert found.excited[0] <= 0.05 <= found.excited[1]
    assert found.error_band[0] <= 0.05 <= found.error_band[1]


def test_accelerations_are_compared_below_0p2_hz_where_the_log_says_so(tmp_path):
    assert measured(tmp_path, "", SHAKEN, at=0.3).error_band[0] == pytest.approx(0.2, abs=0.1)
    said = measured(tmp_path, "excitation: random, from: 0.1 Hz, to: 1 Hz", SHAKEN, at=0.3)
    assert said.excited == said.error_band == (0.1, 1.0)


@pytest.mark.parametrize(("at", "rate", "seconds"), [(0.05, 5.0, 240.0), (60.0, 1000.0, 5.0)])
def test_without_a_band_in_the_log_that_of_the_drive_counts(tmp_path, at, rate, seconds):
    low, high = measured(tmp_path, "", at=at, rate=rate, seconds=seconds).excited
    assert low == pytest.approx(at, rel=0.05)
    assert high == pytest.approx(at, rel=0.05)


def test_a_band_in_which_nothing_drives_is_one_line(tmp_path):
    said = "excitation: random, from: 0.0001 Hz, to: 0.001 Hz"
    wanted = "the log says 0.0001 to 0.001 Hz, but stroke has most power at 0.05 Hz"
    with pytest.raises(DiagnosisError, match=f"{wanted}.*Correct from and to in the log"):
        measured(tmp_path, said)
