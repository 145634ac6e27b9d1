"""Study files: every mistake named with its line, every value where it belongs."""

from pathlib import Path

import pytest

from shakerproc.errors import DocumentError
from shakerproc.studies import StudyRun, read_study
from shakerproc.studies.kinds import KINDS
from shakerproc.studies.kinds.base import jobs_of
from shakerproc.studies.study import placed, unit_of_place

CONFIGS = Path(__file__).resolve().parents[2] / "configs" / "studies"

MODEL = """\
model: 1
title: test
masses: {mass: 1 kg}
elements:
  - {kind: gap, between: [base, mass], stiffness: 1000 N/m, clearance: 0.5 mm}
  - {kind: damper, between: [base, mass], damping_ratio: 0.01}
excitation: {force on: mass}
"""

STUDY = """\
study: 1
title: a grid
kind: grid
model: model.yaml
run: {excitation: sine sweep, level: 5 N, from: 0 Hz, to: 10 Hz, duration: 5 s}
vary:
  - {name: a, set: elements.gap.clearance, values: [0.5 mm, 1 mm]}
  - {name: k, set: elements.0.stiffness, values: [1 kN/m, 2 kN/m]}
claim: {statement: it falls, falls with: a}
"""


@pytest.fixture
def write(tmp_path):
    def written(text, model=MODEL):
        (tmp_path / "model.yaml").write_text(model)
        path = tmp_path / "study.yaml"
        path.write_text(text)
        return path

    return written


def test_a_study_is_every_combination(write):
    study = read_study(write(STUDY))
    jobs = jobs_of(study)
    assert [job.values for job in jobs] == [
        (5e-4, 1000.0),
        (5e-4, 2000.0),
        (1e-3, 1000.0),
        (1e-3, 2000.0),
    ]
    assert jobs[3].model.elements[0].effect.clearance == 1e-3
    assert jobs[3].model.elements[0].effect.stiffness == 2000.0
    assert jobs[3].texts == ("1 mm", "2 kN/m")
    assert study.run.level == 5.0
    (check,) = study.claim.checks
    assert (check.quantity, check.relation, check.along) == ("peak_frequency_hz", "falls", "a")


@pytest.mark.parametrize(
    ("change", "line", "message"),
    [
        (("kind: grid", "kind: grd"), 3, 'did you mean "grid"'),
        (("model: model.yaml", "model: none.yaml"), 4, "expected a model file in"),
        (("model: model.yaml", "model: ../model.yaml"), 4, "expected a model file in"),
        (("level: 5 N", "level: 5 g"), 5, "expected a number with a unit of N"),
        (("to: 10 Hz", "to: 0 Hz"), 5, "needs from and to, with to above from"),
        (("duration: 5 s", "duration: 5 s, spacing: octaves"), 5, "cannot begin at 0 Hz"),
        (("duration: 5 s", "duration: 5"), 5, "expected a number with a unit of s"),
        (("elements.gap.clearance", "elements.gp.clearance"), 7, "no element 'gp'"),
        (("elements.gap.clearance", "elements.gap.gap"), 7, "no parameter of gap 'gap'"),
        (("elements.gap.clearance", "masses.coupon"), 7, "no mass 'coupon'"),
        (("elements.gap.clearance", "run.lvl"), 7, "no key of the run 'lvl'"),
        (("elements.gap.clearance", "clearance"), 7, "expected a place such as"),
        (("0.5 mm, 1 mm", "0.5 mm, 1"), 7, "expected a number with a unit of m"),
        (
            ("set: elements.gap.clearance", "set: [elements.gap.clearance, run.level]"),
            7,
            "places of one unit belong together",
        ),
        (("falls with: a", "falls with: b"), 9, "expected one of 'a', 'k', got 'b'"),
        (("falls with: a", "falls with: a, rises with: k"), 9, "not both"),
        (("claim:", "options: {x: 1}\nclaim:"), 9, "knows no options, not 'x'"),
        (("claim:", "clam:"), 9, "claim"),
        (("falls with: a", "checks: [{}]"), 9, "got none"),
        (("falls with: a", "checks: [{above: 3}]"), 9, "expected a number with a unit of Hz"),
        (("falls with: a", "checks: [{above: 3 Hz, below: 4 Hz}]"), 9, "above and below"),
        (("falls with: a", "checks: [{equals: 3 Hz}]"), 9, "equals needs a tolerance"),
        (
            ("falls with: a", "checks: [{quantity: omega_hz, above: 3 Hz}]"),
            9,
            "peak_frequency_hz",
        ),
        (("falls with: a", "checks: [{equals: 3 Hz, within: -2 %}]"), 9, "at least 0"),
        (
            ("falls with: a", "checks: [{changes with: b}]"),
            9,
            "expected one of 'a', 'k', got 'b'",
        ),
        (("falls with: a", "quantity: growth"), 9, "belongs to falls with or rises with"),
    ],
)
def test_mistakes_are_named_with_their_line(write, change, line, message):
    assert change[0] in STUDY
    with pytest.raises(DocumentError, match=message) as caught:
        read_study(write(STUDY.replace(*change)))
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("study: 1\ntitle: t\nkind: grid\nmodel: model.yaml\n", "needs the key 'run'"),
        ("study: 1\ntitle: t\nkind: force law\n", "needs the key 'model'"),
        ("study: 1\ntitle: t\nkind: formula\n", "formula: expected one of magnification"),
        (
            "study: 1\ntitle: t\nkind: formula\nformula: magnification\n"
            "vary: [{name: a, set: run.level, values: [1 N]}]\n",
            "a study without a model varies nothing",
        ),
        (
            "study: 1\ntitle: t\nkind: force law\nmodel: model.yaml\noptions: {to: 1}\n",
            "options.to: expected a number with a unit of m",
        ),
    ],
)
def test_what_a_kind_needs_is_asked_for(write, text, message):
    with pytest.raises(DocumentError, match=message):
        read_study(write(text))


