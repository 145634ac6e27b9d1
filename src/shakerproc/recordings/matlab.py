"""Read .mat: versions 4 to 7 into memory, version 7.3 (HDF5) through h5py, lazily.

scipy's reader ends the whole process on some damaged files (one bit flipped in a tag is
enough), so the few kinds of variables that hold recordings are read here, and scipy is the
tests' oracle.
"""

import math
import struct
import warnings
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, file_of_arrays
from shakerproc.recordings.guard import AGAIN, first_bytes, foreign, kept_open
from shakerproc.recordings.hdf5 import opened_hdf5, short_walk
from shakerproc.recordings.own_process import opened_apart, result_apart
from shakerproc.recordings.raw import RawFile
from shakerproc.recordings.variables import (
    DEEPEST,
    MatlabObject,
    Stored,
    Tree,
    check_variable,
    flattened,
    is_readable,
)

HEAD: Final = 128
DEEPEST_CELL: Final = 6
MATRIX: Final = 14
COMPRESSED: Final = 15
TYPES: Final = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
"""Numbers as they are stored."""

TEXTS: Final = {
    1: "latin-1",
    2: "latin-1",
    4: "utf-16",
    16: "utf-8",
    17: "utf-16",
    18: "utf-32",
}
LARGEST_SHAPE: Final = 1 << 48
CELL, STRUCT, CHAR, OPAQUE = 1, 2, 4, 17
MOST_ELEMENTS: Final = 10_000
"""Elements of a cell or structure array that are read; recordings have some hundred."""

_OPAQUE_PARTS: Final = ("name", "type system", "class")
NUMERIC: Final = range(6, 16)
COMPLEX: Final = 0x0800

Value: TypeAlias = "NDArray[Any] | list[str] | dict[str, Any] | MatlabObject | None"
"""Numbers, lines of text, the fields of a structure (or the elements of an array of them, or of
a cell array, by their index), an object, or what cannot be used here."""


class Mat5Error(Exception):
    """A file contradicts its own tags.

    Attributes
    ----------
    place : int
        Byte of the file, or of the unpacked variable.
    """

    def __init__(self, place: int, message: str) -> None:
        self.place = place
        super().__init__(message)


@final
@dataclass(frozen=True, slots=True)
class _Element:
    """A tag and its data."""

    kind: int
    data: memoryview
    place: int


def read_variables(content: memoryview, largest: int) -> Iterator[tuple[str, Value]]:
    """Yield name and value of every variable.

    Parameters
    ----------
    content : memoryview
        The whole file.
    largest : int
        Bytes to which compressed variables may unpack, together.

    Raises
    ------
    Mat5Error
        If the file is not what its tags say.
    """
    order = {b"IM": "<", b"MI": ">"}.get(bytes(content[126:128]))
    if order is None:
        raise Mat5Error(126, "the sign of the byte order is missing")
    remaining = largest
    for element in _elements(content, HEAD, order, aligned=False):
        inner = element
        if element.kind == COMPRESSED:
            unpacked = _unpack(element, order, remaining)
            remaining -= len(unpacked)
            inner = next(_elements(unpacked, 0, order, aligned=False), element)
        if inner.kind == MATRIX:
            name, value = _matrix(inner, order, 0)
            if name:  # what objects refer to has none
                yield name, value


def _unpack(element: _Element, order: str, largest: int) -> memoryview:
    machine = zlib.decompressobj()
    try:
        tag = machine.decompress(element.data, 8)
        size = int.from_bytes(tag[4:], "big" if order == ">" else "little")
        if size > largest:
            raise Mat5Error(
                element.place, f"a variable of {size} bytes is more than fits into memory"
            )
        unpacked = tag + machine.decompress(machine.unconsumed_tail, size + 1)
    except zlib.error as error:
        raise Mat5Error(element.place, f"a variable does not unpack: {error}") from error
    if machine.unconsumed_tail:
        raise Mat5Error(element.place, "a variable unpacks to more than it says")
    if not machine.eof:
        raise Mat5Error(element.place, "a variable ends before it is unpacked")
    return memoryview(unpacked)


def _elements(
    content: memoryview, start: int, order: str, *, aligned: bool = True
) -> Iterator[_Element]:
    """Yield the elements one behind the other; small ones have their data in the tag.

    Raises
    ------
    Mat5Error
        If one is longer than what is left.
    """
    at = start
    while at < len(content):
        if at + 8 > len(content):
            raise Mat5Error(at, "the file ends inside a tag")
        kind, size = struct.unpack(order + "II", content[at : at + 8])
        if kind >> 16:
            yield _Element(kind & 0xFFFF, content[at + 4 : at + 4 + min(kind >> 16, 4)], at)
            at += 8
            continue
        stop = at + 8 + size
        if stop > len(content):
            raise Mat5Error(at, f"an element of {size} bytes does not fit into what is left")
        yield _Element(kind, content[at + 8 : stop], at)
        at = stop + (-size % 8 if aligned else 0)


