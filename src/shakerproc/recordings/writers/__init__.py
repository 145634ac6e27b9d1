"""Recordings out: each writer writes whole files or none, in the unit that the file had."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from shakerproc.data import Recording
from shakerproc.recordings.writers.by_libraries import (
    write_csv,
    write_hdf5,
    write_mat,
    write_mf4,
    write_parquet,
    write_tdms,
)
from shakerproc.recordings.writers.uff import write_uff

WRITERS: Mapping[str, Callable[[Path, Recording], None]] = MappingProxyType({
    ".tdms": write_tdms,
    ".csv": write_csv,
    ".mat": write_mat,
    ".uff": write_uff,
    ".unv": write_uff,
    ".parquet": write_parquet,
    ".h5": write_hdf5,
    ".hdf5": write_hdf5,
    ".mf4": write_mf4,
})
"""What writes a file, by its ending in small letters."""

__all__ = [
    "WRITERS",
    "write_csv",
    "write_hdf5",
    "write_mat",
    "write_mf4",
    "write_parquet",
    "write_tdms",
    "write_uff",
]
