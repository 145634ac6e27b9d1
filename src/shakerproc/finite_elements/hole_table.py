"""How much the stiffness of a hole depends on the load law, the half-angle and the mesh."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.finite_elements.coupon import Coupon
from shakerproc.finite_elements.hole_stiffness import (
    LOAD_LAWS,
    Axis,
    Plane,
    half_disc,
    hole_stiffness,
)

MESHES: Final = (1, 2, 3)
"""Refinements of which the convergence is shown; the last counts."""


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


def loaded_holes(
    coupon: Coupon, axis: Axis = "length", *, refinement: int = 1
) -> tuple[LoadedHole, ...]:
    """Return the stiffness for every load law, two half-angles, faces held and free.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    axis : {"length", "width"}
        Direction of the load in a slot.
    refinement : int
        As in `hole_stiffness`; the coarsest is good to a thousandth.
    """
    assumptions = [(law, angle, plane) for plane in _PLANES for law, angle in _LOADS]
    return tuple(
        loaded_hole(coupon, axis, law, angle, plane, refinement=refinement)
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


_PLANES: Final[tuple[Plane, ...]] = ("strain", "stress")
_LOADS: Final = (
    *((law, np.pi / 2.0) for law in LOAD_LAWS),
    ("traction", np.radians(85.0)),
    ("traction", np.radians(60.0)),
)