def _next(parts: Iterator[_Element], place: int, what: str) -> _Element:
    part = next(parts, None)
    if part is None:
        raise Mat5Error(place, f"a variable has no {what}")
    return part


def _numbers(element: _Element, order: str) -> NDArray[Any]:
    name = TYPES.get(element.kind)
    if name is None:
        raise Mat5Error(element.place, f"numbers of type {element.kind}, unknown here")
    dtype = np.dtype(order + name)
    if len(element.data) % dtype.itemsize:
        raise Mat5Error(element.place, "an element holds no whole number of numbers")
    return np.frombuffer(element.data, dtype)


def _matrix(element: _Element, order: str, depth: int) -> tuple[str, Value]:
    """Return name and value of a variable, a cell or a field.

    Raises
    ------
    Mat5Error
        If its flags or dimensions cannot be.
    """
    parts = _elements(element.data, 0, order)
    first = next(parts, None)
    if first is None:
        return "", []  # an empty cell
    flags = _numbers(first, order)
    if flags.size and int(flags[0]) & 0xFF == OPAQUE:
        name, _, kind_of = (_ascii(_next(parts, element.place, what)) for what in _OPAQUE_PARTS)
        return name, MatlabObject(kind_of)
    shape = [int(n) for n in _numbers(_next(parts, element.place, "dimensions"), order)]
    name = _ascii(_next(parts, element.place, "name"))
    if flags.size != 2 or len(shape) < 2 or min(shape) < 0:
        raise Mat5Error(element.place, "flags or dimensions that cannot be")
    if math.prod(n or 1 for n in shape) >= LARGEST_SHAPE:
        raise Mat5Error(element.place, f"a variable of {' x '.join(map(str, shape))} numbers")
    kind = int(flags[0])
    return name, _value(parts, element.place, order, shape, kind, depth)


def _ascii(element: _Element) -> str:
    return bytes(element.data).decode("latin-1").rstrip("\0")


def _value(  # noqa: PLR0917
    parts: Iterator[_Element], place: int, order: str, shape: list[int], kind: int, depth: int
) -> Value:
    """Return the value of a variable of some kind."""
    count = math.prod(shape)
    sort = kind & 0xFF
    value: Value = None
    if depth > DEEPEST_CELL:
        value = None
    elif sort in NUMERIC:
        value = _array(parts, place, order, shape, count)
        if kind & COMPLEX:
            value = value + 1j * _array(parts, place, order, shape, count)
    elif sort == CHAR:
        value = _text(_next(parts, place, "text"), shape, order) if count else []
    elif sort == CELL:
        value = _cells(parts, order, count, depth)
    elif sort == STRUCT and count <= MOST_ELEMENTS:
        value = _fields(parts, place, order, count, depth)
    return value


def _array(
    parts: Iterator[_Element], place: int, order: str, shape: list[int], count: int
) -> NDArray[Any]:
    if not count:
        return np.zeros(shape)
    values = _numbers(_next(parts, place, "numbers"), order)
    if values.size != count:
        raise Mat5Error(place, f"{values.size} numbers where there should be {count}")
    return values.reshape(shape, order="F")


def _text(element: _Element, shape: list[int], order: str) -> list[str]:
    """Return the lines of a text, stored column by column.

    Raises
    ------
    Mat5Error
        If the kind of letters is unknown.
    """
    encoding = TEXTS.get(element.kind)
    if encoding is None:
        raise Mat5Error(element.place, f"text of type {element.kind}, unknown here")
    suffix = {"<": "-le", ">": "-be"}[order] if encoding in {"utf-16", "utf-32"} else ""
    letters = bytes(element.data).decode(encoding + suffix, errors="replace")
    rows = shape[0]
    if rows > len(letters):
        return []
    return [letters[row::rows].rstrip("\0") for row in range(rows)]


def _cells(parts: Iterator[_Element], order: str, count: int, depth: int) -> Value:
    """Return the texts of a cell array, or its cells by their index where it holds others."""
    cells: list[Value] = []
    for number, part in enumerate(parts):
        if number >= min(count, MOST_ELEMENTS) or part.kind != MATRIX:
            return None
        cells.append(_matrix(part, order, depth + 1)[1])
    if len(cells) != count:
        return None
    if all(isinstance(cell, list) and len(cell) <= 1 for cell in cells):
        return [cell[0] if cell else "" for cell in cells if isinstance(cell, list)]
    return {f"{{{number}}}": cell for number, cell in enumerate(cells, 1)}


