"""A coupon: material, annular plate, hole, and how its clearance changes with temperature."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import checks

IndexArray: TypeAlias = NDArray[np.intp]
Clamp: TypeAlias = Literal["shell nodes", "all nodes", "faces"]


@final
@dataclass(frozen=True, slots=True)
class Material:
    """An isotropic linear material.

    Attributes
    ----------
    name : str
        As it is called in the workshop.
    youngs_modulus : float
        [Pa].
    poissons_ratio : float
        [-].
    density : float
        [kg/m³].
    thermal_expansion : float, optional
        Linear coefficient of thermal expansion [1/K].
    """

    name: str
    youngs_modulus: float
    poissons_ratio: float
    density: float
    thermal_expansion: float | None = None

    def __post_init__(self) -> None:
        checks.positive("youngs_modulus", self.youngs_modulus, "Pa")
        checks.positive("density", self.density, "kg/m^3")
        if not -1.0 < self.poissons_ratio < 0.5:
            raise ValueError(
                f"poissons_ratio must lie between -1 and 0.5, not {self.poissons_ratio:g}"
            )


@final
@dataclass(frozen=True, slots=True)
class Hole:
    """A round hole, or a slot with round ends (an obround).

    Attributes
    ----------
    length : float
        Along the first principal axis; of a round hole the diameter [m].
    width : float
        Across it; of a round hole the diameter [m].
    """

    length: float
    width: float

    def __post_init__(self) -> None:
        checks.positive("width", self.width, "m")
        if self.length < self.width:
            raise ValueError(
                f"length must be at least the width {self.width:g} m, not {self.length:g} m"
            )

    @property
    def area(self) -> float:
        """Area of the opening [m²]."""
        return float(np.pi / 4.0 * self.width**2 + (self.length - self.width) * self.width)


@final
@dataclass(frozen=True, slots=True)
class Coupon:
    """A disc with a hole, clamped around the hole.

    Attributes
    ----------
    material : Material
        What it is made of.
    outer_radius : float
        [m].
    clamped_radius : float
        Radius inside which bolt and bushing hold the plate [m].
    thickness : float
        [m].
    hole : Hole
        The joint's opening.
    """

    material: Material
    outer_radius: float
    clamped_radius: float
    thickness: float
    hole: Hole

    def __post_init__(self) -> None:
        checks.positive("thickness", self.thickness, "m")
        checks.positive("clamped_radius", self.clamped_radius, "m")
        if self.outer_radius <= max(self.clamped_radius, self.hole.length / 2.0):
            raise ValueError(
                f"outer_radius must exceed the clamped radius {self.clamped_radius:g} m and "
                f"the hole, not {self.outer_radius:g} m"
            )

    @property
    def mass(self) -> float:
        """Mass of the disc without its hole [kg]."""
        area = np.pi * self.outer_radius**2 - self.hole.area
        return float(self.material.density * area * self.thickness)


def disc_of_inertia(
    across: float, polar: float, *, hole_radius: float = 0.0
) -> tuple[float, float]:
    r"""Return outer radius and thickness [m] of the disc that has an inertia.

    .. math:: J / m = (R^2 + r^2) / 2, \qquad I / m = J / 2m + t^2 / 12

    Parameters
    ----------
    across, polar : float
        Moments of inertia about a diameter and about the axis, for each kilogram [m²].
    hole_radius : float
        Radius of its hole [m].

    Raises
    ------
    ValueError
        If no disc has this inertia.

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       appendix A: CONM2 of 1 kg, 633.07 and 1265.02 kg mm².
    """
    if not across > 0.5 * polar:
        raise ValueError(
            f"the inertia across, {across:g} m^2, must exceed half of the polar inertia, "
            f"{polar:g} m^2"
        )
    if not 2.0 * polar > hole_radius**2:
        raise ValueError(f"a hole of radius {hole_radius:g} m is too wide for {polar:g} m^2")
    radius = np.sqrt(2.0 * polar - hole_radius**2)
    return float(radius), float(np.sqrt(12.0 * (across - 0.5 * polar)))


@final
@dataclass(frozen=True, slots=True)
class ThermalFit:
    """An opening with an insert in it: a hole and a bushing, a slot and a pin.

    Attributes
    ----------
    opening, insert : float
        Sizes along the axis of the play, at the reference temperature [m].
    opening_expansion, insert_expansion : float
        Linear coefficients of thermal expansion of the two materials [1/K].
    """

    opening: float
    insert: float
    opening_expansion: float
    insert_expansion: float

    def __post_init__(self) -> None:
        checks.positive("opening", self.opening, "m")
        checks.positive("insert", self.insert, "m")
        checks.finite("opening_expansion", self.opening_expansion, "1/K")
        checks.finite("insert_expansion", self.insert_expansion, "1/K")


@final
@dataclass(frozen=True, slots=True)
class Clearances:
    """Free play to either side of where the insert rests, below 0 where it is squeezed.

    They are the parameters of the effect ``offset_gap``; where both are equal, of ``gap``.

    Attributes
    ----------
    positive, negative : float
        Along the axis and against it [m].
    """

    positive: float
    negative: float

    @property
    def play(self) -> float:
        """Opening less insert [m]."""
        return self.positive + self.negative


def clearances_at(
    fit: ThermalFit,
    temperature_change: float,
    *,
    span: float = 0.0,
    span_expansion: float = 0.0,
) -> Clearances:
    r"""Return the clearances of a joint at another temperature.

    .. math:: d_o (1 + \alpha_o \Delta T) - d_i (1 + \alpha_i \Delta T)

    is the play, half of it to either side. Where the part is held at another joint a `span`
    away, its opening also moves by :math:`L \, \Delta\alpha \, \Delta T` past the insert: ahead
    of it there is more room by as much as there is less behind. A hole
    grows with its part, however the part is shaped around it.

    Parameters
    ----------
    fit : ThermalFit
        Sizes and materials; the insert is centred at the reference temperature.
    temperature_change : float
        Temperature less that at which the sizes were measured [K].
    span : float
        Distance from the joint that holds the part, along the axis [m].
    span_expansion : float
        Coefficient of the part less that of what it stands on [1/K].

    Returns
    -------
    Clearances
        To either side [m].

    References
    ----------
    .. [1] A. H. Hauglid, "Nonlinear Mechanical Vibrations: The Effect of Gaps", NTNU, 2018,
       sections 1.2 (why the joints have play) and 8.2 (clearances set by a thermal chamber).
    """
    opening = fit.opening * (1.0 + fit.opening_expansion * temperature_change)
    insert = fit.insert * (1.0 + fit.insert_expansion * temperature_change)
    half, shift = (opening - insert) / 2.0, span * span_expansion * temperature_change
    return Clearances(positive=half + shift, negative=half - shift)


def temperature_change_for(fit: ThermalFit, play: float) -> float:
    """Return the change of temperature at which opening less insert is a given play [K].

    Parameters
    ----------
    fit : ThermalFit
        Sizes and materials.
    play : float
        Wanted play; 0 where the joint just closes [m].

    Raises
    ------
    ValueError
        If the play does not change with temperature.
    """
    rate = fit.opening * fit.opening_expansion - fit.insert * fit.insert_expansion
    if rate == 0.0:
        raise ValueError(
            f"the play is {fit.opening - fit.insert:g} m at every temperature: opening and "
            f"insert expand alike"
        )
    return (play - (fit.opening - fit.insert)) / rate
