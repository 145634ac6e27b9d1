"""Which room judges a model."""

import pytest

from shakerproc.models import EFFECTS, Element, Excitation, Mode, Model, Sensor
from shakerproc.workflows.judging import needs_free_runs

JOINT = ("base", "coupon")
LINEAR = (
    Element(EFFECTS["spring"](stiffness=1e5), JOINT),
    Element(EFFECTS["damper"](damping=5.0), JOINT),
)


def model(*more, excitation=None, modes=(), sensor="acceleration"):
    return Model(
        "coupon", {"coupon": 0.1}, (*LINEAR, *more),
        excitation or Excitation("base acceleration"), {"ch3": Sensor("coupon", sensor)},
        modes=modes,
    )  # fmt: skip


def test_a_linear_model_is_judged_by_the_room_that_was_scored():
    assert not needs_free_runs(model())


@pytest.mark.parametrize(
    "more",
    [
        model(Element(EFFECTS["gap"](stiffness=1e6, clearance=1e-5), JOINT)),
        model(modes=(Mode(500.0, 0.01, 1e-3, {"coupon": 1.0}),)),
        model(excitation=Excitation("imposed displacement", "coupon"), sensor="force"),
    ],
    ids=["an effect already", "a further mode", "a component test"],
)
def test_what_that_room_does_not_know_is_judged_by_free_runs(more):
    assert needs_free_runs(more)
