"""Static stiffness of a disc against a load on the edge of its hole, by law, angle and mesh."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Any, Final, Literal, TypeAlias, final

import numpy as np
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    MeshQuad2,
    condense,
    solve,
)
from skfem.utils import solver_direct_scipy

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Coupon, Hole, IndexArray, Material

Plane: TypeAlias = Literal["strain", "stress"]
Axis: TypeAlias = Literal["length", "width"]

_SOLVER = solver_direct_scipy(permc_spec="MMD_AT_PLUS_A")  # three times faster than COLAMD
Spread: TypeAlias = Callable[[FloatArray, FloatArray], FloatArray]

# of the normal (2, ...) out of the material and the cosine of the angle from the load
LOAD_LAWS: Mapping[str, Spread] = MappingProxyType({
    "traction": lambda normal, _: np.stack([np.ones_like(normal[0]), np.zeros_like(normal[0])]),
    "pressure": lambda normal, _: -normal,
    "cosine bearing": lambda normal, cosine: -normal * cosine,
})
"""How the bushing's force spreads over the loaded arc of the hole: its direction there."""

MESHES: Final = (1, 2, 3)
"""Refinements of which the convergence is shown; the last counts."""

_PLANES: Final[tuple[Plane, ...]] = ("strain", "stress")

_LOADS: Final = (
    *((law, np.pi / 2.0) for law in LOAD_LAWS),
    ("traction", np.radians(85.0)),
    ("traction", np.radians(60.0)),
)


@final
@dataclass(frozen=True, slots=True, eq=False)
class HoleStiffness:
    """Displacements of the hole for a unit of force.

    Attributes
    ----------
    stiffness : float
        Force over the largest displacement [N/m].
    points : (2, n_points) array
        Nodes of half the disc, the load along the first axis [m].
    displacement : (2, n_points) array
        Their displacement for a force of 1 N [m].
    """

    stiffness: float
    points: FloatArray
    displacement: FloatArray


def hole_stiffness(
    coupon: Coupon,
    *,
    law: str = "traction",
    half_angle: float = np.pi / 2.0,
    plane: Plane = "strain",
    axis: Axis = "length",
    refinement: int = 2,
) -> HoleStiffness:
    """Return the in-plane stiffness of the disc, its rim fixed, loaded on the hole's edge.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    law : str
        Key of `LOAD_LAWS`.
    half_angle : float
        The load acts where the polar angle from its direction is smaller than this [rad].
    plane : {"strain", "stress"}
        Faces held (u = 0 across them) or free.
    axis : {"length", "width"}
        Direction of the load in a slot.
    refinement : int
        1, 2, 4 ...: twice the number halves every element.

    Returns
    -------
    HoleStiffness
        Stiffness [N/m] with the displacement field.

    Raises
    ------
    ValueError
        If the load law is not known.
    """
    if law not in LOAD_LAWS:
        raise ValueError(f"law must be one of {', '.join(LOAD_LAWS)}, not {law!r}")
    mesh = half_disc(coupon.hole, coupon.outer_radius, axis, refinement, half_angle)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    stiffness = _elastic_form(coupon.material, plane).assemble(basis)
    load, resultant = _edge_load(mesh, LOAD_LAWS[law], half_angle)
    force = load / (2.0 * coupon.thickness * resultant)  # half of 1 N on half of the disc
    reduced = condense(stiffness, force, D=_fixed_dofs(basis, coupon.outer_radius))
    displacement = solve(*reduced, solver=_SOLVER)
    field = np.stack([displacement[_component(basis, 0)], displacement[_component(basis, 1)]])
    largest = float(np.max(np.hypot(*field)))
    return HoleStiffness(1.0 / largest, basis.doflocs[:, _component(basis, 0)], field)


