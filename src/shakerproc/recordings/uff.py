"""Read universal files: time records of data sets 58, and functions of frequency."""

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import RecordingError, SpectraError
from shakerproc.geometry import Place
from shakerproc.geometry.data_sets import UffDataSet, UffError, data_sets
from shakerproc.geometry.universal import Units, units_of, wireframe_of
from shakerproc.recordings.arrays import ArrayRow, LinesSource
from shakerproc.recordings.guard import AGAIN, shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis, half_digit
from shakerproc.recordings.response_functions import Function, FunctionFile, Kind
from shakerproc.recordings.time_base import ROUNDING
from shakerproc.recordings.uff_records import GENERAL, Record, record_of

LARGEST: Final = 1 << 30
KIND: Final = 58
FUNCTIONS: Final = (
    "functions of no stated type", "time responses", "auto spectra", "cross spectra",
    "frequency response functions", "transmissibilities", "coherences", "autocorrelations",
    "cross-correlations", "power spectral densities", "energy spectral densities",
    "probability densities", "spectra", "cumulative frequency distributions",
    "peaks and valleys", "stress cycles", "strain cycles", "orbits", "mode indicators",
    "force patterns", "partial powers", "partial coherences", "eigenvalues", "eigenvectors",
    "shock response spectra", "impulse responses of filters", "multiple coherences",
    "order functions", "phase compensations",
)  # fmt: skip
"""What the records of kind 58 hold, by the number of their type."""

_EXACT: Final = re.compile(r"sample rate ([0-9.eE+-]{1,30}) Hz")

_OF: Final = re.compile(r" Hz, record \d{1,9} of (\d{1,9})")
"""Of how many a record is one, as `write_uff` says; the format itself does not count them."""

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


def read_uff(path: Path, run: str) -> RawFile:
    """Return the time records of a universal file as channels.

    Raises
    ------
    RecordingError
        If it holds none, or a record is not as long as it says.
    """
    content = _content(
        path, run, " are too many to hold in memory. Export the recording as TDMS instead."
    )
    try:
        uff_sets = list(data_sets(content))
        every = [record_of(content, one) for one in uff_sets if one.kind == KIND]
    except UffError as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error
    records = [record for record in every if record.is_recording]
    others = _contents_text([r for r in every if not r.is_recording], uff_sets)
    if not records:
        message = (
            f"{run}: no time record (dataset 58 with function type 1, or 0 over a time); the "
            f"file holds {others or 'no datasets'}. Export the time histories, not the spectra."
        )
        raise SpectraError(message, others) if every else RecordingError(message)
    longest = max(record.promised for record in records)
    channels = tuple(
        _channel(record, name, row, longest)
        for row, (record, name) in enumerate(zip(records, _names(records), strict=True))
    )
    lines = tuple(ArrayRow(record.values, None, upright=True) for record in records)
    notes = [
        f"The file is not whole: it ends inside {shown(c.name)}, {c.n_samples} of "
        f"{c.promised} values."
        for c, record in zip(channels, records, strict=True)
        if record.cut
    ]
    sentences = [match for r in records if r.texts and (match := _OF.search(r.texts[4]))]
    missing = max((int(match[1]) for match in sentences), default=0) - len(records)
    if missing > 0:
        notes.append(
            f"The file is not whole: {missing} of {missing + len(records)} records are missing."
        )
    general = sum(record.function == GENERAL for record in records)
    if general:
        notes.append(f"{general} records of no stated type are over a time: they are channels.")
    filled = sum(record.filled > 0 for record in records)
    if filled:
        notes.append(
            f"Zeros that only fill the last line of {filled} records, beyond the values that "
            "they promise, are left out."
        )
    if others:
        notes.append(f"Left out, no time records: {others}.")
    return RawFile((RawGroup("", channels),), LinesSource(run, lines), tuple(notes))


def _content(path: Path, run: str, advice: str) -> bytes:
    """Return the bytes of a file that fits into memory, and else `advice`.

    Raises
    ------
    RecordingError
        If it cannot be opened, or is larger than `LARGEST`.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise RecordingError(f"{run}: more than {LARGEST >> 20} MB{advice}")
        return path.read_bytes()
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error


def _contents_text(records: Sequence[Record], uff_sets: Sequence[UffDataSet]) -> str:
    """Return the further records and datasets of a file, with their numbers."""
    functions = Counter(
        ("complex " if r.is_complex and r.function <= 1 else "")
        + (FUNCTIONS[r.function] if r.function < len(FUNCTIONS) else f"type {r.function}")
        for r in records
    )
    kinds = Counter(one.kind for one in uff_sets if one.kind != KIND)
    parts = [f"{what} ({count})" for what, count in functions.items()]
    parts += [f"dataset {kind} ({count})" for kind, count in sorted(kinds.items())]
    return ", ".join(parts)


def _channel(record: Record, name: str, row: int, longest: int) -> RawChannel:
    """Return a record as a channel; where it does not say its length it is as the others."""
    return RawChannel(
        name=name,
        row=row,
        n_samples=record.values.size,
        promised=record.promised if record.promised >= 0 else max(longest, 1),
        unit="" if record.unit in {"NONE", "None"} else record.unit,
        axes=_axes(record, name),
    )


def _names(records: Sequence[Record]) -> list[str]:
    """Return the first description that tells the records apart."""
    sentences = [r for r in records if r.texts]
    for kind in ("id1", "place", "id4"):
        names = [
            {"id1": r.texts[0], "place": r.place, "id4": r.texts[3]}[kind] for r in sentences
        ]
        if names and all(n and n != "NONE" for n in names) and len(set(names)) == len(names):
            rest = [f"record {number + 1}" for number in range(len(sentences), len(records))]
            return names + rest
    return [f"record {number + 1}" for number in range(len(records))]


def _axes(record: Record, name: str) -> tuple[TimeAxis, ...]:
    """Return the stated abscissa of a record; the format prints its step to six digits."""
    if not record.texts:
        return (TimeAxis("record", problem="the file ends inside its header"),)
    axis = TimeAxis(
        f"the step of record {shown(name, 30)}" if record.times is None
        else f"the abscissa of record {shown(name, 30)}",
        step=None if record.times is not None else record.step,
        times=record.times,
        start=record.start,
        quantity=record.abscissa,
        unit=record.abscissa_unit,
        digit=half_digit(record.step_text),
        start_digit=half_digit(record.start_text),
    )  # fmt: skip
    exact = _EXACT.search(record.texts[4])
    if exact is None or not _is_float(exact[1]) or record.times is not None:
        return (axis,)
    rate = float(exact[1])
    step = max(record.step, 0.0)
    if rate > 0.0 and abs(step * rate - 1.0) <= rate * axis.digit + ROUNDING:
        return (TimeAxis("id line 5", rate=rate), axis)
    return (axis,)


def _is_float(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def read_uff_functions(path: Path, run: str) -> FunctionFile:
    """Return the functions of the data sets 58 of a universal file.

    Raises
    ------
    RecordingError
        If a record is not as long as it says, or is over no frequencies.
    """
    content = _content(path, run, ". Export fewer functions.")
    try:
        uff_sets = list(data_sets(content))
        records = [
            record_of(content, one, spectra=True) for one in uff_sets if one.kind == KIND
        ]
        units = units_of(content, uff_sets)
        wireframe, left_out = wireframe_of(content, uff_sets, units)
    except UffError as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error
    whole = [record for record in records if record.head]
    names = _point_names(whole)
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
    """Return the unit of an axis, and the factor from the unit of the file.

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


def _point_names(records: Sequence[Record]) -> frozenset[str]:
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
