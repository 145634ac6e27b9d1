"""Every effect in time integration: two solvers that share only the law, and balances."""

import dataclasses

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ModelError, SimulationError
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import (
    EFFECTS,
    EXAMPLES,
    AttachedMode,
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    Iwan,
    Jenkins,
    QuadraticStiffness,
    Spring,
    StiffnessDrift,
    StribeckFriction,
)
from shakerproc.models.faults import Clipping, SensorGain
from shakerproc.simulation import prepare, simulate
from shakerproc.simulation.excitations import (
    faded,
    flat_profile,
    harmonic,
    linear_sweep,
    random_noise,
    rest,
)

RATE = 5688.9
GROUND = ("base", "coupon")
PIECEWISE_LINEAR = {
    "spring", "damper", "gap", "offset_gap", "stop", "jump_gap", "coulomb_friction",
    "contact_damping", "jenkins", "attached_mode", "constant_force",
}  # fmt: skip
NOT_ANALYTIC = {"table", "power_iwan", "hertz_contact"}


def shaken(*effects, mass=0.0286, sensors=None):
    held = (Spring(1.2e5), Damper(damping=1.2), *effects)
    elements = tuple(Element(effect, GROUND) for effect in held)
    return Model(
        "m", {"coupon": mass}, elements, Excitation("base acceleration"), sensors or {}
    )


@pytest.fixture(scope="module")
def noise():
    """Base acceleration of 40 m/s^2 rms, 20 to 1000 Hz, 0.1 s."""
    generator = np.random.default_rng(20261121)
    profile = flat_profile(20.0, 1000.0, 40.0**2 / 980.0)
    return prepare(faded(random_noise(profile, 0.1, RATE, generator), RATE, 0.01), RATE)


@pytest.mark.slow
@pytest.mark.parametrize("kind", EFFECTS)
def test_series_and_runge_kutta_agree_on_every_effect(kind, noise):
    """They share the law itself; steps, orders and how events are found are not shared."""
    model = shaken(EXAMPLES[kind])
    found = simulate(model, noise)
    other = simulate(model, noise, solver="dop853", growth=False)
    wanted = "exact propagators" if kind in PIECEWISE_LINEAR else "Taylor series"
    assert found.solver == ("DOP853" if kind in NOT_ANALYTIC else wanted)
    scale = np.max(np.abs(found.displacement))
    # a slip that is shorter than the stages of a step escapes the Runge-Kutta method
    limit = 1e-5 if "friction" in kind and kind != "lugre_friction" else 1e-11
    assert_allclose(
        found.displacement, other.displacement, atol=scale * limit * max(1.0, found.growth)
    )


@pytest.mark.parametrize("kind", sorted(PIECEWISE_LINEAR))
def test_propagators_and_series_agree(kind, noise):
    model = shaken(EXAMPLES[kind])
    found = simulate(model, noise, solver="exact")
    other = simulate(model, noise, solver="taylor", growth=False)
    scale = np.max(np.abs(found.displacement))
    assert_allclose(
        found.displacement, other.displacement, atol=scale * 1e-12 * max(1.0, found.growth)
    )
    assert_allclose(found.acceleration, other.acceleration, rtol=1e-6, atol=1e-5)


@pytest.mark.parametrize("kind", sorted(set(EFFECTS) - {"attached_mode"}))
def test_what_moves_the_mass_is_the_force_of_the_effects(kind, noise):
    """m x'' against the forces that the effects' own formulas give along the motion found."""
    effect = EXAMPLES[kind]
    model = shaken(effect)
    finer = prepare(noise.samples, RATE, upsample=8)
    dense = dataclasses.replace(finer, stride=1, sample_rate=8.0 * RATE)
    found = simulate(model, dense, growth=False)
    z, v = found.displacement[0], found.velocity[0]
    force = 1.2e5 * z + 1.2 * v + effect.force_along(z, v, 8.0 * RATE)
    inertia = -0.0286 * found.acceleration[0]
    if kind in {"coulomb_friction", "stribeck_friction"}:
        sliding = np.abs(v) > 1e-3
        force, inertia = force[sliding], inertia[sliding]
    limit = 3e-3 if kind == "lugre_friction" else 3e-4
    assert_allclose(force, inertia, atol=limit * np.max(np.abs(inertia)))


