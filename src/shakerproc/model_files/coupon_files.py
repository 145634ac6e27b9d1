"""Coupon files in, and a coupon as a model file out."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal, TypeAlias, TypeVar, final

import numpy as np
from pydantic import BaseModel, Field

from shakerproc.documents import Document, FromList, Section, read_document
from shakerproc.errors import DocumentError
from shakerproc.finite_elements.annular_plate import mindlin_modes
from shakerproc.finite_elements.coupon import Clamp, Coupon, Hole, Material, ThermalFit
from shakerproc.finite_elements.hole_stiffness import Axis, Plane
from shakerproc.models import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.effects.damper import Damper
from shakerproc.models.effects.spring import Spring
from shakerproc.units import in_unit, near_miss

Length: TypeAlias = Annotated[float, in_unit("m", positive=True)]
Hertz: TypeAlias = Annotated[float, in_unit("Hz", positive=True)]
Count: TypeAlias = Annotated[int, Field(ge=0, le=50)]
Law: TypeAlias = Literal["traction", "pressure", "cosine bearing"]
T = TypeVar("T", bound=BaseModel)


class MaterialSection(Section):
    """An isotropic material."""

    youngs_modulus: Annotated[float, in_unit("Pa", positive=True)]
    poissons_ratio: Annotated[float, Field(gt=-1.0, lt=0.5)]
    density: Annotated[float, in_unit("kg/m^3", positive=True)]
    yield_strength: Annotated[float | None, in_unit("Pa", positive=True)] = None
    thermal_expansion: Annotated[float | None, in_unit("1/K")] = None


class MaterialsFile(Section):
    """Several materials by name."""

    materials: Literal[1]
    entries: dict[str, MaterialSection]


class HoleSection(Section):
    """A round hole, or a slot with round ends."""

    diameter: Length | None = None
    length: Length | None = None
    width: Length | None = None


class ClampSection(Section):
    """Part of the coupon that bolt and bushing hold."""

    radius: Length
    held: Clamp
    inferred: bool = False
    stated_radius: Length | None = None


class CouponModeSection(Section):
    """A published natural frequency."""

    diameters: Count
    circles: Count = 0
    frequency: Hertz


class ModesSection(Section):
    """Published natural frequencies."""

    source: str
    frequencies: Annotated[tuple[CouponModeSection, ...], FromList]


class PublishedStiffness(Section):
    """A published stiffness of the hole."""

    axis: Axis = "length"
    stiffness: Annotated[float, in_unit("N/m", positive=True)]
    frequency: Hertz | None = None


class StiffnessSection(Section):
    """How the stiffness of the hole is found, and its published values."""

    source: str = ""
    thickness: Length | None = None
    law: Law = "traction"
    half_angle: Annotated[float, in_unit("rad", positive=True)] = np.pi / 2.0
    plane: Plane = "strain"
    published: Annotated[tuple[PublishedStiffness, ...], FromList] = ()


class JointSection(Section):
    """Part in the hole, for the clearance over temperature."""

    insert: Length
    insert_material: str | MaterialSection
    reference: Annotated[float, in_unit("K")] = 293.15


class CouponSchema(Section):
    """The whole file."""

    coupon: Literal[1]
    title: str
    materials: str | None = None
    material: str | MaterialSection
    outer_radius: Length
    thickness: Length
    hole: HoleSection
    clamp: ClampSection
    damping_ratio: Annotated[float | None, in_unit("1", not_negative=True)] = None
    modes: ModesSection | None = None
    stiffness: StiffnessSection = Field(default_factory=StiffnessSection)
    joint: JointSection | None = None


@final
@dataclass(frozen=True, slots=True)
class CouponFile:
    """Contents of a coupon file.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        One line for reports.
    coupon : Coupon
        For modes.
    static : Coupon
        For the stiffness of the hole, which may have been published for another thickness.
    clamp : Clamp
        What is held inside the clamped radius.
    inferred : bool
        Whether the clamped radius was fitted to results and is not known.
    stated_radius : float, optional
        What the documents say of the clamped radius instead [m].
    damping_ratio : float, optional
        Of every mode [-].
    modes : ModesSection, optional
        Published natural frequencies.
    stiffness : StiffnessSection
        Load, plane, and published stiffness.
    fit : ThermalFit, optional
        Hole and insert with their expansion.
    reference : float
        Temperature of the dimensions [K].
    """

    path: Path
    title: str
    coupon: Coupon
    static: Coupon
    clamp: Clamp
    inferred: bool
    stated_radius: float | None
    damping_ratio: float | None
    modes: ModesSection | None
    stiffness: StiffnessSection
    fit: ThermalFit | None
    reference: float


def read_coupon(path: Path) -> CouponFile:
    """Return the coupon that a YAML file describes.

    Raises
    ------
    DocumentError
        If the file, or the materials file that it names, is not what it should be.
    """
    document = read_document(path, CouponSchema)
    said = document.value
    known = _known_materials(document)
    material = _material(document, said.material, known, "material")
    hole = _hole(document)
    try:
        coupon = Coupon(material, said.outer_radius, said.clamp.radius, said.thickness, hole)
        stated = said.clamp.stated_radius
        if stated is not None:
            Coupon(material, said.outer_radius, stated, said.thickness, hole)
    except ValueError as error:
        raise document.error(("clamp", "radius"), str(error)) from error
    thickness = said.stiffness.thickness or said.thickness
    return CouponFile(
        path=path,
        title=said.title,
        coupon=coupon,
        static=Coupon(material, said.outer_radius, said.clamp.radius, thickness, hole),
        clamp=said.clamp.held,
        inferred=said.clamp.inferred,
        stated_radius=said.clamp.stated_radius,
        damping_ratio=said.damping_ratio,
        modes=said.modes,
        stiffness=said.stiffness,
        fit=_fit(document, material, hole, known),
        reference=said.joint.reference if said.joint else 293.15,
    )


def _known_materials(document: Document[CouponSchema]) -> dict[str, MaterialSection]:
    name = document.value.materials
    if name is None:
        return {}
    path = document.path.parent / name
    if not path.is_file():
        raise document.error(("materials",), f"there is no file {name} beside this one")
    return read_document(path, MaterialsFile).value.entries


def _material(
    document: Document[CouponSchema],
    said: str | MaterialSection,
    known: dict[str, MaterialSection],
    *place: str,
) -> Material:
    """Return the material that is written here, or named.

    Raises
    ------
    DocumentError
        If no material has that name.
    """
    name, entry = (said, known.get(said)) if isinstance(said, str) else ("inline", said)
    if entry is None:
        unknown: DocumentError = _unknown(document, name, known, place)
        raise unknown
    return Material(
        name,
        entry.youngs_modulus,
        entry.poissons_ratio,
        entry.density,
        entry.thermal_expansion,
    )


def _unknown(
    document: Document[CouponSchema],
    name: str,
    known: dict[str, MaterialSection],
    place: tuple[str, ...],
) -> DocumentError:
    if not known:
        hint = "name a file of materials under the key materials, or write the material here"
        return document.error(place, f'no material "{name}"; {hint}')
    meant = near_miss(name, list(known))
    question = f'; did you mean "{meant}"?' if meant else f"; there are {', '.join(known)}"
    return document.error(
        place, f'no material "{name}" in {document.value.materials}{question}'
    )


def _hole(document: Document[CouponSchema]) -> Hole:
    """Return the hole.

    Raises
    ------
    DocumentError
        If it is neither round nor a slot, or both.
    """
    said = document.value.hole
    if said.diameter is not None and said.length is None and said.width is None:
        return Hole(said.diameter, said.diameter)
    if said.diameter is None and said.length is not None and said.width is not None:
        try:
            return Hole(said.length, said.width)
        except ValueError as error:
            raise document.error(("hole", "length"), str(error)) from error
    raise document.error(
        ("hole",), "expected diameter alone (round), or length and width (slot)", at_key=True
    )


def _fit(
    document: Document[CouponSchema],
    material: Material,
    hole: Hole,
    known: dict[str, MaterialSection],
) -> ThermalFit | None:
    joint = document.value.joint
    if joint is None:
        return None
    place = ("joint", "insert_material")
    insert = _material(document, joint.insert_material, known, *place)
    if material.thermal_expansion is None or insert.thermal_expansion is None:
        lacking = material if material.thermal_expansion is None else insert
        raise document.error(place, f"{lacking.name} has no thermal_expansion; write it there")
    return ThermalFit(
        hole.length, joint.insert, material.thermal_expansion, insert.thermal_expansion
    )


OUT_OF_PLANE = """\
Out of plane. A table that moves evenly drives only modes without nodal diameters. Those with
diameters (such as the lowest) answer rocking and uneven sensors, and are not in this model.
Each mass is the effective mass of one mode. Together they carry {share:.0%} of the
{moving:.4g} g outside the clamp; the rest follows the table.
A sensor at radius {radius:.3g} mm measures the mass "coupon". At the rim the motion
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
    equivalent = modal_equivalent(coupon, count)
    modal_mass = sum(one.mass for one in equivalent.oscillators)
    heading = OUT_OF_PLANE.format(
        share=modal_mass / equivalent.moving_mass,
        moving=1e3 * equivalent.moving_mass,
        radius=1e3 * equivalent.unit_radius,
        rim=equivalent.rim_factor,
    )
    return _model(title, equivalent.oscillators, damping_ratio), heading


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
