"""A condition of the tests scales an effect: from the log to simulate and compare."""

import json
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import completed

import shakerproc as sp
from shakerproc.models import EFFECTS
from shakerproc.models.effects import EXAMPLES
from shakerproc.models.effects.base import times
from shakerproc.recordings import open_recording

MODEL = """model: 1
title: damper with a coil
masses: {coupon: 28.6 g}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 1.5207e5 N/m}
  - {kind: damper, between: [base, coupon], damping: 1 N s/m}
  - {kind: damper, between: [base, coupon], damping: 3 N s/m, scaled_by: {voltage: 2 V}}
excitation: {base: acceleration}
sensors:
  ch3: {at: coupon, measures: acceleration}
"""
STUDY = """study: 1
title: a grid
kind: grid
model: model.yaml
run: {excitation: sine sweep, level: 1 g, from: 0 Hz, to: 10 Hz, duration: 5 s}
vary:
  - {name: k, set: elements.0.stiffness, values: [1e5 N/m, 2e5 N/m]}
"""
LOG = """testlog: 1
title: three voltages
channels:
  control 1: {role: control}
  response 1: {role: response, name: ch3, at: coupon}
tests:
"""
TEST = (
    "  - {id: %d, recording: %d.tdms, excitation: random, level: 0.01 g^2/Hz, from: 20 Hz, "
    "to: 1000 Hz%s}\n"
)


def campaign(folder, *conditions, model=MODEL):
    said = [f", conditions: {{{one}}}" if one else "" for one in conditions]
    log = LOG + "".join(TEST % (i, i, one) for i, one in enumerate(said, 1))
    (folder / "model.yaml").write_text(model, "utf-8")
    (folder / "log.yaml").write_text(log, "utf-8")
    return folder / "model.yaml", folder / "log.yaml"


def plain(damping):
    """The model with the force of the coil written out."""
    coil = f"  - {{kind: damper, between: [base, coupon], damping: {damping} N s/m}}\n"
    lines = MODEL.splitlines(keepends=True)
    return "".join(
        line if "scaled_by" not in line else coil if damping else "" for line in lines
    )


def response(path):
    with open_recording(path) as recording:
        return recording.samples()[-1]


def simulated(folder, *conditions, model=MODEL):
    folder.mkdir()
    files = campaign(folder, *conditions, model=model)
    told = completed("simulate", *files, "--duration-s", "2", "--no-growth")
    assert told.returncode == 0, told.stderr
    return [response(folder / "recordings" / f"{i + 1}.tdms") for i in range(len(conditions))]


def test_each_test_is_simulated_at_its_own_condition(tmp_path):
    """At 0, 1 and 4 V the recordings are those of plain models with 0, 1.5 and 6 N s/m."""
    found = simulated(tmp_path / "scaled", "voltage: 0 V", "voltage: 1000 mV", "voltage: 4 V")
    for i, damping in enumerate((0.0, 1.5, 6.0)):
        wanted = simulated(tmp_path / str(i), "", "", "", model=plain(damping))[i]
        assert_allclose(found[i], wanted, atol=1e-9 * np.max(np.abs(wanted)))


def test_a_campaign_at_several_conditions_is_compared_with_one_model(tmp_path):
    """Right at each voltage only if each test has its own damping; one damping misses."""
    folder = tmp_path / "a"
    simulated(folder, "voltage: 0.5 V", "voltage: 4 V")
    told = completed("compare", folder / "model.yaml", folder / "log.yaml", "--no-figures",
               "--out", tmp_path / "right", "--json", tmp_path / "right.json")  # fmt: skip
    assert told.returncode == 0, told.stderr
    (folder / "plain.yaml").write_text(plain(3.0), "utf-8")
    told = completed("compare", folder / "plain.yaml", folder / "log.yaml", "--no-figures",
               "--out", tmp_path / "wrong", "--json", tmp_path / "wrong.json")  # fmt: skip
    assert told.returncode == 0, told.stderr
    right, wrong = (
        json.loads((tmp_path / f"{name}.json").read_text("utf-8"))
        for name in ("right", "wrong")
    )
    assert len(right["tests"]) == 2
    assert right["error"] < 0.02
    assert wrong["error"] > 0.2


