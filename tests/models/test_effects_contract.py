"""The contract of an effect: a new one adds an example and inherits every test."""

import dataclasses
import inspect
import pkgutil
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.models import effects, faults
from shakerproc.models.effects import EFFECTS, EXAMPLES
from shakerproc.models.effects.base import AbstractEffect, AbstractMemorylessEffect, Parameter
from shakerproc.models.faults import FAULT_EXAMPLES, FAULTS, AbstractFault
from shakerproc.models.laws import Law
from shakerproc.units import to_si

DESIGN = """
spring (stiffness); damper (damping, damping_ratio); gap (stiffness, clearance);
offset_gap (stiffness, clearance_positive, clearance_negative);
stop (stiffness, clearance, side);
hertz_contact (stiffness, clearance, restitution_loss, side);
cubic_stiffness (coefficient); quadratic_stiffness (coefficient);
power_law (force, reference_displacement, exponent); coulomb_friction (sliding_force);
stribeck_friction (sliding_force, breakaway_force, stribeck_velocity);
lugre_friction (sliding_force, breakaway_force, stribeck_velocity, bristle_stiffness,
bristle_damping, viscous_damping); quadratic_damping (coefficient);
contact_damping (damping, clearance); jenkins (stiffness, slip_force);
iwan (stiffness, slip_displacement); bouc_wen (stiffness, yield_displacement, exponent);
attached_mode (mass, frequency, damping_ratio); stiffness_drift (rate, reference);
constant_force (force); series (elements); table (displacement, velocity, force, band);
general_bouc_wen (alpha, beta, gamma, exponent)
"""

every_kind = pytest.mark.parametrize("kind", EFFECTS)
MEMORYLESS = [k for k, e in EXAMPLES.items() if isinstance(e, AbstractMemorylessEffect)]
memoryless = pytest.mark.parametrize("kind", MEMORYLESS)
SAMPLE_RATE = 2.0**16
OMEGA = 2.0 * np.pi * 64.0


def cycles(amplitude, n_cycles=8):
    """A sine with whole cycles of 1024 samples."""
    angle = OMEGA * np.arange(n_cycles * 1024 + 1) / SAMPLE_RATE
    return amplitude * np.sin(angle), amplitude * OMEGA * np.cos(angle)


def test_the_names_are_those_of_the_design():
    for kind, names in re.findall(r"(\w+) \(([^)]*)\)", DESIGN):
        given = [name.strip() for name in names.split(",")]
        assert list(EFFECTS[kind].parameters)[: len(given)] == given


def test_every_file_holds_one_registered_effect_with_an_example():
    files = {module.name for module in pkgutil.iter_modules(effects.__path__)} - {"base"}
    assert files == set(EFFECTS) == set(EXAMPLES)


def test_every_fault_is_registered_and_has_an_example():
    classes = {made for made in vars(faults).values() if inspect.isclass(made)}
    kinds = {made.kind for made in classes if made in AbstractFault.__subclasses__()}
    assert kinds == set(FAULTS) == set(FAULT_EXAMPLES)


@pytest.mark.parametrize("made", [*EFFECTS.values(), *FAULTS.values()])
def test_every_kind_is_documented(made):
    assert made.__doc__
    assert made.formula
    fields = [field.name for field in dataclasses.fields(made)]
    assert list(made.parameters) == fields
    for name, parameter in made.parameters.items():
        assert f"{name} : " in made.__doc__
        assert parameter.meaning
        if not parameter.choices and parameter.holds != "effects":
            assert parameter.symbol in made.formula or parameter.symbol == "n"  # superscript
            to_si(f"1 {parameter.unit}" if parameter.unit != "1" else "1", parameter.unit)
    if issubclass(made, AbstractEffect) and made.kind != "stiffness_drift":
        assert "References\n" in made.__doc__


@every_kind
def test_every_kind_is_final_frozen_and_written_in_known_laws(kind):
    made = EFFECTS[kind]
    assert made.__final__
    with pytest.raises(dataclasses.FrozenInstanceError, match="cannot assign"):
        setattr(EXAMPLES[kind], next(iter(made.parameters)), 1.0)
    rows = EXAMPLES[kind].rows()
    assert rows
    assert all(isinstance(row.law, Law) and len(row.values) <= 6 for row in rows)


