"""Modes of a body at many places, and files with them for other programs.

A table, UFF data set 55, Nastran punch or CalculiX; what reads them is in `mode_files`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc import files
from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError
from shakerproc.geometry import Place, Wireframe, data_sets
from shakerproc.geometry.data_sets import NormalMode
from shakerproc.units import quoted

COMPONENTS: Final = ("x", "y", "z", "about x", "about y", "about z")
"""Three translations and three rotations of a node."""

FREQUENCY: Final = "frequency_hz"
DAMPING: Final = "damping_ratio"
PARTICIPATION: Final = "participation"
"""Columns of a table that are no places."""

Stated: TypeAlias = Literal["SI", "nothing", "no units"]


@final
@dataclass(frozen=True, eq=False)
class ModeTable:
    """Modes of a file.

    Attributes
    ----------
    places : tuple of str
        Columns of the table, or nodes with their directions, such as ``12/z``.
    frequencies : (n_modes,) array
        0 of rigid-body modes [Hz].
    shapes : (n_places, n_modes) array
        Normalised for a unit mass of the file.
    damping_ratios : (n_modes,) array, optional
        None where the file has none [-].
    participations : mapping of str to (n_modes,) array
        In an acceleration of the base along ``x``, ``y`` or ``z``, or, of the empty string,
        along the one direction there is [root of its unit of mass].
    positions : mapping of str to (x, y, z)
        Of places, where the file holds nodes with coordinates [m, or its unit of length].
    units : {"SI", "nothing", "no units"}
        ``SI`` where the file states its units, from which these are converted; ``nothing``
        where it could and does not, and kg and m are meant; ``no units`` where its format
        has no room for them.
    """

    places: tuple[str, ...]
    frequencies: FloatArray
    shapes: FloatArray
    damping_ratios: FloatArray | None = None
    participations: Mapping[str, FloatArray] = field(default_factory=dict)
    positions: Mapping[str, Place] = field(default_factory=dict)
    units: Stated = "nothing"

    @property
    def axes(self) -> set[str]:
        """Directions in which places are seen; empty of a place that has none."""
        return {split_place(place)[1] for place in self.places}

    @cached_property
    def row_of(self) -> dict[str, int]:
        """Row of each place."""
        return {place: row for row, place in enumerate(self.places)}

    def no_place(self, place: str) -> str:
        """Return the end of a sentence on a place that is none of these."""
        some = ", ".join(self.places[:6]) + (" ..." if len(self.places) > 6 else "")
        return f"has no place {quoted(place)}; it has {some}"

    def in_si(self, mass: float, length: float | None) -> "ModeTable":
        """Return the modes for a unit mass of a kilogram, at positions in metres.

        Parameters
        ----------
        mass, length : float
            Units in which the file is [kg] and [m]; without a length it has no positions.
        """
        root = np.sqrt(mass)
        scaled = {
            place: (length * x, length * y, length * z)
            for place, (x, y, z) in self.positions.items()
            if length is not None
        }
        return replace(
            self,
            shapes=self.shapes / root,
            participations={axis: v * root for axis, v in self.participations.items()},
            positions=scaled,
            units="SI",
        )


def split_place(place: str) -> tuple[str, str]:
    """Return node and direction of a place, such as -z; empty where it has none."""
    node, _, axis = place.rpartition("/")
    return (node, axis) if node and axis.removeprefix("-") in COMPONENTS else (place, "")


_LISTED: Final = 6
"""Nodes that were numbered, in a sentence."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Nodes:
    """Modes by nodes, each with three translations and three rotations.

    Attributes
    ----------
    numbers : tuple of int
        Those of the places; names are numbered behind them.
    motion : (n_modes, n_nodes, 6) array
        0 along what is not seen [1/sqrt(kg)].
    positions : mapping of int to (x, y, z)
        As far as they are known [m].
    notes : tuple of str
        Which names have which numbers, and what is taken along z.
    """

    numbers: tuple[int, ...]
    motion: FloatArray
    positions: Mapping[int, Place]
    notes: tuple[str, ...]


def write_mode_file(path: Path, table: ModeTable, title: str) -> tuple[str, ...]:
    """Write modes by the ending of a file; return its omissions, a sentence each.

    `table` is in SI, and so is the file.

    Raises
    ------
    ExchangeError
        If its format cannot hold the modes.
    """
    return WRITERS[path.suffix.lower()](path, table, title)


