"""Model files in: masses, elements, and the effects and faults that their kinds name."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Final, Protocol, TypeVar, final

from pydantic import BaseModel

from shakerproc.documents import Document, read_document
from shakerproc.errors import DocumentError, ModelError
from shakerproc.model_files.schema import (
    ModelSchema,
    ProvenanceSection,
    check_driven,
    read_structures,
)
from shakerproc.models.conditions import Conditions, Scale
from shakerproc.models.effects import EFFECTS, SPELLINGS
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.base import Parameter, parameter_in
from shakerproc.models.faults import FAULTS
from shakerproc.models.model import BASE, Element, Excitation, Model, Sensor
from shakerproc.models.motion import Motion, unit_in
from shakerproc.models.structure import Mode
from shakerproc.units import example, near_miss, quoted, to_si

_NUMBERS: Final = re.compile(
    r"((?:[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?(?:\s*,\s*|\s+|$))+)(.*)", re.DOTALL
)
SCALED_BY: Final = "scaled_by"
"""Key of an element for the condition that scales it."""

MOST_NUMBERS: Final = 4096
"""Numbers that a table may have in all."""

Schema = TypeVar("Schema", bound=BaseModel)


def read_numbers(value: object, parameter: Parameter) -> tuple[float, ...]:
    """Return the numbers of a text such as ``-0.1 0 0.1 mm`` in SI.

    Raises
    ------
    ValueError
        If it is none, with what was expected.
    """
    text = repr(value) if isinstance(value, int | float) else value
    match = _NUMBERS.fullmatch(text.strip()) if isinstance(text, str) else None
    if match is None:
        raise ValueError(
            "expected numbers with one unit at the end, such as "
            f"{example_numbers(parameter)}, got {quoted(value)}"
        )
    unit = match[2].strip()
    words = match[1].replace(",", " ").split()
    if len(words) > MOST_NUMBERS:
        raise ValueError(f"expected {MOST_NUMBERS} numbers at most, got {len(words)}")
    return tuple(to_si(f"{word} {unit}".strip(), parameter.unit) for word in words)


def read_rows(value: object, parameter: Parameter) -> tuple[tuple[float, ...], ...]:
    """Return rows of numbers, each a text.

    Raises
    ------
    ValueError
        If they are none, with what was expected.
    """
    if not isinstance(value, list) or not value:
        raise ValueError(f"expected a list of rows, such as [{example_numbers(parameter)}]")
    rows = []
    for i, row in enumerate(value, 1):
        try:
            rows.append(read_numbers(row, parameter))
        except ValueError as error:
            raise ValueError(f"row {i}: {error}") from error
    return tuple(rows)


def example_numbers(parameter: Parameter) -> str:
    """Return how numbers are written."""
    return f"-1 0 1 {parameter.unit}"


def is_list_of_mappings(value: Any) -> bool:
    """Return whether a value is a list of mappings, as effects within an effect are."""
    return isinstance(value, list) and all(isinstance(one, dict) for one in value)


class Kind(Protocol):
    """Interface that effects and faults have in common."""

    parameters: ClassVar[Mapping[str, Parameter]]


KindT = TypeVar("KindT", bound=Kind)


def read_kind(
    document: Document[Schema],
    place: Sequence[str | int],
    said: Mapping[str, Any],
    kinds: Mapping[str, type[KindT]],
    also: Sequence[str] = (),
    *,
    motion: Motion = "translation",
) -> KindT:
    """Return the effect or fault that a mapping of the file describes.

    Parameters
    ----------
    document : Document
        For errors.
    place : sequence of str and int
        Where the mapping stands.
    said : mapping
        Its keys and values.
    kinds : mapping of str to type
        What may be made.
    also : sequence of str
        Keys that are not parameters.
    motion : Motion
        Of the masses: says the units of the parameters.

    Raises
    ------
    DocumentError
        If the kind is not known, or a parameter is unknown, missing, or not a physical value.
    """
    kind = _kind(document, place, said, kinds)
    made = kinds[kind]
    values: dict[str, Any] = {}
    for key, value in said.items():
        if key == "kind" or key in also:
            continue
        if key not in made.parameters:
            allowed = [*made.parameters, *also]
            raise document.error(
                (*place, key), _unknown("parameter", key, allowed, f"of {kind}"), at_key=True
            )
        here, parameter = (*place, key), parameter_in(made.parameters[key], motion)
        if parameter.holds == "effects":
            values[key] = _kinds(document, here, value, kinds, motion)
        else:
            values[key] = _value(document, here, value, parameter)
    for name, parameter in made.parameters.items():
        if name not in values and not parameter.optional:
            raise document.error(
                place,
                f"{kind} needs {name}, such as {name}: "
                f"{_example(parameter_in(parameter, motion))}",
            )
    try:
        return made(**values)
    except ValueError as error:
        raise document.error(place, str(error)) from error


def _kind(
    document: Document[Schema],
    place: Sequence[str | int],
    said: Mapping[str, Any],
    kinds: Mapping[str, type[KindT]],
) -> str:
    kind = said.get("kind")
    if "kind" not in said:
        raise document.error(place, f"expected a kind, one of {', '.join(kinds)}")
    if not isinstance(kind, str) or kind not in kinds:
        raise document.error((*place, "kind"), _unknown("kind", kind, list(kinds)))
    return next((SPELLINGS[kind, key] for key in said if (kind, key) in SPELLINGS), kind)


def _kinds(
    document: Document[Schema],
    place: Sequence[str | int],
    value: Any,
    kinds: Mapping[str, type[KindT]],
    motion: Motion,
) -> tuple[KindT, ...]:
    """Return the effects that an effect is made of."""
    if not is_list_of_mappings(value):
        raise document.error(place, "expected a list of elements, such as [{kind: gap, ...}]")
    return tuple(
        read_kind(document, (*place, i), one, kinds, motion=motion)
        for i, one in enumerate(value)
    )


def _unknown(what: str, value: object, known: list[str], of: str = "") -> str:
    meant = near_miss(value, known) if isinstance(value, str) else None
    hint = f'did you mean "{meant}"?' if meant else f"there are {', '.join(known)}"
    return " ".join(f"unknown {what} {quoted(value)} {of}".split()) + f"; {hint}"


def _value(
    document: Document[Schema], place: Sequence[str | int], value: object, parameter: Parameter
) -> float | str | tuple[Any, ...]:
    """Return a value in SI, the word that it is, or the numbers that it holds."""
    if parameter.choices:
        if value not in parameter.choices:
            wanted = " or ".join(parameter.choices)
            raise document.error(place, f"expected {wanted}, got {quoted(value)}")
        return str(value)
    try:
        if parameter.holds == "numbers":
            return read_numbers(value, parameter)
        if parameter.holds == "rows":
            return read_rows(value, parameter)
        number = to_si(value, parameter.unit)
    except ValueError as error:
        raise document.error(place, str(error)) from error
    if (parameter.sign == "positive" and number <= 0.0) or (
        parameter.sign == "not negative" and number < 0.0
    ):
        bound = "more than 0" if parameter.sign == "positive" else "at least 0"
        raise document.error(
            place, f"expected {bound}, such as {_example(parameter)}, got {quoted(value)}"
        )
    return number


def _example(parameter: Parameter) -> str:
    if parameter.holds == "effects":
        return "[{kind: gap, stiffness: 1.2e5 N/m, clearance: 0.05 mm}, ...]"
    if parameter.holds != "number":
        return f"-1 0 1 {parameter.unit}"
    return parameter.choices[0] if parameter.choices else example(parameter.unit)


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
    conditions : Conditions, optional
        Those that the model is under, if it is not as it stands in the file.
    """

    path: Path
    model: Model
    provenance: tuple[ProvenanceSection, ...]
    document: Document[ModelSchema]
    conditions: Conditions | None = None

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
        _element(document, ("elements", i), places, motion) for i in range(len(said.elements))
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
    document: Document[ModelSchema], place: tuple[str, int], places: list[str], motion: Motion
) -> Element:
    said, also = document.value.elements[place[1]], ("between", SCALED_BY)
    effect = read_kind(document, place, said, EFFECTS, also=also, motion=motion)
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
    if SCALED_BY not in said:
        return Element(effect, tuple(between))
    where = (*place, SCALED_BY)
    try:
        return Element(effect, tuple(between), _scale(document, where, said[SCALED_BY]))
    except ValueError as error:
        raise document.error(where, str(error)) from error


def _scale(document: Document[ModelSchema], place: Sequence[str | int], said: Any) -> Scale:
    """Return the condition that scales an element.

    Raises
    ------
    DocumentError
        If it is not one condition with the value at which the numbers of the element hold.
    """
    if not isinstance(said, dict) or len(said) != 1:
        raise document.error(
            place, "expected one condition and its value at which the numbers hold, such as "
            "{voltage: 2 V}"
        )  # fmt: skip
    ((name, written),) = said.items()
    try:
        return Scale(str(name), written)
    except ValueError as error:
        raise document.error((*place, name), str(error)) from error


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
    excitations = [
        Excitation("base acceleration") if said.base else None,
        Excitation("free decay") if said.free else None,
        _acting(document, "force on", said.force_on, places),
        _acting(document, "displacement of", said.displacement_of, places),
    ]
    chosen = [one for one in excitations if one is not None]
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
