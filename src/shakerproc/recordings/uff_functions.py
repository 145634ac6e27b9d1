"""Read the response functions, spectra and coherences of a universal file, and its nodes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError
from shakerproc.geometry import Place
from shakerproc.geometry.data_sets import UffError, data_sets
from shakerproc.geometry.universal import Units, units_of, wireframe_of
from shakerproc.recordings.guard import AGAIN
from shakerproc.recordings.response_functions import Function, FunctionFile, Kind
from shakerproc.recordings.uff import KIND, LARGEST
from shakerproc.recordings.uff_records import Record, record_of

_KINDS: Final[Mapping[int, Kind]] = {
    2: "auto spectrum", 3: "cross spectrum", 4: "response function", 5: "response function",
    6: "coherence", 9: "auto spectrum", 12: "spectrum", 26: "multiple coherence",
}  # fmt: skip
_UNITS: Final = {
    "8": "m", "11": "m/s", "12": "m/s^2", "13": "N", "9": "N", "15": "Pa",
}  # fmt: skip
"""SI units of the types of data that an axis may have, where it says no other."""

_DIRECTIONS: Final = {
    0: "", 1: "x", -1: "-x", 2: "y", -2: "-y", 3: "z", -3: "-z", 4: "rx", -4: "-rx", 5: "ry",
    -5: "-ry", 6: "rz", -6: "-rz",
}  # fmt: skip


def read_uff_functions(path: Path, run: str) -> FunctionFile:
    """Return the functions of the data sets 58 of a universal file.

    Raises
    ------
    RecordingError
        If a record is not as long as it says, or is over no frequencies.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise RecordingError(
                f"{run}: more than {LARGEST >> 20} MB. Export fewer functions."
            )
        content = path.read_bytes()
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error
    try:
        found = list(data_sets(content))
        records = [record_of(content, one, spectra=True) for one in found if one.kind == KIND]
        units = units_of(content, found)
        wireframe, left_out = wireframe_of(content, found, units)
    except UffError as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error
    whole = [record for record in records if record.head]
    names = _names(whole)
    functions = list(_functions(records, names, units, run))
    places = {
        name: (wireframe.nodes[node], wireframe.turned(node, direction))
        for record in whole
        for name, node, direction in _seats(record, names)
        if node in wireframe.nodes and direction is not None
    }
    notes = [f"Geometry: {note}." for note in (*wireframe.notes, *left_out[:1])]
    if len(left_out) > 1:
        notes.append(f"Geometry: {len(left_out)} lines and surfaces are not drawn for this.")
    others = len(records) - len(functions)
    if others:
        notes.append(f"Not used: {others} records that are no response functions or spectra.")
    silent = sum(not _said(record.head[8]) for record in whole)
    if silent and functions:
        notes.append(
            f"{silent} records do not say their unit: that of their type of data is taken "
            f"(m/s^2, N, m), with {units.length:g} units of length in a metre."
        )
    drawn = replace(wireframe, notes=()) if wireframe.edges else None
    return FunctionFile(tuple(functions), places, tuple(notes), drawn)


def _functions(
    records: Sequence[Record], names: frozenset[str], units: Units, run: str
) -> Iterator[Function]:
    """Yield the records that are functions of a known kind.

    Raises
    ------
    RecordingError
        If the file ends inside one.
    """
    for number, record in enumerate(records, 1):
        if record.cut:
            raise RecordingError(f"{run}: the file ends inside record {number}. {AGAIN}")
        kind = _KINDS.get(record.function)
        if kind is not None:
            yield _function(record, kind, f"record {number}", names, units, run)


def _function(  # noqa: PLR0917
    record: Record, kind: Kind, where: str, names: frozenset[str], units: Units, run: str
) -> Function:
    """Return a record as a function.

    Raises
    ------
    RecordingError
        If it is over no frequencies.
    """
    values = record.spectrum
    if values is None or record.abscissa.casefold() != "frequency":
        over = record.abscissa or "nothing that is said"
        raise RecordingError(f"{run}: {where} is over {over}, not over frequencies.")
    even: FloatArray = record.start + record.step * np.arange(values.size, dtype=float)
    lines = even if record.times is None else record.times
    (response, _, _), (driven, _, _) = _seats(record, names)
    up, scale = _unit(record.head[8], units)
    down, other = _unit(record.head[9], units)
    if kind in {"response function", "cross spectrum"}:
        values = values * (scale / other)
    if kind == "spectrum":
        values = values * scale
    if kind in {"auto spectrum", "spectrum"}:
        driven = response
    return Function(where, kind, response, driven, up, down, lines, values)


def _said(line: str) -> str:
    """Return the unit that the header of an axis says; empty for none."""
    text = line[46:67].strip("\0 ")
    return "" if text.casefold() == "none" else text


def _unit(line: str, units: Units) -> tuple[str, float]:
    """Return the unit of an axis, and what one of the file's is in it.

    What the file says counts; an axis without a text is in the system of units of the file.
    """
    if said := _said(line):
        return said, 1.0
    unit = _UNITS.get(line[:10].strip(), "")
    return unit, 1.0 / (units.length if unit.startswith("m") else units.force)


def _ends(record: Record) -> Iterator[tuple[str, int, int]]:
    """Yield entity, node and direction of response and reference; no entity is empty."""
    line = record.head[5].ljust(80)
    for entity, node, direction in ((31, 41, 51), (56, 66, 76)):
        name = line[entity : entity + 10].strip()
        plain = "" if name.casefold() == "none" else name
        yield plain, _whole(line[node : node + 10]), _whole(line[direction : direction + 4])


def _names(records: Sequence[Record]) -> frozenset[str]:
    """Return the entities that stand for one node in one direction: names of channels.

    Others are names of components, of which nodes and directions tell the places.
    """
    seats: dict[str, set[tuple[int, int]]] = {}
    for record in records:
        for name, node, direction in _ends(record):
            seats.setdefault(name, set()).add((node, direction))
    return frozenset(name for name, there in seats.items() if name and len(there) == 1)


def _seats(record: Record, names: frozenset[str]) -> Iterator[tuple[str, int, Place | None]]:
    """Yield name, node and direction of response and reference."""
    for entity, node, direction in _ends(record):
        along = _DIRECTIONS.get(direction, "")
        if entity in names:
            yield entity, node, _vector(along)
        else:
            yield f"{node}/{along}" if along else str(node), node, _vector(along)


def _vector(along: str) -> Place | None:
    """Return a direction as a unit vector; None of a rotation or of none."""
    axis = "xyz".find(along.removeprefix("-")) if along.removeprefix("-") else -1
    if axis < 0:
        return None
    sign = -1.0 if along.startswith("-") else 1.0
    x, y, z = (sign if at == axis else 0.0 for at in range(3))
    return x, y, z


def _whole(cell: str) -> int:
    try:
        return int(cell)
    except ValueError:
        return 0
