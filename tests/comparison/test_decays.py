"""Decays of a model beside decays that scipy integrates, or that have a closed form."""

import csv
import json

import numpy as np
import pytest
from configs.benchmarks import convert
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from tests.in_process import run

import shakerproc as sp
from shakerproc.errors import DiagnosisError
from shakerproc.workflows.evidence import Evidence, write_evidence

RATE, SECONDS = 2048.0, 4.0
MASS, STIFFNESS, DAMPING = 0.5, 5e4, 1.2
PULLED = 2e-3
HELD = 400
"""Samples for which the mass is held before it is let go [-]."""

MODEL = """model: 1
title: {title}
masses: {{tip: 0.5 kg}}
elements:
  - {{kind: spring, between: [base, tip], stiffness: {stiffness} N/m}}
  - {{kind: damper, between: [base, tip], damping: {damping} N s/m}}
{more}excitation: {excitation}
sensors:
  tip: {{at: tip, measures: acceleration}}
"""
LOG = """testlog: 1
title: a decay
recordings: .
processing: {crop: none}
channels:
  tip: {role: response, at: tip, unit: m/s^2}
tests:
  - {id: 1, recording: decay.npz, excitation: free decay, from: 20 Hz, to: 120 Hz}
"""


def integrated(law):
    """Return the acceleration after the mass is let go, with a further force [m/s^2]."""

    def force(z, v):
        return -(DAMPING * v + STIFFNESS * z + law(z, v))

    times = np.arange(0.0, SECONDS, 1.0 / RATE)
    found = solve_ivp(
        lambda _t, y: [y[1], force(*y) / MASS], (0.0, SECONDS), [PULLED, 0.0],
        t_eval=times, rtol=1e-9, atol=1e-13, method="DOP853",
    )  # fmt: skip
    return force(*found.y) / MASS


def rubbed(friction):
    """Return that with dry friction and no damper: half periods about shifted places."""
    omega = np.sqrt(STIFFNESS / MASS)
    shift = friction / STIFFNESS
    times = np.arange(0.0, SECONDS, 1.0 / RATE)
    half = np.floor(times * omega / np.pi)
    amplitude = PULLED - (2.0 * half + 1.0) * shift
    moving = amplitude > 0.0
    return np.where(moving, -(omega**2) * amplitude * (-1.0) ** half * np.cos(
        omega * times - np.pi * half), 0.0)  # fmt: skip


DECAYS = {
    "linear": (lambda: integrated(lambda z, _v: 0.0 * z), ""),
    "cubic": (lambda: integrated(lambda z, _v: 1.5e9 * z**3), "hardening spring"),
    "quadratic": (lambda: integrated(lambda _z, v: 8.0 * v * np.abs(v)), "quadratic_damping"),
    "friction": (lambda: rubbed(0.25), "coulomb_friction"),
}


def written(folder, samples, *, stiffness=STIFFNESS, damping=DAMPING, more="", title="linear",
            excitation="{free: decay}"):  # fmt: skip
    """Write recording, log and model of a decay; return the paths of log and model."""
    noise = np.random.default_rng(3).standard_normal(samples.size + HELD)
    row = np.concatenate([np.zeros(HELD), samples]) + 1e-4 * samples.std() * noise
    np.savez(folder / "decay.npz", fs=RATE, tip=row)
    (folder / "testlog.yaml").write_text(LOG)
    model = folder / f"{title.replace(' ', '_')}.yaml"
    model.write_text(
        MODEL.format(
            title=title, stiffness=stiffness, damping=damping, more=more, excitation=excitation
        )
    )
    return folder / "testlog.yaml", model


def compared(log, model, **options):
    return sp.compare(sp.read_model(model), sp.read_log(log), **options)


@pytest.mark.parametrize("kind", ["cubic", "quadratic", "friction"])
def test_where_the_curves_disagree_says_which_law_the_model_lacks(tmp_path, kind):
    decay, law = DECAYS[kind]
    found = compared(*written(tmp_path, decay()))
    assert "What the model lacks" in found.sentence
    assert law in found.sentence


def test_the_rest_after_a_decay_is_said_and_its_curve_is_whole(tmp_path):
    """Dry friction stops the mass after some two of four seconds."""
    slides_s = PULLED * np.sqrt(STIFFNESS * MASS) * np.pi / (2.0 * 0.25)
    test = compared(*written(tmp_path, DECAYS["friction"][0]())).found.tests[0]
    (said,) = [note for note in test.measured.notes if "at rest" in note]
    told_s = float(said.split("the last ")[1].split(" s ")[0])
    assert_allclose(told_s, SECONDS - slides_s, atol=0.4)
    amplitudes = [reading.amplitude for reading in test.modes[0].measured.fitted]
    assert min(amplitudes) < 0.1 * max(amplitudes)