@every_kind
def test_values_that_are_not_physical_are_refused(kind):
    made, example = EFFECTS[kind], EXAMPLES[kind]
    for name, parameter in made.parameters.items():
        for value in refused(parameter):
            with pytest.raises(ValueError, match=name):
                dataclasses.replace(example, **{name: value})


def refused(parameter: Parameter):
    if parameter.choices:
        return ["up"]
    if parameter.holds != "number":
        return [1.0, "1", (None,), ()]
    bad = [float("nan"), float("inf"), "1", True]
    return bad + {"positive": [0.0, -1.0], "not negative": [-1.0], "any": []}[parameter.sign]


@every_kind
@pytest.mark.parametrize("amplitude", [1e-6, 1e-4, 1e-3])
def test_no_effect_gains_energy_over_a_closed_cycle(kind, amplitude):
    if kind == "stiffness_drift":
        pytest.skip("its force depends on time: work over a cycle has either sign")
    displacement, velocity = cycles(amplitude)
    force = EXAMPLES[kind].force_along(displacement, velocity, SAMPLE_RATE)
    work = force[-1024:] * velocity[-1024:]
    assert np.mean(work) >= -1e-5 * np.max(np.abs(work), initial=1e-30)


def iwan_work(effect, amplitude):
    """Every slider phi that slips gives 4 k/z_s phi (a - phi); their integral."""
    k, slip = effect.stiffness, effect.slip_displacement
    if amplitude < slip:
        return 2.0 * k * amplitude**3 / (3.0 * slip)
    return 2.0 * k * slip * (amplitude - 2.0 * slip / 3.0)


def power_damping_work(effect, amplitude):
    """The mean of sin^4 cos^2 is 1/16."""
    share = amplitude**6 / effect.reference_displacement**4
    return np.pi / 8.0 * effect.damping * OMEGA * share


def none(*_):
    return 0.0


DISSIPATED = {
    "damper": lambda e, a: np.pi * e.damping * OMEGA * a**2,
    "coulomb_friction": lambda e, a: 4.0 * e.sliding_force * a,
    "quadratic_damping": lambda e, a: 8.0 / 3.0 * e.coefficient * OMEGA**2 * a**3,
    "jenkins": lambda e, a: 4.0 * e.slip_force * (a - e.slip_force / e.stiffness),
    "iwan": iwan_work,
    "power_law_damping": power_damping_work,
    "gap": none,
    "cubic_stiffness": none,
    "quadratic_stiffness": none,
    "power_law": none,
}


@pytest.mark.parametrize("kind", DISSIPATED)
@pytest.mark.parametrize("amplitude", [5e-5, 2e-4])
def test_the_work_of_a_cycle_is_that_of_its_closed_form(kind, amplitude):
    displacement, velocity = cycles(amplitude)
    force = EXAMPLES[kind].force_along(displacement, velocity, SAMPLE_RATE)
    step = np.diff(displacement[-1025:])
    work = np.sum(0.5 * (force[-1025:-1] + force[-1024:]) * step)
    scale = amplitude * np.max(np.abs(force))
    assert_allclose(work, DISSIPATED[kind](EXAMPLES[kind], amplitude), atol=2e-3 * scale)


@every_kind
def test_the_force_is_linear_in_what_claims_to_be_linear(kind):
    example = EXAMPLES[kind]
    linear = [name for name, p in example.parameters.items() if p.linear]
    if not linear:
        pytest.skip("it claims nothing")
    displacement, velocity = cycles(1e-4, 2)

    def force(factors):
        values = {n: getattr(example, n) * f for n, f in zip(linear, factors, strict=True)}
        changed = dataclasses.replace(example, **values)
        return changed.force_along(displacement, velocity, SAMPLE_RATE)

    ones = np.ones(len(linear))
    tilted = 1.0 + 0.1 * np.arange(len(linear))
    base = force(0.0 * ones + 1e-9) if kind == "lugre_friction" else 0.0
    assert_allclose(
        force(2.0 * ones + 3.0 * tilted) - base,
        2.0 * (force(ones) - base) + 3.0 * (force(tilted) - base),
        atol=1e-9 * np.max(np.abs(force(ones))),
    )


