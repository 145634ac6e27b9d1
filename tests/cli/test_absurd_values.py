"""Values beyond physics, of every option and key: one line, at once, and no traceback."""

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import ModelError, ShakerprocError
from shakerproc.model_files import read_model
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.simulation import simulate
from shakerproc.simulation.harmonic_balance import (
    frequency_response,
    response_columns,
    samples_of_branch,
)
from shakerproc.studies import read_study, run_study

ROOT = Path(__file__).resolve().parents[2]
STUDIES = ROOT / "configs" / "studies"

MODEL = """\
model: 1
title: test
masses: {m: 1 kg}
elements:
  - {kind: gap, between: [base, m], stiffness: 1000 N/m, clearance: 0.5 mm}
  - {kind: damper, between: [base, m], damping: 0.6 N s/m}
excitation: {force on: m}
"""

STUDY = """\
study: 1
title: a grid
kind: grid
model: model.yaml
run: {excitation: sine sweep, level: 5 N, from: 0 Hz, to: 10 Hz, duration: 2 s,
      sample rate: 100 Hz}
measure: {ensemble: 0}
vary:
  - {name: a, set: elements.gap.clearance, values: [0.5 mm, 1 mm]}
"""

LOG = """\
testlog: 1
title: t
recordings: .
channels: {force: {role: force}, ch: {role: response, at: m, unit: m/s^2}}
tests:
  - {id: 1, recording: one.tdms, excitation: sine, level: 1 N, frequency: 5 Hz}
"""

BAD = ("nan", "inf", "-inf", "1e300", "-1e300", "1e-300", "-1")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.yaml").write_text(MODEL)
    (tmp_path / "study.yaml").write_text(STUDY)
    (tmp_path / "log.yaml").write_text(LOG)
    return tmp_path


def command(*arguments):
    return CliRunner().invoke(build_app(), [str(argument) for argument in arguments])


def refused(done):
    """Whether a command ended in a message: an error of ours, or one of usage."""
    if done.exit_code == 2:
        return "Invalid value" in done.output
    return isinstance(done.exception, ShakerprocError) and "\n" not in str(done.exception)


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize(
    ("key", "unit"),
    [("1 kg", "kg"), ("1000 N/m", "N/m"), ("0.6 N s/m", "N s/m"), ("0.5 mm", "mm")],
)
def test_a_model_beyond_physics_is_refused_with_its_line(folder, key, unit, bad):
    (folder / "model.yaml").write_text(MODEL.replace(key, f"{bad} {unit}"))
    with pytest.raises(ShakerprocError, match=r"model\.yaml:[356]:\d+: ") as caught:
        read_model(folder / "model.yaml")
    assert f"{bad} {unit}" in str(caught.value)


@pytest.mark.parametrize("bad", BAD)
@pytest.mark.parametrize(
    "key", ["level: 5 N", "to: 10 Hz", "duration: 2 s", "sample rate: 100 Hz", "0.5 mm"]
)
def test_a_study_beyond_physics_is_refused_before_it_runs(folder, key, bad):
    if key == "level: 5 N" and bad == "-1":
        return  # a force the other way is a force
    number = re.search(r"[\d.]+(?= )", key)[0]
    (folder / "study.yaml").write_text(STUDY.replace(key, key.replace(number, bad)))
    assert refused(command("study", "study.yaml", "--no-figures"))
    assert not list(folder.glob("*_study"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("level: 5 N", "level: 0 N", "level"),
        ("from: 0 Hz, to: 10 Hz", "from: 10 Hz, to: 5 Hz", "to above from"),
        ("duration: 2 s", "duration: 1e15 s", "samples"),
        ("level: 5 N, ", "", "level"),
    ],
)
def test_a_study_that_cannot_run_says_why_before_it_does(folder, old, new, message):
    (folder / "study.yaml").write_text(STUDY.replace(old, new))
    with pytest.raises(ShakerprocError, match=message):
        read_study(folder / "study.yaml")


@pytest.mark.parametrize("value", ["0 N", "1e300 N"])
def test_a_level_that_is_varied_is_looked_at_too(folder, value):
    vary = "{name: F, set: run.level, values: [5 N, BAD]}".replace("BAD", value)
    (folder / "study.yaml").write_text(
        STUDY.replace("{name: a, set: elements.gap.clearance, values: [0.5 mm, 1 mm]}", vary)
    )
    with pytest.raises(ShakerprocError, match=r"study\.yaml:9:\d+: vary"):
        read_study(folder / "study.yaml")


def test_a_range_whose_ends_cross_while_they_vary_is_refused(folder):
    vary = "{name: f, set: run.from, values: [1 Hz, 20 Hz]}"
    (folder / "study.yaml").write_text(
        STUDY.replace("{name: a, set: elements.gap.clearance, values: [0.5 mm, 1 mm]}", vary)
    )
    with pytest.raises(ShakerprocError, match="to above from"):
        read_study(folder / "study.yaml")


