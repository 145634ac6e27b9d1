"""Constant force, series, tables, the general Bouc-Wen law, Iwan with an exponent, bistable."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import DocumentError
from shakerproc.model_files.reading import read_model
from shakerproc.models import BASE, Element, Excitation, Model
from shakerproc.models.effects import (
    BoucWen,
    ConstantForce,
    CoulombFriction,
    CubicStiffness,
    Damper,
    Gap,
    GeneralBoucWen,
    Iwan,
    Jenkins,
    LuGreFriction,
    PowerIwan,
    Series,
    Spring,
    Stop,
    Table,
)
from shakerproc.models.laws import Law
from shakerproc.simulation import simulate

RATE = 2.0**15


def sine(amplitude, n_cycles=4, omega=2.0 * np.pi * 32.0):
    time = np.arange(n_cycles * 1024 + 1) / RATE
    return amplitude * np.sin(omega * time), amplitude * omega * np.cos(omega * time)


def work(effect, amplitude):
    """Energy lost in the last cycle [J]."""
    z, v = sine(amplitude)
    force = effect.force_along(z, v, RATE)[-1025:]
    return np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(z[-1025:]))


def one_mass(*effects):
    elements = tuple(Element(effect, (BASE, "coupon")) for effect in effects)
    return Model("one mass", {"coupon": 0.1}, elements, Excitation("base acceleration"))


def rest_of(model, start=0.0):
    """Where a mass comes to rest [m]."""
    quiet = np.zeros(20000)
    found = simulate(model, quiet, 5000.0, start={"coupon": (start, 0.0)}, growth=False)
    assert np.max(np.abs(found.velocity[0, -100:])) < 1e-9
    return found.displacement[0, -1]


def test_dead_weight_hangs_on_its_spring():
    model = one_mass(Spring(1e4), Damper(damping=5.0), ConstantForce(0.98))
    assert_allclose(rest_of(model), -0.98 / 1e4, rtol=1e-9)


def test_dead_weight_without_a_spring_is_held_by_friction_alone():
    model = one_mass(Damper(damping=5.0), CoulombFriction(1.2), ConstantForce(0.98))
    assert rest_of(model) == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_negative_stiffness_beside_a_cubic_has_two_places_of_rest(side):
    model = one_mass(Spring(-1e4), CubicStiffness(1e10), Damper(damping=5.0))
    assert_allclose(rest_of(model, side * 1e-5), side * 1e-3, rtol=1e-6)


def test_play_before_a_slider_loses_what_its_parallelogram_holds():
    """The loop is cut twice by the play: 4 Fs (A - a - Fs / k)."""
    effect = Series((Gap(1e5, 4e-5), CoulombFriction(2.0)))
    lost = 4.0 * 2.0 * (2e-4 - 4e-5 - 2.0 / 1e5)
    assert_allclose(work(effect, 2e-4), lost, rtol=1e-3)
    assert_allclose(work(effect, 5e-5), 0.0, atol=1e-12)  # never slips


def test_a_spring_and_a_slider_are_a_jenkins_element():
    (row,) = Series((Spring(1e5), CoulombFriction(2.0))).rows()
    assert row.law is Law.JENKINS
    assert_allclose(row.values, (1e5, 2.0))
    z, v = sine(1e-4)
    series = Series((Spring(1e5), CoulombFriction(2.0))).force_along(z, v, RATE)
    assert_allclose(series, Jenkins(1e5, 2.0).force_along(z, v, RATE), atol=1e-12)


def test_compliances_and_plays_add_up():
    two = Series((Gap(1e5, 3e-5), Gap(3e5, 1e-5)))
    assert_allclose(two.rows()[0].values, Gap(0.75e5, 4e-5).rows()[0].values)
    one_side = Series((Stop(1e5, 3e-5, "positive"), Spring(1e5)))
    (row,) = one_side.rows()
    assert_allclose(row.values, Stop(0.5e5, 3e-5, "positive").rows()[0].values)


def test_a_spring_and_a_damper_have_maxwells_complex_stiffness():
    k, c, omega = 1e5, 300.0, 2.0 * np.pi * 32.0
    z, v = sine(1e-4, 8)
    force = Series((Spring(k), Damper(damping=c))).force_along(z, v, RATE)[-1024:]
    wanted = 1.0 / (1.0 / k + 1.0 / (1j * omega * c))
    angle = omega * np.arange(z.size)[-1024:] / RATE
    assert_allclose(force, 1e-4 * np.imag(wanted * np.exp(1j * angle)), atol=1e-6 * 10.0)


@pytest.mark.parametrize(
    ("elements", "match"),
    [
        ((Gap(1e5, 1e-5),), "two at least"),
        ((CoulombFriction(1.0), Damper(damping=3.0)), "need a stiffness"),
        ((Gap(1e5, 0.0), CoulombFriction(1.0), CoulombFriction(2.0)), "one coulomb_friction"),
        ((Stop(1e5, 0.0, "positive"), Stop(1e5, 0.0, "negative")), "face apart"),
        ((Spring(1e5), CubicStiffness(1e9)), "cubic_stiffness cannot stand in series"),
        ((Spring(1e5), LuGreFriction(1.0, 2.0, 0.1, 1e5, 1.0, 0.0)), "lugre_friction cannot"),
        ((Spring(1e5), Damper(damping_ratio=0.1)), "use in_place"),
    ],
)
def test_a_series_that_cannot_be_added_up_is_refused(elements, match):
    with pytest.raises(ValueError, match=match):
        Series(elements)


def test_the_general_bouc_wen_law_holds_the_usual_one():
    k, slip, n = 1e5, 4e-5, 2.0
    half = 0.5 * k / (k * slip) ** n
    z, v = sine(1e-4)
    general = GeneralBoucWen(k, half, half, n).force_along(z, v, RATE)
    assert_allclose(general, BoucWen(k, slip, n).force_along(z, v, RATE), atol=1e-5)


@pytest.mark.parametrize("gamma", [-1100.0, 900.0])
def test_first_loading_of_the_published_benchmark_is_its_closed_form(gamma):
    """With n = 1, dF/dz = alpha - (beta + gamma) F; it hardens where beta + gamma < 0."""
    z = np.linspace(0.0, 3e-3, 3001)
    force = GeneralBoucWen(5e4, 800.0, gamma, 1.0).force_along(z, 0.0 * z, 1.0)
    sum_ = 800.0 + gamma
    assert_allclose(force, 5e4 / sum_ * -np.expm1(-sum_ * z), rtol=1e-6)
    assert (force[-1] > 5e4 * z[-1]) == (sum_ < 0.0)


def test_the_iwan_law_with_an_exponent_is_the_limit_of_many_sliders():
    chi, count = -0.5, 400
    edges = np.linspace(0.0, 1.0, count + 1)
    slips = 0.5 * (edges[1:] + edges[:-1])
    shares = np.diff(edges ** (chi + 1.0))
    z = 1.4 * np.sin(np.linspace(0.0, 12.0, 2000)) * np.linspace(0.1, 1.0, 2000)
    sliders = sum(
        Jenkins(2.0 * share, 2.0 * share * slip).force_along(z, 0.0 * z, 1.0)
        for share, slip in zip(shares, slips, strict=True)
    )
    assert_allclose(PowerIwan(2.0, 1.0, chi).force_along(z, 0.0 * z, 1.0), sliders, atol=2e-3)


def test_the_iwan_law_of_exponent_0_is_the_uniform_one():
    assert PowerIwan(1e5, 6e-5, 0.0).rows() == Iwan(1e5, 6e-5).rows()


PLANE = Table(
    (-1e-4, 0.0, 3e-4),
    (-0.1, 0.2),
    tuple((2e4 * z - 0.3, 2e4 * z + 0.6) for z in (-1e-4, 0.0, 3e-4)),
)


def test_a_table_of_a_plane_is_that_plane_and_goes_on_straight():
    z, v = np.meshgrid(np.linspace(-5e-4, 8e-4, 14), np.linspace(-0.7, 0.9, 9))
    assert_allclose(PLANE.force_at(z, v), 2e4 * z + 3.0 * v, atol=1e-12)


def test_a_table_goes_through_its_numbers_and_is_smooth_between_them():
    z = np.linspace(-1e-4, 1e-4, 9)
    rows = tuple((float(force),) for force in 3.0 * np.sin(2e4 * z))
    effect = Table(tuple(z), (0.0,), rows)
    assert_allclose(effect.force_at(z, 0.0 * z), np.ravel(rows), atol=1e-12)
    fine = np.linspace(-6e-5, 6e-5, 500)
    assert_allclose(effect.force_at(fine, 0.0 * fine), 3.0 * np.sin(2e4 * fine), atol=0.02)


def test_what_leaves_the_range_of_a_table_is_told():
    z = np.array([0.0, 4e-4])
    assert "displacement reached 0 to 0.0004 m" in PLANE.remark(z, 0.0 * z)
    assert PLANE.remark(0.5 * z, 0.0 * z) is None


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"displacement": (0.0, 0.0, 1.0)}, "displacement must rise"),
        ({"force": ((1.0, 2.0),)}, "force must have 3 rows"),
        ({"band": ((1.0,), (1.0,), (1.0,))}, "of 2 numbers"),
    ],
)
def test_a_table_whose_numbers_do_not_fit_is_refused(changed, match):
    values = {name: getattr(PLANE, name) for name in PLANE.parameters}
    with pytest.raises(ValueError, match=match):
        Table(**{**values, **changed})


MODEL = """\
model: 1
masses: {{coupon: 0.1 kg}}
elements:
  - {{kind: spring, between: [base, coupon], stiffness: 1e4 N/m}}
  - {element}
