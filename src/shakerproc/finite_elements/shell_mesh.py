"""Annular plate as a polar mesh of four-node shell elements, the mesh of a Nastran user.

Its figures hold the error of such a mesh; `mindlin_modes` has none to speak of. The mass is
lumped at the nodes, as Nastran does unless told otherwise.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.sparse import coo_array, csr_array

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Coupon, IndexArray
from shakerproc.finite_elements.lowest_modes import lowest_modes
from shakerproc.finite_elements.mindlin_plate import SHEAR_CORRECTION

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
    stiffness, mass = _matrices(coupon, nodes[quads])
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


def _matrices(coupon: Coupon, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
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
