"""What a model and a log that do not fit together are told, in one line each."""

import re
from dataclasses import replace

import pytest
import yaml
from tests.comparison.small_campaigns import ONE_MASS, campaign, drive, written

from shakerproc import comparison
from shakerproc.errors import DiagnosisError, LogError, ModelError, SimulationError
from shakerproc.model_files import read_model
from shakerproc.models import Element
from shakerproc.models.effects import EFFECTS
from shakerproc.testlog import read_testlog


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    path = tmp_path_factory.mktemp("bad")
    written(campaign(drives=(drive(),), seconds=2.0), path)
    return path


def edited(path, name, change):
    """The document of this name with a change, beside the original."""
    document = yaml.safe_load((path / name).read_text())
    change(document)
    other = path / f"edited-{name}"
    other.write_text(yaml.safe_dump(document))
    return other


def run(path, log="testlog.yaml", model="model.yaml", **options):
    return comparison.compare(read_model(path / model), read_testlog(path / log), **options)


def test_a_sensor_that_is_no_channel(place):
    def rename(model):
        model["sensors"]["ch9"] = model["sensors"].pop("ch3")

    edited(place, "model.yaml", rename)
    with pytest.raises(DiagnosisError, match=r"sensor 'ch9' is no channel.*ch3 \(response"):
        run(place, model="edited-model.yaml")


def test_a_model_without_sensors(place):
    edited(place, "model.yaml", lambda model: model.pop("sensors"))
    with pytest.raises(ModelError, match="no sensors"):
        run(place, model="edited-model.yaml")


def test_a_log_without_control(place):
    def demote(log):
        log["channels"]["control 1"]["role"] = "ignore"
        log["channels"]["control 2"]["role"] = "response"

    edited(place, "testlog.yaml", demote)
    with pytest.raises(DiagnosisError, match="no channel has the role control"):
        run(place, log="edited-testlog.yaml")


def test_controls_and_responses_exchanged(place):
    def exchange(log):
        log["channels"] = {
            "control 1": {"role": "response", "name": "ch3"},
            "control 2": {"role": "ignore"},
            "response 1": {"role": "control"},
        }

    edited(place, "testlog.yaml", exchange)
    found = run(place, log="edited-testlog.yaml")
    (warning,) = found.warnings
    assert re.search(r"test 1 .*may be exchanged: over \d+ freq.*ch3.*correlation -0", warning)


def test_roles_that_are_right_raise_no_warning(place):
    assert run(place).warnings == ()


def test_a_channel_that_is_both(place):
    def both(model):
        model["sensors"] = {"control 1": {"at": "coupon", "measures": "acceleration"}}

    edited(place, "model.yaml", both)
    with pytest.raises(DiagnosisError, match="both drives the model and is a sensor"):
        run(place, model="edited-model.yaml")


def test_a_sensor_of_another_unit(place):
    def displaced(model):
        model["sensors"]["ch3"]["measures"] = "relative displacement"

    edited(place, "model.yaml", displaced)
    with pytest.raises(DiagnosisError, match=r"is in m/s\^2 \(g\), but sensor 'ch3' needs m"):
        run(place, model="edited-model.yaml")


def test_a_force_where_there_is_none(place):
    edited(place, "model.yaml", lambda m: m.update(excitation={"force on": "coupon"}))
    with pytest.raises(DiagnosisError, match="no channel has the role force"):
        run(place, model="edited-model.yaml")


def test_a_log_without_recordings(place):
    edited(place, "testlog.yaml", lambda log: log["tests"][0].update(discarded=True))
    with pytest.raises(LogError, match="no test has a recording"):
        run(place, log="edited-testlog.yaml")


def test_nothing_left_to_fit_to(place):
    edited(place, "testlog.yaml", lambda log: log["tests"][0].update(hold_out=True))
    with pytest.raises(DiagnosisError, match="every test is held out"):
        run(place, log="edited-testlog.yaml", fit=True)


def test_a_crop_that_leaves_next_to_nothing_is_noted(place):
    edited(
        place,
        "testlog.yaml",
        lambda log: log["processing"].update(crop={"from": "1 s", "to": "1.04 s"}),
    )
    found = run(place, log="edited-testlog.yaml")
    notes = " ".join(found.tests[0].measured.notes)
    assert re.search(r"samples that are compared hold \d periods", notes)


def test_a_crop_that_finds_no_run_is_noted_and_everything_compared(place):
    edited(
        place,
        "testlog.yaml",
        lambda log: log["processing"].update(
            crop={"channel": "control 2", "threshold": "99 g"}
        ),
    )
    found = run(place, log="edited-testlog.yaml")
    assert "finds no run" in found.tests[0].measured.notes[0]
    assert found.tests[0].prediction.input.size == found.tests[0].measured.controls.shape[1]


def test_a_model_that_runs_away_names_the_run(place):
    model = read_model(place / "model.yaml")
    joint = ONE_MASS.joints[0]
    soft = Element(EFFECTS["cubic_stiffness"](-joint.stiffness * 1e12), ("base", "coupon"))
    unstable = replace(model, elements=(*model.elements, soft))
    with pytest.raises(SimulationError, match=r"test 1 \(Acceleration.tdms\): .*runs away"):
        comparison.compare(unstable, read_testlog(place / "testlog.yaml"))


def test_a_place_that_the_model_lacks_is_told_with_what_was_meant(place):
    edited(place, "testlog.yaml", lambda log: log["channels"]["response 1"].update(at="cupon"))
    tests = run(place, log="edited-testlog.yaml").tests
    for test in tests:
        (line,) = [text for text in test.measured.remarks if "at:" in text]
        assert line == (
            'channel ch3: the log says at: "cupon", the model "coupon" (its places: base, '
            'coupon); did you mean "coupon"?'
        )


def test_a_place_of_the_model_that_is_another_than_that_of_the_sensor_is_told(place):
    edited(place, "testlog.yaml", lambda log: log["channels"]["response 1"].update(at="base"))
    (line, *_) = run(place, log="edited-testlog.yaml").tests[0].measured.remarks
    assert line.endswith('at: "base", the model "coupon" (its places: base, coupon)')


def test_places_on_which_log_and_model_agree_are_not_remarked_upon(place):
    edited(place, "testlog.yaml", lambda log: log["channels"]["response 1"].update(at="coupon"))
    assert not run(place, log="edited-testlog.yaml").tests[0].measured.places
