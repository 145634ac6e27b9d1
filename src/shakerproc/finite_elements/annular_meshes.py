"""Finite elements of an annular plate: a solid by Fourier rings, a polar mesh of shells.

`named_modes` sets them beside the plates of theory.

The solid tells a clamp that holds the plate through its thickness from one that holds its two
faces.

The frequencies of the shells, the mesh of a Nastran user, hold the error of such a mesh;
`mindlin_modes` has none to speak of. Their mass is lumped at the nodes, as Nastran does unless
told otherwise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, final

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array
from scipy.sparse.linalg import LinearOperator, eigsh, splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad

from shakerproc.data import FloatArray
from shakerproc.finite_elements.annular_plate import (
    SHEAR_CORRECTION,
    mindlin_modes,
    plate_frequency,
    plate_roots,
)
from shakerproc.finite_elements.coupon import Clamp, Coupon, IndexArray


def lowest_modes(
    stiffness: csr_array, mass: csr_array, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return the lowest natural frequencies and their shapes.

    Parameters
    ----------
    stiffness, mass : (n, n) sparse array
        Symmetric, the stiffness of something that is held.
    count : int
        How many.

    Returns
    -------
    frequencies : (count,) array
        Rising [Hz].
    shapes : (n, count) array
        Of modal mass 1.
    """
    # a quarter of the entries, and of the time, of the ordering that eigsh would choose itself
    factors = splu(
        csc_array(stiffness),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    size = mass.shape[0]
    squared, shapes = eigsh(
        stiffness,
        k=count,
        M=mass,
        sigma=0.0,
        OPinv=LinearOperator((size, size), matvec=factors.solve, dtype=np.float64),
        v0=np.ones(size),
    )
    order = np.argsort(squared)
    return np.sqrt(squared[order]) / (2.0 * np.pi), shapes[:, order]


def solid_frequencies(
    coupon: Coupon,
    diameters: int,
    count: int,
    *,
    clamp: Clamp = "faces",
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

    Returns
    -------
    (count,) array
        Natural frequencies, rising [Hz].
    """
    basis, stiffness, mass = _ring_matrices(coupon, diameters, 24)
    held = _clamped_dofs(basis, coupon, clamp)
    free = np.setdiff1d(np.arange(basis.N), held)
    return lowest_modes(stiffness[free][:, free], mass[free][:, free], count)[0]


@lru_cache(maxsize=2)  # both clamps need the same
def _ring_matrices(coupon: Coupon, diameters: int, elements: int) -> tuple[Basis, Any, Any]:
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


def _clamped_dofs(basis: Basis, coupon: Coupon, clamp: Clamp) -> IndexArray:
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


_GAUSS = 1.0 / np.sqrt(3.0)
_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@final
@dataclass(frozen=True, slots=True, eq=False)
class ShellModes:
    """The lowest modes of the mesh.

    Attributes
    ----------
    frequencies : (n_modes,) array
        Natural frequencies, rising [Hz]; modes with nodal diameters come in pairs.
    diameters, circles : (n_modes,) array
        Nodal diameters and nodal circles, the clamp not counted.
    """

    frequencies: FloatArray
    diameters: IndexArray
    circles: IndexArray


def shell_modes(
    coupon: Coupon, count: int, *, radial: int = 20, around: int = 80
) -> ShellModes:
    """Return the lowest modes of radial x around MITC4 elements.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    count : int
        How many; modes with nodal diameters come in pairs.
    radial, around : int
        Elements along the radius and around; 20 x 80 are the thesis' 1600.

    Returns
    -------
    ShellModes
        Frequencies [Hz] and what the modes look like.

    References
    ----------
    .. [1] K.-J. Bathe and E. N. Dvorkin, "A four-node plate bending element based on
       Mindlin/Reissner plate theory and a mixed interpolation", International Journal for
       Numerical Methods in Engineering 21, 367-383, 1985.
    """
    nodes, quads = _polar_mesh(coupon, radial, around)
    stiffness, mass = _element_matrices(coupon, nodes[quads])
    dofs = (3 * quads[:, :, np.newaxis] + np.arange(3)).reshape(len(quads), 12)
    free = np.arange(3 * around, 3 * len(nodes))  # the first ring is clamped
    frequencies, shapes = lowest_modes(
        _assemble(stiffness, dofs)[free][:, free], _assemble(mass, dofs)[free][:, free], count
    )
    deflection = shapes[::3].T.reshape(count, radial, around)
    named = np.array([_nodal_lines(shape) for shape in deflection])
    return ShellModes(frequencies, named[:, 0], named[:, 1])


def _nodal_lines(deflection: FloatArray) -> tuple[int, int]:
    """Return nodal diameters and circles of a (rings, places) array of deflections."""
    waves = np.fft.rfft(deflection, axis=1)
    diameters = int(np.argmax(np.sum(np.abs(waves) ** 2, axis=0)))
    along = waves[:, diameters]
    profile = np.real(along * np.conj(along[np.argmax(np.abs(along))]))
    clear = profile[np.abs(profile) > 1e-3 * np.max(np.abs(profile))]
    return diameters, int(np.count_nonzero(np.diff(np.sign(clear))))


def _polar_mesh(coupon: Coupon, radial: int, around: int) -> tuple[FloatArray, IndexArray]:
    radii = np.linspace(coupon.clamped_radius, coupon.outer_radius, radial + 1)
    angles = 2.0 * np.pi * np.arange(around) / around
    nodes = np.stack([np.outer(radii, np.cos(angles)), np.outer(radii, np.sin(angles))], -1)
    ring, place = np.meshgrid(np.arange(radial), np.arange(around), indexing="ij")
    after = (place + 1) % around
    quads = np.stack([ring, ring + 1, ring + 1, ring], -1) * around + np.stack(
        [place, place, after, after], -1
    )
    return nodes.reshape(-1, 2), quads.reshape(-1, 4)


def _element_matrices(coupon: Coupon, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    material, t = coupon.material, coupon.thickness
    nu, young = material.poissons_ratio, material.youngs_modulus
    rigidity = young * t**3 / (12.0 * (1.0 - nu**2))
    bending = rigidity * np.array([
        [1.0, nu, 0.0],
        [nu, 1.0, 0.0],
        [0.0, 0.0, (1.0 - nu) / 2.0],
    ])
    shearing = SHEAR_CORRECTION * young / (2.0 * (1.0 + nu)) * t
    lumped = np.diag(np.tile([t, t**3 / 12.0, t**3 / 12.0], 4)) * material.density / 4.0
    stiffness = np.zeros((len(corners), 12, 12))
    mass = np.zeros_like(stiffness)
    for xi in (-_GAUSS, _GAUSS):
        for eta in (-_GAUSS, _GAUSS):
            slopes, jacobian = _slopes(corners, xi, eta)
            area = np.abs(np.linalg.det(jacobian))[:, np.newaxis, np.newaxis]
            b, s = _bending(slopes), _tied_shear(corners, xi, eta, jacobian)
            stiffness += area * (b.transpose(0, 2, 1) @ bending @ b)
            stiffness += area * shearing * (s.transpose(0, 2, 1) @ s)
            mass += area * lumped
    return stiffness, mass


def _slopes(corners: FloatArray, xi: float, eta: float) -> tuple[FloatArray, FloatArray]:
    a, b = _CORNERS.T
    local = 0.25 * np.stack([a * (1.0 + b * eta), b * (1.0 + a * xi)])
    jacobian = local @ corners
    everywhere = np.broadcast_to(local, (len(corners), 2, 4))
    return np.asarray(np.linalg.solve(jacobian, everywhere)), jacobian


def _bending(slopes: FloatArray) -> FloatArray:
    rows = np.zeros((len(slopes), 3, 12))
    rows[:, 0, 1::3] = slopes[:, 0]
    rows[:, 1, 2::3] = slopes[:, 1]
    rows[:, 2, 1::3] = slopes[:, 1]
    rows[:, 2, 2::3] = slopes[:, 0]
    return rows


def _covariant_shear(corners: FloatArray, xi: float, eta: float, direction: int) -> FloatArray:
    """Return the shear strain along one local direction, (n_elements, 12) array."""
    a, b = _CORNERS.T
    shape = 0.25 * (1.0 + a * xi) * (1.0 + b * eta)
    local = 0.25 * np.stack([a * (1.0 + b * eta), b * (1.0 + a * xi)])
    tangent = (local @ corners)[:, direction]
    row = np.zeros((len(corners), 12))
    row[:, 0::3] = local[direction]
    row[:, 1::3] = -tangent[:, :1] * shape
    row[:, 2::3] = -tangent[:, 1:] * shape
    return row


def _tied_shear(corners: FloatArray, xi: float, eta: float, jacobian: FloatArray) -> FloatArray:
    along = 0.5 * (
        (1.0 - eta) * _covariant_shear(corners, 0.0, -1.0, 0)
        + (1.0 + eta) * _covariant_shear(corners, 0.0, 1.0, 0)
    )
    across = 0.5 * (
        (1.0 - xi) * _covariant_shear(corners, -1.0, 0.0, 1)
        + (1.0 + xi) * _covariant_shear(corners, 1.0, 0.0, 1)
    )
    return np.asarray(np.linalg.solve(jacobian, np.stack([along, across], axis=1)))


def _assemble(matrices: FloatArray, dofs: IndexArray) -> csr_array:
    rows = np.broadcast_to(dofs[:, :, np.newaxis], matrices.shape)
    columns = np.broadcast_to(dofs[:, np.newaxis, :], matrices.shape)
    entries = (matrices.ravel(), (rows.ravel(), columns.ravel()))
    return coo_array(entries).tocsr()


MODELS: Final = ("Kirchhoff", "Mindlin", "shell mesh", "solid, all nodes", "solid, faces")
"""Thin plate, plate with shear, 1600 shells; solids held through the thickness or on faces."""


@final
@dataclass(frozen=True, slots=True)
class NamedMode:
    """One mode.

    Attributes
    ----------
    diameters, circles : int
        Nodal diameters and nodal circles, the clamp not counted.
    frequencies : mapping of str to float
        By model, a key of `MODELS` [Hz].
    """

    diameters: int
    circles: int
    frequencies: Mapping[str, float]


def named_modes(coupon: Coupon, count: int = 6) -> tuple[NamedMode, ...]:
    """Return the lowest modes, by rising frequency; a pair with diameters counts once.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    count : int
        How many.
    """
    frequencies = _lowest(coupon, count)
    columns: dict[str, dict[tuple[int, int], float]] = {model: {} for model in MODELS}
    for n in sorted({n for n, _ in frequencies}):
        circles = 1 + max(s for m, s in frequencies if m == n)
        ratio = coupon.clamped_radius / coupon.outer_radius
        roots = plate_roots(ratio, coupon.material.poissons_ratio, n, circles)
        for s, root in enumerate(roots):
            columns["Kirchhoff"][n, s] = plate_frequency(
                root.lambda_squared, coupon.material, coupon.thickness, coupon.outer_radius
            )
        for model, clamp in (("solid, all nodes", "all nodes"), ("solid, faces", "faces")):
            solid = solid_frequencies(coupon, n, circles, clamp=clamp)  # type: ignore[arg-type]
            columns[model] |= {(n, s): float(f) for s, f in enumerate(solid)}
    columns["Mindlin"] = frequencies
    columns["shell mesh"] = _shells(coupon, count)
    return tuple(
        NamedMode(n, s, {m: columns[m][n, s] for m in MODELS if (n, s) in columns[m]})
        for n, s in frequencies
    )


def _lowest(coupon: Coupon, count: int) -> dict[tuple[int, int], float]:
    """Return the lowest modes of the Mindlin plate, of as many diameters as it takes."""
    modes: dict[tuple[int, int], float] = {}
    n = 0
    while True:
        frequencies = mindlin_modes(coupon, n, count).frequencies
        modes |= {(n, s): float(f) for s, f in enumerate(frequencies)}
        lowest = sorted(modes.items(), key=lambda item: item[1])[:count]
        if n > 1 and frequencies[0] > lowest[-1][1]:
            return dict(lowest)
        n += 1


def _shells(coupon: Coupon, count: int) -> dict[tuple[int, int], float]:
    modes = shell_modes(coupon, 2 * count + 2)
    named: dict[tuple[int, int], float] = {}
    for n, s, frequency in zip(modes.diameters, modes.circles, modes.frequencies, strict=True):
        named.setdefault((int(n), int(s)), float(frequency))
    return named