@memoryless
def test_the_slopes_are_the_derivatives_of_the_force(kind):
    """Central differences, away from the switching surfaces that the effect names."""
    effect = EXAMPLES[kind]
    z, v = np.meshgrid(np.linspace(-1.7e-4, 1.9e-4, 41), np.linspace(-0.0213, 0.0207, 41))
    for switch in effect.switches():
        values = z if switch.variable == "displacement" else v
        keep = np.abs(values - switch.at) > 1e-7
        z, v = z[keep], v[keep]
    by_z, by_v = effect.slopes(z, v)
    dz, dv = 1e-9, 1e-7
    difference_z = (effect.force_at(z + dz, v) - effect.force_at(z - dz, v)) / (2.0 * dz)
    difference_v = (effect.force_at(z, v + dv) - effect.force_at(z, v - dv)) / (2.0 * dv)
    assert by_z.shape == by_v.shape == z.shape
    assert_allclose(by_z, difference_z, rtol=1e-5, atol=1e-5 * np.max(np.abs(by_z)))
    assert_allclose(by_v, difference_v, rtol=1e-5, atol=1e-5 * np.max(np.abs(by_v)))


@memoryless
def test_a_force_keeps_the_shape_of_what_it_is_given(kind):
    effect = EXAMPLES[kind]
    z, v = np.full((3, 4), 1e-4), np.full((3, 4), -1e-2)
    assert effect.force_at(z, v).shape == (3, 4)
    assert_allclose(effect.force_at(z[0], v[:, :1]), effect.force_at(z, v))


def test_the_switches_are_where_the_force_or_its_slope_breaks():
    gap = effects.OffsetGap(2.0, 1.0, 3.0)
    assert [s.at for s in gap.switches()] == [-3.0, 1.0]
    z = np.array([-4.0, -3.0, 0.0, 1.0, 2.0])
    assert_allclose(gap.force_at(z, 0.0 * z), [-2.0, 0.0, 0.0, 0.0, 2.0])
    stop = effects.Stop(2.0, 1.0, "negative")
    assert_allclose(stop.force_at(z, 0.0 * z), [-6.0, -4.0, 0.0, 0.0, 0.0])
    jump = effects.JumpGap(2.0, 1.5)
    assert_allclose(jump.force_at(z, 0.0 * z), [-8.0, -6.0, 0.0, 0.0, 4.0])


def test_friction_needs_at_least_as_much_to_break_away():
    with pytest.raises(ValueError, match="breakaway_force must be at least"):
        effects.StribeckFriction(2.0, 1.0, 1e-3)
    with pytest.raises(ValueError, match="breakaway_force must be at least"):
        effects.LuGreFriction(2.0, 1.0, 1e-3, 1e6, 1.0, 0.0)
    with pytest.raises(ValueError, match="damping or damping_ratio"):
        effects.Damper()
    with pytest.raises(ValueError, match="damping or damping_ratio"):
        effects.Damper(damping=1.0, damping_ratio=0.1)


@pytest.mark.parametrize("kind", ["damper", "stiffness_drift"])
def test_an_effect_that_needs_its_surroundings_says_so(kind):
    alone = {
        "damper": effects.Damper(damping_ratio=0.1),
        "stiffness_drift": effects.StiffnessDrift(1e-3, 0.0),
    }[kind]
    with pytest.raises(ValueError, match="use in_place"):
        alone.force_along(np.zeros(3), np.zeros(3), 1.0)
    with pytest.raises(ValueError, match="use in_place"):
        alone.rows()
    assert alone.in_place(1e5, 0.1).rows()


def test_the_kinds_of_faults_do_what_they_say():
    time = np.arange(4096) / 4096.0
    signal = np.sin(2.0 * np.pi * 8.0 * time)
    for kind, fault in FAULT_EXAMPLES.items():
        assert isinstance(fault, AbstractFault)
        assert fault.kind == kind
    late = faults.SensorDelay(1e-3).apply(signal, 4096.0)
    assert_allclose(late, np.sin(2.0 * np.pi * 8.0 * (time - 1e-3)), atol=1e-12)
    assert_allclose(faults.SensorGain(1.1).apply(signal, 1.0), 1.1 * signal)
    assert_allclose(faults.SensorPolarity().apply(signal, 1.0), -signal)
    assert np.max(faults.Clipping(0.5).apply(signal, 1.0)) == 0.5
    hum = faults.MainsHum(50.0, 0.2).apply(signal, 4096.0) - signal
    assert_allclose(hum, 0.2 * np.sin(2.0 * np.pi * 50.0 * time), atol=1e-12)