def _write_table(path: Path, table: ModeTable, _: str) -> tuple[str, ...]:
    """Write a table with a row for each mode and a column for each place.

    Raises
    ------
    ExchangeError
        If a place has the name of another column.
    """
    taken = {FREQUENCY, DAMPING, PARTICIPATION} & {*table.places}
    if taken:
        raise ExchangeError(f"{path.name}: a place is called {taken.pop()}; rename it")
    columns: dict[str, FloatArray] = {FREQUENCY: table.frequencies}
    if table.damping_ratios is not None:
        columns[DAMPING] = table.damping_ratios
    one = len(({*table.participations} | table.axes) - {""}) <= 1
    for share in table.participations.values() if one else ():
        columns[PARTICIPATION] = share
    files.write_csv(path, {**columns, **dict(zip(table.places, table.shapes, strict=True))})
    lost = [] if one or not table.participations else ["participations in several directions"]
    return _without([*lost, *["positions"] * bool(table.positions)])


def _write_universal(path: Path, table: ModeTable, title: str) -> tuple[str, ...]:
    """Write data sets 151, 164, 2411 and 55, normal modes of unit modal mass."""
    nodes = _nodes_of(table)
    turning = np.any(nodes.motion[..., 3:])
    zero = np.zeros(table.frequencies.size)
    damping = zero if table.damping_ratios is None else table.damping_ratios
    with files.atomic_path(path) as temporary, temporary.open("w", encoding="ascii") as file:
        file.write(data_sets.header(title, "modes", "shakerproc"))
        file.write(data_sets.geometry(Wireframe(nodes.positions)))
        modes = zip(table.frequencies, damping, nodes.motion, strict=True)
        for number, (frequency, ratio, motion) in enumerate(modes, 1):
            mode = NormalMode(
                number, float(frequency), float(ratio), nodes.numbers,
                motion if turning else motion[:, :3],
            )  # fmt: skip
            file.write(data_sets.normal_mode(mode, title))
    undamped = ["damping (0 is written)"] * (table.damping_ratios is None)
    return nodes.notes + _without(["participations"] * bool(table.participations) + undamped)


def _write_punch(path: Path, table: ModeTable, title: str) -> tuple[str, ...]:
    """Write eigenvectors as VECTOR(PUNCH,SORT1,REAL)=ALL does."""
    nodes = _nodes_of(table)
    lines: list[str] = []
    for number, motion in enumerate(nodes.motion, 1):
        square = (2.0 * np.pi * table.frequencies[number - 1]) ** 2
        lines += [
            f"$TITLE   = {files.printable(title)}"[:72], "$SUBTITLE=", "$LABEL   =",
            "$EIGENVECTOR", "$REAL OUTPUT", f"$SUBCASE ID = {1:11d}",
            f"$EIGENVALUE = {square:14.7E}  MODE = {number:5d}",
        ]  # fmt: skip
        for node, row in zip(nodes.numbers, motion.tolist(), strict=True):
            lines.append(f"{node:10d}       G" + "".join(f"{v:18.6E}" for v in row[:3]))
            lines.append(f"{'-CONT-':18s}" + "".join(f"{v:18.6E}" for v in row[3:]))
    numbered = (f"{line:<72}{i % 10**8:8d}\n" for i, line in enumerate(lines, 1))
    files.write_text(path, "".join(numbered))
    return nodes.notes + _without([
        *["positions"] * bool(table.positions),
        *["damping"] * (table.damping_ratios is not None),
        *["participations"] * bool(table.participations),
        "units (kg)",
    ])  # fmt: skip