@pytest.mark.parametrize("bad", ["nan", "inf", "-inf", "1e300", "-1", "0"])
@pytest.mark.parametrize("option", ["--from-hz", "--to-hz"])
def test_a_band_beyond_physics_is_wrong_usage(folder, option, bad):
    assert refused(command("response", "model.yaml", "--level", "5 N", option, bad))


@pytest.mark.parametrize("bad", [*(f"{one} N" for one in BAD), "0 N", "5 g"])
def test_a_level_beyond_physics_is_wrong_usage(folder, bad):
    assert refused(command("response", "model.yaml", "--level", bad))


@pytest.mark.parametrize("order", [-3, 0, 1, 1000])
def test_an_order_beyond_reason_is_wrong_usage(folder, order):
    assert refused(command("response", "model.yaml", "--level", "5 N", "--subharmonic", order))


@pytest.mark.parametrize(
    "option", ["--sample-rate-hz", "--duration-s", "--lead-in-s", "--lead-out-s"]
)
@pytest.mark.parametrize("bad", ["nan", "inf", "-1", "1e300"])
def test_simulate_refuses_absurd_lengths(folder, option, bad):
    done = command("simulate", "model.yaml", "log.yaml", option, bad, "--out", "out")
    assert refused(done)


def test_more_harmonics_than_half_the_samples_are_evaluated_exactly():
    """33 harmonics on 64 samples: as those of more samples, every eighth one."""
    elements = (
        Element(EFFECTS["gap"](stiffness=1000.0, clearance=5e-4), ("base", "m")),
        Element(EFFECTS["damper"](damping=2.0), ("base", "m")),
    )
    model = Model("gap", {"m": 1.0}, elements, Excitation("force", "m"))
    found = frequency_response(model, 5.0, from_hz=4.0, to_hz=4.2, harmonics=33)
    few, many = (samples_of_branch(found.branches[0], n) for n in (64, 512))
    assert_allclose(few, many[..., ::8], atol=1e-12 * np.max(np.abs(many)))


def chain(count, *laws):
    elements = [
        Element(effect, ("base" if i == 0 else f"m{i - 1}", f"m{i}"))
        for i in range(count)
        for effect in (EFFECTS["spring"](stiffness=1e6), EFFECTS["damper"](damping=5.0))
    ]
    elements += [Element(law, ("base", "m0")) for law in laws]
    masses = {f"m{i}": 0.1 for i in range(count)}
    return Model("chain", masses, tuple(elements), Excitation("base acceleration"))


def test_a_linear_model_of_many_masses_is_solved_and_not_followed():
    """Against the mechanical impedance from the free end, which needs no matrix."""
    found = frequency_response(chain(12), 2.0, from_hz=20.0, to_hz=900.0)
    (branch,) = found.branches
    assert found.not_followed == ()
    columns = response_columns(found)
    assert len(columns["frequency_hz"]) > 400
    for i in range(0, branch.frequency.size, 97):
        omega = 2.0 * np.pi * branch.frequency[i]
        link, carried = 1e6 + 5.0j * omega, 0.0
        for _ in range(12):  # force to move the near end of a link by 1 m, from the far end
            carried = 1.0 / (1.0 / link + 1.0 / (carried - 0.1 * omega**2))
        table = -2.0 / omega**2
        first = table * (1.0 - carried / link)  # the absolute motion of the first mass
        assert_allclose(branch.coefficients[i, 0, 0], first - table, rtol=1e-6)
    assert branch.stable.all()


def test_a_nonlinear_model_that_is_too_large_says_what_would_fit():
    cubic = EFFECTS["cubic_stiffness"](coefficient=1e12)
    with pytest.raises(ModelError, match=r"6400 unknowns.* Take at most 9 harmonics"):
        frequency_response(chain(200, cubic), 1.0, from_hz=1.0, to_hz=100.0)


def test_a_model_without_a_spring_is_told_at_once(folder):
    text = re.sub(r".*kind: gap.*\n", "", MODEL)
    (folder / "model.yaml").write_text(text)
    done = command("response", "model.yaml", "--level", "1 N")
    assert refused(done)
    assert "no spring holds a mass" in " ".join(done.output.replace("│", " ").split())
    wide = command(
        "response", "model.yaml", "--level", "1 N", "--from-hz", 1, "--to-hz", 5, "--no-figures"
    )
    assert wide.exit_code == 0, wide.output


def test_a_rate_that_would_take_for_ever_is_refused_at_once():
    elements = (
        Element(EFFECTS["gap"](stiffness=1000.0, clearance=1e-3), ("base", "m")),
        Element(EFFECTS["damper"](damping=1e12), ("base", "m")),
    )
    model = Model("stiff", {"m": 1.0}, elements, Excitation("force", "m"))
    with pytest.raises(ShakerprocError, match=r"1e\+12 1/s, takes .* steps in a sample"):
        simulate(model, np.ones(100), 5000.0)


def test_every_ready_made_study_still_reads():
    for path in STUDIES.glob("*.yaml"):
        read_study(path)
    assert run_study(read_study(STUDIES / "figure_3_10.yaml")).outcome == "held"