def test_the_true_model_agrees_at_every_amplitude(tmp_path):
    more = "  - {kind: cubic_stiffness, between: [base, tip], coefficient: 1.5e9 N/m^3}\n"
    found = compared(*written(tmp_path, DECAYS["cubic"][0](), more=more, title="cubic"))
    assert "agrees within the intervals" in found.sentence


def test_wrong_linear_numbers_are_no_missing_law(tmp_path):
    found = compared(
        *written(tmp_path, DECAYS["linear"][0](), stiffness=1.04 * STIFFNESS, damping=1.44)
    )
    assert "numbers of the linear elements" in found.sentence
    row = found.rows[0]
    for end in ("largest", "smallest"):
        wanted = 100.0 * (1.0 / np.sqrt(1.04) - 1.0)
        assert_allclose(row[f"frequency_difference_at_{end}_percent"], wanted, atol=0.01)
        zeta = 0.5 / np.sqrt(MASS * STIFFNESS)
        wanted = 100.0 * zeta * (DAMPING - 1.44 / np.sqrt(1.04))
        assert_allclose(row[f"damping_difference_at_{end}_percent"], wanted, atol=0.005)


def test_a_law_that_the_model_has_too_much_of_is_said_so(tmp_path):
    more = "  - {kind: quadratic_damping, between: [base, tip], coefficient: 8 N s^2/m^2}\n"
    found = compared(*written(tmp_path, DECAYS["linear"][0](), more=more, title="too much"))
    assert "The model has more than was measured" in found.sentence
    assert "quadratic_damping" in found.sentence


def test_the_command_writes_curves_of_both_models(tmp_path, capsys):
    log, old = written(tmp_path, DECAYS["cubic"][0]())
    more = "  - {kind: cubic_stiffness, between: [base, tip], coefficient: 1.5e9 N/m^3}\n"
    _, new = written(tmp_path, DECAYS["cubic"][0](), more=more, title="with cubic")
    out = tmp_path / "out"
    assert run("compare", new, log, "--before", old, "--out", out) == 0
    assert "agrees within the intervals" in capsys.readouterr().out
    with (out / "decay_curves.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["whose"] for row in rows} == {"measured", "model"}
    assert {row["method"] for row in rows} == {"least squares", "peaks and crossings"}
    assert json.loads((out / "compare.json").read_text())["modes"][0]["outside_percent"] < 10.0
    assert (out / "decay_1_1_frequency.png").stat().st_size > 10_000
    page = (out / "report.html").read_text()
    assert "with cubic" in page
    assert "What the model lacks" in page  # of the older model


def test_what_adds_an_effect_shows_the_decays_of_both_models(tmp_path):
    log, model = written(tmp_path, DECAYS["cubic"][0]())
    added = sp.add("cubic_stiffness", sp.read_model(model), sp.read_log(log))
    labels = [text.get_text() for text in added.plot().axes[0].get_legend().get_texts()]
    assert any("with cubic stiffness" in text for text in labels)
    assert "linear" in labels
    found = compared(log, model, before=added.model)
    page = write_evidence(tmp_path, "a decay", "none", Evidence(decays=found.drawn))
    text = page.read_text()
    assert "frequency and damping against amplitude" in text
    assert "What the model lacks" in text


@pytest.mark.slow
def test_a_decay_is_diagnosed_and_told_by_the_command(tmp_path, capsys, few_effects):
    """No free-run error is asked of it: nothing drives the test."""
    log, model = written(tmp_path, DECAYS["cubic"][0]())
    words = ["diagnose", str(model), str(log), "--out", str(tmp_path / "out")]
    assert run(*words) == 0
    assert "The model lacks cubic stiffness between base and tip" in capsys.readouterr().out
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [({"fit": True}, "shakerproc add"), ({"before": "driven"}, "something drives the older")],
)
def test_what_a_decay_cannot_do_is_one_line(tmp_path, options, says):
    log, model = written(tmp_path, DECAYS["linear"][0]())
    if "before" in options:
        _, driven = written(
            tmp_path, DECAYS["linear"][0](), title="driven", excitation="{base: acceleration}"
        )
        options = {"before": sp.read_model(driven)}
    with pytest.raises(DiagnosisError, match=says):
        compared(log, model, **options)


def test_a_decay_in_which_nothing_rings_is_one_line(tmp_path):
    noise = np.random.default_rng(8).standard_normal(round(SECONDS * RATE))
    noise[100] = 30.0
    log, model = written(tmp_path, noise)
    with pytest.raises(DiagnosisError, match="no mode stands out of the noise"):
        compared(log, model)


@pytest.mark.shared
def test_a_jointed_structure_slips_where_a_linear_model_does_not(shared, tmp_path):
    folder = convert.folder_of("ringdown", tmp_path, shared / "data")
    found = compared(folder / "decay.yaml", folder / "decay_model.yaml")
    assert "slip in a joint" in found.sentence
    row = found.rows[0]
    assert_allclose(row["frequency_at_smallest_hz"], 151.7, rtol=1e-3)  # of the paper's curve
    assert 0.05 < row["frequency_difference_at_smallest_percent"] < 2.0
