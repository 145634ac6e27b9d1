"""Read .mat: versions 4 to 7 into memory, version 7.3 (HDF5) through h5py, lazily."""

import math
import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, file_of_arrays
from shakerproc.recordings.guard import AGAIN, foreign
from shakerproc.recordings.mat5 import MOST_ELEMENTS, Mat5Error, Value, read_variables
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
    try:
        with path.open("rb") as file:
            start = file.read(520)
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error
    if start[:8] == _HDF5 or start[512:520] == _HDF5:
        return _read_hdf5(path, run)
    return _read_old(path, start, run)


def _read_old(path: Path, start: bytes, run: str) -> RawFile:
    """Read version 4 through scipy, versions 5 to 7 through the room's own reader.

    Raises
    ------
    RecordingError
        If they are too many numbers.
    """
    if path.stat().st_size > LARGEST:
        raise RecordingError(f"{run}: {_TOO_MANY}")
    trees = _version_4(path, run) if b"\0" in start[:4] else _version_5(path, run)
    return _file_of(trees, run)


def _file_of(trees: Iterable[tuple[str, Tree]], run: str, handle: Any = None) -> RawFile:
    found = flattened(trees)
    return file_of_arrays(
        found.arrays,
        found.texts,
        run,
        called=found.called,
        left_out=found.left_out,
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
    return [(name, value) for name, value in content.items() if not name.startswith("__")]


def _version_5(path: Path, run: str) -> list[tuple[str, Value]]:
    try:
        return list(read_variables(memoryview(path.read_bytes()), LARGEST))
    except Mat5Error as error:
        raise RecordingError(f"{run}: byte {error.place}: {error}. {AGAIN}") from error


def _read_hdf5(path: Path, run: str) -> RawFile:
    import h5py

    with foreign(run, "opening the file"):
        file = h5py.File(path, "r")
    try:
        with foreign(run, "reading the variables"):
            trees = [
                (key, _tree(file, key, run, key, 0)) for key in file if not key.startswith("#")
            ]
        return _file_of(trees, run, file)
    except BaseException:
        file.close()
        raise


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
