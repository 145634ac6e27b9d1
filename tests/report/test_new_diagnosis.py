"""What the report says of a diagnosis by free-run simulation."""

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from pydantic import TypeAdapter
from tests.report.test_evidence import DIAGNOSIS

from shakerproc.comparison.hidden_joints import Banded, HiddenJoint
from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.joint_outcomes import FurtherMode, Outside
from shakerproc.diagnosis.result import Diagnosis, Errors, Tried
from shakerproc.diagnosis.updated import updated_model
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.report.evidence import motion as drawing
from shakerproc.report.evidence.motion import effect_of
from shakerproc.report.evidence.numbers import interval, tables
from shakerproc.report.evidence.sections import diagnosis_section, error_ladder
from shakerproc.report.page.methods import methods_of

ALONG = Outside(
    ("base", "coupon"), (-1e-4, 0.0, 1e-4), (0.0,), ((-2.0,), (0.0,), (2.0,)),
    ((0.1,), (0.0,), (0.1,)),
)  # fmt: skip
ACROSS = Outside(
    ("base", "coupon"), (0.0,), (-0.1, 0.0, 0.1), ((-3.0, 0.0, 3.0),), ((0.1,) * 3,)
)
BOTH = Outside(
    ("base", "coupon"), (-1e-4, 0.0, 1e-4), (-0.1, 0.0, 0.1),
    tuple(tuple(2e4 * z + 30.0 * v for v in (-0.1, 0.0, 0.1)) for z in (-1e-4, 0.0, 1e-4)),
    ((0.0,) * 3,) * 3,
)  # fmt: skip


def errors(*horizons):
    old = DIAGNOSIS.errors
    told = {str(i): length for i, length in enumerate(horizons)}
    return Errors(old.fitted, old.held_out, old.noise_floor, told)


@pytest.mark.parametrize(("law", "lines"), [(ALONG, 3), (ACROSS, 3), (BOTH, 3)])
def test_a_law_without_a_name_is_drawn(law, lines):
    drawn = drawing.free_law(law)
    assert "base and coupon" in drawn.title
    x = np.linspace(-0.1, 0.1, 5) if len(law.displacement) == 1 else np.linspace(-1e-4, 1e-4, 5)
    curves = drawing.forces_along(law, x, along_velocity=len(law.displacement) == 1)
    assert len(curves) == lines
    if law is BOTH:  # linear in both: the spline goes through it exactly
        for (_, force), v in zip(curves, (-0.1, 0.0, 0.1), strict=True):
            np.testing.assert_allclose(force, 2e4 * x + 30.0 * v, atol=1e-12)


def test_the_report_shows_the_law_and_says_how_far_ahead_it_predicts():
    found = replace(
        DIAGNOSIS, verdict="outside library", effects=(), outside=ALONG, confidence=0.93,
        errors=errors(None, 0.5),
    )  # fmt: skip
    section = diagnosis_section(found, None)
    assert any("probability of 93 %" in text for text in section.paragraphs)
    assert "Missing force" in [part.title for part in section.parts]
    assert "windows of 0.5 s" in error_ladder(found).caption
    whole = replace(found, errors=errors(None))
    assert "of whole tests" in error_ladder(whole).caption


def band(size):
    return Banded(*((x, -x) for x in (size, 0.9 * size, 1.1 * size)))


def test_joints_that_no_recording_tells_are_drawn_with_bands_that_of_the_effect_first():
    hidden = tuple(
        HiddenJoint(("base", place), "2", (0.1, 0.2), band(size), band(2e5 * size))
        for place, size in (("foot", 3e-5), ("coupon", 2e-4))
    )
    found = replace(DIAGNOSIS, hidden=hidden)
    drawn = drawing.hidden(found, "translation")
    assert [one.title.split(",")[0] for one in drawn] == [
        "Displacement between base and coupon", "Force between base and coupon",
        "Displacement between base and foot", "Force between base and foot",
    ]  # fmt: skip
    assert ["[mm]" in one.drawing or "[µm]" in one.drawing for one in drawn[::2]] == [
        True,
        True,
    ]
    assert "[N]" in drawn[1].drawing
    table = tables(None, found)["hidden_joints.csv"]
    assert table["between"] == ["base - foot"] * 2 + ["base - coupon"] * 2
    assert table["displacement_high_m"][2] == pytest.approx(2.2e-4)
    assert table["force_low_n"][0] == pytest.approx(5.4)
    kept = TypeAdapter(Diagnosis).validate_json(json.dumps(asdict(found)))
    assert kept.hidden == hidden  # as a worker elsewhere sends it


def test_the_methods_name_the_way_of_the_diagnosis():
    told = methods_of([], diagnosed=True)
    assert any("free-run simulations" in text for text in told.paragraphs)
    assert any("Cameron" in text for text in told.references)


def test_the_updated_model_has_the_law_and_every_own_number_as_add_writes_them():
    joint = ("base", "coupon")
    made = (EFFECTS["spring"](1e5), EFFECTS["gap"](5e4, 1e-4), EFFECTS["damper"](3.0))
    model = Model(
        "x",
        {"coupon": 0.1},
        tuple(Element(e, joint) for e in made),
        Excitation("force", "coupon"),
    )
    numbers = {
        "stiffness base-coupon": (1.1e5, "N/m"), "gap.stiffness base-coupon": (4e4, "N/m"),
        "clearance base-coupon": (2e-4, "m"), "mass coupon": (0.12, "kg"),
    }  # fmt: skip
    found = replace(
        DIAGNOSIS, verdict="outside library", effects=(), outside=ALONG,
        modes=(FurtherMode(500.0, 0.01, 1e-3, {"coupon": 1.0}),),
        linear={name: Estimate(v, None, None, unit) for name, (v, unit) in numbers.items()},
    )  # fmt: skip
    new = updated_model(model, found)
    assert new.masses["coupon"] == 0.12
    assert new.elements[0].effect.stiffness == 1.1e5
    assert new.elements[1].effect == EFFECTS["gap"](4e4, 2e-4)
    assert new.elements[2] == model.elements[2]
    assert new.elements[3].effect.force == ALONG.force
    assert new.modes == model.modes  # further ones are written where `add --modes` asks


def test_a_candidate_of_two_elements_in_series_is_an_effect():
    numbers = {"stiffness": 1e5, "clearance": 1e-4, "sliding_force": 3.0}
    tried = Tried(
        "series", ("base", "coupon"), 0.1, 0.1,
        {name: Estimate(value, None, None, "") for name, value in numbers.items()},
    )  # fmt: skip
    assert effect_of(tried) == EFFECTS["series"].of_numbers(numbers)
    assert interval(tried.parameters["clearance"])[0]
