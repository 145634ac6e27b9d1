r"""Annular plates clamped inside: thin by Bessel functions, with shear by elements.

With shear and rotary inertia a field of n nodal diameters is :math:`w(r) \cos n\theta`, with
rotations :math:`\beta_r(r) \cos n\theta` and :math:`\beta_\theta(r) \sin n\theta`, so that one
line of elements of high order replaces a mesh of shells.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq
from scipy.special import ive, jv, kve, yv
from skfem import Basis, BilinearForm, ElementLinePp, ElementVector, LinearForm, MeshLine

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Coupon, Material

_STEP = 0.02  # of lambda; roots of one number of diameters lie about pi R / (R - b) apart


@final
@dataclass(frozen=True, slots=True)
class PlateRoot:
    r"""One natural frequency of the plate.

    Attributes
    ----------
    diameters : int
        Number of nodal diameters.
    circles : int
        Number of nodal circles, the clamp not counted.
    lambda_squared : float
        Frequency parameter :math:`\lambda^2 = \omega R^2 \sqrt{\rho t / D}` [-].
    """

    diameters: int
    circles: int
    lambda_squared: float


def plate_roots(
    radius_ratio: float, poissons_ratio: float, diameters: int, count: int
) -> tuple[PlateRoot, ...]:
    r"""Return the lowest roots of an annular plate, clamped inside and free outside.

    The deflection is :math:`w = [A J_n + B Y_n + C I_n + D K_n](\lambda r / R) \cos n\theta`;
    deflection and slope vanish at the clamp, moment and Kirchhoff shear at the rim.

    Parameters
    ----------
    radius_ratio : float
        Clamped radius over outer radius, between 0 and 1 [-].
    poissons_ratio : float
        [-].
    diameters : int
        Number of nodal diameters n.
    count : int
        How many roots.

    Returns
    -------
    tuple of PlateRoot
        By rising frequency.

    Raises
    ------
    ValueError
        If the radius ratio does not lie between 0 and 1.

    References
    ----------
    .. [1] A. W. Leissa, "Vibration of Plates", NASA SP-160, 1969, section 2.2.
    """
    if not 0.0 < radius_ratio < 1.0:
        raise ValueError(f"radius_ratio must lie between 0 and 1, not {radius_ratio:g}")

    def determinant(value: float) -> float:
        return _determinant(value, radius_ratio, poissons_ratio, diameters)

    roots = _roots(determinant, _STEP / (1.0 - radius_ratio), count)
    return tuple(PlateRoot(diameters, i, root**2) for i, root in enumerate(roots))


def plate_frequency(
    lambda_squared: float, material: Material, thickness: float, outer_radius: float
) -> float:
    r"""Return the natural frequency that belongs to a root [Hz].

    .. math:: f = \frac{\lambda^2}{2 \pi R^2} \sqrt{\frac{D}{\rho t}}, \qquad
              D = \frac{E t^3}{12 (1 - \nu^2)}

    Parameters
    ----------
    lambda_squared : float
        Root of `plate_roots` [-].
    material : Material
        What the plate is made of.
    thickness, outer_radius : float
        [m].
    """
    stretched = 1.0 - material.poissons_ratio**2
    rigidity = material.youngs_modulus * thickness**3 / (12.0 * stretched)
    speed = np.sqrt(rigidity / (material.density * thickness))
    return float(lambda_squared * speed / (2.0 * np.pi * outer_radius**2))


def _roots(function: Callable[[float], float], step: float, count: int) -> list[float]:
    values: list[float] = []
    start, value = 0.5, function(0.5)
    while len(values) < count:
        right = start + step
        after = function(right)
        if np.sign(value) != np.sign(after):
            values.append(float(brentq(function, start, right, xtol=1e-14, rtol=1e-14)))
        start, value = right, after
    return values


def _determinant(value: float, ratio: float, poisson: float, n: int) -> float:
    inner, outer = value * ratio, value
    rows = np.empty((4, 4))
    for column, family in enumerate((_bessel_j, _bessel_y, _bessel_i, _bessel_k)):
        at_clamp = family(inner, n, outer if column == 2 else inner)
        at_rim = family(outer, n, outer if column == 2 else inner)
        rows[0, column], rows[1, column] = at_clamp[0], at_clamp[1]
        rows[2, column] = _moment(outer, at_rim, n, poisson)
        rows[3, column] = _shear(outer, at_rim, n, poisson, -1.0 if column < 2 else 1.0)
    rows[2:] /= outer**2
    return float(np.linalg.det(rows / np.max(np.abs(rows), axis=0)))


def _moment(x: float, w: FloatArray, n: int, poisson: float) -> float:
    return float(w[2] + poisson * (w[1] / x - n**2 * w[0] / x**2))


def _shear(x: float, w: FloatArray, n: int, poisson: float, laplacian: float) -> float:
    # the Laplacian of J and Y is -1 times the function, of I and K +1 times
    return float(laplacian * w[1] - (1.0 - poisson) * n**2 / x**2 * (w[1] - w[0] / x))


def _derivatives(
    order: Callable[[int], float], x: float, n: int, signs: tuple[float, float, float]
) -> FloatArray:
    lower, upper, laplacian = signs
    value = order(n)
    first = 0.5 * (lower * order(n - 1) + upper * order(n + 1))
    second = laplacian * value - first / x + n**2 / x**2 * value
    return np.array([value, first, second])


def _bessel_j(x: float, n: int, _: float) -> FloatArray:
    return _derivatives(lambda m: float(jv(m, x)), x, n, (1.0, -1.0, -1.0))


def _bessel_y(x: float, n: int, _: float) -> FloatArray:
    return _derivatives(lambda m: float(yv(m, x)), x, n, (1.0, -1.0, -1.0))


def _bessel_i(x: float, n: int, scale: float) -> FloatArray:
    shrink = float(np.exp(x - scale))
    return shrink * _derivatives(lambda m: float(ive(m, x)), x, n, (1.0, 1.0, 1.0))


def _bessel_k(x: float, n: int, scale: float) -> FloatArray:
    shrink = float(np.exp(scale - x))
    return shrink * _derivatives(lambda m: float(kve(m, x)), x, n, (-1.0, -1.0, 1.0))


SHEAR_CORRECTION = 5.0 / 6.0
ORDER = 5
ELEMENTS = 12
"""Elements along the radius, each of order 5."""


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


def mindlin_modes(coupon: Coupon, diameters: int, count: int) -> RadialModes:
    """Return the lowest modes of a Mindlin plate clamped inside and free outside.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    diameters : int
        Number of nodal diameters.
    count : int
        How many modes.

    Returns
    -------
    RadialModes
        Frequencies [Hz] and shapes.

    References
    ----------
    .. [1] R. D. Mindlin, "Influence of rotatory inertia and shear on flexural motions of
       isotropic, elastic plates", Journal of Applied Mechanics 18, 31-38, 1951.
    """
    mesh = MeshLine(np.linspace(coupon.clamped_radius, coupon.outer_radius, ELEMENTS + 1))
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