def _fields(
    parts: Iterator[_Element], place: int, order: str, count: int, depth: int
) -> dict[str, Any]:
    """Return the fields of a structure; of several, those of each by its index.

    Raises
    ------
    Mat5Error
        If their names cannot be.
    """
    length = _numbers(_next(parts, place, "length of its field names"), order)
    names = bytes(_next(parts, place, "field names").data)
    width = int(length[0]) if length.size else 0
    if not count:
        return {}
    if not 0 < width <= 256 or len(names) % width:
        raise Mat5Error(place, "field names that cannot be")
    keys = [
        names[at : at + width].split(b"\0")[0].decode("latin-1")
        for at in range(0, len(names), width)
    ]
    elements: list[dict[str, Any]] = []
    for _ in range(count):
        entries: dict[str, Any] = {}
        for key in keys:
            part = _next(parts, place, f"field {key!r}")
            entries[key] = _matrix(part, order, depth + 1)[1] if part.kind == MATRIX else None
        elements.append(entries)
    if count == 1:
        return elements[0]
    return {f"({number})": element for number, element in enumerate(elements, 1)}


_HERE: Final = "shakerproc.recordings.matlab"
_HDF5: Final = b"\x89HDF\r\n\x1a\n"
_OBJECT: Final = 3
"""How MATLAB marks variables of its classes."""

_TOO_MANY: Final = (
    "these are too many to hold in memory. Save them with -v7.3, or export the recording as "
    "TDMS."
)


def read_mat(path: Path, run: str) -> RawFile:
    """Return the variables of a MATLAB file as channels.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    if _is_hdf5(path, run):
        return opened_apart(path, run, f"{_HERE}:read_hdf5", "h5py")
    return _file_of(_read_old(path, run), run)


def mat_variables(path: Path, run: str) -> dict[str, Any]:
    """Return the variables of a MATLAB file by name: arrays, complex ones too, and texts.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    if _is_hdf5(path, run):
        entries: dict[str, Any] = result_apart(path, run, f"{_HERE}:hdf5_variables", "h5py")
        return entries
    return dict(_read_old(path, run))


def _is_hdf5(path: Path, run: str) -> bool:
    start = first_bytes(path, run, 520)
    return _HDF5 in {start[:8], start[512:520]}


def _read_old(path: Path, run: str) -> list[tuple[str, Any]]:
    """Read version 4 through scipy, versions 5 to 7 through the room's own reader.

    Raises
    ------
    RecordingError
        If they are too many numbers.
    """
    if path.stat().st_size > LARGEST:
        raise RecordingError(f"{run}: {_TOO_MANY}")
    old = b"\0" in first_bytes(path, run, 4)
    return _version_4(path, run) if old else _version_5(path, run)


def _file_of(trees: Iterable[tuple[str, Tree]], run: str, handle: Any = None) -> RawFile:
    variables = flattened(trees)
    return file_of_arrays(
        variables.arrays,
        variables.texts,
        run,
        called=variables.called,
        left_out=variables.left_out,
        handle=handle,
    )


def _version_4(path: Path, run: str) -> list[tuple[str, Value]]:
    from scipy import io as scipy_io

    with foreign(run, "reading the variables"), warnings.catch_warnings():
        warnings.simplefilter("error")
        promised = sum(math.prod(map(int, shape)) for _, shape, _ in scipy_io.whosmat(path))
        if promised > path.stat().st_size:  # a number takes a byte at least
            raise RecordingError(
                f"{run}: the variables say they hold {promised} numbers, but the file has "
                f"{path.stat().st_size} bytes. {AGAIN}"
            )
        content = scipy_io.loadmat(path, chars_as_strings=True)
    return [
        (name, list(map(str, value.reshape(-1))) if value.dtype.kind == "U" else value)
        for name, value in content.items()
        if not name.startswith("__")
    ]


def _version_5(path: Path, run: str) -> list[tuple[str, Value]]:
    try:
        return list(read_variables(memoryview(path.read_bytes()), LARGEST))
    except Mat5Error as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error


