"""What a model must be to be simulated, and what an element takes from its surroundings."""

import pickle

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ModelError
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.coordinates import parallel_stiffness, reduced_mass, resolved
from shakerproc.models.effects import (
    AttachedMode,
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    QuadraticStiffness,
    Spring,
    StiffnessDrift,
    Stop,
)

GROUND = ("base", "a")
SHAKEN = Excitation("base acceleration")


def model(*effects, masses=None, between=None, **more):
    masses = masses or {"a": 2.0}
    elements = tuple(
        Element(effect, (between or {}).get(i, GROUND)) for i, effect in enumerate(effects)
    )
    return Model("m", masses, elements, more.pop("excitation", SHAKEN), more.pop("sensors", {}))


REFUSED = [
    ({"masses": {"base": 1.0}}, [Spring(1.0)], "base is the shaker table"),
    ({"between": {0: ("base", "b")}}, [Spring(1.0)], "no place 'b'"),
    ({"between": {0: ("base", "coupn")}, "masses": {"coupon": 1.0}}, [Spring(1.0)],
     "did you mean 'coupon'"),
    ({"between": {0: ("a", "a")}}, [Spring(1.0)], "between a and itself"),
    ({}, [AttachedMode(1.0, 1.0, 0.0)], "no chain of elements leads from a to the base"),
    ({"masses": {"a": 1.0, "b": 1.0}, "between": {1: ("a", "b")}},
     [AttachedMode(1.0, 1.0, 0.0), Spring(1.0)], "no chain of elements"),
    ({"between": {1: ("a", "base")}}, [Spring(1.0), AttachedMode(1.0, 1.0, 0.0)],
     "attached mode on the base"),
    ({"sensors": {"x": Sensor("b")}}, [Spring(1.0)], "sensor x: no place 'b'"),
    ({"excitation": Excitation("force", "base")}, [Spring(1.0)], "the mass that it acts on"),
    ({"excitation": Excitation("force", "b")}, [Spring(1.0)], "excitation: no place 'b'"),
    ({}, [Spring(-1.0)], "drives the mass away .* positive side"),
    ({}, [CubicStiffness(-1.0)], "drives the mass away"),
    ({}, [QuadraticStiffness(1.0)], "drives the mass away .* negative side"),
    ({}, [Damper(damping_ratio=0.1)], "takes the stiffness of the spring in parallel"),
    ({}, [StiffnessDrift(0.1, 0.0)], "takes the stiffness of the spring in parallel"),
]  # fmt: skip


@pytest.mark.parametrize(("more", "effects", "message"), REFUSED)
def test_a_model_that_cannot_stand_is_refused(more, effects, message):
    with pytest.raises(ModelError, match=message):
        model(*effects, **more)


def test_a_model_without_masses_is_refused():
    with pytest.raises(ModelError, match="no masses"):
        Model("m", {}, (), SHAKEN)


@pytest.mark.parametrize(
    "effects",
    [
        [Spring(-1.0), CubicStiffness(1.0)],
        [Spring(-1.0), Gap(10.0, 0.1)],
        [Spring(5.0), CubicStiffness(-1.0)],
        [Spring(5.0), QuadraticStiffness(1.0)],
        [Gap(10.0, 0.1)],
        [Stop(10.0, 0.1, "positive"), Spring(1.0)],
    ],
)
def test_what_pushes_back_somewhere_may_stand(effects):
    model(*effects)


def test_a_negative_spring_may_stand_where_the_whole_is_stable():
    model(
        Spring(5.0), Spring(5.0), Spring(-1.0),
        masses={"a": 1.0, "b": 1.0}, between={1: ("base", "b"), 2: ("a", "b")},
    )  # fmt: skip


def test_wrong_arguments_are_the_callers_mistake():
    with pytest.raises(ValueError, match="two places"):
        Element(Spring(1.0), ("a",))
    with pytest.raises(ValueError, match="measures must be one of"):
        Sensor("a", "speed")
    with pytest.raises(ValueError, match="needs the mass it acts on"):
        Excitation("force")
    with pytest.raises(ValueError, match="kind must be"):
        Excitation("shaking")
    with pytest.raises(ValueError, match="mass of a must be above 0"):
        model(Spring(1.0), masses={"a": -1.0})


def test_the_damping_ratio_is_that_of_the_springs_in_parallel():
    damped = model(Spring(30.0), Damper(damping_ratio=0.1), Spring(20.0), Gap(1e5, 0.1))
    damping = resolved(damped)[1].effect.damping
    assert_allclose(damping, 2.0 * 0.1 * np.sqrt(50.0 * 2.0))


def test_where_there_is_no_spring_the_contact_counts():
    damped = model(Gap(1000.0, 0.1), Damper(damping_ratio=0.01), masses={"a": 1.0})
    assert_allclose(resolved(damped)[1].effect.damping, 2.0 * 0.01 * np.sqrt(1000.0))


def test_between_two_masses_the_reduced_mass_counts():
    two = model(
        Spring(10.0), Spring(40.0), Damper(damping_ratio=0.5),
        masses={"a": 2.0, "b": 2.0}, between={1: ("a", "b"), 2: ("b", "a")},
    )  # fmt: skip
    assert reduced_mass(two, two.elements[2]) == 1.0
    assert parallel_stiffness(two, two.elements[2]) == 40.0
    assert_allclose(resolved(two)[2].effect.damping, np.sqrt(40.0))


def test_a_drift_takes_the_stiffness_beside_it():
    drifting = model(Spring(40.0), StiffnessDrift(-0.1, 0.0))
    assert resolved(drifting)[1].effect == StiffnessDrift(-0.1, 0.0, 40.0)
    own = model(Spring(40.0), StiffnessDrift(-0.1, 0.0, 7.0))
    assert resolved(own)[1].effect.stiffness == 7.0


def test_a_model_travels_to_another_process_and_cannot_be_changed():
    made = model(Spring(1.0), CoulombFriction(1.0), sensors={"x": Sensor("a")})
    assert pickle.loads(pickle.dumps(made)) == made  # noqa: S301
    with pytest.raises(TypeError, match="does not support item assignment"):
        made.masses["a"] = 2.0