def test_one_model_is_fitted_to_tests_at_several_conditions(tmp_path):
    """Both dampers are told; the model before is scored under the same conditions."""
    folder = tmp_path / "a"
    simulated(folder, "voltage: 0.5 V", "voltage: 4 V")
    log = sp.read_log(folder / "log.yaml")
    off = MODEL.replace("damping: 1 N", "damping: 1.5 N").replace(
        "damping: 3 N", "damping: 2 N"
    )
    (folder / "off.yaml").write_text(off, "utf-8")
    found = sp.compare(sp.read_model(folder / "off.yaml"), log, fit=True)
    dampers = [one.effect.damping for one in found.model.elements[1:]]
    assert_allclose(dampers, [1.0, 3.0], rtol=0.02)
    assert (
        found.model.elements[2].scaled_by
        == sp.read_model(folder / "off.yaml").model.elements[2].scaled_by
    )
    assert found.error < 0.02
    assert found.before.error > 0.1
    told = completed("compare", folder / "model.yaml", folder / "log.yaml", "--no-figures",
               "--before", folder / "off.yaml", "--out", tmp_path / "both")  # fmt: skip
    assert told.returncode == 0, told.stderr


def test_a_channel_measures_the_condition(tmp_path):
    """Recordings with the voltage in a channel, compared by a log that does not state it."""
    model, log = campaign(tmp_path, "voltage: 0.5 V", "voltage: 4 V")
    channel = "  supply: {role: condition, name: voltage}\ntests:"
    log.write_text(log.read_text("utf-8").replace("tests:", channel), "utf-8")
    told = completed("simulate", model, log, "--duration-s", "2", "--no-growth")
    assert told.returncode == 0, told.stderr
    silent = re.sub(r", conditions: \{[^}]*\}", "", log.read_text("utf-8"))
    log.write_text(silent, "utf-8")
    told = completed("compare", model, log, "--no-figures", "--out", tmp_path / "out",
                     "--json", tmp_path / "out.json")  # fmt: skip
    assert told.returncode == 0, told.stderr
    assert re.search(
        r"test 2: voltage (4|3\.9)\S* V in the mean, varying by .* V rms", told.stderr
    )
    assert json.loads((tmp_path / "out.json").read_text("utf-8"))["error"] < 0.02
    log.write_text(silent.replace("name: voltage", "name: voltages"), "utf-8")
    told = completed("compare", model, log, "--out", tmp_path / "other")
    assert told.returncode == 1
    assert "test 1 says no voltage; did you mean its voltages?" in told.stderr