@pytest.mark.parametrize(
    "effects",
    [
        (Gap(1.2e5, 5e-5), CoulombFriction(2.0)),
        (Gap(1.2e5, 5e-5), CubicStiffness(1e13)),
        (Iwan(1.2e5, 6e-5), Gap(1.2e5, 5e-5)),
        (Jenkins(1.2e5, 4.0), Jenkins(5e4, 1.0), Gap(1e5, 5e-5)),
        (StribeckFriction(1.5, 2.5, 5e-3), Gap(1.2e5, 5e-5)),
        (AttachedMode(5e-3, 200.0, 0.02), Gap(1.2e5, 5e-5)),
        (CoulombFriction(1.0), CoulombFriction(0.5)),
        (CoulombFriction(1.0), StribeckFriction(0.5, 1.0, 5e-3)),
    ],
)
def test_several_effects_at_once_do_not_depend_on_the_tolerance(effects, noise):
    model = shaken(*effects)
    found = simulate(model, noise)
    other = simulate(model, noise, tolerance=1e-12, solver="taylor", growth=False)
    scale = np.max(np.abs(found.displacement))
    assert_allclose(
        found.displacement, other.displacement, atol=1e-9 * scale * max(1.0, found.growth)
    )


def test_two_coulomb_frictions_in_parallel_are_one():
    given = prepare(harmonic(100.0, 60.0), RATE, duration=0.1)
    two = simulate(shaken(CoulombFriction(0.5), CoulombFriction(0.7)), given)
    one = simulate(shaken(CoulombFriction(1.2)), given)
    assert_allclose(two.displacement, one.displacement, rtol=0.0, atol=1e-18)
    with pytest.raises(ModelError, match="two Stribeck frictions"):
        simulate(
            shaken(StribeckFriction(0.5, 1.0, 1e-3), StribeckFriction(0.5, 1.0, 2e-3)), given
        )


def test_many_combinations_of_branches_are_left_to_the_series(noise):
    crowded = shaken(*(Gap(1e4, k * 1e-5) for k in range(1, 5)))
    found = simulate(crowded, noise)
    assert found.solver == "Taylor series"
    with pytest.raises(ValueError, match="too many combinations"):
        simulate(crowded, noise, solver="exact")


def test_a_drifting_stiffness_drifts():
    """Free vibration: the frequency follows the stiffness, slowly enough for WKB."""
    model = shaken(StiffnessDrift(-0.2, 0.0))
    model = dataclasses.replace(model, elements=(model.elements[0], model.elements[2]))
    found = simulate(
        model, rest(), RATE, duration=1.0, start={"coupon": (1e-4, 0.0)}, growth=False
    )
    signs = np.sign(found.displacement[0])
    crossings = np.flatnonzero(np.diff(signs) != 0)
    omega = np.pi / np.diff(found.time[crossings[::20]]) * 20.0
    middle = 0.5 * (found.time[crossings[::20]][1:] + found.time[crossings[::20]][:-1])
    expected = np.sqrt(1.2e5 / 0.0286 * (1.0 - 0.2 * middle))
    assert_allclose(omega, expected, rtol=5e-3)


def test_an_attached_mode_splits_the_resonance_as_den_hartog_says():
    model = shaken(AttachedMode(0.0286 * 0.25, 326.0, 0.0))
    matrix = np.array([[1.2e5, 0.0], [0.0, 0.0]])
    k = 0.0286 * 0.25 * (2.0 * np.pi * 326.0) ** 2
    matrix += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    omega = np.sqrt(np.linalg.eigvals(np.linalg.inv(np.diag([0.0286, 0.0286 * 0.25])) @ matrix))
    found = simulate(
        dataclasses.replace(model, elements=(model.elements[0], model.elements[2])),
        rest(), RATE, duration=2.0, start={"coupon": (1e-4, 0.0)}, growth=False,
    )  # fmt: skip
    assert found.masses == ("coupon", "attached 1")
    spectrum = np.abs(np.fft.rfft(found.displacement[0] * np.hanning(found.time.size)))
    peaks = (
        np.flatnonzero((spectrum[1:-1] > spectrum[:-2]) & (spectrum[1:-1] > spectrum[2:])) + 1
    )
    strongest = np.sort(peaks[np.argsort(spectrum[peaks])[-2:]])
    assert_allclose(strongest * RATE / found.time.size, np.sort(omega) / 2.0 / np.pi, atol=0.5)