DRIVEN = "run: {excitation: sine, level: 5 N, frequency: 5 Hz}\n"
VARIED = "vary: [{name: F, set: run.level, values: [1 N, 2 N]}]\n"


@pytest.mark.parametrize(
    ("kind", "rest", "place", "message"),
    [
        ("response", DRIVEN + "options: {from: 13 Hz, to: 10 Hz}", (6, 10), "to above from"),
        ("response", DRIVEN + "options: {from: 10 Hz, to: 10 Hz}", (6, 10), "to above from"),
        ("response", DRIVEN + "options: {from: 0 Hz, to: 9 Hz}", (6, 17), "expected a value"),
        ("response", DRIVEN + "options: {harmonics: 0}", (6, 22), "a whole number from 1"),
        ("response", DRIVEN + "options: {harmonics: 2.5}", (6, 22), "a whole number from 1"),
        ("response", DRIVEN, (5, 6), "from above 0 Hz"),
        (
            "response",
            "run: {excitation: sine, level: -1 N, from: 1 Hz, to: 9 Hz}\n",
            (5, 6),
            "a level above 0, not -1",
        ),
        (
            "response",
            "options: {from: 1 Hz, to: 9 Hz}\n" + DRIVEN + VARIED.replace("2 N", "-2 N"),
            (7, 8),
            "a level above 0, not -2",
        ),
        ("backbone", "options: {from: 5 mm, to: 1 mm}", (5, 10), "to above from"),
        ("force law", "options: {points: 1}", (5, 19), "a whole number from 3"),
        ("force law", "options: {to: 0 mm}", (5, 15), "expected a value from"),
        ("poincare", DRIVEN + "options: {periods: 0}", (6, 20), "a whole number from 1"),
        ("poincare", DRIVEN + "options: {phases: 0}", (6, 19), "a whole number from 1"),
        (
            "poincare",
            DRIVEN.replace("frequency: 5 Hz", "from: 1 Hz"),
            (5, 6),
            "frequency above",
        ),
        (
            "bifurcation",
            "run: {excitation: random, level: 5 N, from: 1 Hz, to: 9 Hz}\n" + VARIED,
            (5, 6),
            "needs a sine, not random",
        ),
        ("spectrogram", DRIVEN + "options: {segment: 1e7}", (6, 10), "no segment of 1e"),
        ("grid", DRIVEN + VARIED + "measure: {from: 9 Hz, to: 5 Hz}", (7, 10), "to above from"),
        (
            "spectra",
            DRIVEN + "measure: {estimator: welch, segment: 1000000}",
            (6, 10),
            "no segment of 1000000",
        ),
    ],
)
def test_what_no_job_of_a_kind_can_use_is_named_at_its_place(write, kind, rest, place, message):
    with pytest.raises(DocumentError, match=message) as caught:
        read_study(write(f"study: 1\ntitle: t\nkind: {kind}\nmodel: model.yaml\n{rest}\n"))
    assert (caught.value.line, caught.value.column) == place, str(caught.value)


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_ready_made_study_is_valid(path):
    study = read_study(path)
    assert study.kind in KINDS
    assert jobs_of(study)
    assert study.title


def test_the_ready_made_studies_cover_the_figures_of_the_thesis():
    drawn = {
        figure.strip()
        for path in CONFIGS.glob("*.yaml")
        for figure in read_study(path).figure.split(",")
    }
    chapters = {
        3: (1, 3, 5, 6, 7, 9, 10),
        4: range(2, 20),
        5: (7, 14),
        6: (8, 9, 10, 12, 13, 14),
    }
    wanted = {
        f"{chapter}.{number}" for chapter, numbers in chapters.items() for number in numbers
    }
    assert wanted <= drawn


def test_places_of_a_run_and_of_masses(write):
    study = read_study(write(STUDY))
    assert unit_of_place(study.model, "run.initial velocity") == "m/s"
    assert unit_of_place(study.model, "run.level") == "N"
    assert unit_of_place(study.model, "masses.mass") == "kg"
    model, run = placed(study.model, study.run, ["run.seed", "run.to"], 7.0)
    assert (run.seed, run.to_hz) == (7, 7.0)
    assert isinstance(run.seed, int)
    model, run = placed(model, StudyRun("free"), ["masses.mass"], 2.0)
    assert model.masses["mass"] == 2.0
