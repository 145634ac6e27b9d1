"""Read .mat: versions 4 to 7 into memory, version 7.3 (HDF5) through h5py, lazily."""

import math
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, ArrayLike, file_of_arrays
from shakerproc.recordings.guard import AGAIN, foreign
from shakerproc.recordings.mat5 import Mat5Error, Value, read_variables
from shakerproc.recordings.raw import RawFile

_HDF5: Final = b"\x89HDF\r\n\x1a\n"
_DEEPEST: Final = 4
_PACKED: Final = 1040
"""Times that packing makes numbers smaller at most: deflate reaches 1032."""

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
    arrays: dict[str, ArrayLike] = {}
    texts: dict[str, list[str]] = {}
    left_out: list[str] = []
    for name, value in _version_4(path, run) if b"\0" in start[:4] else _version_5(path, run):
        _sort_in(name, value, arrays, texts, left_out)
    return file_of_arrays(arrays, texts, run, left_out=left_out)


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


def _sort_in(
    name: str,
    value: Any,
    arrays: dict[str, ArrayLike],
    texts: dict[str, list[str]],
    left_out: list[str],
) -> None:
    """Put a variable where it belongs; the fields of a structure one by one."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "iufb" and value.ndim <= 2:
        arrays[name] = value
    elif isinstance(value, list):
        texts[name] = [text.strip() for text in value]
    elif isinstance(value, dict):
        for field, inner in value.items():
            _sort_in(f"{name}.{field}", inner, arrays, texts, left_out)
    else:
        left_out.append(name)


def _read_hdf5(path: Path, run: str) -> RawFile:
    import h5py

    arrays: dict[str, ArrayLike] = {}
    texts: dict[str, list[str]] = {}
    left_out: list[str] = []
    with foreign(run, "opening the file"):
        file = h5py.File(path, "r")
    try:
        with foreign(run, "reading the variables"):
            _walk_hdf5(file, "", arrays, texts, left_out, 0)
        return file_of_arrays(arrays, texts, run, left_out=left_out, handle=file)
    except BaseException:
        file.close()
        raise


def _walk_hdf5(  # noqa: PLR0917
    group: Any,
    above: str,
    arrays: dict[str, ArrayLike],
    texts: dict[str, list[str]],
    left_out: list[str],
    depth: int,
) -> None:
    """Collect the datasets below a group, following no link out of the file."""
    import h5py

    for key in group:
        if key.startswith("#"):
            continue
        name = f"{above}.{key}" if above else key
        if not isinstance(group.get(key, getlink=True), h5py.HardLink):
            left_out.append(name)
            continue
        item = group[key]
        if isinstance(item, h5py.Group) and depth < _DEEPEST:
            _walk_hdf5(item, name, arrays, texts, left_out, depth + 1)
        elif isinstance(item, h5py.Dataset) and _is_readable(item):
            kind = item.attrs.get("MATLAB_class", b"")
            if kind == b"char":
                texts[name] = [_hdf5_text(item)]
            elif kind == b"cell" and item.size < 10_000:
                texts[name] = [_hdf5_text(group.file[ref]) for ref in item[...].reshape(-1)]
            elif item.dtype.kind in "iuf" and len(item.shape) <= 2:
                arrays[name] = item
            else:
                left_out.append(name)
        else:
            left_out.append(name)


def _is_readable(item: Any) -> bool:
    """Return whether a dataset lies in this file, in pieces that fit into memory."""
    if item.shape is None or item.is_virtual or item.external:
        return False
    chunk = math.prod(item.chunks) if item.chunks else 0
    width = int(item.dtype.itemsize)
    stored = int(item.id.get_storage_size())
    return chunk * width <= 1 << 28 and math.prod(item.shape) * width <= _PACKED * stored


def _hdf5_text(item: Any) -> str:
    """Return a text of MATLAB: a column of character codes."""
    if item.attrs.get("MATLAB_class", b"") != b"char" or item.size > 10_000:
        return ""
    if item.attrs.get("MATLAB_empty", 0):
        return ""
    return "".join(chr(code) for code in item[...].T.reshape(-1))
