r"""Thin annular plate, clamped inside and free outside, by Bessel functions."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.optimize import brentq
from scipy.special import ive, jv, kve, yv

from shakerproc.data import FloatArray
from shakerproc.finite_elements.coupon import Material

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
    found: list[float] = []
    left, value = 0.5, function(0.5)
    while len(found) < count:
        right = left + step
        after = function(right)
        if np.sign(value) != np.sign(after):
            found.append(float(brentq(function, left, right, xtol=1e-14, rtol=1e-14)))
        left, value = right, after
    return found


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