@pytest.mark.parametrize(
    ("conditions", "changed", "said"),
    [
        (("voltage: 1 V", ""), ("", ""), r"test 2 says no voltage; add conditions: {volt"),
        (("volt: 1 V",), ("", ""), r"test 1 says no voltage; did you mean its volt\?"),
        (("voltage: 1 N",), ("", ""), 'voltage of test 1: expected .* of V, .* got "1 N"'),
        (("voltage: -1 V",), ("", ""), r"voltage of test 1 is -1 V; .* at least 0"),
        (("voltage: 1 V",), ("{voltage: 2 V}", "2 V"), "expected one condition and its value"),
        (("voltage: 1 V",), ("{voltage: 2 V}", "{voltage: 2}"), "a quantity with its unit"),
        (("voltage: 1 V",), ("{voltage: 2 V}", "{voltage: 0 V}"), "expected more than 0"),
        (("voltage: 1 V",), ("{voltage: 2 V}", '{"": 2 V}'), "the name of a condition"),
        (("voltage: 1 V",), ("damping: 3 N s/m", "damping_ratio: 0.1"), "no number with"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_condition_is_one_line(tmp_path, conditions, changed, said):
    model = MODEL.replace(*changed) if changed[0] else MODEL
    told = completed("simulate", *campaign(tmp_path, *conditions, model=model))
    assert told.returncode == 1
    assert len(told.stderr.strip().splitlines()) == 1
    assert re.search(said, told.stderr)
    assert not (tmp_path / "recordings").exists()


def test_what_cannot_yet_take_conditions_says_so(tmp_path):
    model, log = campaign(tmp_path, "voltage: 1 V")
    (tmp_path / "study.yaml").write_text(STUDY, "utf-8")
    for doing, words in (
        ("response", ("response", model, "--level", "1 g")),
        ("a plan", ("plan", log, "--model", model)),
        ("a study", ("study", tmp_path / "study.yaml")),
        ("nastran", ("nastran", "write", model)),
    ):
        told = completed(*words, "--out", tmp_path / "out")
        assert told.returncode == 1
        assert (
            f"damper between base and coupon is scaled by voltage, and {doing} cannot yet take "
            "a model under conditions of tests. Write its numbers at one voltage"
        ) in told.stderr
        assert len(told.stderr.strip().splitlines()) == 1
        assert not (tmp_path / "out").exists()
    with pytest.raises(sp.ShakerprocError, match="and a simulation cannot yet take"):
        sp.simulate(sp.read_model(model), np.ones(100), 1000.0)


@pytest.mark.slow
@pytest.mark.long
def test_an_effect_is_added_to_the_file_with_what_scales_it(tmp_path):
    """Numbers of elements that are scaled are written as they hold at their own voltage."""
    friction = "{kind: coulomb_friction, between: [base, coupon], sliding_force: 0.5 N%s}\n"
    truth = MODEL.replace("exci", f"  - {friction % ', scaled_by: {voltage: 1 V}'}exci")
    folder, new = tmp_path / "a", tmp_path / "a" / "new.yaml"
    simulated(folder, "voltage: 1 V", "voltage: 3 V", model=truth)
    off = MODEL.replace("damping: 3 N", "damping: 2.6 N")
    (folder / "off.yaml").write_text(off, "utf-8")
    words = ["add", "coulomb_friction", folder / "off.yaml", folder / "log.yaml", "-o", new]
    told = completed(*words, "--scaled-by", "voltage=2")
    assert told.returncode == 2
    assert 'voltage: expected a quantity with its unit, such as 2 V, got "2"' in told.stderr
    told = completed(*words, "--scaled-by", "voltage=2V")
    assert told.returncode == 0, told.stderr
    lines = new.read_text("utf-8").splitlines()
    coil, added = (one for one in lines if "scaled_by: {voltage: " in one)
    damping = float(re.search(r"damping: (\S+) N s/m", coil)[1])
    assert damping == pytest.approx(3.0, rel=0.1)  # beside friction that takes more
    assert float(re.search(r"force: (\S+) N", added)[1]) == pytest.approx(1.0, rel=0.03)


def test_a_notebook_reads_the_model_under_a_condition(tmp_path):
    model, _ = campaign(tmp_path)
    found = sp.read_model(model, conditions={"voltage": "500 mV"}).model
    assert found.elements[-1].effect == EFFECTS["damper"](damping=0.75)
    assert len(sp.read_model(model, conditions={"voltage": "0 V"}).model.elements) == 2
    with pytest.raises(sp.ShakerprocError, match="conditions says no voltage"):
        sp.read_model(model, conditions={})
    for wrong in ("2 V", {"voltage": 2}, {"voltage": "2"}, {2: "2 V"}):
        with pytest.raises(sp.ArgumentError, match="conditions"):
            sp.read_model(model, conditions=wrong)


SCALED = [kind for kind in EFFECTS if kind not in {"stiffness_drift", "general_bouc_wen"}]


@pytest.mark.parametrize("kind", SCALED)
def test_a_scaled_effect_has_that_multiple_of_the_force(kind):
    """By the law itself, along a sine with a ramp, for every kind that can be scaled."""
    time = np.arange(4000) / 4e4
    z = 1.5e-4 * np.sin(400.0 * time) * (0.2 + 8.0 * time)
    v = np.gradient(z, time)
    effect = EXAMPLES[kind]
    wanted = 2.5 * effect.force_along(z, v, 4e4)
    found = times(effect, 2.5).force_along(z, v, 4e4)
    assert np.any(wanted)
    assert_allclose(found, wanted, rtol=1e-9, atol=1e-9 * np.max(np.abs(wanted)))


@pytest.mark.parametrize(
    ("kind", "said"),
    [("stiffness_drift", "spring beside it"), ("general_bouc_wen", "bouc_wen")],
)
def test_an_effect_that_cannot_be_scaled_says_why(kind, said):
    with pytest.raises(ValueError, match=said):
        times(EXAMPLES[kind], 2.0)
