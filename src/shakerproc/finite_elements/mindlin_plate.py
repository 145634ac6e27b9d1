r"""Annular plate with shear and rotary inertia: Fourier around, elements along the radius.

A field of n nodal diameters is :math:`w(r) \cos n\theta`, with rotations :math:`\beta_r(r)
\cos n\theta` and :math:`\beta_\theta(r) \sin n\theta`, so that one line of elements of high
order replaces a mesh of shells.
"""

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from scipy.linalg import eigh
from skfem import Basis, BilinearForm, ElementLinePp, ElementVector, LinearForm, MeshLine

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Coupon

SHEAR_CORRECTION = 5.0 / 6.0
ORDER = 5


@final
@dataclass(frozen=True, slots=True, eq=False)
class RadialModes:
    """The lowest modes of one number of nodal diameters.

    Attributes
    ----------
    frequencies : (n_modes,) array
        Natural frequencies, rising [Hz].
    radius : (n_points,) array
        Where the shapes are given [m].
    shapes : (n_modes, n_points) array
        Out-of-plane deflection along the radius, the largest being 1 [-].
    effective_mass : (n_modes,) array
        Mass that a table moving out of plane feels of each mode; 0 where the mode has nodal
        diameters, because the halves cancel [kg].
    largest_factor : (n_modes,) array
        Deflection where the shape is 1, over that of an oscillator of the same frequency on
        the same table: the participation factor with this scaling [-].
    """

    frequencies: FloatArray
    radius: FloatArray
    shapes: FloatArray
    effective_mass: FloatArray
    largest_factor: FloatArray


def mindlin_modes(
    coupon: Coupon, diameters: int, count: int, *, elements: int = 12
) -> RadialModes:
    """Return the lowest modes of a Mindlin plate clamped inside and free outside.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    diameters : int
        Number of nodal diameters.
    count : int
        How many modes.
    elements : int
        Elements along the radius, each of order 5.

    Returns
    -------
    RadialModes
        Frequencies [Hz] and shapes.

    References
    ----------
    .. [1] R. D. Mindlin, "Influence of rotatory inertia and shear on flexural motions of
       isotropic, elastic plates", Journal of Applied Mechanics 18, 31-38, 1951.
    """
    mesh = MeshLine(np.linspace(coupon.clamped_radius, coupon.outer_radius, elements + 1))
    basis = Basis(mesh, ElementVector(ElementLinePp(ORDER), 3), intorder=2 * ORDER + 2)
    stiffness = _stiffness_form(coupon, diameters).assemble(basis).toarray()
    mass = _mass_form(coupon).assemble(basis).toarray()
    held = basis.get_dofs(lambda x: np.isclose(x[0], coupon.clamped_radius)).flatten()
    free = np.setdiff1d(np.arange(basis.N), held)
    squared, vectors = eigh(
        stiffness[np.ix_(free, free)],
        mass[np.ix_(free, free)],
        subset_by_index=[0, count - 1],
    )
    full = np.zeros((basis.N, count))
    full[free] = vectors
    radius = np.linspace(coupon.clamped_radius, coupon.outer_radius, 201)
    probes = basis.probes(radius[np.newaxis, :])
    shapes = np.array([(probes @ mode).reshape(3, -1)[0] for mode in full.T])
    largest = shapes[np.arange(count), np.argmax(np.abs(shapes), axis=1)]
    pushed = _push_form(coupon).assemble(basis) @ full if diameters == 0 else np.zeros(count)
    return RadialModes(
        frequencies=np.sqrt(squared) / (2.0 * np.pi),
        radius=radius,
        shapes=shapes / largest[:, np.newaxis],
        effective_mass=2.0 * np.pi * pushed**2,  # the forms hold no 2 pi, both of them
        largest_factor=pushed * largest,
    )


def _stiffness_form(coupon: Coupon, n: int) -> BilinearForm:
    material, t = coupon.material, coupon.thickness
    nu, young = material.poissons_ratio, material.youngs_modulus
    rigidity = young * t**3 / (12.0 * (1.0 - nu**2))
    shear = SHEAR_CORRECTION * young / (2.0 * (1.0 + nu)) * t

    def strains(field: Any, r: FloatArray) -> tuple[FloatArray, ...]:
        (w, radial, around), slope = np.asarray(field), np.asarray(field.grad)[:, 0]
        return (
            slope[1],
            (radial + n * around) / r,
            slope[2] - (n * radial + around) / r,
            slope[0] - radial,
            -n * w / r - around,
        )

    @BilinearForm
    def form(u: Any, v: Any, at: Any) -> Any:
        r = at.x[0]
        a, b = strains(u, r), strains(v, r)
        bending = a[0] * b[0] + a[1] * b[1] + nu * (a[0] * b[1] + a[1] * b[0])
        twisting = 0.5 * (1.0 - nu) * a[2] * b[2]
        return (rigidity * (bending + twisting) + shear * (a[3] * b[3] + a[4] * b[4])) * r

    return form


def _mass_form(coupon: Coupon) -> BilinearForm:
    density, t = coupon.material.density, coupon.thickness

    @BilinearForm
    def form(u: Any, v: Any, at: Any) -> Any:
        rotary = u[1] * v[1] + u[2] * v[2]
        return density * (t * u[0] * v[0] + t**3 / 12.0 * rotary) * at.x[0]

    return form


def _push_form(coupon: Coupon) -> LinearForm:
    """Return the work of a uniform acceleration on the inertia of the plate, over 2 pi."""

    @LinearForm
    def form(v: Any, at: Any) -> Any:
        return coupon.material.density * coupon.thickness * v[0] * at.x[0]

    return form
