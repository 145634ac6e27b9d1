"""Read .npz: named arrays, never a pickle."""

import zipfile
from pathlib import Path

import numpy as np

from shakerproc.errors import RecordingError
from shakerproc.recordings.arrays import LARGEST, ArrayLike, file_of_arrays
from shakerproc.recordings.guard import foreign
from shakerproc.recordings.raw import RawFile


def read_npz(path: Path, run: str) -> RawFile:
    """Return the arrays of a NumPy archive as channels."""
    with foreign(run, "reading the archive"):
        _check_size(path, run)
        arrays: dict[str, ArrayLike] = {}
        texts: dict[str, list[str]] = {}
        left_out = []
        with np.load(path, allow_pickle=False) as archive:
            for name in archive.files:
                values = archive[name]
                if values.dtype.kind in "iuf" and values.ndim <= 2:
                    arrays[name] = values
                elif values.dtype.kind == "U" and values.ndim <= 1:
                    texts[name] = [str(text) for text in np.atleast_1d(values)]
                else:
                    left_out.append(name)
    return file_of_arrays(arrays, texts, run, left_out=left_out)


def _check_size(path: Path, run: str) -> None:
    with zipfile.ZipFile(path) as archive:
        total = sum(entry.file_size for entry in archive.infolist())
    if total > LARGEST:
        raise RecordingError(
            f"{run}: {total >> 20} MB of arrays are too many to hold in memory. "
            "Export the recording as TDMS instead."
        )
