"""General Bouc-Wen elements far in saturation, beside closed forms and scipy's solver."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import BoucWen, Damper, GeneralBoucWen, Spring
from shakerproc.simulation import (
    Runs,
    free_runs,
    largest_states,
    prepare,
    prepare_displacement,
    simulate,
)

STIFFNESS, YIELD, RATE, DRIVEN = 1e5, 1e-4, 1000.0, 10.0
TIME = np.arange(round(2.25 * RATE / DRIVEN)) / RATE
SINE = np.sin(2.0 * np.pi * DRIVEN * TIME)
TURNS = np.arange(25, TIME.size, 50)
AMPLITUDES = (0.1, 1.0, 10.0, 100.0)


def law(exponent, loading, back):
    """Return the law whose slope falls by these shares of (h / yield)^n."""
    size = STIFFNESS * (STIFFNESS * YIELD) ** -exponent
    beta, gamma = 0.5 * (loading - back) * size, 0.5 * (loading + back) * size
    return GeneralBoucWen(STIFFNESS, beta, gamma, exponent)


def forces(effect, displacement):
    """Return the force that imposes a displacement, by the fine and by the quick stepper."""
    model = Model(
        "rod", {"rod": 1e-9}, (Element(effect, ("base", "rod")),),
        Excitation("imposed displacement", "rod"), {"force": Sensor("rod", "force")},
    )  # fmt: skip
    fine = simulate(model, displacement, RATE, growth=False).outputs["force"]
    whole = Runs(
        (prepare_displacement(displacement, RATE),), np.array([[0, 0, displacement.size]])
    )
    quick = free_runs(model, whole, means=False)
    assert not quick.failed.any()
    return fine, quick.outputs[0][0]


def one_curve(way, exponent):
    """Return the force of a law whose branches are one, over that of yield, by scipy."""
    size = np.abs(way)
    found = solve_ivp(
        lambda _u, h: 1.0 - h**exponent, (0.0, max(np.max(size), 1.0)), [0.0], "DOP853",
        dense_output=True, rtol=1e-13, atol=1e-15,
    )  # fmt: skip
    return np.sign(way) * found.sol(size)[0]


CURVES = {
    1.0: lambda way: -np.sign(way) * np.expm1(-np.abs(way)),
    2.0: np.tanh,
    1.5: lambda way: one_curve(way, 1.5),
    3.0: lambda way: one_curve(way, 3.0),
    4.0: lambda way: one_curve(way, 4.0),
}


@pytest.mark.parametrize("times", AMPLITUDES)
@pytest.mark.parametrize("exponent", CURVES)
def test_branches_that_are_one_are_a_spring_however_far_it_saturates(exponent, times):
    way = times * SINE
    wanted = STIFFNESS * YIELD * CURVES[exponent](way)
    effect = law(exponent, 1.0, 1.0)
    fine, quick = forces(effect, YIELD * way)
    size = np.max(np.abs(wanted))
    within = slice(20, -20)  # interpolation rests on predictions near the ends
    assert_allclose(fine[within], wanted[within], rtol=0.0, atol=1e-8 * size)
    assert_allclose(quick[within], wanted[within], rtol=0.0, atol=1e-5 * size)
    along = effect.force_along(YIELD * way, np.gradient(YIELD * way, 1.0 / RATE), RATE)
    assert_allclose(along, wanted, rtol=0.0, atol=1e-11 * size)


def hysteresis(way, exponent, loading, back):
    """Return the force between turning points over that of yield, branch by branch by scipy."""
    found, held, first = np.zeros_like(way), 0.0, 0
    ends = [0.0, *way[TURNS]]
    for here, there, last in zip(ends[:-1], ends[1:], TURNS + 1, strict=True):
        side, left = np.sign(there - here), abs(there - here)
        ahead, begun = np.abs(way[first:last] - here), 0.0
        while begun < left:
            returns = held * side < 0.0
            share = back if returns else loading

            def at_rest(_x, h):
                return h[0]

            at_rest.terminal = True
            branch = solve_ivp(
                lambda _x, h, side=side, share=share: side
                * (1.0 - share * np.abs(h) ** exponent),
                (begun, left), [held], "DOP853", dense_output=True, rtol=1e-11, atol=1e-14,
                events=at_rest if returns else None,
            )  # fmt: skip
            inside = (ahead >= begun) & (ahead <= branch.t[-1])
            if inside.any():
                found[first:last][inside] = branch.sol(ahead[inside])[0]
            begun, held = branch.t[-1], 0.0 if branch.status == 1 else branch.y[0, -1]
        first = last
    return found


@pytest.mark.parametrize(
    ("exponent", "loading", "back", "times"),
    [
        (1.0, 1.0, 0.98, 30.0),
        (2.0, 1.0, 0.6, 10.0),
        (2.0, 1.0, 0.98, 30.0),
        (1.5, 1.0, 0.6, 10.0),
        (3.0, 1.0, -0.5, 10.0),
        (2.0, 1.0, 0.0, 30.0),
        (4.0, 0.2, -0.2, 10.0),
        (1.0, -0.3, -1.0, 3.0),
        (1.0, -1.0, -1.0, 3.0),
        (2.0, 1.0, 1.2, 1.0),
    ],
)
def test_loops_are_those_of_scipy_branch_by_branch(exponent, loading, back, times):
    way = times * SINE[: TURNS[-1] + 1]
    wanted = STIFFNESS * YIELD * hysteresis(way, exponent, loading, back)
    fine, quick = forces(law(exponent, loading, back), YIELD * times * SINE)
    size, within = np.max(np.abs(wanted)), slice(20, TURNS[-1] - 20)
    assert_allclose(fine[within], wanted[within], rtol=0.0, atol=1e-8 * size)
    assert_allclose(quick[within], wanted[within], rtol=0.0, atol=1e-4 * size)


def test_a_mass_on_a_saturating_spring_moves_as_on_that_spring():
    sensors = {"z": Sensor("rod", "relative displacement")}
    effects = (Spring(2e4), Damper(damping=8.0), law(2.0, 1.0, 1.0))
    joined = tuple(Element(effect, ("base", "rod")) for effect in effects)
    model = Model("rod", {"rod": 1.0}, joined, Excitation("force", "rod"), sensors)
    given = prepare(lambda t: 30.0 * np.sin(2.0 * np.pi * 21.0 * t), RATE, duration=1.0)

    def rates(t, y):
        force = 30.0 * np.sin(2.0 * np.pi * 21.0 * t)
        held = 2e4 * y[0] + 8.0 * y[1] + STIFFNESS * YIELD * np.tanh(y[0] / YIELD)
        return y[1], force - held

    times = np.arange(given.n_samples) / RATE
    solved = solve_ivp(
        rates, (0.0, times[-1]), (0.0, 0.0), "DOP853", times, rtol=1e-11, atol=1e-14,
        max_step=2e-4,
    )  # fmt: skip
    size = np.max(np.abs(solved.y[0]))
    assert size > 50.0 * YIELD
    fine = simulate(model, given, growth=False).outputs["z"]
    assert_allclose(fine, solved.y[0], rtol=0.0, atol=1e-8 * size)
    quick = free_runs(model, Runs((given,), np.array([[0, 0, given.n_samples]])), means=False)
    assert_allclose(quick.outputs[0][0], solved.y[0], rtol=0.0, atol=5e-5 * size)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 2.7])
def test_no_way_back_is_longer_than_that_from_the_largest_force(exponent):
    """By the closed forms of exponents 1 and 2; by the slope of the branch for others."""
    share = 0.9
    model = Model(
        "rod", {"rod": 1.0}, (Element(law(exponent, 1.0, share), ("base", "rod")),),
        Excitation("force", "rod"), {},
    )  # fmt: skip
    heights = np.linspace(0.0, 1.0, 200_001)
    wanted = np.trapezoid(1.0 / (1.0 - share * heights**exponent), heights)
    assert largest_states(model)[0] == pytest.approx([YIELD, wanted * YIELD], rel=1e-7)
    same = Model(
        "rod", {"rod": 1.0}, (Element(law(exponent, 1.0, 1.0), ("base", "rod")),),
        Excitation("force", "rod"), {},
    )  # fmt: skip
    assert np.isinf(largest_states(same)[0, 1])


def test_the_memory_of_an_element_that_unloads_straight_is_its_stretch():
    effect = BoucWen(STIFFNESS, YIELD, 2.0)
    way = 3.0 * YIELD * SINE
    model = Model(
        "rod", {"rod": 1e-9}, (Element(effect, ("base", "rod")),),
        Excitation("imposed displacement", "rod"), {"force": Sensor("rod", "force")},
    )  # fmt: skip
    found = simulate(model, way, RATE, growth=False)
    inertia = 1e-9 * found.acceleration[0]
    force = found.outputs["force"] - inertia
    assert_allclose(STIFFNESS * found.states[0], force, rtol=0.0, atol=1e-9 * STIFFNESS * YIELD)
