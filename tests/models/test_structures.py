"""Structures by their modes against the chains of masses that they are made of."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh

from shakerproc.models import EFFECTS, Element, Excitation, Model, Sensor
from shakerproc.models.coordinates import coordinates_of
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.simulation import Runs, free_runs, prepare, simulate
from shakerproc.simulation.harmonic_balance.response import frequency_response

RATE = 4000.0
MASSES = np.array([0.4, 0.7, 0.5, 0.3])
LINKS = np.array([3e5, 5e5, 2e5])
DAMPING = 4e-5  # s: damping in proportion to stiffness, so that modes are real
POINTS = tuple(f"p{i}" for i in range(MASSES.size))
FEET = (
    Element(EFFECTS["spring"](stiffness=1.5e5), ("base", "p0")),
    Element(EFFECTS["damper"](damping=6.0), ("base", "p0")),
    Element(EFFECTS["spring"](stiffness=2.5e5), ("base", "p3")),
    Element(EFFECTS["damper"](damping=3.0), ("base", "p3")),
)
SENSORS = {
    "a1": Sensor("p1"),
    "z3": Sensor("p3", "relative displacement"),
    "v0": Sensor("p0", "relative velocity"),
    "x2": Sensor("p2", "displacement"),
}


def links():
    """The elements that make a chain of four masses."""
    made = []
    for i, stiffness in enumerate(LINKS):
        between = (POINTS[i], POINTS[i + 1])
        made.append(Element(EFFECTS["spring"](stiffness=stiffness), between))
        made.append(Element(EFFECTS["damper"](damping=DAMPING * stiffness), between))
    return tuple(made)


def matrix(*springs):
    """The stiffness matrix of the chain, with springs to ground."""
    found = np.diag([*springs, *np.zeros(MASSES.size - len(springs))])
    for i, stiffness in enumerate(LINKS):
        found[np.ix_((i, i + 1), (i, i + 1))] += stiffness * np.array([[1, -1], [-1, 1]])
    return found


def by_modes(stiffness, *, participations=False):
    """The chain by all its modes."""
    squares, shapes = eigh(stiffness, np.diag(MASSES))
    omega = np.sqrt(np.where(np.abs(squares) < 1e-6 * squares[-1], 0.0, squares))
    modes = tuple(
        StructureMode(
            w / (2.0 * np.pi), DAMPING * w / 2.0, tuple(shape),
            float(shape @ MASSES) if participations else None,
        )
        for w, shape in zip(omega, shapes.T, strict=True)
    )  # fmt: skip
    return Structure(POINTS, modes)


def chain(*effects, excitation="base acceleration", on=None, between=("base", "p3")):
    """The chain as masses on its feet, with effects at the last one."""
    extra = tuple(Element(effect, between) for effect in effects)
    masses = dict(zip(POINTS, MASSES, strict=True))
    drive = Excitation(excitation, on)
    return Model("chain", masses, (*links(), *FEET, *extra), drive, SENSORS)


def structure(model, one=None):
    """The same with the chain by its modes, free-free."""
    elements = tuple(e for e in model.elements if e not in links())
    one = by_modes(matrix()) if one is None else one
    return replace(model, masses={}, elements=elements, structures={"body": one})


def outputs(model, **more):
    noise = np.random.default_rng(3).standard_normal(1200)
    size = 30.0 if model.excitation.moves_base else 40.0
    return simulate(model, size * noise, RATE, growth=False, **more).outputs


def assert_alike(first, second, rtol=1e-9):
    for name, row in first.items():
        assert_allclose(second[name], row, rtol=0.0, atol=rtol * np.max(np.abs(row)))


EFFECTS_TRIED = {
    "linear": (),
    "gap": (EFFECTS["gap"](stiffness=4e5, clearance=1e-4),),
    "cubic": (EFFECTS["cubic_stiffness"](coefficient=2e12),),
    "coulomb": (EFFECTS["coulomb_friction"](sliding_force=3.0),),
    "jenkins": (EFFECTS["jenkins"](stiffness=2e5, slip_force=4.0),),
}


@pytest.mark.parametrize("excitation", ["base acceleration", "force"])
@pytest.mark.parametrize("effects", EFFECTS_TRIED.values(), ids=EFFECTS_TRIED)
def test_a_chain_by_its_modes_moves_as_the_chain_of_masses(effects, excitation):
    model = chain(*effects, excitation=excitation, on="p1" if excitation == "force" else None)
    assert_alike(outputs(model), outputs(structure(model)))


def test_modes_of_a_fixed_base_with_participations_move_as_free_ones_with_rigid_body_modes():
    """The chain stands on its springs to the base, which are then no elements any more."""
    model = chain(*EFFECTS_TRIED["gap"])
    held = by_modes(matrix(1.5e5), participations=True)
    feet = tuple(e for e in model.elements if e not in FEET[:2])
    rest = replace(
        model, elements=(*feet, Element(EFFECTS["spring"](stiffness=1.5e5), ("base", "p0")))
    )
    fixed = structure(rest, held)
    springs = [e for e in fixed.elements if e.between != ("base", "p0")]
    fixed = replace(fixed, elements=tuple(springs))
    damped = Element(EFFECTS["damper"](damping=DAMPING * 1.5e5), ("base", "p0"))
    assert_alike(outputs(replace(rest, elements=(*rest.elements, damped))), outputs(fixed))


def test_periodic_motions_by_harmonic_balance_balance_the_forces_of_the_chain():
    model = chain(*EFFECTS_TRIED["cubic"])
    modal = structure(model)
    band = {"from_hz": 40.0, "to_hz": 70.0, "harmonics": 3}
    branch = frequency_response(modal, 5.0, **band).branches[0]
    linear = coordinates_of(modal)
    directions = np.array([linear.at(point) for point in POINTS])
    balance = frequency_response(model, 5.0, **band).branches[0].balance
    load = np.linalg.norm(balance.load)
    for frequency, motion in zip(branch.frequency, branch.coefficients, strict=True):
        unknowns = balance.real(directions @ motion)
        left = balance.residual(unknowns, 2.0 * np.pi * frequency).force
        assert np.linalg.norm(left) < 1e-9 * load


def test_the_frequency_response_is_that_of_mass_damping_and_stiffness():
    """Against (K + i w C - w^2 M)^-1 of the whole chain, written out here."""
    frequency, model = (
        np.linspace(5.0, 400.0, 200),
        structure(chain(excitation="force", on="p1")),
    )
    damping = DAMPING * matrix() + np.diag([6.0, 0.0, 0.0, 3.0])
    stiffness = matrix() + np.diag([1.5e5, 0.0, 0.0, 2.5e5])
    linear = coordinates_of(model)
    for f in frequency:
        w = 2.0 * np.pi * f
        whole = stiffness + 1j * w * damping - w**2 * np.diag(MASSES)
        modal = linear.stiffness + 1j * w * linear.damping - w**2 * np.diag(linear.mass)
        wanted = np.linalg.solve(whole, np.eye(4)[1])
        found = np.array([linear.at(p) for p in POINTS]) @ np.linalg.solve(modal, linear.load)
        assert_allclose(found, wanted, rtol=1e-9)


def test_windows_of_a_test_are_those_of_the_chain_also_where_a_law_has_memory():
    noise = 40.0 * np.random.default_rng(5).standard_normal(800)
    for name in ("gap", "jenkins", "cubic"):
        model = chain(*EFFECTS_TRIED[name])
        runs = Runs((prepare(noise, RATE),), np.array([[0, 0, 800], [0, 200, 300]]))
        first, second = (free_runs(one, runs) for one in (model, structure(model)))
        for row, other in zip(first.outputs, second.outputs, strict=True):
            size = np.max(np.abs(row), axis=1, keepdims=True)
            assert_allclose(other / size, row / size, rtol=0.0, atol=2e-5)