def pressed_displacement(coupon: Coupon, pressure: float, *, refinement: int = 2) -> float:
    """Return the displacement of the hole's edge under pressure all around, plane strain [m].

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    pressure : float
        [Pa].
    refinement : int
        As in `hole_stiffness`.
    """
    mesh = half_disc(coupon.hole, coupon.outer_radius, "length", refinement)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    stiffness = _elastic_form(coupon.material, "strain").assemble(basis)
    load, _ = _edge_load(mesh, LOAD_LAWS["pressure"], np.pi)
    held = _fixed_dofs(basis, coupon.outer_radius)
    displacement = solve(*condense(stiffness, pressure * load, D=held), solver=_SOLVER)
    return float(np.max(np.abs(displacement)))


def half_disc(
    hole: Hole,
    outer_radius: float,
    axis: Axis,
    refinement: int,
    half_angle: float = np.pi / 2.0,
) -> MeshQuad2:
    """Return the upper half of the disc as curved quadrilaterals, the load along x.

    Parameters
    ----------
    hole : Hole
        The opening.
    outer_radius : float
        [m].
    axis : {"length", "width"}
        Which axis of the hole lies along x.
    refinement : int
        Multiplies the number of elements both ways.
    half_angle : float
        Where the load ends: no element reaches across [rad].

    Returns
    -------
    MeshQuad2
        Isoparametric mesh.
    """
    half_straight = (hole.length - hole.width) / 2.0
    corner = np.arctan2(hole.width / 2.0, half_straight)  # where the straight side begins
    if axis == "width":
        corner = np.pi / 2.0 - corner
    ends = np.unique(np.round([0.0, corner, half_angle, np.pi - corner, np.pi], 12))
    angles = np.unique(
        np.concatenate([
            np.linspace(
                start, stop, max(1, round(24 * (stop - start) / np.pi)) * refinement + 1
            )
            for start, stop in pairwise(ends)
        ]).round(12)
    )
    outward = np.linspace(0.0, 1.0, 12 * refinement + 1)
    flat = MeshQuad2.from_mesh(MeshQuad.init_tensor(outward, angles))
    return _curved(flat, hole, outer_radius, axis)


def _curved(flat: MeshQuad2, hole: Hole, outer_radius: float, axis: Axis) -> MeshQuad2:
    outward, angle = flat.doflocs
    inner = edge_radius(hole, angle if axis == "length" else angle + np.pi / 2.0)
    radius = inner * (outer_radius / inner) ** outward  # geometric: finest at the hole
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)])
    return MeshQuad2(points, flat.t)


def edge_radius(hole: Hole, angle: FloatArray) -> FloatArray:
    """Return the distance of the hole's edge from its centre [m].

    Parameters
    ----------
    hole : Hole
        The opening.
    angle : (n,) array
        Polar angle from its first axis [rad].

    Returns
    -------
    (n,) array
        [m].
    """
    end, half_straight = hole.width / 2.0, (hole.length - hole.width) / 2.0
    sine, cosine = np.abs(np.sin(angle)), np.abs(np.cos(angle))
    on_side = end * cosine <= half_straight * sine
    side = end / np.maximum(sine, 1e-12)
    round_end = half_straight * cosine + np.sqrt(
        np.maximum(end**2 - (half_straight * sine) ** 2, 0.0)
    )
    return np.where(on_side, side, round_end)


def _elastic_form(material: Material, plane: Plane) -> BilinearForm:
    young, nu = material.youngs_modulus, material.poissons_ratio
    shear = young / (2.0 * (1.0 + nu))
    first = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    if plane == "stress":
        first = 2.0 * first * shear / (first + 2.0 * shear)

    @BilinearForm
    def form(u: Any, v: Any, _: Any) -> Any:
        a, b = u.grad, v.grad
        volume = (a[0, 0] + a[1, 1]) * (b[0, 0] + b[1, 1])
        normal = a[0, 0] * b[0, 0] + a[1, 1] * b[1, 1]
        shearing = (a[0, 1] + a[1, 0]) * (b[0, 1] + b[1, 0])
        return first * volume + shear * (2.0 * normal + shearing)

    return form


