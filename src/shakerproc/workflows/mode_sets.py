"""Modes of one program for another, at all of their places or at those of sensors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Final, final

import numpy as np
import scipy

from shakerproc import files
from shakerproc.data import ChannelUse, Role
from shakerproc.errors import ArgumentError, ExchangeError
from shakerproc.exchange.mode_files import READERS, read_mode_file
from shakerproc.exchange.modes import (
    FREQUENCY,
    WRITERS,
    ModeTable,
    split_place,
    write_mode_file,
)
from shakerproc.geometry import Place
from shakerproc.geometry.data_sets import UffError, data_sets
from shakerproc.model_files.exchanged import seen_at, structure_of, table_of
from shakerproc.model_files.schema import YAML, read_structure
from shakerproc.model_files.writing import structure_text
from shakerproc.models.structure import AXES
from shakerproc.recordings import WRITERS as RECORDING_WRITERS
from shakerproc.recordings.uff_records import record_of
from shakerproc.testlog import TestLog, read_testlog
from shakerproc.units import to_si
from shakerproc.workflows.arguments import pairs

SEATED: Final[frozenset[Role]] = frozenset({"response", "displacement", "velocity", "force"})
"""Roles of channels that measure at a place of the body."""

_UNDIRECTED: Final = (
    "points are seen along several axes: state --direction of the base where it moves",
)
_PRINTED: Final = b"E I G E N V A L U E"


@final
@dataclass(frozen=True, slots=True)
class ModeOptions:
    """How modes are read, and where.

    Attributes
    ----------
    mass_unit, length_unit : str, optional
        Of a file that states none.
    damping_ratio : float, optional
        Of all modes, in place of those of the file [-].
    direction : str, optional
        ``x``, ``y`` or ``z``: in which the base moves, and sensors without a direction measure.
    at : sequence of str
        ``NAME=PLACE``: a point, and its place in the file.
    sensors : Path, optional
        Test log; its sensors are points too.
    """

    mass_unit: str | None = None
    length_unit: str | None = None
    damping_ratio: float | None = None
    direction: str | None = None
    at: Sequence[str] = ()
    sensors: Path | None = None


@final
@dataclass(frozen=True, slots=True)
class ConvertedModes:
    """A file with modes that was written.

    Attributes
    ----------
    places, modes : int
        How many it holds.
    notes : tuple of str
        Where its points are, and what the format does not hold, a sentence each.
    """

    places: int
    modes: int
    notes: tuple[str, ...]


@final
@dataclass(frozen=True, slots=True)
class _Seat:
    """Where a sensor sits.

    Attributes
    ----------
    name : str
        Of the sensor.
    names : tuple of str
        By which its place may be called.
    position : (x, y, z), optional
        [m].
    axis : str
        Along which it measures, such as ``-z``.
    """

    name: str
    names: tuple[str, ...]
    position: Place | None
    axis: str


def is_of_modes(source: Path, out: Path) -> bool:
    """Return whether a conversion is one of modes, not of a recording.

    The new file says, where its format holds one of both alone; else what the other holds.
    """
    ending = out.suffix.lower()
    if ending not in RECORDING_WRITERS or ending not in WRITERS:
        return ending in {*WRITERS, *YAML}
    return source.suffix.lower() in YAML or _holds_modes(source)


def _holds_modes(path: Path) -> bool:
    ending = path.suffix.lower()
    if ending not in READERS:
        return False
    if ending in {".uff", ".unv"}:
        return _is_universal_of_modes(path.read_bytes())
    with path.open("rb") as file:
        head = file.read(1 << 16)
    mark = {".csv": FREQUENCY.encode(), ".dat": _PRINTED}.get(ending, b"")
    return mark in (head.partition(b"\n")[0] if ending == ".csv" else head)


def _is_universal_of_modes(content: bytes) -> bool:
    try:
        uff_sets = list(data_sets(content))
        records = any(
            record_of(content, one).is_recording for one in uff_sets if one.kind == 58
        )
    except UffError:
        return False  # the reader of recordings says where
    return not records and any(one.kind == 55 for one in uff_sets)


def convert_modes(source: Path, out: Path, options: ModeOptions) -> ConvertedModes:
    """Write the modes of a file in the format of another.

    Raises
    ------
    ArgumentError
        If the file does not say its units or damping and no option does, or a place is none.
    ExchangeError
        If it holds no modes, or the other format cannot hold them.
    """
    if options.direction not in {None, *"xyz"}:
        raise ArgumentError("direction", f"expected x, y or z, got {options.direction!r}")
    log = None if options.sensors is None else read_testlog(options.sensors)
    table, notes = _read(source, options)
    table, told = _chosen(table, source.name, options, log)
    if out.suffix.lower() not in YAML:
        lost = write_mode_file(out, table, source.stem)
        return ConvertedModes(len(table.places), table.frequencies.size, (*notes, *told, *lost))
    if table.damping_ratios is None:
        raise ArgumentError(
            "damping_ratio",
            f"{source.name} holds no damping; state that of all modes, say 0.01",
        )
    try:
        structure = structure_of(table, table.damping_ratios, options.direction)
    except ValueError as error:
        raise ExchangeError(f"{source.name}: {error}") from error
    told += _UNDIRECTED * (options.direction is None and len(table.axes) > 1)
    comments = "".join(f"# {one}\n" for one in told)
    files.write_text(out, comments + structure_text(structure, source.stem))
    still = table.frequencies.size - len(structure.modes)
    lost = (f"{still} modes move none of the points: they are left out",) * bool(still)
    return ConvertedModes(
        len(table.places), len(structure.modes), (*notes, *told, *lost)
    )  # fmt: skip


def _read(path: Path, options: ModeOptions) -> tuple[ModeTable, tuple[str, ...]]:
    """Return the modes of a file in SI, and a sentence on the assumptions.

    Raises
    ------
    ArgumentError
        If units are missing, or stated twice.
    ExchangeError
        If the file holds no modes.
    """
    ending, notes = path.suffix.lower(), []
    if ending in YAML:
        structure = read_structure(path)
        table = table_of(structure)
        notes += ["residual flexibilities are left out"] * bool(structure.residual)
    elif ending in READERS:
        table = read_mode_file(path)
    else:
        raise ExchangeError(
            f"{path.name}: no reader of modes for {ending or 'a file without ending'}; modes "
            f"are in files {', '.join((*YAML, *READERS))}"
        )
    if options.damping_ratio is not None:
        ratios = np.where(table.frequencies > 0.0, options.damping_ratio, 0.0)
        table = replace(table, damping_ratios=ratios)
    said = {"mass_unit": options.mass_unit, "length_unit": options.length_unit}
    for name in (name for name, unit in said.items() if unit and table.units == "SI"):
        raise ArgumentError(name, f"{path.name} states its units itself; leave it out")
    if table.units == "no units":
        _check_said(path.name, table, options)
    elif table.units == "nothing" and not all(said.values()):
        notes.append(f"{path.name} states no units: kg and m are taken where no option says")
    factors = [_factor(name, unit) for name, unit in said.items()]
    return table.in_si(*factors), tuple(notes)


def _check_said(file: str, table: ModeTable, options: ModeOptions) -> None:
    """Pass options that say the units of a format without units.

    Raises
    ------
    ArgumentError
        If one is missing.
    """
    if options.mass_unit is None:
        raise ArgumentError(
            "mass_unit",
            f"{file} does not say for which unit of mass its shapes are normalised. State "
            f"it: kg, or t of a model in mm, t and N",
        )
    if table.positions and options.length_unit is None:
        raise ArgumentError(
            "length_unit",
            f"{file} does not say in which unit its nodes are; state it: m, or mm",
        )


def _factor(name: str, unit: str | None) -> float:
    """Return a unit in that of SI.

    Raises
    ------
    ArgumentError
        If it is none of that quantity.
    """
    wanted = {"mass_unit": "kg", "length_unit": "m"}[name]
    try:
        return to_si(f"1 {unit or wanted}", wanted)
    except ValueError as error:
        raise ArgumentError(name, str(error)) from error


def _chosen(
    table: ModeTable, file: str, options: ModeOptions, log: TestLog | None
) -> tuple[ModeTable, tuple[str, ...]]:
    """Return modes at the points that were asked for, and a sentence on each.

    All places of the file are points where none was asked for.

    Raises
    ------
    ArgumentError
        If one has no place in the file, or two have one name.
    """
    if not options.at and log is None:
        return table, ()
    points, notes = {}, []
    for name, place in pairs(options.at).items():
        points[name] = "/".join(place.split(maxsplit=1)) if place not in table.row_of else place
        if points[name] not in table.row_of:
            raise ArgumentError("at", f"{file} {table.no_place(points[name])}")
    seats = list(_seats(log, table, options.direction)) if log is not None else []
    mixed = len({seat.axis.removeprefix("-") for seat in seats}) > 1
    for seat in seats:
        axis = seat.axis.removeprefix("-")
        point = f"{seat.name}/{axis}" if mixed else seat.name
        if point in points:
            raise ArgumentError("at", f"{point} is the name of a sensor; choose another")
        points[point], how = _place_of(table, file, seat)
        against = ", against its direction: declare sensor_polarity" * (seat.axis != axis)
        notes.append(f"{point}: {points[point]}{how}{against}")
    axes = {options.direction or "", *(split_place(p)[1] for p in points.values())} - {""}
    return seen_at(table, points, axes or {""}), tuple(notes)


def _seats(log: TestLog, table: ModeTable, direction: str | None) -> Iterator[_Seat]:
    """Yield where the sensors of a log sit, each once.

    Raises
    ------
    ArgumentError
        If one sits elsewhere in another test, or its direction is not known or no axis.
    """
    uses: dict[str, ChannelUse] = {}
    for use in chain.from_iterable(test.channels for test in log.tests if not test.discarded):
        if use.role in SEATED:
            name = use.name or str(use.key)
            known = uses.setdefault(name, use)
            if (known.position, known.direction) != (use.position, use.direction):
                raise ArgumentError(
                    "sensors", f"{name} has not the same place in all tests; give a log of one"
                )
    for name, use in uses.items():
        yield _Seat(
            name, (name, *filter(None, [use.at])), use.position,
            _axis_of(name, use.direction, table, direction),
        )  # fmt: skip


def _axis_of(name: str, along: Place | None, table: ModeTable, direction: str | None) -> str:
    """Return the axis along which a sensor measures, with its sign.

    Raises
    ------
    ArgumentError
        If it is none, or not said.
    """
    if along is not None:
        text = next((axis for axis, unit in AXES.items() if unit == along), None)
        if text is None:
            told = " ".join(f"{v:.3g}" for v in along)
            raise ArgumentError(
                "sensors", f"{name} measures along {told}; a point is seen along x, y or z"
            )
        return text
    axes = table.axes if direction is None else {direction}
    if len(axes) != 1:
        raise ArgumentError(
            "direction",
            f"the log does not say along which axis {name} measures; state it there, or one "
            f"for all sensors",
        )
    return axes.pop()


def _place_of(table: ModeTable, file: str, seat: _Seat) -> tuple[str, str]:
    """Return the place of a sensor, by its name or by the nearest node, and how far that is.

    Raises
    ------
    ArgumentError
        If no place has its name and no node or no position is known.
    """
    axis = seat.axis.removeprefix("-")
    named = chain(seat.names, (f"{name}/{axis}" for name in seat.names))
    for place in named:
        if place in table.row_of:
            return place, ""
    nodes = [p for p in table.positions if split_place(p)[1] == axis]
    if seat.position is None or not nodes:
        raise ArgumentError(
            "sensors",
            f"{file} has no place {seat.name}/{axis}, and "
            + (
                "the log no position of it"
                if nodes
                else f"no nodes with positions along {axis}"
            ),
        )
    return _nearest(table.positions, nodes, seat.position)


def _nearest(
    positions: Mapping[str, Place], nodes: Sequence[str], position: Place
) -> tuple[str, str]:
    """Return the node nearest to a position [m], and how far that is, as text."""
    places = np.array([positions[node] for node in nodes])
    distance, row = scipy.spatial.cKDTree(places).query(position)
    others = places[np.any(places != places[row], axis=1)]
    beside = np.min(np.linalg.norm(others - places[row], axis=1), initial=np.inf)
    far = (
        f", farther than its nearest node is from it ({1e3 * beside:.3g} mm): check position "
        f"and units"
    ) * bool(distance > beside)
    return nodes[int(row)], f", {1e3 * distance:.3g} mm from its position{far}"
