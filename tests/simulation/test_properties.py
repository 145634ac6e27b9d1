"""What holds for any input: superposition of a linear model, symmetry, causality, energy."""

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.simulation import prepare, simulate

RATE, N = 2000.0, 400
JOINT = ("base", "mass")
QUICK = settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
seeds = st.integers(0, 2**32 - 1)
odd_effects = st.sampled_from([
    EFFECTS["gap"](8e4, 1e-5),
    EFFECTS["cubic_stiffness"](1e13),
    EFFECTS["coulomb_friction"](0.3),
    EFFECTS["jenkins"](5e4, 0.5),
])


def model(*effects):
    """Return 1 kg at 50 Hz, damped by 2 %, with effects beside the spring."""
    laws = [EFFECTS["spring"](1e5), EFFECTS["damper"](12.0), *effects]
    return Model(
        "one mass", {"mass": 1.0}, tuple(Element(law, JOINT) for law in laws),
        Excitation("base acceleration"), {"top": Sensor("mass", "relative displacement")},
    )  # fmt: skip


def shaken(seed, level=5.0):
    """Return a random input within 300 Hz [m/s^2]."""
    rng = np.random.default_rng(seed)
    inside = np.fft.rfftfreq(N, 1.0 / RATE) < 300.0
    return level * np.fft.irfft(inside * np.fft.rfft(rng.standard_normal(N)), N)


def moved(given_model, samples):
    return simulate(given_model, samples, RATE, growth=False).outputs["top"]


@QUICK
@given(seeds, seeds, st.floats(-3.0, 3.0))
def test_inputs_of_a_linear_model_superpose(one, other, times):
    first, second = shaken(one), shaken(other)
    expected = moved(model(), first) + times * moved(model(), second)
    found = moved(model(), first + times * second)
    np.testing.assert_allclose(found, expected, atol=1e-9 * (1e-6 + np.abs(expected).max()))


@QUICK
@given(seeds, odd_effects)
def test_an_input_turned_round_turns_the_motion_round(seed, effect):
    there, back = (moved(model(effect), sign * shaken(seed)) for sign in (1.0, -1.0))
    np.testing.assert_allclose(back, -there, atol=1e-7 * np.abs(there).max())


@QUICK
@given(seeds, odd_effects, st.integers(1, 60))
def test_nothing_moves_before_it_is_pushed(seed, effect, late):
    """Held as a step, so that no sample rings before its time."""
    samples = shaken(seed)
    waiting = np.concatenate([np.zeros(late), samples])
    one, other = (
        simulate(model(effect), prepare(given_, RATE, hold="linear"), growth=False).outputs[
            "top"
        ]
        for given_ in (np.concatenate([[0.0], samples]), np.concatenate([[0.0], waiting]))
    )
    assert np.all(other[:late] == 0.0)
    np.testing.assert_allclose(other[late:], one, atol=1e-6 * np.abs(one).max())
