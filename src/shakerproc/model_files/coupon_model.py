"""A coupon as a model file: masses, springs and dampers with its natural frequencies."""

from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.finite_elements.coupon import Coupon
from shakerproc.finite_elements.mindlin_plate import mindlin_modes
from shakerproc.models import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.spring import Spring

OUT_OF_PLANE = """\
Out of plane. A table that moves evenly drives only modes without nodal diameters; those with
diameters (such as the lowest) answer rocking and uneven sensors, and are not in this model.
Each mass is the effective mass of one mode, and together they carry {share:.0%} of the
{moving:.4g} g outside the clamp; the rest follows the table.
A sensor at radius {radius:.3g} mm sees what the mass "coupon" does; at the rim the motion
relative to the table is {rim:.4g} times as large."""
IN_PLANE = """\
In plane. The whole coupon moves on the stiffness of its hole on the bushing, without play.
It depends on the load law, here {law}; shakerproc coupon shows by how much."""


@final
@dataclass(frozen=True, slots=True)
class Oscillator:
    """One mass of the model.

    Attributes
    ----------
    name : str
        Name of the mass.
    mass : float
        [kg].
    frequency : float
        Of the mass on its spring [Hz].
    """

    name: str
    mass: float
    frequency: float

    @property
    def stiffness(self) -> float:
        """Stiffness of the spring [N/m]."""
        return float(self.mass * (2.0 * np.pi * self.frequency) ** 2)

    def damping(self, ratio: float) -> float:
        """Return the damping of the damper for a damping ratio [N s/m]."""
        return 2.0 * ratio * self.mass * 2.0 * np.pi * self.frequency


@final
@dataclass(frozen=True, slots=True)
class ModalEquivalent:
    """Mass and spring equivalent to a plate on an evenly moving table.

    Attributes
    ----------
    oscillators : tuple of Oscillator
        One for each mode without nodal diameters.
    moving_mass : float
        Mass of the plate outside the clamp [kg].
    unit_radius : float
        Where the first mode is as large as its oscillator; beyond the rim if nowhere [m].
    rim_factor : float
        Motion of the rim relative to the table, over that of the first oscillator [-].
    """

    oscillators: tuple[Oscillator, ...]
    moving_mass: float
    unit_radius: float
    rim_factor: float


def modal_equivalent(coupon: Coupon, count: int = 1) -> ModalEquivalent:
    r"""Return oscillators that load the table and ring as the plate does.

    With shapes :math:`\phi_i`, modal masses :math:`m_i` and participation
    :math:`\Gamma_i = \int \rho t \phi_i \, dA`, a mode moves as
    :math:`\phi_i(r) \Gamma_i / m_i` times an oscillator of its frequency, and pulls at the
    table like one of the effective mass :math:`\Gamma_i^2 / m_i`.

    Parameters
    ----------
    coupon : Coupon
        Material and dimensions.
    count : int
        How many modes without nodal diameters.
    """
    modes = mindlin_modes(coupon, 0, count)
    factor = modes.shapes[0] * modes.largest_factor[0]
    names = ["coupon", *(f"coupon mode {i}" for i in range(2, count + 1))]
    pairs = zip(names, modes.effective_mass, modes.frequencies, strict=True)
    area = np.pi * (coupon.outer_radius**2 - coupon.clamped_radius**2)
    return ModalEquivalent(
        oscillators=tuple(Oscillator(name, float(m), float(f)) for name, m, f in pairs),
        moving_mass=float(coupon.material.density * coupon.thickness * area),
        unit_radius=float(np.interp(1.0, factor, modes.radius)),
        rim_factor=float(factor[-1]),
    )


def out_of_plane_model(
    coupon: Coupon, title: str, damping_ratio: float, count: int = 1
) -> tuple[Model, str]:
    """Return the model of a plate on an evenly moving table, and remarks on it.

    `damping_ratio` is a share of the critical damping [-].
    """
    found = modal_equivalent(coupon, count)
    carried = sum(one.mass for one in found.oscillators)
    heading = OUT_OF_PLANE.format(
        share=carried / found.moving_mass,
        moving=1e3 * found.moving_mass,
        radius=1e3 * found.unit_radius,
        rim=found.rim_factor,
    )
    return _model(title, found.oscillators, damping_ratio), heading


def in_plane_model(
    coupon: Coupon, title: str, damping_ratio: float, frequency: float, law: str
) -> tuple[Model, str]:
    """Return the model of a coupon on the stiffness of its hole, and remarks on it.

    `damping_ratio` is a share of the critical damping [-], `frequency` in [Hz].
    """
    one = Oscillator("coupon", coupon.mass, frequency)
    return _model(title, (one,), damping_ratio), IN_PLANE.format(law=law)


def _model(title: str, oscillators: tuple[Oscillator, ...], damping_ratio: float) -> Model:
    """Return oscillators on the base, each with a spring and a damper."""
    elements: list[Element] = []
    for one in oscillators:
        between = (BASE, one.name)
        elements.append(Element(Spring(stiffness=one.stiffness), between))
        elements.append(Element(Damper(damping=one.damping(damping_ratio)), between))
    return Model(
        title=title,
        masses={one.name: one.mass for one in oscillators},
        elements=tuple(elements),
        excitation=Excitation("base acceleration"),
        sensors={oscillators[0].name: Sensor(oscillators[0].name)},
    )
