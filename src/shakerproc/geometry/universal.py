"""The geometry of a universal file: nodes, trace lines, elements, coordinate systems, units.

Data sets 15, 781 and 2411 hold nodes, 82 lines, 2412 elements, 18 and 2420 the coordinate
systems that nodes are given and measured in, 164 the units.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.geometry import Axes, Wireframe, problem_of
from shakerproc.geometry.data_sets import UffDataSet, UffError, data_sets

NODES: Final = (15, 781, 2411)
"""Data sets of nodes: in the first a node is a line, in the others two."""

_BEAMS: Final = (11, 21, 22, 23, 24)
"""Elements with a line of their own before their nodes."""

_SOLIDS: Final = (111, 112, 115, 116, 117, 118)
_CARTESIAN: Final = 0

_NUMBER: Final = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?")


@final
@dataclass(frozen=True, slots=True)
class Units:
    """How many of a file's units are in those of SI.

    Attributes
    ----------
    length, force : float
        In a metre and in a newton [-].
    said : bool
        Whether the file says it.
    """

    length: float = 1.0
    force: float = 1.0
    said: bool = False

    @property
    def mass(self) -> float:
        """Unit of mass: that which a unit of force gives a unit of acceleration [kg]."""
        return self.length / self.force


@final
@dataclass(frozen=True, slots=True, eq=False)
class _System:
    """A Cartesian coordinate system: its axes in rows, and its origin [unit of the file]."""

    axes: FloatArray
    origin: FloatArray


def units_of(content: bytes, uff_sets: Sequence[UffDataSet]) -> Units:
    """Return the units of a file, by its data set 164; SI without one.

    Raises
    ------
    UffError
        If it says two.
    """
    said: Units | None = None
    for one in uff_sets:
        rows = _numbers(content, one)[1:] if one.kind == 164 else []
        if rows and len(rows[0]) >= 2 and min(rows[0][:2]) > 0.0:
            here = Units(rows[0][0], rows[0][1], said=True)
            if said is not None and here != said:
                raise UffError(
                    one.start,
                    f"its data sets 164 differ: {said.length:g} and {here.length:g} units of "
                    f"length in a metre; export all parts in one system of units",
                )
            said = here
    return said or Units()


def read_wireframe(content: bytes) -> Wireframe:
    """Return the geometry of a whole universal file.

    Raises
    ------
    UffError
        If it holds no nodes, a data set is not what it says, or a line or an element has a node
        without coordinates.
    """
    uff_sets = list(data_sets(content))
    wireframe, left_out = wireframe_of(content, uff_sets, units_of(content, uff_sets))
    if left_out:
        raise UffError(0, left_out[0])
    if not wireframe.nodes:
        raise UffError(0, "no nodes in it (data set 15 or 2411); export the geometry too")
    return wireframe


def wireframe_of(
    content: bytes, uff_sets: Sequence[UffDataSet], units: Units
) -> tuple[Wireframe, list[str]]:
    """Return nodes [m], lines and surfaces of a universal file, and notes on the rest.

    The wireframe is empty where the file holds none; lines and elements with a node without
    coordinates are left out.

    Raises
    ------
    UffError
        If a data set is not what it says.
    """
    systems, notes = _systems(content, uff_sets)
    nodes, axes = {}, {}
    for number, (given, measured), place in _nodes(content, uff_sets):
        one = systems.get(given)
        where = place if one is None else place @ one.axes + one.origin
        x, y, z = (float(v) / units.length for v in where)
        nodes[number] = (x, y, z)
        if measured in systems:
            axes[number] = _as_axes(systems[measured].axes)
    elements = [e for one in uff_sets if one.kind == 2412 for e in _elements(content, one)]
    solids = sum(kind in _SOLIDS for kind, _ in elements)
    flat = [nodes_of for kind, nodes_of in elements if kind not in _SOLIDS]
    kinds = {
        "lines": [
            *(line for one in uff_sets if one.kind == 82 for line in _traces(content, one)),
            *(e for e in flat if len(e) == 2),
        ],
        "surfaces": [e for e in flat if len(e) > 2],
    }
    problems = {(k, e): problem_of(nodes, k, e) for k, each in kinds.items() for e in each}
    left_out = [
        f"{k[:-1]} {_nodes_text(e)}: {said}" for (k, e), said in problems.items() if said
    ]
    lines, surfaces = (
        tuple(e for e in each if not problems[k, e]) for k, each in kinds.items()
    )
    if solids:
        notes.append(f"{solids} solid elements are not drawn: surfaces of shells are")
    if nodes and not units.said:
        notes.append("no data set 164: coordinates are taken as metres")
    return Wireframe(nodes, lines, surfaces, axes, tuple(notes)), left_out


def _nodes_text(nodes: Sequence[int]) -> str:
    """Return the nodes of a line as a word."""
    return "-".join(map(str, nodes[:4])) + "-..." * (len(nodes) > 4)


def _nodes(
    content: bytes, uff_sets: Sequence[UffDataSet]
) -> Iterator[tuple[int, tuple[int, int], FloatArray]]:
    """Yield number, systems of definition and of measurement, and coordinates of each node.

    Raises
    ------
    UffError
        If one has no three coordinates.
    """
    for one in (one for one in uff_sets if one.kind in NODES):
        lines = _numbers(content, one)
        rows = lines
        if one.kind != 15:
            rows = [a + b for a, b in zip(lines[::2], [*lines[1::2], []], strict=False)]
        for row in rows:
            if len(row) != 7:
                named = f"node {row[0]:g}" if row else "a node"
                raise UffError(
                    one.start,
                    f"{named} of data set {one.kind} has no number, systems, colour and three "
                    f"coordinates",
                )
            yield int(row[0]), (int(row[1]), int(row[2])), np.array(row[4:])


def _traces(content: bytes, one: UffDataSet) -> Iterator[tuple[int, ...]]:
    """Yield the lines of a data set 82: 0 lifts the pen."""
    drawn = [int(number) for row in _numbers(content, one)[2:] for number in row]
    for lifted, numbers in groupby(drawn, key=lambda number: number == 0):
        line = tuple(numbers)
        if not lifted and len(line) > 1:
            yield line


def _elements(content: bytes, one: UffDataSet) -> Iterator[tuple[int, tuple[int, ...]]]:
    """Yield kind and nodes of each element of a data set 2412 that joins nodes.

    Raises
    ------
    UffError
        If one has not as many nodes as it says.
    """
    rows = iter(_numbers(content, one))
    for head in rows:
        kind, count = (int(head[1]), int(head[5])) if len(head) == 6 else (0, 0)
        if kind in _BEAMS:
            next(rows, [])
        nodes: list[int] = []
        while len(nodes) < count and (row := next(rows, [])):
            nodes += map(int, row)
        if not 0 < count == len(nodes):
            named = f"element {head[0]:g}" if head else "an element"
            raise UffError(one.start, f"{named} of data set 2412 has not the nodes it says")
        if count > 1:
            yield kind, tuple(nodes)


def _systems(
    content: bytes, uff_sets: Sequence[UffDataSet]
) -> tuple[Mapping[int, _System], list[str]]:
    """Return the Cartesian coordinate systems by number, and a sentence on others."""
    systems, others = {}, 0
    for one in uff_sets:
        rows = _numbers(content, one) if one.kind in {18, 2420} else []
        # a name stands on the second line of a system; of 2420 that of the part comes first
        first, each = (0, 4) if one.kind == 18 else (2, 6)
        for at in range(first, len(rows) - each + 1, each):
            head = rows[at]
            values = [v for row in rows[at + 2 : at + each] for v in row]
            cartesian = len(head) > 2 and int(head[1]) == _CARTESIAN
            system = _system(values) if cartesian and len(values) in {9, 12} else None
            if system is None:
                others += 1
            else:
                systems[int(head[0])] = system
    text = f"{others} coordinate systems are not Cartesian: their nodes are taken as global"
    return systems, [text] * bool(others)


def _system(values: Sequence[float]) -> _System | None:
    """Return a system by three points or by axes and origin; None where they span none.

    The points are the origin, one on the x axis and one in the x-z plane.
    """
    if len(values) == 9:
        origin, along, plane = np.array(values).reshape(3, 3)
        x, y = along - origin, np.cross(plane - origin, along - origin)
        axes = np.array([x, y, np.cross(x, y)])
    else:
        *rows, origin = np.array(values).reshape(4, 3)
        axes = np.array(rows)
    sizes = np.linalg.norm(axes, axis=1, keepdims=True)
    return _System(axes / sizes, origin) if np.all(sizes > 0.0) else None


def _as_axes(rows: FloatArray) -> Axes:
    x, y, z = ((float(a), float(b), float(c)) for a, b, c in rows)
    return x, y, z


def _numbers(content: bytes, one: UffDataSet) -> list[list[float]]:
    """Return the numbers of each line of a data set.

    Raises
    ------
    UffError
        If one is beyond all numbers.
    """
    text = content[one.start : one.stop].decode("ascii", errors="replace")
    rows = [
        [float(cell.replace("D", "E").replace("d", "e")) for cell in _NUMBER.findall(line)]
        for line in text.splitlines()
    ]
    if not np.all(np.isfinite([value for row in rows for value in row])):
        raise UffError(one.start, f"a number of data set {one.kind} is infinite")
    return rows
