"""Annular solid: Fourier around, quadratic quadrilaterals over the cross-section.

It tells a clamp that holds the plate through its thickness from one that holds its two faces.
"""

from functools import lru_cache
from typing import Any

import numpy as np
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Clamp, Coupon, IndexArray
from shakerproc.finite_elements.lowest_modes import lowest_modes


def solid_frequencies(
    coupon: Coupon,
    diameters: int,
    count: int,
    *,
    clamp: Clamp = "faces",
    elements: int = 24,
) -> FloatArray:
    """Return the lowest natural frequencies of the coupon's bending, as a solid [Hz].

    Motion out of plane is the same on both sides of the middle plane and motion in the plane
    is opposite, which leaves out the modes of stretching.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions; the hole counts as round, with its length as diameter.
    diameters : int
        Number of nodal diameters.
    count : int
        How many frequencies.
    clamp : {"faces", "all nodes"}
        What is held inside the clamped radius: the two faces, or all of the material.
    elements : int
        Elements outside the clamp along the radius; 4 through the thickness.

    Returns
    -------
    (count,) array
        Natural frequencies, rising [Hz].
    """
    basis, stiffness, mass = _matrices(coupon, diameters, elements)
    held = _held(basis, coupon, clamp)
    free = np.setdiff1d(np.arange(basis.N), held)
    return lowest_modes(stiffness[free][:, free], mass[free][:, free], count)[0]


@lru_cache(maxsize=2)  # both clamps need the same
def _matrices(coupon: Coupon, diameters: int, elements: int) -> tuple[Basis, Any, Any]:
    basis = _basis(coupon, elements)
    stiffness = _stiffness_form(coupon, diameters).assemble(basis)
    return basis, stiffness, _mass_form(coupon.material.density).assemble(basis)


def _basis(coupon: Coupon, elements: int) -> Basis:
    hole, clamped = coupon.hole.length / 2.0, coupon.clamped_radius
    inner = clamped + (hole - clamped) * (np.linspace(1.0, 0.0, elements // 2 + 1) ** 2)
    share = (
        np.linspace(0.0, 1.0, elements + 1) ** 2
    )  # finest at the clamp, where it is singular
    outer = clamped + (coupon.outer_radius - clamped) * share
    along = np.concatenate([inner[:-1], outer]) if hole < clamped else outer
    across = np.linspace(-coupon.thickness / 2.0, coupon.thickness / 2.0, 5)
    mesh = MeshQuad.init_tensor(along, across)
    return Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=5)


def _held(basis: Basis, coupon: Coupon, clamp: Clamp) -> IndexArray:
    radius, height = basis.doflocs
    inside = radius <= coupon.clamped_radius * (1.0 + 1e-9)
    at_face = np.abs(height) >= 0.5 * coupon.thickness * (1.0 - 1e-9)
    held = inside & at_face if clamp == "faces" else inside
    across = np.zeros(basis.N, dtype=bool)
    across[basis.get_dofs(elements=True).all(["u^3"])] = True
    in_middle = np.abs(height) < 1e-9 * coupon.thickness
    return np.flatnonzero(held | (in_middle & ~across))


def _stiffness_form(coupon: Coupon, n: int) -> BilinearForm:
    nu, young = coupon.material.poissons_ratio, coupon.material.youngs_modulus
    shear = young / (2.0 * (1.0 + nu))
    first = young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    def strains(field: Any, r: FloatArray) -> tuple[FloatArray, ...]:
        (u, v, w), d = np.asarray(field), np.asarray(field.grad)
        return (
            d[0, 0],
            (u + n * v) / r,
            d[2, 1],
            d[1, 0] - (v + n * u) / r,
            d[0, 1] + d[2, 0],
            d[1, 1] - n * w / r,
        )

    @BilinearForm
    def form(u: Any, v: Any, at: Any) -> Any:
        r = at.x[0]
        a, b = strains(u, r), strains(v, r)
        normal = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
        shearing = a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
        volume = (a[0] + a[1] + a[2]) * (b[0] + b[1] + b[2])
        return (first * volume + shear * (2.0 * normal + shearing)) * r

    return form


def _mass_form(density: float) -> BilinearForm:
    @BilinearForm
    def form(u: Any, v: Any, at: Any) -> Any:
        return density * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * at.x[0]

    return form
