"""What the old search does not know is refused in one line, before any work."""

from dataclasses import replace

import pytest

from shakerproc.diagnose.candidates import sought
from shakerproc.diagnose.translate import skeleton
from shakerproc.errors import DiagnosisError
from shakerproc.models import EFFECTS, Element, Excitation, Mode, Model, Sensor

PLACE = ("base", "rod")
SPRING = Element(EFFECTS["spring"](stiffness=1e5), PLACE)


def model(*more, **changes):
    plain = Model(
        "rod", {"rod": 0.1}, (SPRING, *more), Excitation("base acceleration"),
        {"ch3": Sensor("rod")},
    )  # fmt: skip
    return replace(plain, **changes)


REFUSED = {
    "the model has modes": model(modes=(Mode(500.0, 0.01, 1e-3, {"rod": 1.0}),)),
    "a joint has a negative stiffness": model(
        Element(EFFECTS["spring"](stiffness=-2e5), PLACE),
        Element(EFFECTS["cubic_stiffness"](coefficient=1e12), PLACE),
    ),
    "the excitation is imposed displacement": model(
        excitation=Excitation("imposed displacement", "rod"),
        sensors={"ch3": Sensor("rod", "force")},
    ),
}


@pytest.mark.parametrize("found", REFUSED)
def test_a_model_that_the_search_would_misread_is_refused(found):
    with pytest.raises(DiagnosisError, match=rf"rod: {found}, which .* Take it out, or use"):
        skeleton(REFUSED[found], ("ch3",))


def test_a_model_that_it_knows_is_not():
    assert skeleton(model(), ("ch3",)).sensors == ("ch3",)


def test_effects_without_a_candidate_are_not_sought():
    by_hand = {"spring", "damper", "jump_gap", "power_law_damping"}
    new = {"constant_force", "series", "table", "general_bouc_wen", "power_iwan"}
    assert set(EFFECTS) - sought() == by_hand | new
