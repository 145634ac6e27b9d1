"""Model files in."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

from shakerproc.documents import Document, read_document
from shakerproc.errors import DocumentError, ModelError
from shakerproc.model_files.kinds import read_kind
from shakerproc.model_files.schema import ModelSchema, ProvenanceSection
from shakerproc.model_files.structures import check_driven, read_structures
from shakerproc.models.effects import EFFECTS
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.faults import FAULTS
from shakerproc.models.model import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.motion import Motion, unit_in
from shakerproc.models.structure import Mode
from shakerproc.units import example, near_miss, quoted, to_si


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class ModelFile:
    """A model and where it stands.

    Attributes
    ----------
    path : Path
        The file.
    model : Model
        What it describes.
    provenance : tuple of ProvenanceSection
        Where its fitted parts come from.
    document : Document
        For messages with line and column.
    """

    path: Path
    model: Model
    provenance: tuple[ProvenanceSection, ...]
    document: Document[ModelSchema]

    def __repr__(self) -> str:
        elements = ", ".join(
            f"{element.effect.kind} between {' and '.join(element.between)}"
            for element in self.model.elements
        )
        return f"Model {self.path}: {self.model.title}; {elements}"


def read_model(path: Path) -> Model:
    """Return the model that a YAML file describes.

    Raises
    ------
    DocumentError
        If the file is not strict YAML, or something in it is unknown, missing, without unit,
        not physical, or cannot stand; with line and column.
    """
    return read_model_file(path).model


def read_model_file(path: Path) -> ModelFile:
    """Return the model that a YAML file describes, and where everything stands in it.

    Raises
    ------
    DocumentError
        As `read_model` does.
    """
    document = read_document(path, ModelSchema)
    said = document.value
    if not said.masses and not said.structures:
        raise document.error(("masses",), "expected a mass, such as coupon: 28.6 g")
    if BASE in said.masses:
        raise document.error(
            ("masses", BASE), f"{BASE} is the shaker table and has no mass here", at_key=True
        )
    structures = read_structures(document)
    points = [point for one in structures.values() for point in one.points]
    places = [BASE, *said.masses, *points]
    motion = _motion(document)
    masses = {
        name: _mass(document, ("masses", name), written, motion)
        for name, written in said.masses.items()
    }
    elements = tuple(
        _element(document, ("elements", i), element, places, motion)
        for i, element in enumerate(said.elements)
    )
    sensors = {
        name: _sensor(document, ("sensors", name), places, motion) for name in said.sensors
    }
    excitation = _excitation(document, places)
    check_driven(document, structures, excitation)
    modes = tuple(_mode(document, i, places, motion) for i in range(len(said.modes)))
    try:
        model = Model(
            said.title or path.stem,
            masses,
            elements,
            excitation,
            sensors,
            modes,
            motion,
            structures,
        )
    except ModelError as error:
        raise document.error(("elements",), str(error), at_key=True) from error
    except ValueError as error:
        raise document.error(("modes",), str(error), at_key=True) from error
    return ModelFile(path, model, said.provenance, document)


_OF_MASSES: Final[Mapping[str, Motion]] = MappingProxyType({
    "kg m^2": "rotation", "kg": "translation",
})  # fmt: skip
"""What moves by the unit of the masses."""


def _motion(document: Document[ModelSchema]) -> Motion:
    """Return how the masses move: moments of inertia turn.

    Where no mass has a unit of either, the stiffnesses of the elements tell it.
    """
    masses = document.value.masses.values()
    for unit, motion in _OF_MASSES.items():
        if any(_reads(mass, unit) for mass in masses):
            return motion
    values = (value for element in document.value.elements for value in element.values())
    return "rotation" if any(_reads(v, "N m/rad") for v in values) else "translation"


def _reads(written: object, unit: str) -> bool:
    """Return whether a text is a number of a unit."""
    try:
        to_si(written, unit)
    except ValueError:
        return False
    return True


def _mass(
    document: Document[ModelSchema], place: Sequence[str | int], written: Any, motion: Motion
) -> float:
    """Return a mass [kg], or a moment of inertia [kg m^2] of a rotational model.

    Raises
    ------
    DocumentError
        If it is none, or not above 0.
    """
    unit = unit_in("kg", motion)
    try:
        mass = to_si(written, unit)
    except ValueError as error:
        raise document.error(place, f"{error}{_mixed(written, motion)}") from error
    if mass <= 0.0:
        wanted = f"expected more than 0, such as {example(unit)}, got {quoted(written)}"
        raise document.error(place, wanted)
    return mass


def _mixed(written: object, motion: Motion) -> str:
    """Return the remedy for a mass of the other kind of motion; empty where it is none."""
    if not _reads(written, "kg" if motion == "rotation" else "kg m^2"):
        return ""
    return "; masses of one model are all in kg, or all moments of inertia in kg m^2"


def _element(
    document: Document[ModelSchema],
    place: Sequence[str | int],
    said: Any,
    places: list[str],
    motion: Motion,
) -> Element:
    effect = read_kind(document, place, said, EFFECTS, also=("between",), motion=motion)
    between = said.get("between")
    if "between" not in said:
        raise document.error(place, f"{effect.kind} needs between: [{BASE}, {places[1]}]")
    if not isinstance(between, list) or not all(isinstance(name, str) for name in between):
        raise document.error(
            (*place, "between"), f"expected two places, such as [{BASE}, {places[1]}]"
        )
    for i, name in enumerate(between):
        _check_place(document, (*place, "between", i), name, places)
    alone = isinstance(effect, AttachedMode) and len(between) == 1
    if not alone and (len(between) != 2 or between[0] == between[1]):
        raise document.error(
            (*place, "between"),
            f"expected two different places, got {len(between)}"
            if len(between) != 2
            else f"expected two different places, got {between[0]} twice",
        )
    if isinstance(effect, AttachedMode) and between[-1] == BASE:
        raise document.error(
            (*place, "between"), f"expected the mass that it sits on last, got {BASE}"
        )
    return Element(effect, tuple(between))


def _sensor(
    document: Document[ModelSchema],
    place: tuple[str, str],
    places: list[str],
    motion: Motion,
) -> Sensor:
    said = document.value.sensors[place[1]]
    _check_place(document, (*place, "at"), said.at, places)
    faults = tuple(
        read_kind(document, (*place, "faults", i), fault, FAULTS, motion=motion)
        for i, fault in enumerate(said.faults)
    )
    return Sensor(said.at, said.measures, faults)


def _mode(
    document: Document[ModelSchema], index: int, places: list[str], motion: Motion
) -> Mode:
    said = document.value.modes[index]
    where = ("modes", index, "participation")
    for name in said.participation:
        _check_place(document, (*where, name), name, places)
        if name == BASE:
            raise document.error((*where, name), f"expected a mass, got {BASE}")
    try:
        mass = _mass(document, ("modes", index, "mass"), said.mass, motion)
        return Mode(said.frequency, said.damping_ratio, mass, said.participation)
    except ValueError as error:
        raise document.error(where, str(error), at_key=True) from error


def _excitation(document: Document[ModelSchema], places: list[str]) -> Excitation:
    said = document.value.excitation
    found = [
        Excitation("base acceleration") if said.base else None,
        Excitation("free decay") if said.free else None,
        _acting(document, "force on", said.force_on, places),
        _acting(document, "displacement of", said.displacement_of, places),
    ]
    chosen = [one for one in found if one is not None]
    if len(chosen) != 1:
        raise document.error(
            ("excitation",),
            f"expected {{base: acceleration}}, {{force on: {places[1]}}}, "
            f"{{displacement of: {places[1]}}} or {{free: decay}}",
        )
    return chosen[0]


def _acting(
    document: Document[ModelSchema], key: str, mass: str | None, places: list[str]
) -> Excitation | None:
    """Return the excitation that acts on a mass, or None without one."""
    if mass is None:
        return None
    if mass == BASE:
        raise document.error(("excitation", key), f"expected a mass, got {BASE}")
    _check_place(document, ("excitation", key), mass, places)
    if key == "displacement of" and mass not in document.value.masses:
        raise document.error(
            ("excitation", key),
            f"expected a mass, got {mass}, a point of a structure; a force may act on it",
        )
    return Excitation("force" if key == "force on" else "imposed displacement", mass)


def _check_place(
    document: Document[ModelSchema],
    where: Sequence[str | int],
    name: str,
    places: list[str],
) -> None:
    """Pass a place that the model has.

    Raises
    ------
    DocumentError
        If it has not.
    """
    if name in places:
        return
    meant = near_miss(name, places)
    hint = f'did you mean "{meant}"?' if meant else f"places are {', '.join(places)}"
    error: DocumentError = document.error(where, f"no place {quoted(name)}; {hint}")
    raise error
