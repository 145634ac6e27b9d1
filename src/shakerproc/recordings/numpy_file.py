"""Read .npy a slice at a time and .npz in memory: arrays, never a pickle."""

import math
import os
import zipfile
from operator import itemgetter
from pathlib import Path
from typing import Any, BinaryIO, Final, cast

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, ArrayLike, file_of_arrays
from shakerproc.recordings.guard import AGAIN, foreign, kept_open, opened, shown
from shakerproc.recordings.raw import Frames, RawFile

_ENCRYPTED: Final = 1
"""Flag of a part of an archive that needs a password."""

_HEADERS: Final = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def read_npz(path: Path, run: str) -> RawFile:
    """Return the arrays of a NumPy archive as channels."""
    arrays: dict[str, ArrayLike] = {}
    texts: dict[str, list[str]] = {}
    left_out = []
    with foreign(run, "reading the archive"), zipfile.ZipFile(path) as archive:
        _check_archive(archive, run)
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


def read_npy(path: Path, run: str) -> RawFile:
    """Return the columns of a NumPy array, or the fields of a structured one, as channels.

    Raises
    ------
    RecordingError
        If it holds no real numbers, or is not as long as it says.
    """
    with foreign(run, "reading the header"):
        return kept_open(opened(path, run), lambda file: _stored(file, path.stem, run))


def _stored(file: BinaryIO, name: str, run: str) -> RawFile:
    """Return an array that stands in an open file.

    Raises
    ------
    RecordingError
        If it holds no real numbers, or is not as long as it says.
    """
    version = npy.read_magic(file)
    if version not in _HEADERS:
        raise RecordingError(f"{run}: version {version} of .npy is unknown. Save it again.")
    shape, by_column, dtype = _HEADERS[version](file)
    if dtype.hasobject:
        raise RecordingError(
            f"{run}: holds Python objects (a pickle), which are never read. Save real numbers."
        )
    there = os.fstat(file.fileno()).st_size - file.tell()
    _check_length(shape, dtype, there, name, run)
    shape = shape[::-1] if by_column else shape
    if dtype.names and len(shape) == 1:
        fields = {key: dtype[key] for key in dtype.names if dtype[key].kind in "iuf"}
        arrays: dict[str, ArrayLike] = {
            key: Frames(run, file, file.tell(), shape, dtype, itemgetter(key), kind)
            for key, kind in fields.items()
        }
        rest = [key for key in dtype.names if key not in fields]
        return file_of_arrays(arrays, {}, run, left_out=rest, handle=file)
    if dtype.kind not in "iuf" or not 1 <= len(shape) <= 2:
        raise RecordingError(
            f"{run}: {len(shape)} axes of {dtype} are no channels. Save real numbers with a "
            "row for each sample and a column for each channel."
        )
    stored = Frames(run, file, file.tell(), shape, dtype)
    return file_of_arrays({name: stored}, {}, run, handle=file)


def _check_length(
    shape: tuple[int, ...], dtype: "np.dtype[Any]", there: int, name: str, run: str
) -> None:
    """Pass an array that is as long as it says.

    Raises
    ------
    RecordingError
        If it is not.
    """
    promised = math.prod(shape) * dtype.itemsize
    if promised != there:
        raise RecordingError(
            f"{run}: {shown(name)} says it holds {' x '.join(map(str, shape))} numbers in "
            f"{promised} bytes, but {there} are there. {AGAIN}"
        )


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
    _check_length(shape, dtype, size - file.tell(), name, run)
    data = file.read()
    values: NDArray[Any] = np.frombuffer(data, dtype, math.prod(shape))
    return values.reshape(shape, order="F" if by_column else "C")


def _check_archive(archive: zipfile.ZipFile, run: str) -> None:
    """Pass an archive that is not encrypted, of arrays that memory holds.

    Raises
    ------
    RecordingError
        If it is none.
    """
    if any(entry.flag_bits & _ENCRYPTED for entry in archive.infolist()):
        raise RecordingError(f"{run}: is encrypted. Save it without a password.")
    total = sum(entry.file_size for entry in archive.infolist())
    if total > LARGEST:
        raise RecordingError(
            f"{run}: {total >> 20} MB of arrays are too many to hold in memory. "
            "Export the recording as TDMS instead."
        )