def read_hdf5(path: Path, run: str) -> RawFile:
    """Return the variables of a file of version 7.3 as channels.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    return kept_open(opened_hdf5(path, run), lambda file: _read_variables(file, run))


def _read_variables(file: Any, run: str) -> RawFile:
    return _file_of(_trees(file, run), run, file)


def _trees(file: Any, run: str) -> list[tuple[str, Tree]]:
    """Return the variables of an open file of version 7.3."""
    with foreign(run, "reading the variables"), short_walk():
        keys = [key for key in file if not key.startswith("#")]
        return [(key, _tree(file, key, run, key, 0)) for key in keys]


def hdf5_variables(path: Path, run: str) -> dict[str, Any]:
    """Return the arrays and texts of a file of version 7.3, axes as MATLAB has them.

    Raises
    ------
    RecordingError
        If it cannot be read, or holds more than fits into memory.
    """
    entries: dict[str, Any] = {}
    with opened_hdf5(path, run) as file:
        for name, tree in _trees(file, run):
            numbers = tree if isinstance(tree, list) else _in_memory(file, name, tree, run)
            if numbers is not None:
                entries[name] = numbers
    return entries


def _in_memory(file: Any, name: str, tree: Tree, run: str) -> NDArray[Any] | None:
    """Return the numbers of a variable, complex ones too; None where it is of another kind.

    Raises
    ------
    RecordingError
        If they are more than fit into memory.
    """
    import h5py

    is_hard_link = isinstance(file.get(name, getlink=True), h5py.HardLink)
    item = file[name] if is_hard_link else None
    if not isinstance(item, h5py.Dataset) or not is_readable(item):
        return None
    if not isinstance(tree, Stored) and item.dtype.names != ("real", "imag"):
        return None
    if item.size * np.dtype(complex).itemsize > LARGEST:
        raise RecordingError(
            f"{run}: variable {name} holds {item.size} numbers, too many to hold in memory. "
            "Save the functions alone."
        )
    if isinstance(tree, Stored):
        return np.asarray(tree[...]).T
    return np.asarray(item["real"] + 1j * item["imag"]).T


def _tree(group: Any, key: str, run: str, name: str, depth: int) -> Tree:
    """Return the tree below a name, following no link out of the file."""
    import h5py

    if depth > DEEPEST or not isinstance(group.get(key, getlink=True), h5py.HardLink):
        return None
    return _of_item(group[key], run, name, depth)


def _of_item(item: Any, run: str, name: str, depth: int) -> Tree:
    """Return the content of a group or of a data set."""
    import h5py

    if isinstance(item, h5py.Group):
        fields: dict[str, Tree] = {}
        for key in item:
            fields[key] = _tree(item, key, run, f"{name}.{key}", depth + 1)
        return _elements_first(fields)
    if not isinstance(item, h5py.Dataset) or not is_readable(item):
        return None
    kind = bytes(item.attrs.get("MATLAB_class", b"")).decode("latin-1")
    if item.attrs.get("MATLAB_object_decode", 0) == _OBJECT:
        return MatlabObject(kind)
    if item.dtype == h5py.ref_dtype:
        return _referred(item, kind, run, name, depth)
    if kind == "char":
        return [_hdf5_text(item)]
    return _stored(item, run, name) if item.dtype.kind in "iuf" else None


def _stored(item: Any, run: str, name: str) -> Stored:
    """Return a variable of numbers."""
    check_variable(item, run, name)
    return Stored(run, name, item)


def _referred(item: Any, kind: str, run: str, name: str, depth: int) -> Tree:
    """Return the cells of a cell array, or one field of an array of structures."""
    if depth >= DEEPEST or item.size > MOST_ELEMENTS:
        return None
    within = [item.file[ref] for ref in item[...].T.reshape(-1) if ref]
    if kind == "cell" and all(i.attrs.get("MATLAB_class", b"") == b"char" for i in within):
        return [_hdf5_text(text) for text in within]
    opened, closed = "{}" if kind == "cell" else "()"
    return {
        f"{opened}{number}{closed}": _of_item(inner, run, name, depth + 1)
        for number, inner in enumerate(within, 1)
    }


def _elements_first(fields: dict[str, Tree]) -> dict[str, Tree]:
    """Return the elements of an array of structures, which HDF5 keeps field by field."""
    inner = [value for value in fields.values() if isinstance(value, dict)]
    if not inner or len(inner) != len(fields) or any(
        set(value) != set(inner[0]) or not all(key.startswith("(") for key in value)
        for value in inner
    ):  # fmt: skip
        return fields
    return {
        index: {key: value[index] for key, value in fields.items() if isinstance(value, dict)}
        for index in inner[0]
    }


def _hdf5_text(item: Any) -> str:
    """Return a text of MATLAB: a column of character codes."""
    if item.attrs.get("MATLAB_class", b"") != b"char" or item.size > 10_000:
        return ""
    if item.attrs.get("MATLAB_empty", 0):
        return ""
    return "".join(chr(code) for code in item[...].T.reshape(-1))
