"""Schema of a model file, and its structures: written in it, or in files of their own."""

import re
from collections.abc import Container, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from shakerproc.data import FloatArray
from shakerproc.documents import Document, FromList, Section, read_document
from shakerproc.exchange.mode_files import READERS, read_mode_file
from shakerproc.exchange.modes import ModeTable
from shakerproc.geometry import Place
from shakerproc.model_files.exchanged import modes_of, seen_at
from shakerproc.models.model import BASE, Excitation, Measures
from shakerproc.models.structure import Structure, StructureMode, check_mass, check_modes
from shakerproc.units import in_unit, quoted, to_si

_Metre = Annotated[float, in_unit("m")]


class ExcitationSection(Section):
    """``{base: acceleration}``, ``{force on: coupon}`` and so on: one of them."""

    base: Literal["acceleration"] | None = None
    force_on: Annotated[str | None, Field(alias="force on")] = None
    displacement_of: Annotated[str | None, Field(alias="displacement of")] = None
    free: Literal["decay"] | None = None


class SensorSection(Section):
    """Place and quantity of one channel."""

    at: str
    measures: Measures = "acceleration"
    faults: Annotated[tuple[dict[str, Any], ...], FromList] = ()


class ModeSection(Section):
    """One further linear mode."""

    frequency: Annotated[float, in_unit("Hz", positive=True)]
    damping_ratio: float = Field(ge=0.0)
    mass: Any
    participation: dict[str, float]


class ProvenanceSection(Section):
    """Where a fitted part of the model comes from."""

    added: str
    between: Annotated[tuple[str, ...], FromList]
    from_model: Annotated[str, Field(alias="from model")] = ""
    tests: Annotated[tuple[str | int, ...], FromList] = ()
    sha256: dict[str, str] = Field(default_factory=dict)
    intervals: dict[str, Annotated[tuple[str, str], FromList]] = Field(default_factory=dict)
    program: str = ""
    date: str = ""


class StructureModeSection(Section):
    """One mode of a structure."""

    frequency: Annotated[float, in_unit("Hz", not_negative=True)]
    damping_ratio: float = Field(ge=0.0)
    shape: Annotated[tuple[float, ...], FromList]
    participation: Any = None


class StructureSchema(Section):
    """A structure by its modes: a whole file, or a part of a model."""

    structure: Literal[1] = 1
    title: str = ""
    points: Annotated[tuple[str, ...], FromList] = ()
    direction: str | None = None
    modes: Annotated[tuple[StructureModeSection, ...], FromList] = ()
    modes_from: str | None = None
    nodes: dict[str, str] = Field(default_factory=dict)
    damping_ratio: Annotated[float | None, Field(ge=0.0)] = None
    residual: dict[str, Annotated[float, in_unit("m/N", positive=True)]] = Field(
        default_factory=dict
    )
    positions: dict[str, Annotated[tuple[_Metre, _Metre, _Metre], FromList]] = Field(
        default_factory=dict
    )
    mass: Annotated[float | None, in_unit("kg", positive=True)] = None
    mass_unit: str | None = None
    length_unit: str | None = None


class ModelSchema(Section):
    """The whole file."""

    model: Literal[1]
    title: str = ""
    masses: dict[str, Any] = Field(default_factory=dict)
    structures: dict[str, str | StructureSchema] = Field(default_factory=dict)
    elements: Annotated[tuple[dict[str, Any], ...], FromList]
    excitation: ExcitationSection
    modes: Annotated[tuple[ModeSection, ...], FromList] = ()
    sensors: dict[str, SensorSection] = Field(default_factory=dict)
    provenance: Annotated[tuple[ProvenanceSection, ...], FromList] = ()


YAML: Final = (".yaml", ".yml")

Where = Sequence[str | int]

_ROOT_OF_MASS: Final = re.compile(r"(.*?)\s*sqrt\((\w+)\)\s*")


