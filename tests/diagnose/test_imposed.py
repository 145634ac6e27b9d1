"""Component tests: loops from a generator of their own, in plain Python, and what is named."""

import math

import numpy as np
import pytest

from shakerproc.diagnose import TestArrays, diagnose_arrays
from shakerproc.diagnose.imposed_motion import loops, scatter, turns_of
from shakerproc.diagnose.structure import Joint, Sensing, Structure
from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor

RATE = 256.0
SECONDS = 14
FINER = 8
SPRING, DAMPER = 2.0e4, 300.0


def imposed(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A rig's motion on a grid finer than the recording: 1 Hz, up and down in amplitude."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(SECONDS * RATE * FINER)) / (RATE * FINER)
    steps = np.array([0.2, 0.5, 0.8, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.8, 0.5, 0.35, 0.2])
    grown = np.interp(t, np.arange(SECONDS) + 0.5, steps)
    return t, 0.02 * grown * np.sin(2.0 * np.pi * t + rng.uniform(0.0, 6.28))


def recorded(force, seed: int, *, noise: float = 0.01, **more) -> TestArrays:
    """A recording of the motion and of spring, damper and one more force along it."""
    t, z = imposed(seed)
    v = np.gradient(z, t)
    total = SPRING * z + DAMPER * v + np.array(force(z.tolist(), v.tolist()))
    rng = np.random.default_rng(1000 + seed)
    kept = slice(None, None, FINER)
    total = total[kept] + noise * np.std(total) * rng.standard_normal(z[kept].size)
    moved = z[kept] + 1e-6 * rng.standard_normal(z[kept].size)
    return TestArrays(
        f"test {seed}", RATE, (total - total.mean())[None], (moved - moved.mean())[None],
        excitation="sine", band=(0.5, 2.0), **more,
    )  # fmt: skip


def nothing(z, v):
    return [0.0 for _ in z]


def friction(limit):
    return lambda _, v: [math.copysign(limit, speed) for speed in v]


def hardening(cubic):
    return lambda z, _: [cubic * x**3 for x in z]


def play_then_slider(stiffness, clearance, limit):
    """Step by step: the contact pushes the slider as far as its force exceeds the limit."""

    def along(z, v):
        slider, out = z[0], []
        for x in z:
            stretch = x - slider
            if stretch > clearance:
                pull = stiffness * (stretch - clearance)
            elif stretch < -clearance:
                pull = stiffness * (stretch + clearance)
            else:
                pull = 0.0
            if abs(pull) > limit:
                slider += math.copysign((abs(pull) - limit) / stiffness, pull)
                pull = math.copysign(limit, pull)
            out.append(pull)
        return out

    return along


def wedge(limit, width):
    """Friction that grows away from the middle: no effect of the library."""
    return lambda z, v: [
        math.copysign(limit * (0.2 + (x / width) ** 2), speed)
        for x, speed in zip(z, v, strict=True)
    ]


def component(mass: float = 1.0) -> Model:
    return Model(
        title="component",
        masses={"rod": mass},
        elements=(
            Element(EFFECTS["spring"](stiffness=1.3 * SPRING), ("base", "rod")),
            Element(EFFECTS["damper"](damping=0.5 * DAMPER), ("base", "rod")),
        ),
        excitation=Excitation("force", "rod"),
        sensors={"stroke": Sensor("rod", "displacement")},
    )


def diagnosis(*tests):
    return diagnose_arrays(component(), tests)


def near(estimate, truth, share):
    assert estimate.value == pytest.approx(truth, rel=share)
    assert estimate.low < estimate.value < estimate.high


def test_spring_and_damper_alone_lack_nothing():
    found = diagnosis(recorded(nothing, 1))
    assert found.verdict == "nothing missing"
    assert found.effects == ()
    near(found.linear["stiffness base-rod"], SPRING, 0.01)
    near(found.linear["damping base-rod"], DAMPER, 0.03)
    assert found.errors.noise_floor == pytest.approx(0.01, rel=0.3)


def test_dry_friction_is_named_with_its_force():
    found = diagnosis(recorded(friction(250.0), 2))
    assert found.verdict == "effect found"
    (effect,) = found.effects
    assert (effect.kind, effect.between) == ("coulomb_friction", ("base", "rod"))
    near(effect.parameters["sliding_force"], 250.0, 0.02)
    assert found.errors.held_out.after < 0.05 < found.errors.held_out.before


@pytest.mark.parametrize("seed", [3, 4])
def test_play_in_series_with_friction_is_named_as_both(seed):
    found = diagnosis(recorded(play_then_slider(2.0e5, 1.5e-3, 400.0), seed))
    assert found.verdict == "effect found"
    assert "in series" in found.sentence
    assert [effect.kind for effect in found.effects] == ["coulomb_friction", "gap"]
    assert {effect.between for effect in found.effects} == {("base", "rod")}
    slider, gap = (effect.parameters for effect in found.effects)
    near(slider["sliding_force"], 400.0, 0.01)
    near(gap["clearance"], 1.5e-3, 0.02)
    near(gap["stiffness"], 2.0e5, 0.03)
    assert found.errors.held_out.after < 1.5 * found.errors.noise_floor
    document = found.as_json()
    assert document["candidates"][0]["kind"] == "coulomb_friction+gap"
    assert document["candidates"][0]["parameters"]["arrangement"]["value"] == "in series"


def test_a_slider_without_play_is_a_jenkins_element():
    found = diagnosis(recorded(play_then_slider(2.0e5, 0.0, 400.0), 5))
    assert [effect.kind for effect in found.effects] == ["jenkins"]
    near(found.effects[0].parameters["slip_force"], 400.0, 0.02)


def test_a_cubic_spring_is_named():
    found = diagnosis(recorded(hardening(1.0e8), 6))
    assert found.verdict == "effect found"
    assert found.effects[0].kind == "cubic_stiffness"
    near(found.effects[0].parameters["coefficient"], 1.0e8, 0.02)


@pytest.mark.slow
def test_two_effects_side_by_side_are_both_named():
    def both(z, v):
        pairs = zip(friction(250.0)(z, v), hardening(1.0e8)(z, v), strict=True)
        return [one + two for one, two in pairs]

    found = diagnosis(recorded(both, 7))
    assert found.verdict == "effect found"
    kinds = {effect.kind for effect in found.effects}
    assert kinds == {"coulomb_friction", "cubic_stiffness"}
    assert "in series" not in found.sentence


@pytest.mark.slow
def test_friction_that_depends_on_the_place_is_outside_the_library():
    found = diagnosis(recorded(wedge(300.0, 0.01), 8))
    assert found.verdict == "outside library"
    assert found.effects == ()


@pytest.mark.slow
def test_a_test_that_is_held_out_takes_no_part():
    law = play_then_slider(2.0e5, 1.5e-3, 400.0)
    other = play_then_slider(2.0e5, 1.5e-3, 800.0)
    found = diagnosis(recorded(law, 9), recorded(other, 10, hold_out=True))
    tried = {one.kind: one for one in found.candidates}["coulomb_friction+gap"]
    near(tried.parameters["sliding_force"], 400.0, 0.02)
    assert tried.fitted_error < 0.02
    assert tried.held_out_error > 0.2


STRUCTURE = Structure(
    np.array([1.0]), (Joint(-1, 0, SPRING, DAMPER),), (Sensing(0, 0, True),), 0
)


def test_where_inertia_is_a_large_share_the_motion_is_not_imposed():
    test = recorded(nothing, 11)
    (loop,) = loops(STRUCTURE, [test])
    t, z = imposed(11)
    pull = np.gradient(np.gradient(z, t), t)[::FINER]
    expected = np.sqrt(np.mean(pull**2) / np.mean(test.controls**2))
    assert loop.inertia == pytest.approx(expected, rel=0.05)
    heavy = Structure(
        np.array([0.2 / expected]), STRUCTURE.joints, STRUCTURE.sensing, STRUCTURE.forced
    )
    assert loops(heavy, [test]) is None


def test_turns_are_those_of_the_motion_and_not_of_its_noise():
    angle = np.linspace(0.0, 6.0 * np.pi, 3001)
    noise = 0.003 * np.random.default_rng(0).standard_normal(angle.size)
    found = turns_of(np.sin(angle) + noise)
    expected = np.pi * (np.arange(6) + 0.5)
    assert angle[found[1:-1]] == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("noise", [0.005, 0.02, 0.08])
def test_repeats_of_a_swing_show_the_noise_whatever_the_law(noise):
    """White noise of a known size on a loop; no model is involved."""
    test = recorded(play_then_slider(2.0e5, 1.5e-3, 400.0), 12, noise=noise)
    clean = recorded(play_then_slider(2.0e5, 1.5e-3, 400.0), 12, noise=0.0)
    own = np.std(test.controls - clean.controls)
    assert scatter(loops(STRUCTURE, [test])) == pytest.approx(own, rel=0.15)
