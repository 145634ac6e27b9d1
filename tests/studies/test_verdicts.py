"""Verdicts are the outcome of checks: another parameter gives another verdict."""

import re
from dataclasses import replace
from math import inf, nan, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shakerproc.models import EFFECTS, Element, Model
from shakerproc.studies import read_study, run_study
from shakerproc.studies.kinds import KINDS
from shakerproc.studies.kinds.base import JobFinding, jobs_of
from shakerproc.studies.readings import period_of
from shakerproc.studies.results import (
    Checked,
    above,
    below,
    equals,
    sentence_of,
    trends,
    verdict_of,
)
from shakerproc.studies.study import Claim
from shakerproc.verification import thesis_claims
from shakerproc.verification.base import ClaimFinding

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs" / "studies"
QUIET = {"level": 1e-6, "initial_velocity": 0.0, "initial_displacement": 0.0}


def verdict(name, *, vary=None, model=None, options=None, **run):
    """The verdict of a ready-made study with parts of it changed."""
    study = read_study(CONFIGS / f"{name}.yaml")
    if run:
        study = replace(study, run=replace(study.run, **run))
    if model is not None:
        study = replace(study, model=model(study.model))
    if vary is not None:
        study = replace(study, vary=vary(study.vary))
    if options is not None:
        study = replace(study, options=options)
    return run_study(study).outcome


def with_exponent(exponent):
    def changed(model):
        elements = [
            Element(replace(e.effect, exponent=exponent), e.between)
            if e.effect.kind == "power_law"
            else e
            for e in model.elements
        ]
        return replace(model, elements=tuple(elements))

    return changed


def with_a_second_mass(model):
    """Two linear masses: two natural frequencies at once."""
    spring = EFFECTS["spring"](stiffness=1e4)
    elements = (
        Element(EFFECTS["spring"](stiffness=1e4), ("base", "mass")),
        Element(spring, ("mass", "other")),
    )
    return Model("two", {"mass": 1.0, "other": 0.7}, elements, model.excitation)


def with_values(vary, *values):
    """The one variation of a study with other values."""
    (variation,) = vary
    return (replace(variation, values=values, texts=tuple(str(v) for v in values)),)


FLIPPED = [
    ("figure_4_17", "held", {**QUIET}, "did not hold"),
    (
        "figure_4_14",
        "held",
        {"vary": lambda v: with_values(v, 1e-6, 2e-6), **QUIET},
        "did not hold",
    ),
    ("figure_4_08", "held", {"model": with_exponent(1.0)}, "held in part"),
    (
        "figure_4_07",
        "did not hold",
        {"model": with_a_second_mass, "vary": lambda _: ()},
        "held",
    ),
    ("figure_4_13", "held", {"options": (("to", 1.5e-3), ("load", 5.0))}, "did not hold"),
    ("figure_3_07", "held", {"vary": lambda v: with_values(v, 1.0, 1.0)}, "did not hold"),
    ("figure_5_07", "held", {"to_hz": 40.0}, "held in part"),
    ("figure_5_07", "held", {"octaves": True}, "did not hold"),
    ("figure_5_07", "held", {"down": True}, "held in part"),
    ("power_law_poincare", "held", {**QUIET}, "did not hold"),
    ("figure_6_08", "did not hold", {"level": 500.0}, "held"),
]


@pytest.mark.parametrize(
    ("name", "before", "changed", "after"), FLIPPED, ids=[row[0] for row in FLIPPED]
)
def test_another_parameter_gives_another_verdict(name, before, changed, after):
    assert verdict(name) == before
    found = verdict(name, **changed)
    assert found != before
    assert found == after


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_no_ready_made_study_types_a_verdict(path):
    """Words of the file are captions; a statement without checks is not checked."""
    study = read_study(path)
    if study.claim is None:
        return
    assert not re.match(r"(held|did not hold)", study.claim.comment)
    assert study.claim.checks
    for check in study.claim.checks:
        assert check.quantity in KINDS[study.kind].quantities


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_a_kind_without_a_claim_or_without_checks_is_not_checked(kind):
    assert verdict_of(()) == "not checked"
    assert sentence_of(()) == "not checked"
    assert set(kind.quantities)


RUN_IN_TIME = ("grid", "spectra", "motion", "bifurcation", "poincare", "spectrogram")


@pytest.mark.parametrize("name", RUN_IN_TIME)
def test_chaos_is_flagged_in_every_kind_that_runs_a_model_in_time(name):
    """Figure 4.18 is chaotic: so says each kind that can show it."""
    study = read_study(CONFIGS / "figure_4_18.yaml")
    shown = read_study(CONFIGS / "figure_4_16.yaml").vary[0]
    one = replace(shown, values=(15.0,), texts=("15 N",))
    chaotic = replace(
        study,
        kind=name,
        vary=(one,) if "vary" in KINDS[name].needs else (),
        measure=replace(study.measure, ensemble=0),
        options=(("periods", 200.0), ("settle periods", 100.0)) if "p" in name else (),
        claim=None,
    )
    (note,) = run_study(chaotic).notes
    assert "1 of 1 runs are chaotic" in note
    assert "of a single run" in note
    quiet = replace(chaotic, run=replace(study.run, **QUIET), vary=())
    if "vary" not in KINDS[name].needs:
        assert run_study(quiet).notes == ()