def read_structures(document: Document[ModelSchema]) -> dict[str, Structure]:
    """Return the structures of a model, by name.

    Raises
    ------
    DocumentError
        If one is no structure, or two places have one name; with line and column.
    """
    structures: dict[str, Structure] = {}
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
        structures[name] = one
    return structures


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
    path = _path_below(document, where, name, (*YAML, *READERS))
    if path.suffix.lower() in YAML:
        return read_structure(path)
    return _structure(document, where, StructureSchema(modes_from=name))


def _path_below(
    document: Document[Any], where: Where, name: str, endings: Sequence[str]
) -> Path:
    """Return the path of a file that a document names, below its own folder or beside it.

    Raises
    ------
    DocumentError
        If there is none, or it ends otherwise.
    """
    path = document.path.parent / name
    if path.suffix.lower() not in endings:
        raise document.error(
            where, f"no reader for {quoted(name)}; modes are in files {', '.join(endings)}"
        )
    if not path.is_file():
        raise document.error(where, f"no file {quoted(name)} beside {document.path.name}")
    return path


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
    root = _root_of_unit(document, where, said.mass_unit)
    shares: FloatArray | None = None
    if said.modes_from is None:
        points, positions = said.points, dict(said.positions)
        _check_points(document, where, points)
        if not said.modes:
            raise document.error((*where, "modes"), "expected modes; a structure moves in them")
        modes = tuple(_mode(document, where, said, i, root) for i in range(len(said.modes)))
        ratios = np.array([mode.damping_ratio for mode in modes])
        written = np.array([mode.shape for mode in said.modes]).T
        _check_modes(document, (*where, "modes"), [m.frequency for m in modes], ratios, written)
    else:
        points, modes, positions, shares = _modes_of_file(document, where, said, root)
        _check_points(document, where, points)
    if said.direction is not None and not any(
        point.endswith(f"/{said.direction}") for point in points
    ):
        raise document.error(
            (*where, "direction"),
            f"no point ends in /{said.direction}; it is the direction in which the base "
            f"moves, such as z of foot 1/z",
        )
    _check_named(document, (*where, "residual"), said.residual, {*points})
    undirected = {point.rpartition("/")[0] for point in points}
    _check_named(document, (*where, "positions"), said.positions, {*points, *undirected})
    try:
        structure = Structure(points, modes, said.direction, said.residual, positions)
    except ValueError as error:
        raise document.error((*where, "residual"), str(error)) from error
    if said.mass is not None:
        try:
            shares = structure.participations if shares is None else shares
            check_mass(shares, said.mass, fixed=structure.of_fixed_base)
        except ValueError as error:
            raise document.error((*where, "mass"), str(error)) from error
    return structure


def _check_named(
    document: Document[Any], where: Where, said: Iterable[str], points: Container[str]
) -> None:
    """Pass a mapping whose keys are points.

    Raises
    ------
    DocumentError
        If one is none.
    """
    for point in said:
        if point not in points:
            raise document.error((*where, point), f"no point {quoted(point)}", at_key=True)


def _check_points(document: Document[Any], where: Where, points: Sequence[str]) -> None:
    if not points:
        raise document.error((*where, "points"), "expected points, such as [foot 1, tip]")
    known: set[str] = set()
    for i, point in enumerate(points):
        if point in known:
            raise document.error(
                (*where, "points", i), f"point {quoted(point)} stands twice; rename one"
            )
        known.add(point)


def _check_modes(
    document: Document[Any], where: Where, frequencies: ArrayLike, damping: FloatArray,
    shapes: FloatArray,
) -> None:  # fmt: skip
    """Pass modes that can be those of a structure (see `check_modes`).

    Raises
    ------
    DocumentError
        If they cannot.
    """
    try:
        check_modes(np.asarray(frequencies, float), damping, shapes)
    except ValueError as error:
        raise document.error(where, str(error)) from error


