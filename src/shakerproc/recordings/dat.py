"""Read .dat: three formats share the ending, and their first bytes tell them apart."""

from pathlib import Path

from shakerproc.recordings import famos, mdf
from shakerproc.recordings.csv import read_csv
from shakerproc.recordings.raw import RawFile


def read_dat(path: Path, run: str) -> RawFile:
    """Return the channels of a file of MDF 2 or 3, of imc FAMOS, or else of a table of text.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    with path.open("rb") as file:
        start = file.read(8)
    if start in mdf.MAGIC:
        return mdf.read_mdf(path, run)
    if start.startswith(famos.MAGIC):
        return famos.read_famos(path, run)
    return read_csv(path, run)