def test_kinds_that_run_in_time_are_those_that_know_of_chaos():
    """A new kind that has a run declares whether it is chaotic, or is no run in time."""
    assert {n for n, kind in KINDS.items() if "chaotic" in kind.quantities} == set(RUN_IN_TIME)
    no_time = {"response", "backbone", "force law", "formula"}
    assert set(KINDS) == set(RUN_IN_TIME) | no_time


def test_a_kind_finds_every_quantity_that_it_declares():
    for name in ("figure_4_06", "figure_4_08", "figure_3_03", "figure_3_10", "gap_backbone"):
        study = read_study(CONFIGS / f"{name}.yaml")
        found = KINDS[study.kind].compute(study, jobs_of(study)[0])
        assert isinstance(found, JobFinding)
        assert set(found.quantities) == set(KINDS[study.kind].quantities)


finite = st.floats(-1e6, 1e6)


@given(st.lists(finite, min_size=1, max_size=6), finite, st.floats(0.0, 1e3))
def test_a_bound_holds_for_what_lies_on_its_side(values, bound, within):
    """Each value counts by itself; the verdict is all, some or none of them."""
    for check, true in (
        (above("x", values, bound), [v > bound for v in values]),
        (below("x", values, bound), [v < bound for v in values]),
        (equals("x", values, bound, within), [abs(v - bound) <= within for v in values]),
    ):
        assert (check.passed, check.of) == (sum(true), len(true))
        wanted = "held" if all(true) else "held in part" if any(true) else "did not hold"
        assert verdict_of([check]) == wanted
        assert ClaimFinding("", (check,)).held == wanted


@given(st.lists(finite, min_size=2, max_size=8, unique=True), st.floats(0.0, 10.0))
def test_a_trend_turns_with_its_values(values, slack):
    x = np.arange(float(len(values)))
    y, room = np.array(values), np.full(len(values), slack)
    one = trends("x", [(x, y, room)], "falls", "a")
    other = trends("x", [(x, -y, room)], "rises", "a")
    assert one.held == other.held
    assert not (one.held and trends("x", [(x, y, room)], "rises", "a").held)
    if one.held:
        assert trends("x", [(x, y, room)], "changes", "a").held
        assert y[-1] - y[0] < -slack


@pytest.mark.parametrize("missing", [nan, inf])
def test_what_is_not_known_does_not_hold(missing):
    x, room = np.arange(3.0), np.zeros(3)
    y = np.array([1.0, missing, 3.0])
    for wanted in ("falls", "rises", "changes"):
        assert not trends("x", [(x, y, room)], wanted, "a").held
    assert not equals("x", nan, 1.0, 10.0).held
    assert not above("x", nan, -inf).held
    assert not below("x", nan, inf).held


def test_a_check_says_quantity_value_wanted_and_tolerance():
    assert str(equals("f_hz", [5.0, 7.0], 5.1, 0.02, relative=True)) == (
        "f_hz 5, 7 (wanted: 5.1 within 2 %, so in 1 of 2)"
    )
    assert sentence_of([below("x", 3.0, 2.0)]) == "did not hold: x 3 (wanted: below 2)"


def test_a_period_is_found_however_long_it_is():
    turn = 2.0 * pi / 5.0 * np.arange(48)
    assert period_of(np.cos(turn), np.sin(turn)) == 5.0
    assert period_of(np.cos(turn * 0.913), np.sin(turn * 0.913)) == inf
    assert period_of(np.ones(8), np.zeros(8)) == 1.0


SAME = {
    "figure_3_01": ("sec. 3.1, fig. 3.1", "more damping"),
    "figure_3_10": ("eq. 3.42, 3.49", "the frequency"),
    "figure_4_06": ("sec. 4.2", "nonlinearity gives rise"),
    "figure_4_09": ("fig. 4.9", "omega_e rises with the exponent n (from rest"),
    "figure_4_09_listing": ("fig. 4.9", "omega_e rises with the exponent n (with the listing"),
    "figure_4_12": ("fig. 4.12", "omega_e falls"),
    "figure_5_14": ("sec. 5.2.2, eq. 5.5", "1 g at 400 Hz"),
    "figure_6_10": ("fig. 6.10", "omega_e of the cubic joint"),
}


@pytest.mark.parametrize("name", SAME)
def test_a_figure_has_one_verdict_wherever_it_is_asked_for(name):
    """The study and the table of claims judge one figure alike (all: `make verdicts`)."""
    where, says = SAME[name]
    page = (ROOT / "docs" / "thesis_claims.md").read_text(encoding="utf-8")
    (row,) = [r for r in page.splitlines() if r.startswith(f"| {where} | {says}")]
    assert row.endswith(f"| {verdict(name)} |")


def test_every_statement_of_the_thesis_is_checked():
    """None of the functions types its verdict: `ClaimFinding` has no place for one."""
    assert not {"held"} & set(ClaimFinding.__slots__)
    cheap = [c for c in thesis_claims() if c.where.startswith(("eq.", "sec. 3", "table"))]
    for claim in cheap[:8]:
        outcome = claim.outcome()
        assert outcome.checks
        assert all(isinstance(check, Checked) for check in outcome.checks)
        assert outcome.held == verdict_of(outcome.checks)


def test_a_claim_may_go_unchecked_but_then_says_so():
    study = replace(read_study(CONFIGS / "figure_3_10.yaml"), claim=Claim("it is so"))
    assert run_study(study).verdict == "not checked"