def _modes_of_file(
    document: Document[Any], where: Where, said: StructureSchema, root: float
) -> tuple[tuple[str, ...], tuple[StructureMode, ...], dict[str, Place], FloatArray | None]:
    """Return points, modes and positions of a structure whose modes stand in another file.

    The last are the participations of all modes of the file [sqrt(kg)], as far as it tells
    them; those that move no point are no modes of the structure.

    Raises
    ------
    DocumentError
        If the file has no such place or no damping, or modes are given twice.
    """
    if said.modes:
        raise document.error((*where, "modes"), "expected modes or modes_from, got both")
    named, here = str(said.modes_from), (*where, "modes_from")
    table = read_mode_file(_path_below(document, here, named, tuple(READERS)))
    if table.units == "SI" and said.mass_unit is not None:
        raise document.error(
            (*where, "mass_unit"), f"{named} states units itself; leave it out"
        )
    written = table.shapes
    table = table.in_si(root**2, _length_unit(document, where, said, table))
    points = {
        point: _place_of(document, where, said, table, point)
        for point in said.points or tuple(said.nodes) or table.places
    }
    damping = table.damping_ratios
    if said.damping_ratio is not None:
        damping = np.full(table.frequencies.size, said.damping_ratio)
    if damping is None:
        raise document.error(
            here, f"{named} holds no damping; state damping_ratio: 0.01, say, of all modes"
        )
    _check_modes(document, here, table.frequencies, damping, written)
    axis = said.direction or _one_axis(points.values())
    table_seen = seen_at(table, points, {axis})
    modes, shares = modes_of(table_seen, damping, axis)
    known = {p: place for p, place in table_seen.positions.items() if _unsaid(said, p)}
    return tuple(points), modes, known | said.positions, shares


def _place_of(
    document: Document[Any], where: Where, said: StructureSchema, table: ModeTable, point: str
) -> str:
    """Return the place of a table where a point stands.

    Raises
    ------
    DocumentError
        If there is none.
    """
    if point not in said.nodes and point in table.row_of:
        return point
    place = "/".join(said.nodes.get(point, point).split(maxsplit=1))
    if place not in table.row_of:
        key = "nodes" if point in said.nodes else "points"
        raise document.error((*where, key), f"{said.modes_from} {table.no_place(place)}")
    return place


def _one_axis(places: Iterable[str]) -> str:
    """Return the direction in which all places are seen; empty where they have several."""
    axes = {place.rpartition("/")[2] for place in places}
    return axes.pop() if len(axes) == 1 else ""


def _unsaid(said: StructureSchema, point: str) -> bool:
    """Return whether a file does not say where a point is, with or without direction."""
    return not {point, point.rpartition("/")[0]} & {*said.positions}


def _length_unit(
    document: Document[Any], where: Where, said: StructureSchema, table: ModeTable
) -> float | None:
    """Return the unit of length of a file [m]; None where nobody says it.

    Raises
    ------
    DocumentError
        If a unit is stated that is none of a length, or that the file states itself.
    """
    if said.length_unit is None:
        return None if table.units == "no units" else 1.0
    here = (*where, "length_unit")
    if table.units == "SI":
        raise document.error(here, f"{said.modes_from} states units itself; leave it out")
    try:
        return to_si(f"1 {said.length_unit}", "m")
    except ValueError as error:
        raise document.error(here, str(error)) from error


def _root_of_unit(document: Document[Any], where: Where, unit: str | None) -> float:
    """Return the root of the unit of mass for which shapes are normalised [sqrt(kg)]."""
    try:
        return float(to_si(f"1 {unit or 'kg'}", "kg") ** 0.5)
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
    match = _ROOT_OF_MASS.fullmatch(written) if isinstance(written, str) else None
    if match is None:
        raise document.error(where, wanted)
    try:
        return to_si(match[1], "1") * float(to_si(f"1 {match[2]}", "kg") ** 0.5)
    except ValueError as error:
        raise document.error(where, wanted) from error
