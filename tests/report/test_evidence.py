"""Evidence of a gap that was left out, on a campaign whose every number is known."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.comparison.small_campaigns import JOINT, campaign, drive, written
from tests.comparison.test_errors import CLEARANCE, CONTACT, GAP
from tests.report.test_page import PAYLOADS, Page
from typer.testing import CliRunner

from shakerproc import comparison
from shakerproc.cli import build_app
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.result import (
    BeforeAfter,
    Diagnosis,
    Errors,
    Finding,
    NextTest,
    Tried,
    Where,
)
from shakerproc.diagnosis.updated import updated_model
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element
from shakerproc.recordings import sha256
from shakerproc.report.evidence import motion
from shakerproc.report.evidence.comparison import Models, loudest, unit_of_sensor
from shakerproc.report.evidence.motion import cloud
from shakerproc.report.evidence.numbers import interval, tables
from shakerproc.report.evidence.sections import ONE_METHOD, sections
from shakerproc.report.evidence.spectra import lowest_phase, phase_of
from shakerproc.report.page.methods import references_of
from shakerproc.report.page.page import Report, html
from shakerproc.testlog import read_testlog
from shakerproc.workflows.evidence import (
    Evidence,
    inputs_of,
    methods_of,
    name_of_new,
    write_evidence,
)


def estimate(value, unit):
    return Estimate(value, 0.99 * value, 1.01 * value, unit)


NUMBERS = {"stiffness": estimate(CONTACT, "N/m"), "clearance": estimate(CLEARANCE, "m")}
DIAGNOSIS = Diagnosis(
    verdict="effect found",
    sentence="The model lacks a gap.",
    effects=(Finding("gap", ("base", "coupon"), NUMBERS),),
    indistinguishable=("offset_gap",),
    errors=Errors(BeforeAfter(0.5, 0.02), BeforeAfter(0.6, 0.03), 0.01),
    candidates=(
        Tried("gap", ("base", "coupon"), 0.02, 0.03, NUMBERS),
        Tried("cubic_stiffness", ("base", "coupon"), 0.2, 0.25, {}),
        Tried("lugre_friction", ("base", "coupon"), None, None, {}),
    ),
    where=Where(),
    next_test=(NextTest("random", "0.01 g^2/Hz", ("gap", "offset_gap"), "they differ there"),),
    linear={"stiffness base-coupon": estimate(1.001 * JOINT.stiffness, "N/m")},
)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    made = campaign(
        hidden=((0, GAP),),
        drives=(drive(level=3.0), drive(level=5.0, number=2), drive("sine sweep", 5.0)),
        hold_out=(1,),
        seconds=3.0,
    )
    return written(made, tmp_path_factory.mktemp("evidence"))


@pytest.fixture(scope="module")
def models(files):
    log, path = files
    model = read_model(path)
    gap = Element(EFFECTS["gap"](CONTACT, CLEARANCE), ("base", "coupon"))
    tests = comparison.measured_tests(read_testlog(log), model)
    return Models(
        comparison.compare_tests(model, tests),
        comparison.compare_tests(replace(model, elements=(*model.elements, gap)), tests),
        new="with gap",
    )


def parts_of(found):
    return {part.anchor: part for section in found for part in section.parts}


def test_the_page_has_all_the_evidence_in_order(models):
    found = sections(models, DIAGNOSIS)
    assert [section.anchor for section in found] == ["model", "diagnosis"]
    assert list(parts_of(found)) == [
        "responses", "errors", "forces", "ladder", "numbers", "open"
    ]  # fmt: skip
    assert all(f.caption for part in parts_of(found).values() for f in part.figures)
    assert ONE_METHOD in found[1].paragraphs
    assert ONE_METHOD not in sections(None, DIAGNOSIS)[0].paragraphs
    text = "".join(Page(html(Report("t", [], sections=found))).text)
    for told in ("lugre friction", "gap, offset gap", "they differ there", "0.01 g²/Hz"):
        assert told in text


def test_tables_hold_the_errors_of_both_models(models):
    found = tables(models, DIAGNOSIS)
    by_test = found["errors_by_test.csv"]
    n = len(models.before.tests)
    assert by_test["error"][:n] == [t.error for t in models.before.tests]
    assert by_test["error"][n:] == [t.error for t in models.after.tests]
    assert max(by_test["error"][n:]) < 0.2 * min(by_test["error"][:n])
    assert found["ladder.csv"]["held_out_error"] == [0.6, 0.03, 0.25, None, 0.03, 0.01]
    assert set(found["parameters.csv"]["of"]) == {"found", "linear", "candidate"}


def test_the_table_of_response_functions_is_that_of_the_samples(models):
    """Against the quotient of spectra of one long transform, smoothed over bins."""
    columns = tables(models, None)["response_functions.csv"]
    rows = np.array([
        (f, g, p)
        for test, whose, f, g, p in zip(
            columns["test"], columns["whose"], columns["frequency_hz"], columns["magnitude"],
            columns["phase_deg"], strict=True,
        )
        if test == "1" and whose == "measured"
    ])  # fmt: skip
    test = models.before.tests[0]
    given, seen = np.fft.rfft(test.prediction.input), np.fft.rfft(test.prediction.response[0])
    frequency = np.fft.rfftfreq(test.prediction.input.size, 1.0 / test.measured.sample_rate)
    for f, gain, phase in rows[(rows[:, 0] > 40.0) & (rows[:, 0] < 90.0)][::3]:
        near = np.abs(frequency - f) < 4.0
        h1 = np.sum(seen[near] * given[near].conj()) / np.sum(np.abs(given[near]) ** 2)
        assert gain == pytest.approx(abs(h1), rel=0.03)
        assert phase == pytest.approx(np.degrees(np.angle(h1)), abs=3.0)


def test_force_over_displacement_is_the_law_and_the_damper_does_not_blur_it(models):
    index = loudest(models.after)
    z, force, law = cloud(models.after.tests[index].joints[0], by_velocity=False)
    expected = JOINT.stiffness * z + CONTACT * np.sign(z) * np.maximum(np.abs(z) - CLEARANCE, 0)
    assert_allclose(law, expected, atol=0.03 * np.max(np.abs(expected)))
    assert np.sqrt(np.mean((force - expected) ** 2)) < 0.05 * np.max(np.abs(expected))


def test_force_over_velocity_shows_the_damper_alone(models):
    index = loudest(models.after)
    speed, _, law = cloud(models.after.tests[index].joints[0], by_velocity=True)
    slope = np.sum(law * speed) / np.sum(speed**2)
    assert slope == pytest.approx(JOINT.damping, rel=0.02)


def test_the_phase_of_one_mass_runs_through_its_resonance_without_a_jump():
    r = np.linspace(0.1, 3.0, 300)
    h1 = (1 + 0.04j * r) / (1 - r**2 + 0.04j * r)
    coherence = np.ones(300)
    for turn in (1.0, -1.0, 1j):  # a sensor the wrong way round, a velocity
        lowest = lowest_phase(turn * h1, coherence)
        phase = phase_of(turn * h1, coherence, lowest)
        assert np.isfinite(phase).all()
        assert np.max(np.abs(np.diff(phase))) < 90.0


def test_the_updated_model_has_the_effect_and_the_fitted_numbers(files):
    model = read_model(files[1])
    new = updated_model(model, DIAGNOSIS)
    assert len(new.elements) == len(model.elements) + 1
    gap = new.elements[-1].effect
    assert (gap.stiffness, gap.clearance) == pytest.approx((CONTACT, CLEARANCE), rel=1e-3)
    springs = [e.effect for e in new.elements if e.effect.kind == "spring"]
    assert springs[0].stiffness == pytest.approx(1.001 * JOINT.stiffness)
    assert name_of_new(DIAGNOSIS) == "with gap"
    assert updated_model(model, replace(DIAGNOSIS, verdict="outside library")) is None
    fault = replace(DIAGNOSIS, effects=(Finding("sensor_gain", ("ch3",), {}),))
    assert len(updated_model(model, fault).elements) == len(model.elements)


def test_springs_that_share_a_joint_keep_their_numbers(files):
    model = read_model(files[1])
    twice = replace(model, elements=(*model.elements, model.elements[0]))
    kinds = [e for e in updated_model(twice, DIAGNOSIS).elements if e.effect.kind == "spring"]
    assert kinds == [e for e in twice.elements if e.effect.kind == "spring"]


@pytest.mark.parametrize(
    ("value", "unit", "shown"),
    [
        (5e-5, "m", ("0.05", "0.0495", "0.0505", "1 %", "mm")),
        (49932.0, "N/m", ("49930", "49430", "50430", "1 %", "N/m")),
        (3e8, "N/m^3", ("3e+08", "2.97e+08", "3.03e+08", "1 %", "N/m^3")),
    ],
)
def test_numbers_are_told_in_the_units_of_people(value, unit, shown):
    assert interval(estimate(value, unit)) == shown


def test_the_report_names_files_methods_and_references(models, files, tmp_path):
    log, model = files
    documents = [(w, p, sha256(p)) for w, p in (("model", model), ("test log", log))]
    inputs = inputs_of(documents, [found.measured for found in models.before.tests])
    recordings = {digest for _, _, digest in inputs[2:]}
    assert recordings == {sha256(one.recording) for one in read_testlog(log).active}
    evidence = Evidence(models, DIAGNOSIS, inputs)
    page = write_evidence(tmp_path, "Gap", DIAGNOSIS.sentence, evidence)
    text = page.read_text(encoding="utf-8")
    for _, name, digest in inputs:
        assert name in text
        assert digest in text
    for words in ("Masri", "Cameron", "Shaw and P. J. Holmes"):
        assert words in text
    document = json.loads((tmp_path / "report.json").read_text())
    assert document["diagnosis"]["verdict"] == "effect found"
    assert set(document["compare"]) == {"model as it was", "with gap"}
    with (tmp_path / "errors_by_band.csv").open() as file:
        assert {row["model"] for row in csv.DictReader(file)} == set(document["compare"])
    assert "Masri" not in " ".join(methods_of([], Evidence(None, DIAGNOSIS)).references)


def test_every_effect_brings_its_references():
    for kind in EFFECTS:
        found = references_of(kind)
        assert found, kind
        assert all(len(text) > 20 and not text.startswith(".") for text in found), kind


@pytest.fixture(scope="module")
def tame_tags(models):
    """Every tag of a page of evidence with harmless words."""
    page = Page(html(Report("t", [], sections=sections(models, DIAGNOSIS))))
    return {tag for tag, _ in page.tags}


@pytest.mark.parametrize("payload", PAYLOADS)
def test_text_of_models_is_inert(models, tame_tags, payload):
    named = replace(models, old=payload, new=payload[::-1])
    told = replace(
        DIAGNOSIS,
        sentence=payload,
        notes=(payload,),
        indistinguishable=(payload,),
        candidates=(
            Tried(payload, (payload, payload), 0.1, 0.1, {payload: NUMBERS["clearance"]}),
        ),
        next_test=(NextTest(payload, payload, (payload,), payload),),
        linear={f"stiffness {payload}": NUMBERS["stiffness"]},
    )
    page = Page(html(Report("t", [], sections=sections(named, told))))
    assert {tag for tag, _ in page.tags} <= tame_tags
    assert sum(tag == "script" for tag, _ in page.tags) == 1
    assert not [a for _, a in page.tags for name in a if name.startswith("on")]


def test_laws_of_rivals_are_drawn_by_their_numbers(models):
    """A gap is nothing inside its play and a straight line outside, on both sides."""
    other = {
        "stiffness": estimate(CONTACT, "N/m"),
        "clearance_positive": estimate(CLEARANCE, "m"),
        "clearance_negative": estimate(CLEARANCE, "m"),
    }
    told = replace(
        DIAGNOSIS,
        candidates=(
            *DIAGNOSIS.candidates,
            Tried("offset_gap", ("base", "coupon"), 0.02, 0.03, other),
        ),
    )
    assert [t.kind for t in motion.alternatives(told)] == ["gap", "offset_gap"]
    assert motion.laws(models, DIAGNOSIS) is None
    drawing = motion.laws(models, told)
    assert "gap" in str(drawing.drawing)
    z, force = motion.forced_cycle(motion.effect_of(told.candidates[0]), 3.0 * CLEARANCE, 100.0)
    expected = CONTACT * np.sign(z) * np.maximum(np.abs(z) - CLEARANCE, 0.0)
    assert_allclose(force, expected, atol=1e-9 * CONTACT)


@pytest.mark.slow
def test_a_batch_with_a_model_has_the_evidence_before_its_runs(files, tmp_path, monkeypatch):
    monkeypatch.setattr("shakerproc.diagnosis.diagnose_tests", lambda *_, **__: DIAGNOSIS)
    log, model = files
    words = ["batch", str(log), "--model", str(model), "--no-figures", "--out", str(tmp_path)]
    done = CliRunner().invoke(build_app(), words)
    assert done.exit_code == 0, done.output
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    text = "".join(Page(page.split("<main>")[1]).text)
    places = [
        text.index(words)
        for words in (
            "3 of 3 tests processed", DIAGNOSIS.sentence, "All runs", "Trends",
            "Where the model fails", "What is missing", "Test 1,", "Methods", "Masri",
        )
    ]  # fmt: skip
    assert text.count(DIAGNOSIS.sentence) == 2
    assert json.loads((tmp_path / "report.json").read_text())["diagnosis"]["effects"]
    assert (tmp_path / "ladder.csv").is_file()
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("sensor", "drive", "shown"),
    [
        ("m", "N", "m/N"),
        ("m/s^2", "N", "(m/s²)/N"),
        ("m", "m/s^2", "m/(m/s²)"),
        ("N", "N", "-"),
    ],
)
def test_the_unit_of_a_response_function_has_brackets_where_it_needs_them(sensor, drive, shown):
    class Known:
        model = type("Known", (), {
            "sensors": {"a": sensor}, "sensor_unit": str, "drive_unit": drive,
        })  # fmt: skip

    assert unit_of_sensor(Known, "a") == shown