excitation: {{base: acceleration}}
"""


def read(tmp_path, element):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL.format(element=element))
    return read_model(path).elements[1].effect


def test_the_spellings_of_the_model_file(tmp_path):
    general = read(
        tmp_path,
        "{kind: bouc_wen, between: [base, coupon], alpha: 5e4 N/m, beta: 800 1/m, "
        "gamma: -1100 1/m, exponent: 1}",
    )
    assert general == GeneralBoucWen(5e4, 800.0, -1100.0, 1.0)
    assert read(
        tmp_path,
        "{kind: iwan, between: [base, coupon], stiffness: 1e5 N/m, slip_displacement: 60 um, "
        "chi: -0.5}",
    ) == PowerIwan(1e5, 6e-5, -0.5)
    assert read(
        tmp_path,
        "{kind: table, between: [base, coupon], displacement: -0.1 0 0.3 mm, "
        "velocity: '-100, 200 mm/s', force: [-2.3 -1.4 N, -0.3 0.6 N, 5.7 6.6 N]}",
    ).displacement == (-1e-4, 0.0, 3e-4)


@pytest.mark.parametrize(
    ("element", "match"),
    [
        ("{kind: series, between: [base, coupon], elements: gap}", ":5:.*list of elements"),
        (
            "{kind: series, between: [base, coupon], elements: [{kind: gap, clearance: 1 mm}, "
            "{kind: damper, damping: 1 N s/m}]}",
            "gap needs stiffness",
        ),
        (
            "{kind: series, between: [base, coupon], elements: [{kind: jenkins, "
            "stiffness: 1 N/m, slip_force: 1 N}, {kind: damper, damping: 1 N s/m}]}",
            "jenkins cannot stand in series",
        ),
        (
            "{kind: table, between: [base, coupon], displacement: 1 2 kg, velocity: 0 m/s, "
            "force: [1 N, 2 N]}",
            "kg",
        ),
        (
            "{kind: table, between: [base, coupon], displacement: 1 2 mm, velocity: 0 m/s, "
            "force: [1 N, two]}",
            "row 2: expected numbers",
        ),
        ("{kind: bouc_wen, between: [base, coupon], alpha: 1 N/m}", "needs beta"),
    ],
)
def test_what_a_model_file_gets_wrong_is_told_with_its_line(element, match, tmp_path):
    with pytest.raises(DocumentError, match=match):
        read(tmp_path, element)
