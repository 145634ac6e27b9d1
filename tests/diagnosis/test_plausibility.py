"""Mistakes that a diagnosis tells before it searches, and tests too small for a spectrum."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.comparison.small_campaigns import campaign, drive, written
from tests.comparison.test_errors import GAP
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.comparison import compare_tests, measured_tests, quiet_of, sentence
from shakerproc.diagnosis.plausibility import check_plausible
from shakerproc.errors import DiagnosisError
from shakerproc.model_files import read_model
from shakerproc.models.effects.spring import Spring
from shakerproc.testlog import read_testlog


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    """A model that lacks a gap, a test that does not reach it, and one that rattles."""
    levels = (drive(level=0.5), drive(level=15.0, number=2))
    made = campaign(hidden=((0, GAP),), drives=levels, seconds=2.0)
    log, path = written(made, tmp_path_factory.mktemp("plausible"))
    model = read_model(path)
    return model, measured_tests(read_testlog(log), model)


def test_a_model_that_lacks_a_gap_is_plausible(given):
    check_plausible(*given)


@pytest.mark.parametrize("factor", [0.1, 2.0, -1.0, -10.0])
def test_a_gain_or_polarity_is_for_the_search_to_name(given, factor):
    model, tests = given
    check_plausible(model, [replace(t, responses=factor * t.responses) for t in tests])


def _over_mass(factor):
    return re.escape(f"stiffness over mass {factor:.0e} times")


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_mass_in_another_unit_is_told(given, factor):
    model, tests = given
    wrong = replace(model, masses={"coupon": factor * model.masses["coupon"]})
    with pytest.raises(DiagnosisError, match=_over_mass(factor)):
        check_plausible(wrong, tests[:1])


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_stiffness_in_another_unit_is_told(given, factor):
    model, tests = given
    wrong = replace(
        model,
        elements=tuple(
            replace(e, effect=Spring(factor * e.effect.stiffness))
            if isinstance(e.effect, Spring) else e
            for e in model.elements
        ),
    )  # fmt: skip
    with pytest.raises(DiagnosisError, match=_over_mass(1.0 / factor)):
        check_plausible(wrong, tests[:1])


def test_a_sensitivity_in_another_unit_is_told(given):
    model, tests = given
    with pytest.raises(DiagnosisError, match="with gains 1e-03 times as large"):
        check_plausible(model, [replace(t, responses=1e-3 * t.responses) for t in tests[:1]])


def test_exchanged_channels_and_a_control_turned_round_are_told(given):
    model, tests = given
    exchanged = [replace(t, controls=t.responses, responses=t.controls[:1]) for t in tests[:1]]
    with pytest.raises(DiagnosisError, match="with control and ch3 exchanged"):
        check_plausible(model, exchanged)
    turned = [replace(t, responses=-t.controls[:1]) for t in tests]
    with pytest.raises(DiagnosisError, match="ch3 is the control turned round"):
        check_plausible(model, turned)


def test_a_joint_that_holds_is_a_verdict(given):
    model, tests = given
    check_plausible(model, [replace(t, responses=t.controls[:1]) for t in tests])


def test_a_level_that_shifts_the_peak_is_no_case_for_a_fit(given):
    """With a model so wrong that the error is near 1 at both levels."""
    model, tests = given
    soft = replace(model, masses={"coupon": 40.0 * model.masses["coupon"]})
    said = sentence(compare_tests(soft, tests))
    assert "--fit" not in said
    assert "the response function of ch3 changes by" in said
    assert "something depends on amplitude" in said


def test_a_short_rest_at_25_hz_tells_no_noise_and_ends_in_no_traceback():
    rng = np.random.default_rng(1)
    level = np.where(np.arange(2000) < 30, 1e-3, 1.0)
    rows = level * rng.standard_normal((2, 2000))
    assert quiet_of(rows[:1], rows[1:], 25.0) is None


def test_a_sine_between_two_lines_is_compared_and_not_diagnosed(tmp_path):
    """A component test of a spring and a damper, against a spring of half the stiffness."""
    t = np.arange(256 * 20) / 256.0
    z, v = 1e-3 * np.sin(np.pi * t), 1e-3 * np.pi * np.cos(np.pi * t)
    table = np.column_stack([t, z, 2e3 * z + 50.0 * v])
    head = "time [s],stroke [m],force [N]"
    np.savetxt(tmp_path / "s.csv", table, "%.9g", ",", header=head, comments="")
    (tmp_path / "log.yaml").write_text(
        "testlog: 1\nrecordings: .\nchannels: {stroke: {role: displacement, at: rod}, "
        "force: {role: force, at: rod}}\nprocessing: {crop: none}\n"
        "tests: [{id: 1, recording: s.csv, excitation: sine, frequency: 0.5 Hz}]\n"
    )
    (tmp_path / "model.yaml").write_text(
        "model: 1\ntitle: rod\nmasses: {rod: 1 g}\nelements:\n"
        "  - {kind: spring, between: [base, rod], stiffness: 1 N/mm}\n"
        "  - {kind: damper, between: [base, rod], damping: 50 N s/m}\n"
        "excitation: {displacement of: rod}\nsensors: {force: {at: rod, measures: force}}\n"
    )
    files = [str(tmp_path / "model.yaml"), str(tmp_path / "log.yaml")]
    expected = 1e3 / np.hypot(2e3, 50.0 * np.pi)
    model = read_model(tmp_path / "model.yaml")
    found = compare_tests(model, measured_tests(read_testlog(tmp_path / "log.yaml"), model))
    assert found.error == pytest.approx(expected, rel=0.02)
    again = CliRunner().invoke(build_app(), ["diagnose", *files, "--out", f"{tmp_path}/d"])
    assert isinstance(again.exception, DiagnosisError)
    assert "nothing can be held out" in str(again.exception)