def _write_frd(path: Path, table: ModeTable, title: str) -> tuple[str, ...]:
    """Write nodes and displacements of modes as a result file of CalculiX 2.20, as text."""
    nodes = _nodes_of(table)
    here = [number for number in nodes.numbers if number in nodes.positions]
    places = np.array([nodes.positions[number] for number in here]).reshape(-1, 3)
    parts = [
        "    1C\n",
        f"    1UUSER {files.printable(title)[:60]}\n    1UPGM               shakerproc\n",
        f"    2C{len(here):30d}{1:38d}\n{_rows(here, places)}",
    ]
    for number, motion in enumerate(nodes.motion, 1):
        frequency, count = table.frequencies[number - 1], len(nodes.numbers)
        parts += [
            f"    1PSTEP{number:26d}{1:12d}{1:12d}          \n    1PMODE{number:26d}\n",
            f"  100CL{100 + number:5d}{_hertz(frequency)}{count:12d}{'':20s} 2{number:5d}MODAL"
            f"      1\n -4  DISP        4    1\n",
            *(f" -5  D{i}          1    2    {i}    0\n" for i in (1, 2, 3)),
            " -5  ALL         1    2    0    0    1ALL\n",
            _rows(nodes.numbers, motion[:, :3]),
        ]
    files.write_text(path, "".join(parts) + " 9999\n")
    unplaced = len(nodes.numbers) - len(here)
    return nodes.notes + _without([
        *[f"positions of {unplaced} nodes"] * bool(unplaced),
        *["rotations"] * bool(np.any(nodes.motion[..., 3:])),
        *["damping"] * (table.damping_ratios is not None),
        *["participations"] * bool(table.participations),
        "elements", "units (kg, m)",
    ])  # fmt: skip


def _hertz(frequency: float) -> str:
    """Return a frequency as CalculiX prints it: ten digits from 1 Hz on [Hz]."""
    return f"{frequency:#12.10g}" if 1.0 <= frequency < 1e9 else f"{frequency:12.5E}"


def _rows(numbers: Sequence[int], values: FloatArray) -> str:
    """Return three numbers of each node in columns, closed."""
    each = zip(numbers, values.tolist(), strict=True)
    return (
        "".join(f" -1{n:10d}{x:12.5E}{y:12.5E}{z:12.5E}\n" for n, (x, y, z) in each) + " -3\n"
    )


def _nodes_of(table: ModeTable) -> _Nodes:
    """Return modes by nodes: a name that is no number gets one behind the others."""
    parts = [split_place(place) for place in table.places]
    names = list(dict.fromkeys(name for name, _ in parts))
    numbers = {name: int(name) for name in names if name == str(_whole(name))}
    named = [name for name in names if name not in numbers]
    first = max(numbers.values(), default=0) + 1
    numbers |= {name: number for number, name in enumerate(named, first)}
    row_of = {name: row for row, name in enumerate(names)}
    motion = np.zeros((table.frequencies.size, len(names), len(COMPONENTS)))
    for (name, axis), shape in zip(parts, table.shapes, strict=True):
        turned = -1.0 if axis.startswith("-") else 1.0
        column = COMPONENTS.index(axis.removeprefix("-") or "z")
        motion[:, row_of[name], column] = turned * shape
    positions = {
        numbers[name]: table.positions[place]
        for place, (name, _) in zip(table.places, parts, strict=True)
        if place in table.positions
    }
    return _Nodes(
        tuple(numbers[name] for name in names), motion, positions,
        _numbered_text(named, numbers) + _along_z_text(parts),
    )  # fmt: skip


def _whole(text: str) -> int:
    """Return a number of a node; 0 of a text that is none."""
    return int(text) if text.isascii() and text.isdigit() else 0


def _numbered_text(named: Sequence[str], numbers: Mapping[str, int]) -> tuple[str, ...]:
    if not named:
        return ()
    some = ", ".join(f"{name}: {numbers[name]}" for name in named[:_LISTED])
    more = f" and {len(named) - _LISTED} more, one after the other" * (len(named) > _LISTED)
    return (f"nodes have numbers in this format: {some}{more}",)


def _along_z_text(parts: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    count = sum(not axis for _, axis in parts)
    return (f"{count} places without direction are written along z",) * bool(count)


def _without(lost: Sequence[str]) -> tuple[str, ...]:
    """Return the sentence on quantities that a format cannot hold."""
    return (f"the format does not hold {', '.join(lost)}",) if lost else ()


WRITERS: Final[Mapping[str, Callable[[Path, ModeTable, str], tuple[str, ...]]]] = (
    MappingProxyType({
        ".csv": _write_table,
        ".uff": _write_universal,
        ".unv": _write_universal,
        ".pch": _write_punch,
        ".frd": _write_frd,
    })
)
"""Writers of files with modes, by their endings."""
