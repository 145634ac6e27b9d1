"""Read .npz: named arrays, never a pickle."""

import math
import zipfile
from pathlib import Path
from typing import Any, BinaryIO, Final, cast

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, ArrayLike, file_of_arrays
from shakerproc.recordings.guard import AGAIN, foreign, shown
from shakerproc.recordings.raw import RawFile

_HEADERS: Final = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def read_npz(path: Path, run: str) -> RawFile:
    """Return the arrays of a NumPy archive as channels."""
    arrays: dict[str, ArrayLike] = {}
    texts: dict[str, list[str]] = {}
    left_out = []
    with foreign(run, "reading the archive"), zipfile.ZipFile(path) as archive:
        _check_size(archive, run)
        for entry in archive.infolist():
            name = entry.filename.removesuffix(".npy")
            with archive.open(entry) as file:
                values = _array(cast("BinaryIO", file), entry.file_size, name, run)
            if values is None:
                left_out.append(name)
            elif values.dtype.kind == "U":
                texts[name] = [str(text) for text in np.atleast_1d(values)]
            else:
                arrays[name] = values
    return file_of_arrays(arrays, texts, run, left_out=left_out)


def _array(file: BinaryIO, size: int, name: str, run: str) -> NDArray[Any] | None:
    """Return an array of real numbers or text, or None where it holds something else.

    Raises
    ------
    RecordingError
        If it is not as long as it says.
    """
    version = npy.read_magic(file)
    if version not in _HEADERS:
        return None
    shape, by_column, dtype = _HEADERS[version](file)
    axes = {"i": 2, "u": 2, "f": 2, "U": 1}.get(dtype.kind, -1)
    if len(shape) > axes:
        return None
    there, promised = size - file.tell(), math.prod(shape) * dtype.itemsize
    if promised != there:
        raise RecordingError(
            f"{run}: {shown(name)} says it holds {' x '.join(map(str, shape))} numbers in "
            f"{promised} bytes, but {there} are there. {AGAIN}"
        )
    data = file.read()
    values: NDArray[Any] = np.frombuffer(data, dtype, math.prod(shape))
    return values.reshape(shape, order="F" if by_column else "C")


def _check_size(archive: zipfile.ZipFile, run: str) -> None:
    total = sum(entry.file_size for entry in archive.infolist())
    if total > LARGEST:
        raise RecordingError(
            f"{run}: {total >> 20} MB of arrays are too many to hold in memory. "
            "Export the recording as TDMS instead."
        )
