"""Structures of a model file: written in it, or in a file of their own."""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from shakerproc.documents import Document, read_document
from shakerproc.model_files.schema import ModelSchema, StructureSchema
from shakerproc.models.model import BASE, Excitation
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.units import quoted, to_si

Where = Sequence[str | int]

_ROOT_OF_MASS: Final = re.compile(r"(.*?)\s*sqrt\((\w+)\)\s*")


def read_structures(document: Document[ModelSchema]) -> dict[str, Structure]:
    """Return the structures of a model, by name.

    Raises
    ------
    DocumentError
        If one is no structure, or two places have one name; with line and column.
    """
    found: dict[str, Structure] = {}
    owner = dict.fromkeys(document.value.masses, "a mass") | {BASE: "the shaker table"}
    for name, said in document.value.structures.items():
        where = ("structures", name)
        if isinstance(said, str):
            one = _of_file(document, where, said)
        else:
            one = _structure(document, where, said)
        for point in one.points:
            if point in owner:
                raise document.error(
                    where,
                    f"point {quoted(point)} is the name of {owner[point]} already; names of "
                    f"places are unique in a model",
                )
        owner |= dict.fromkeys(one.points, f"a point of {name}")
        found[name] = one
    return found


def check_driven(
    document: Document[ModelSchema], structures: Mapping[str, Structure], excitation: Excitation
) -> None:
    """Pass structures on which the base can act, where it moves.

    Raises
    ------
    DocumentError
        If one has neither rigid-body modes that move as the base does nor participations.
    """
    for name, one in structures.items():
        if excitation.moves_base:
            try:
                one.participations  # noqa: B018
            except ValueError as error:
                raise document.error(("structures", name), str(error)) from error


def _of_file(document: Document[ModelSchema], where: Where, name: str) -> Structure:
    path = document.path.parent / name
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise document.error(
            where,
            f"no reader for {quoted(name)}; a structure is a file that ends in "
            f"{', '.join(READERS)}, or stands here itself",
        )
    if not path.is_file():
        raise document.error(where, f"no file {quoted(name)} beside the model")
    return reader(path)


def read_structure(path: Path) -> Structure:
    """Return the structure that a YAML file describes.

    Raises
    ------
    DocumentError
        If it is none, with line and column.
    """
    document = read_document(path, StructureSchema)
    return _structure(document, (), document.value)


def _structure(document: Document[Any], where: Where, said: StructureSchema) -> Structure:
    """Return the structure that stands at a place of a file.

    Raises
    ------
    DocumentError
        If its shapes do not fit its points, a mode moves none, or a name stands twice.
    """
    if not said.points:
        raise document.error((*where, "points"), "expected points, such as [foot 1, tip]")
    for i, point in enumerate(said.points):
        if point in said.points[:i]:
            raise document.error(
                (*where, "points", i), f"point {quoted(point)} stands twice; rename one"
            )
    if not said.modes:
        raise document.error((*where, "modes"), "expected modes; a structure moves in them")
    if said.direction is not None and not any(
        point.endswith(f"/{said.direction}") for point in said.points
    ):
        raise document.error(
            (*where, "direction"),
            f"no point ends in /{said.direction}; it is the direction in which the base "
            f"moves, such as z of foot 1/z",
        )
    root = _root_of_unit(document, where, said.mass_unit)
    modes = tuple(_mode(document, where, said, i, root) for i in range(len(said.modes)))
    structure = Structure(said.points, modes, said.direction)
    if said.mass is not None:
        try:
            structure.check_mass(said.mass)
        except ValueError as error:
            raise document.error((*where, "mass"), str(error)) from error
    return structure


def _root_of_unit(document: Document[Any], where: Where, unit: str) -> float:
    """Return the root of the unit of mass for which shapes are normalised [sqrt(kg)]."""
    try:
        return float(to_si(f"1 {unit}", "kg") ** 0.5)
    except ValueError as error:
        raise document.error((*where, "mass_unit"), str(error)) from error


def _mode(
    document: Document[Any], where: Where, said: StructureSchema, i: int, root: float
) -> StructureMode:
    mode, here = said.modes[i], (*where, "modes", i)
    if len(mode.shape) != len(said.points):
        raise document.error(
            (*here, "shape"),
            f"expected {len(said.points)} values, one for each point, got {len(mode.shape)}",
        )
    if not any(mode.shape):
        raise document.error(
            (*here, "shape"), "a mode that moves none of the points; leave the mode out"
        )
    participation = None
    if mode.participation is not None:
        participation = _participation(document, (*here, "participation"), mode.participation)
    shape = tuple(value / root for value in mode.shape)
    try:
        return StructureMode(mode.frequency, mode.damping_ratio, shape, participation)
    except ValueError as error:
        raise document.error(here, str(error)) from error


def _participation(document: Document[Any], where: Where, written: object) -> float:
    """Return a participation, such as ``1.9 sqrt(kg)`` [sqrt(kg)]."""
    wanted = f"expected such as 1.9 sqrt(kg), got {quoted(written)}"
    found = _ROOT_OF_MASS.fullmatch(written) if isinstance(written, str) else None
    if found is None:
        raise document.error(where, wanted)
    try:
        return to_si(found[1], "1") * float(to_si(f"1 {found[2]}", "kg") ** 0.5)
    except ValueError as error:
        raise document.error(where, wanted) from error


READERS: Final[Mapping[str, Callable[[Path], Structure]]] = MappingProxyType({
    ".yaml": read_structure,
    ".yml": read_structure,
})
"""Readers of files that hold a structure, by their endings."""
