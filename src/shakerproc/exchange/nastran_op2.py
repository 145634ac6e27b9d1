"""Real modes of OP2 files, as Nastran writes them with PARAM,POST,-1: no library needed.

A file is Fortran records of 4-byte words. A key of n words announces a block of n words; a
negative key ends a record, 0 ends a table. Of a table of results, records are pairs: 146 words
that say what follows (analysis, mode, eigenvalue, words of an entry), and the entries.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.errors import ExchangeError
from shakerproc.geometry import Place

_SHAPES: Final = ("BOUGV1", "BOPHIG", "OUGV1", "OPHIG", "OUG1")
"""Tables with eigenvectors; those in the axes of the whole structure first."""

_VALUES: Final = ("LAMA", "LAMAS")
_NODES: Final = ("GEOM1", "GEOM1S")
_TITLE: Final = b"NASTRAN FORT TAPE ID CODE"
_IDENT: Final = 146  # words
_REAL_MODES, _COMPLEX_MODES = 2, 9  # analyses
_GRID: Final = 1  # type of an entry: a point with six directions
_GRID_CARD: Final = (4501, 45, 1)

Record: TypeAlias = list[bytes]
Tables: TypeAlias = dict[str, list[Record]]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Op2Modes:
    """Modes of an OP2 file.

    Attributes
    ----------
    nodes : tuple of int
        Grid points.
    frequencies : (n_modes,) array
        Natural frequencies [Hz].
    shapes : (n_nodes, 6, n_modes) array
        Three translations and three rotations of each, for a unit mass of the model.
    positions : mapping of int to (x, y, z)
        Of grid points whose place and axes are those of the whole structure [unit of length of
        the model].
    """

    nodes: tuple[int, ...]
    frequencies: FloatArray
    shapes: FloatArray
    positions: Mapping[int, Place] = field(default_factory=dict)


def read_op2(path: Path) -> Op2Modes:
    """Return the real modes of an OP2 file.

    Raises
    ------
    ExchangeError
        If it holds none, is cut off or damaged, or was written another way.
    """
    try:
        with path.open("rb") as file:
            order, tables = _tables(path, file)
    except OSError as error:
        raise ExchangeError(f"{path.name}: cannot be read: {error.strerror}") from error
    name = next((name for name in _SHAPES if name in tables), None)
    if name is None:
        raise ExchangeError(
            f"{path.name}: no eigenvectors; ask for them with VECTOR(PLOT)=ALL and "
            "PARAM,POST,-1, and give the OP2 of SOL 103"
        )
    numbers, nodes, eigenvalues, shapes = _eigenvectors(path, tables[name], order)
    masses = _modal_masses(path, tables, order)
    scale = np.array([masses.get(mode, 1.0) for mode in numbers]) ** -0.5
    positions = _positions(tables, order)
    return Op2Modes(
        nodes,
        np.sqrt(np.maximum(eigenvalues, 0.0)) / (2.0 * np.pi),
        shapes * scale,
        {node: positions[node] for node in nodes if node in positions},
    )


def _tables(path: Path, file: BinaryIO) -> tuple[str, Tables]:
    """Return the byte order of a file, and the records of the tables that modes are in.

    Raises
    ------
    ExchangeError
        If it is no such file, or is cut off.
    """
    first = file.read(4)
    orders = {struct.pack(f"{order}i", 4): order for order in "<>"}
    if first not in orders:
        long = first in {struct.pack("<i", 8), struct.pack(">i", 8)}
        raise ExchangeError(
            f"{path.name}: written in words of 8 bytes; those of 4 are read. Write it with "
            "MODE=I4, or punch the modes"
            if long
            else f"{path.name}: no OP2 of Nastran: it does not begin with a record of one word"
        )
    order = orders[first]
    wanted = {*_SHAPES, *_VALUES, *_NODES}
    tables: Tables = {}
    walk = _blocks(path, file, order)
    key = _key(path, walk, order)
    in_table = True
    while key != 0:
        name = next(walk)[1].decode("latin-1").strip()
        records: list[Record] = [[]]
        while (key := _key(path, walk, order)) != 0:
            if key < 0:
                records.append([])
            else:
                _, block = next(walk)
                if in_table or name in wanted:
                    records[-1].append(block)
        if in_table and not any(_TITLE in block for block in records[0]):
            raise ExchangeError(f"{path.name}: no OP2 of Nastran; write it with PARAM,POST,-1")
        in_table = False
        if name in wanted:
            tables[name] = tables.get(name, []) + records[3:]  # after name, sizes and date
        key = _key(path, walk, order)
    return order, tables


def _blocks(path: Path, file: BinaryIO, order: str) -> Iterator[tuple[int, bytes]]:
    """Yield place and content of each Fortran record.

    Raises
    ------
    ExchangeError
        Where the file ends too early, or a record has another length at its end.
    """
    marker, size = struct.Struct(f"{order}i"), path.stat().st_size
    file.seek(0)
    at = 0
    while True:
        length = marker.unpack(file.read(4))[0] if at + 4 <= size else -1
        if length < 0 or at + length + 8 > size:
            raise ExchangeError(
                f"{path.name}: cut off at byte {at} of {size}, before its tables end; copy it "
                "again"
            )
        block = file.read(length)
        if marker.unpack(file.read(4))[0] != length:
            raise ExchangeError(
                f"{path.name}: damaged at byte {at}: a record of {length} bytes does not end "
                "as it begins"
            )
        yield at, block
        at += length + 8


def _key(path: Path, walk: Iterator[tuple[int, bytes]], order: str) -> int:
    """Return a key: the number of words that follow, or the end of a record or table.

    Raises
    ------
    ExchangeError
        If something else stands there.
    """
    at, block = next(walk)
    if len(block) != 4:
        raise ExchangeError(
            f"{path.name}: damaged at byte {at}: {len(block)} bytes where a key of 4 stands"
        )
    return int(struct.unpack(f"{order}i", block)[0])


def _pairs(path: Path, records: list[Record]) -> Iterator[tuple[bytes, bytes]]:
    """Yield the identification and the entries of each record pair of a table.

    Raises
    ------
    ExchangeError
        If one stands alone.
    """
    whole = [b"".join(record[1:]) for record in records]
    whole = [one for one in whole if one]
    for first, second in zip(whole[::2], whole[1::2], strict=False):
        if len(first) != 4 * _IDENT:
            raise ExchangeError(
                f"{path.name}: damaged: {len(first)} bytes where {4 * _IDENT} name a result"
            )
        yield first, second
    if len(whole) % 2:
        raise ExchangeError(
            f"{path.name}: a result is named and does not follow; write it again"
        )


def _eigenvectors(
    path: Path, records: list[Record], order: str
) -> tuple[list[int], tuple[int, ...], FloatArray, FloatArray]:
    """Return numbers of modes, grid points, eigenvalues and shapes of a table.

    Raises
    ------
    ExchangeError
        If modes are complex, of several subcases or at other points, or there is none.
    """
    entry = np.dtype([("id", f"{order}i4"), ("type", f"{order}i4"), ("v", f"{order}f4", 6)])
    numbers: list[int] = []
    eigenvalues, shapes, nodes, cases = [], [], np.zeros(0, int), set()
    for ident, entries in _pairs(path, records):
        said = np.frombuffer(ident, f"{order}i4")
        analysis, sort, wide = said[0] // 10, said[1] // 1000, said[9]
        if analysis == _COMPLEX_MODES:
            raise ExchangeError(f"{path.name}: complex modes; write those of SOL 103")
        if analysis != _REAL_MODES:
            continue
        if sort or wide != 8 or len(entries) % entry.itemsize:
            raise ExchangeError(
                f"{path.name}: mode {said[4]} is not in rows of real points (SORT1, REAL); ask "
                "for VECTOR(SORT1,REAL)=ALL"
            )
        points = np.frombuffer(entries, entry)
        points = points[points["type"] == _GRID]
        here = points["id"] // 10
        if numbers and not np.array_equal(here, nodes):
            raise ExchangeError(f"{path.name}: mode {said[4]} has other points than mode 1")
        nodes = here
        cases.add(int(said[3]))
        numbers.append(int(said[4]))
        eigenvalues.append(float(np.frombuffer(ident, f"{order}f4")[5]))
        shapes.append(points["v"].astype(float))
    if not numbers or not nodes.size:
        raise ExchangeError(f"{path.name}: no real eigenvectors of grid points")
    if len(cases) > 1:
        text = ", ".join(map(str, sorted(cases)))
        raise ExchangeError(f"{path.name}: modes of subcases {text}; write one of them alone")
    points_of = tuple(int(node) for node in nodes)
    return numbers, points_of, np.array(eigenvalues), np.moveaxis(np.array(shapes), 0, -1)


def _modal_masses(path: Path, tables: Tables, order: str) -> dict[int, float]:
    """Return the generalised mass of each mode, by its number; none where the file has none.

    Raises
    ------
    ExchangeError
        If one is not above 0.
    """
    row = np.dtype([("mode", f"{order}i4"), ("order", f"{order}i4"), ("v", f"{order}f4", 5)])
    values: dict[int, float] = {}
    for name in _VALUES:
        for _, rows in _pairs(path, tables.get(name, [])):
            for one in np.frombuffer(rows[: len(rows) // row.itemsize * row.itemsize], row):
                values[int(one["mode"])] = float(one["v"][3])
    wrong = next((mode for mode, mass in values.items() if not mass > 0.0), None)
    if wrong is not None:
        raise ExchangeError(
            f"{path.name}: mode {wrong} has a generalised mass of {values[wrong]:g}: its "
            "shape cannot be normalised; ask for NORM=MASS on EIGRL"
        )
    return values


def _positions(tables: Tables, order: str) -> dict[int, Place]:
    """Return the places of grid points that stand in the axes of the whole structure."""
    card = np.dtype([
        ("id", f"{order}i4"), ("cp", f"{order}i4"), ("x", f"{order}f4", 3),
        ("cd", f"{order}i4"), ("ps", f"{order}i4"), ("seid", f"{order}i4"),
    ])  # fmt: skip
    places: dict[int, Place] = {}
    for name in _NODES:
        for record in tables.get(name, []):
            whole = b"".join(record[1:])
            key = tuple(np.frombuffer(whole[:12], f"{order}i4")) if len(whole) >= 12 else ()
            if key == _GRID_CARD and (len(whole) - 12) % card.itemsize == 0:
                for one in np.frombuffer(whole[12:], card):
                    if one["cp"] == 0 and one["cd"] == 0:
                        x, y, z = map(float, one["x"])
                        places[int(one["id"])] = (x, y, z)
    return places
