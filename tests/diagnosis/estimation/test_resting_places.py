"""Where a motion whose mean was not measured lies: closed forms of the mean force."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnosis.estimation.resting_places import resting_places
from shakerproc.models import NO_CONDITIONS, Element, Excitation, Model, Sensor
from shakerproc.models.effects import EFFECTS, Spring

RATE, HZ, AMPLITUDE = 8192.0, 64.0, 1e-4
STIFFNESS = 1e4
TABLE = np.array([(0, 2000, 500), (0, 4000, 500)])
OF_MOTION = 0.02  # what 100 samples leave open of a mean, over the amplitude


def model(*effects, measures="acceleration"):
    elements = [Element(effect, ("base", "mass")) for effect in effects]
    return Model(
        title="one mass", masses={"mass": 0.1}, elements=tuple(elements),
        excitation=Excitation("base acceleration"),
        sensors={"top": Sensor("mass", measures)},
    )  # fmt: skip


def places_of(model, amplitude=AMPLITUDE):
    z = amplitude * np.sin(2.0 * np.pi * HZ * np.arange(8192) / RATE)
    motion = SimpleNamespace(displacement=z, velocity=np.gradient(z, 1.0 / RATE))
    test = SimpleNamespace(sample_rate=RATE, conditions=NO_CONDITIONS)
    data = SimpleNamespace(
        tests=[test], lengths=SimpleNamespace(unit_s=1.0 / HZ),
        across=lambda _joint: (motion,), largest_across=lambda _joint: amplitude,
    )  # fmt: skip
    return resting_places(data, model, TABLE)


def test_a_dead_weight_moves_the_mean_by_force_over_stiffness():
    found = places_of(model(Spring(STIFFNESS), EFFECTS["constant_force"](0.5)))
    for own in found:
        assert_allclose(own, [[-0.5 / STIFFNESS]], atol=OF_MOTION * AMPLITUDE)


def test_a_quadratic_spring_moves_it_by_the_square_of_the_motion():
    c = 0.5 * STIFFNESS / AMPLITUDE
    exact = (-STIFFNESS + np.sqrt(STIFFNESS**2 - 2.0 * (c * AMPLITUDE) ** 2)) / (2.0 * c)
    for own in places_of(model(Spring(STIFFNESS), EFFECTS["quadratic_stiffness"](c))):
        assert_allclose(own[0], exact, atol=OF_MOTION * AMPLITUDE)


def test_a_bistable_joint_rests_in_either_well():
    """To an eighth of their distance: the starts are fitted from there."""
    c = STIFFNESS / AMPLITUDE**2  # wells at the amplitude, seen from the upper one
    seen = (
        Spring(2.0 * STIFFNESS),
        EFFECTS["quadratic_stiffness"](3.0 * c * AMPLITUDE),
        EFFECTS["cubic_stiffness"](c),
    )
    for own in places_of(model(*seen), amplitude=0.15 * AMPLITUDE):
        assert_allclose(own[:, 0], [0.0, -2.0 * AMPLITUDE], atol=0.25 * AMPLITUDE)


@pytest.mark.parametrize("measures", ["displacement", "acceleration"])
def test_nothing_is_moved_that_was_measured_or_is_linear(measures):
    weight = (EFFECTS["constant_force"](0.5),) if measures == "displacement" else ()
    for own in places_of(model(Spring(STIFFNESS), *weight, measures=measures)):
        assert_allclose(own, [[0.0]])