def test_chaos_is_called_by_its_name():
    """A gap oscillator whose clearance is twenty times the play it was tuned for."""
    generator = np.random.default_rng(3)
    force = random_noise(flat_profile(0.5, 20.0, 1.0), 60.0, 200.0, generator)
    model = Model(
        "wide gap",
        {"m": 1.0},
        (
            Element(Gap(1000.0, 0.02), ("base", "m")),
            Element(Damper(damping=0.6), ("base", "m")),
        ),
        Excitation("force", "m"),
    )
    found = simulate(model, force, 200.0)
    assert found.chaotic
    assert found.growth > 1e4
    assert "only statistics" in found.notes[0]
    assert found.error > 1e-9
    calm = simulate(shaken(), force, 200.0)
    assert not calm.chaotic
    assert calm.growth < 10.0
    assert calm.notes == ()


def test_a_disturbance_of_the_input_makes_as_much_of_a_linear_response():
    generator = np.random.default_rng(3)
    force = random_noise(flat_profile(0.5, 20.0, 1.0), 10.0, 200.0, generator)
    held = (Element(Spring(1000.0), ("base", "m")), Element(Damper(damping=4.0), ("base", "m")))
    model = Model("linear", {"m": 1.0}, held, Excitation("force", "m"))
    assert_allclose(simulate(model, force, 200.0).growth, 1.0, atol=0.1)


def test_chaos_is_found_after_a_long_rest():
    """A disturbance of the start alone would have died out before anything shakes."""
    generator = np.random.default_rng(3)
    force = random_noise(flat_profile(0.5, 20.0, 1.0), 60.0, 200.0, generator)
    model = Model(
        "held gap",
        {"m": 1.0},
        (
            Element(Spring(300.0), ("base", "m")),
            Element(Gap(1e5, 0.005), ("base", "m")),
            Element(Damper(damping=4.0), ("base", "m")),
        ),
        Excitation("force", "m"),
    )
    found = simulate(model, np.concatenate((np.zeros(6000), force)), 200.0)
    assert found.chaotic
    without_rest = simulate(model, force, 200.0)
    assert_allclose(np.log10(found.growth), np.log10(without_rest.growth), atol=1.0)


def test_growth_in_passing_is_sensitive_but_not_chaotic():
    """A sweep that loses contact: the disturbance stays, but does not go on growing."""
    model = Model(
        "wide gap",
        {"m": 1.0},
        (
            Element(Gap(1000.0, 0.02), ("base", "m")),
            Element(Damper(damping=0.02 * np.sqrt(1000.0)), ("base", "m")),
        ),
        Excitation("force", "m"),
    )
    sweep = linear_sweep(0.0, 30.0, 30.0, 5.0, 0.5 * np.pi)
    found = simulate(model, sweep, 500.0, duration=30.0)
    assert found.sensitive
    assert not found.chaotic
    assert found.notes[0].startswith("sensitive")
    assert found.error < 1e-4


def test_the_growth_of_a_known_instability_is_found():
    """On top of a hill of negative stiffness a disturbance grows by exp(lambda t)."""
    model = Model(
        "hill",
        {"m": 1.0},
        (Element(Spring(-4.0), ("base", "m")), Element(CubicStiffness(1.0), ("base", "m"))),
        Excitation("force", "m"),
    )
    found = simulate(model, rest(), 100.0, duration=2.0, start={"m": (1e-6, 0.0)})
    assert_allclose(found.growth, np.cosh(4.0), rtol=1e-3)


def test_a_model_that_runs_away_says_when():
    model = shaken(QuadraticStiffness(1e9))
    with pytest.raises(SimulationError, match=r"m: the motion runs away at 0\.\d+ s"):
        simulate(model, harmonic(326.0, 100.0), RATE, duration=1.0)


