"""Recordings out: each writer writes whole files or none, in the unit that the file had."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from shakerproc.data import Recording
from shakerproc.recordings.writers.columns import write_csv, write_parquet
from shakerproc.recordings.writers.matlab import write_mat
from shakerproc.recordings.writers.tdms import write_tdms
from shakerproc.recordings.writers.uff import write_uff

WRITERS: Mapping[str, Callable[[Path, Recording], None]] = MappingProxyType({
    ".tdms": write_tdms,
    ".csv": write_csv,
    ".mat": write_mat,
    ".uff": write_uff,
    ".unv": write_uff,
    ".parquet": write_parquet,
})
"""What writes a file, by its ending in small letters."""

__all__ = ["WRITERS", "write_csv", "write_mat", "write_parquet", "write_tdms", "write_uff"]
