"""Free runs of windows against the simulation of the whole test, and their failures."""

import numpy as np
import pytest

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    BoucWen,
    CubicStiffness,
    Damper,
    Gap,
    GeneralBoucWen,
    Iwan,
    Jenkins,
    LuGreFriction,
    Spring,
)
from shakerproc.simulation import (
    Runs,
    free_runs,
    largest_states,
    motions_of,
    prepare,
    simulate,
)

RATE, COUNT = 1000.0, 1500
SENSORS = {
    "acceleration": Sensor("coupon"),
    "velocity": Sensor("coupon", "velocity"),
    "displacement": Sensor("coupon", "relative displacement"),
    "table": Sensor("base"),
}


def model_with(*effects):
    elements = (Spring(1000.0), Damper(damping=1.0), *effects)
    joined = tuple(Element(effect, ("base", "coupon")) for effect in elements)
    return Model("one mass", {"coupon": 1.0}, joined, Excitation("base acceleration"), SENSORS)


@pytest.fixture(scope="module")
def given():
    noise = np.random.default_rng(0).standard_normal(COUNT)
    smooth = np.convolve(noise, np.hanning(25), "same")
    return prepare(5.0 * smooth * np.hanning(COUNT), RATE)


@pytest.mark.parametrize("law", [(), (Gap(5000.0, 1e-3),), (CubicStiffness(2e6),)])
def test_windows_follow_the_simulation_of_the_whole_test(law, given):
    model = model_with(*law)
    whole = simulate(model, given, growth=False)
    windows = np.array([[0, 0, COUNT], [0, 300, 200], [0, 1400, 100]])
    starts = np.array([
        np.concatenate((whole.displacement[:, i], whole.velocity[:, i])) for i in windows[:, 1]
    ])
    runs = free_runs(model, Runs((given,), windows, starts), tolerance=1e-9, means=False)
    assert not runs.failed.any()
    absolute = simulate(model, given, growth=False).outputs
    for (_, first, count), found in zip(windows, runs.outputs, strict=True):
        assert found.shape == (len(SENSORS), count)
        for name, row in zip(SENSORS, found, strict=True):
            wanted = absolute[name][first : first + count]
            size = np.max(np.abs(absolute[name]))
            np.testing.assert_allclose(row, wanted, rtol=0.0, atol=2e-6 * size)


@pytest.mark.parametrize(
    "law",
    [
        BoucWen(3000.0, 1e-3, 2.0),
        Jenkins(3000.0, 2.0),
        LuGreFriction(1.0, 1.5, 0.01, 5e3, 5.0, 0.0),
    ],
    ids=["bouc_wen", "jenkins", "lugre_friction"],
)
def test_a_window_goes_on_with_the_memory_that_its_start_says(law, given):
    model = model_with(law)
    whole = simulate(model, given, growth=False, tolerance=1e-9)
    first, count = 700, 300
    motion = np.concatenate([whole.displacement, whole.velocity, whole.states])[:, first]
    runs = free_runs(
        model, Runs((given,), np.array([[0, first, count]]), motion[None]),
        tolerance=1e-9, means=False,
    )  # fmt: skip
    wanted = whole.outputs["displacement"]
    assert runs.outputs[0][2] == pytest.approx(
        wanted[first : first + count], abs=1e-5 * np.max(np.abs(wanted))
    )
    assert np.all(np.abs(whole.states) <= largest_states(model)[:, 1:] * (1.0 + 1e-9))


@pytest.mark.parametrize("share", [-1.4, -0.6, 0.0, 0.3, 0.999])
@pytest.mark.parametrize("velocity", [0.2, -0.2])
def test_an_iwan_element_begins_on_first_loading_as_far_from_rest_as_its_state(share, velocity):
    law = Iwan(stiffness=3000.0, slip_displacement=1e-3)
    still = prepare(np.zeros(60), RATE)
    start = np.array([[2e-3, velocity, share * 1e-3]])
    runs = free_runs(model_with(law), Runs((still,), np.array([[0, 0, 3]]), start), means=False)
    far = np.sign(share) * min(abs(share), 1.0) * 1e-3
    wanted = -1000.0 * 2e-3 - velocity - 3000.0 * far * (1.0 - abs(far) / 2e-3)
    assert runs.outputs[0][0, 0] == pytest.approx(wanted, abs=1e-9)


def test_means_are_those_of_a_finer_simulation(given):
    model = model_with(Gap(5000.0, 1e-3))
    runs = free_runs(model, Runs((given,), np.array([[0, 0, 1000], [0, 700, 800]])))
    fine = 16
    finer = prepare(given.samples, RATE, upsample=fine)
    dense = simulate(model, finer, growth=False)
    velocity = dense.outputs["velocity"]
    wanted = np.diff(velocity) * RATE
    found = runs.outputs[0][0]
    size = np.max(np.abs(wanted))
    np.testing.assert_allclose(found, wanted[:1000], rtol=0.0, atol=1e-4 * size)
    assert runs.outputs[1][0, -1] == runs.outputs[1][0, -2]


def test_windows_that_run_away_fail_alone_and_are_large(given):
    model = model_with(CubicStiffness(-3e8))
    starts = np.array([[0.0, 0.0], [0.1, 0.0]])
    runs = free_runs(model, Runs((given,), np.array([[0, 0, 50], [0, 0, 400]]), starts))
    assert runs.failed.tolist() == [False, True]
    assert np.all(np.isfinite(runs.outputs[1]))
    size = np.max(np.abs(runs.outputs[0][2]))
    assert np.max(np.abs(runs.outputs[1][2])) == pytest.approx(1e3 * size)


def test_motions_are_named_in_the_order_of_starts():
    assert motions_of(model_with()) == ("x coupon", "v coupon")


def test_a_law_whose_rate_runs_away_within_a_sample_costs_its_window_alone():
    """Nothing dissipates, and beyond its limit the force runs off in no time."""
    law = GeneralBoucWen(alpha=3496.8, beta=5.1e8, gamma=-6.5e8, exponent=5.5)
    elements = (
        Element(Spring(stiffness=256913.5), ("base", "beam")),
        Element(Damper(damping=1.5), ("base", "beam")),
        Element(law, ("base", "beam")),
    )
    model = Model(
        "beam", {"beam": 0.288}, elements, Excitation("force", "beam"),
        {"a": Sensor("beam", "acceleration")},
    )  # fmt: skip
    rest = (prepare(np.zeros(200), 640.0),)
    windows = np.array([[0, 10, 42], [0, 60, 42]])
    starts = np.array([[1.2454e-4, -0.02808, 0.0], [0.0, 1e-9, 0.0]])
    found = free_runs(model, Runs(rest, windows, starts))
    assert found.failed.tolist() == [True, False]