def test_sensors_measure_what_they_say(noise):
    sensors = {
        "absolute": Sensor("coupon"),
        "table": Sensor("base"),
        "z": Sensor("coupon", "relative displacement"),
        "w": Sensor("coupon", "relative velocity"),
        "x": Sensor("coupon", "displacement"),
        "v": Sensor("coupon", "velocity"),
        "bad": Sensor("coupon", "acceleration", (SensorGain(2.0), Clipping(50.0))),
    }
    found = simulate(shaken(Gap(1.2e5, 5e-5), sensors=sensors), noise, growth=False)
    outputs = found.outputs
    assert_allclose(outputs["table"], noise.samples)
    assert_allclose(outputs["z"], found.relative_displacement("base", "coupon"))
    assert_allclose(outputs["w"], found.relative_velocity("base", "coupon"))
    assert_allclose(outputs["bad"], np.clip(2.0 * outputs["absolute"], -50.0, 50.0))
    step = 1.0 / RATE
    middle = outputs["v"][1:-1]
    assert_allclose(np.gradient(outputs["x"], step)[1:-1], middle, atol=0.1 * np.std(middle))
    base = outputs["x"] - outputs["z"]
    twice = np.diff(base, 2) / step**2
    assert_allclose(twice, noise.samples[1:-1], atol=0.1 * np.max(noise.samples))


def test_a_force_leaves_the_base_alone():
    model = Model(
        "m", {"a": 2.0}, (Element(Spring(8.0), ("base", "a")),), Excitation("force", "a"),
        {"x": Sensor("a", "displacement"), "base": Sensor("base"), "a": Sensor("a")},
    )  # fmt: skip
    found = simulate(model, harmonic(0.2, 3.0), 50.0, duration=4.0)
    assert np.all(found.outputs["base"] == 0.0)
    assert_allclose(found.outputs["x"], found.displacement[0])
    expected = (found.excitation - 8.0 * found.displacement[0]) / 2.0
    assert_allclose(found.outputs["a"], expected, atol=1e-13)


def test_arguments_that_do_not_fit_are_refused(noise):
    model = shaken()
    for arguments, message in [
        (([1.0], 1.0), "at least 2"),
        (([[1.0, 2.0]], 1.0), r"\(n,\) samples"),
        (([1.0, np.nan], 1.0), "sample 1 is nan"),
        (([1.0, 2.0],), "needs a sample rate"),
        (([1.0, 2.0], -1.0), "sample_rate must be above 0"),
        ((rest(), 1.0), "needs a duration"),
        ((noise, 1.0), "sample rate of its own"),
    ]:
        with pytest.raises(ValueError, match=message):
            simulate(model, *arguments)
    with pytest.raises(ValueError, match="no mass 'rim'"):
        simulate(model, noise, start={"rim": (0.0, 0.0)})


@pytest.mark.parametrize("duration", [1.0, 1.0025, 1.005, 1.0075])
@pytest.mark.parametrize("driven", ["force", "base"])
def test_steps_over_several_samples_give_what_steps_of_one_do(duration, driven):
    """Displacements, velocities and accelerations, between the steps and past their end."""
    excitation = (
        Excitation("force", "m") if driven == "force" else Excitation("base acceleration")
    )
    model = Model(
        "mixed",
        {"m": 1.0},
        (
            Element(Gap(1000.0, 5e-4), ("base", "m")),
            Element(CubicStiffness(1e6), ("base", "m")),
            Element(CoulombFriction(0.5), ("base", "m")),
            Element(Damper(damping=0.6), ("base", "m")),
        ),
        excitation,
        {"a": Sensor("m", "acceleration")},
    )
    chirp = linear_sweep(2.0, 20.0, 2.0, 5.0, 0.3)
    long = simulate(model, chirp, 400.0, duration=duration)
    short = simulate(model, prepare(chirp, 400.0, duration=duration))
    assert long.switchings == short.switchings > 5
    assert_allclose(long.excitation, short.excitation, atol=1e-12)
    for name in ("displacement", "velocity", "acceleration"):
        one, other = getattr(long, name), getattr(short, name)
        assert_allclose(one, other, atol=1e-10 * np.max(np.abs(other)))
    assert_allclose(long.outputs["a"], short.outputs["a"], atol=1e-9)
