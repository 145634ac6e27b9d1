"""A thin rectangular plate that nothing holds: its modes, seen at points."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from scipy.linalg import eigh
from skfem import Basis, BilinearForm, ElementQuadBFS, MeshQuad
from skfem.helpers import dd

from shakerproc import checks
from shakerproc.data import FloatArray

ELEMENTS: Final = 8
"""Elements along each side: the lowest ten frequencies of a square plate are converged to
1e-3 [-]."""

_RIGID: Final = 1e-3
"""Share of the first elastic frequency below which rounding alone is left of zero [-]."""


@final
@dataclass(frozen=True, slots=True)
class Plate:
    """A thin rectangular plate.

    Attributes
    ----------
    length, width, thickness : float
        Along x, along y, and across [m].
    youngs_modulus : float
        [Pa].
    poissons_ratio : float
        [-].
    density : float
        [kg/m³].
    """

    length: float
    width: float
    thickness: float
    youngs_modulus: float
    poissons_ratio: float
    density: float

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness"):
            checks.positive(name, getattr(self, name), "m")
        checks.positive("youngs_modulus", self.youngs_modulus, "Pa")
        checks.positive("density", self.density, "kg/m^3")

    @property
    def rigidity(self) -> float:
        """Flexural rigidity [N m]."""
        return self.youngs_modulus * self.thickness**3 / (12.0 * (1.0 - self.poissons_ratio**2))

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return self.density * self.thickness * self.length * self.width


def free_plate_modes(
    plate: Plate, points: Sequence[tuple[float, float]], count: int
) -> tuple[FloatArray, FloatArray]:
    r"""Return frequencies and shapes of a free plate, rigid-body modes first.

    Kirchhoff's theory, by Bogner, Fox and Schmit's conforming elements:

    .. math:: D \nabla^4 w = \rho t \omega^2 w

    Parameters
    ----------
    plate : Plate
        The plate, from (0, 0) to (length, width).
    points : sequence of (float, float)
        Where shapes are wanted, x and y [m].
    count : int
        How many modes, the three of the rigid body among them.

    Returns
    -------
    frequencies : (count,) array
        Rising; 0 of the rigid-body modes [Hz].
    shapes : (n_points, count) array
        Out of plane, for unit modal mass [1/sqrt(kg)].

    References
    ----------
    .. [1] F. K. Bogner, R. L. Fox and L. A. Schmit, "The generation of interelement compatible
       stiffness and mass matrices by the use of interpolation formulas", AFFDL-TR-66-80, 1966.
    """
    mesh = MeshQuad.init_tensor(
        np.linspace(0.0, plate.length, ELEMENTS + 1),
        np.linspace(0.0, plate.width, ELEMENTS + 1),
    )
    basis = Basis(mesh, ElementQuadBFS(), intorder=6)
    stiffness = _stiffness_form(plate).assemble(basis).toarray()
    mass = _mass_form(plate).assemble(basis).toarray()
    squared, vectors = eigh(stiffness, mass, subset_by_index=[0, count - 1])
    shapes = np.asarray(basis.probes(np.array(points, float).T) @ vectors)
    frequencies = np.sqrt(np.abs(squared)) / (2.0 * np.pi)
    first = frequencies[3] if count > 3 else np.inf
    return np.where(frequencies < _RIGID * first, 0.0, frequencies), shapes


def _stiffness_form(plate: Plate) -> BilinearForm:
    nu = plate.poissons_ratio

    @BilinearForm
    def form(u: Any, v: Any, _: Any) -> Any:
        a, b = dd(u), dd(v)
        bending = a[0, 0] * b[0, 0] + a[1, 1] * b[1, 1]
        across = nu * (a[0, 0] * b[1, 1] + a[1, 1] * b[0, 0])
        return plate.rigidity * (bending + across + 2.0 * (1.0 - nu) * a[0, 1] * b[0, 1])

    return form


def _mass_form(plate: Plate) -> BilinearForm:
    @BilinearForm
    def form(u: Any, v: Any, _: Any) -> Any:
        return plate.density * plate.thickness * u * v

    return form