def _edge_load(mesh: MeshQuad2, law: Spread, half_angle: float) -> tuple[FloatArray, float]:
    """Return the load vector of the law and its resultant along x, both per thickness."""
    middle = np.hypot(*mesh.p[:, mesh.facets].mean(axis=1))
    boundary = mesh.boundary_facets()
    rim = np.max(np.hypot(*mesh.p))
    closed = np.abs(mesh.p[1, mesh.facets]).max(axis=0) > 1e-9 * rim  # not on the symmetry line
    hole = boundary[(middle[boundary] < 0.5 * rim) & closed[boundary]]
    basis = FacetBasis(mesh, ElementVector(ElementQuad2()), facets=hole, intorder=6)

    def direction(at: Any) -> FloatArray:
        cosine = at.x[0] / np.hypot(*at.x)
        return np.asarray(law(at.n, cosine) * (cosine >= np.cos(half_angle)))

    @LinearForm
    def form(v: Any, at: Any) -> Any:
        along, across = direction(at)
        return along * v[0] + across * v[1]

    load = form.assemble(basis)
    uniform = np.zeros(basis.N)
    uniform[_component(basis, 0)] = 1.0
    return load, float(uniform @ load)


def _component(basis: Any, which: int) -> IndexArray:
    """Return the degrees of freedom of one component, in the order of their places."""
    names = basis.get_dofs(elements=True)
    return np.asarray(np.sort(names.all([f"u^{which + 1}"])))


def _fixed_dofs(basis: Any, outer_radius: float) -> IndexArray:
    x, y = basis.doflocs
    rim = np.hypot(x, y) > outer_radius * (1.0 - 1e-6)
    second = np.zeros(basis.N, dtype=bool)
    second[_component(basis, 1)] = True
    return np.flatnonzero(rim | (second & (np.abs(y) < 1e-9 * outer_radius)))


@final
@dataclass(frozen=True, slots=True)
class LoadedHole:
    """Stiffness under one assumption.

    Attributes
    ----------
    law : str
        Key of `LOAD_LAWS`.
    half_angle : float
        Of the loaded arc [rad].
    plane : {"strain", "stress"}
        Faces held or free.
    stiffness : float
        Force over the largest displacement [N/m].
    frequency : float
        Of the coupon's mass on that stiffness [Hz].
    """

    law: str
    half_angle: float
    plane: Plane
    stiffness: float
    frequency: float


def loaded_holes(coupon: Coupon, axis: Axis = "length") -> tuple[LoadedHole, ...]:
    """Return the stiffness for every load law, two half-angles, faces held and free.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    axis : {"length", "width"}
        Direction of the load in a slot.
    """
    assumptions = [(law, angle, plane) for plane in _PLANES for law, angle in _LOADS]
    return tuple(
        loaded_hole(coupon, axis, law, angle, plane, refinement=1)  # good to a thousandth
        for law, angle, plane in assumptions
    )


def loaded_hole(
    coupon: Coupon, axis: Axis, law: str, half_angle: float, plane: Plane, *, refinement: int
) -> LoadedHole:
    """Return the stiffness under one assumption; for the arguments see `hole_stiffness`.

    `half_angle` is in [rad].
    """
    stiffness = hole_stiffness(
        coupon, law=law, half_angle=half_angle, plane=plane, axis=axis, refinement=refinement
    ).stiffness
    return LoadedHole(law, half_angle, plane, stiffness, joint_frequency(stiffness, coupon))


def joint_frequency(stiffness: float, coupon: Coupon) -> float:
    r"""Return the frequency of the coupon on its hole, :math:`\sqrt{k/m} / 2 \pi` [Hz]."""
    return float(np.sqrt(stiffness / coupon.mass) / (2.0 * np.pi))


def mesh_convergence(
    coupon: Coupon, axis: Axis, law: str, half_angle: float, plane: Plane
) -> Mapping[int, float]:
    """Return the stiffness by number of elements, on `MESHES` [N/m]."""
    return {
        half_disc(coupon.hole, coupon.outer_radius, axis, n, half_angle).nelements: (
            hole_stiffness(
                coupon, law=law, half_angle=half_angle, plane=plane, axis=axis, refinement=n
            ).stiffness
        )
        for n in MESHES
    }
