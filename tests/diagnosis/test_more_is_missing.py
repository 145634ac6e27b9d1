"""A force that the library lacks beside one that it has, on simulated component tests."""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.component import ROD, component, rod
from tests.few_effects import FEW, seek_few

from shakerproc.diagnosis import component_tests, diagnose_arrays
from shakerproc.diagnosis.adding import add_to_arrays
from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation.intervals import linear_estimates
from shakerproc.diagnosis.headline import probability_text
from shakerproc.diagnosis.wanted import Wanted
from shakerproc.models import EFFECTS, Element

FRICTION = 20.0


def both(x, v):
    """Return dry friction, and a force that waves with the displacement, in no library [N]."""
    return FRICTION * np.sign(v) + 25.0 * np.sin(2.0 * np.pi * x / 4e-4)


def waves(x, _):
    """Return the second of these alone."""
    return both(x, 0.0)


@pytest.fixture(scope="module")
def found():
    return judged(both)


def judged(law):
    with pytest.MonkeyPatch.context() as patch:
        seek_few(patch)
        return diagnose_arrays(rod(), pair_of(law))


def pair_of(law):
    return [component(law, 1), component(law, 2)]


def told(sentence):
    return set(re.findall(r"\d\.\d+", sentence))


def test_the_part_that_the_library_has_is_named_and_that_more_is_missing(found):
    assert found.verdict == "effect found"
    (effect,) = found.effects
    assert effect.kind == "coulomb_friction"
    assert effect.parameters["sliding_force"].value == pytest.approx(FRICTION, rel=0.1)
    assert found.errors.held_out.after <= 0.9 * found.errors.without
    assert not found.complete
    assert "More is missing" in found.sentence
    assert found.confidence is None
    assert probability_text(found).startswith("no probability: more is missing")


def test_its_sentence_quotes_the_errors_that_are_printed(found):
    errors = found.errors
    printed = (
        errors.held_out.before, errors.without, errors.held_out.after, errors.noise_floor
    )  # fmt: skip
    assert {f"{one:.3g}" for one in printed} <= told(found.sentence)


def test_what_is_named_can_be_added_with_the_gain_that_was_promised(found):
    added = add_to_arrays(Wanted("coulomb_friction", ROD), rod(), pair_of(both))
    assert added.errors.held_out.after == pytest.approx(found.errors.held_out.after, rel=1e-3)


def test_where_nothing_can_be_named_every_candidate_was_fitted():
    found = judged(waves)
    assert found.verdict == "cannot tell"
    assert {one.kind for one in found.candidates} == FEW
    errors = [one.held_out_error for one in found.candidates]
    assert min(errors) > 0.9 * found.errors.held_out.after  # as the sentence says
    assert f"leaves {found.errors.held_out.after:.3g} of" in found.sentence
    assert found.confidence is None


@pytest.mark.parametrize("damping", [0.5, 50.0, 5e3])
def test_the_linear_part_of_a_component_test_does_not_depend_on_the_damping_of_the_file(
    damping,
):
    """By least squares of the force on displacement and velocity."""
    tests = pair_of(lambda _, v: FRICTION * np.sign(v))
    spring = rod().elements[0]
    given = replace(rod(), elements=(spring, Element(EFFECTS["damper"](damping), ROD)))
    data = campaign_of(given, prepared(tests, imposed=True)).data
    fit = component_tests.linear_fit(data, component_tests.form_of(data))
    fitted = {name.split()[0]: one.value for name, one in linear_estimates(fit).items()}
    x, force = tests[0].controls[0], tests[0].responses[0]
    wanted, *_ = np.linalg.lstsq(np.c_[x, np.gradient(x, 1e-3)], force, rcond=None)
    assert [fitted["stiffness"], fitted["damping"]] == pytest.approx(wanted, rel=0.02)
