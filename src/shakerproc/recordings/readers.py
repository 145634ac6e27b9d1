"""The mapping of all readers: those of shakerproc, and those of installed packages."""

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Final, final

from shakerproc.errors import RecordingError
from shakerproc.late import loaded
from shakerproc.recordings.guard import foreign
from shakerproc.recordings.raw import RawFile, Reader

GROUP: Final = "shakerproc.readers"
"""Entry points of packages that bring readers: the name is the ending of the files, without its
dot, and the value a function from the path and the name of the run to a `RawFile`."""


@final
class Readers(Mapping[str, Reader]):
    """Readers of files, by the ending in small letters.

    All are loaded when they are asked for. Readers of installed packages are looked for when
    all are listed, or when an ending is asked for that shakerproc does not know.
    """

    def __init__(self, known: Mapping[str, str]) -> None:
        self._known = dict(known)
        self._installed: dict[str, EntryPoint] | None = None

    def __getitem__(self, ending: str) -> Reader:
        if ending not in self._known:
            return of_entry(self._entries()[ending])
        reader: Reader = loaded(f"shakerproc.recordings.{self._known[ending]}")
        return reader

    def __iter__(self) -> Iterator[str]:
        return iter({**self._known, **self._entries()})

    def __len__(self) -> int:
        return len({**self._known, **self._entries()})

    @property
    def known(self) -> Mapping[str, str]:
        """Where the readers of shakerproc itself are, by ending."""
        return dict(self._known)

    def _entries(self) -> dict[str, EntryPoint]:
        """Return the first entry point for each ending that shakerproc does not read."""
        if self._installed is None:
            found: dict[str, EntryPoint] = {}
            for entry in entry_points(group=GROUP):
                ending = f".{entry.name.lower()}"
                if ending not in self._known:
                    found.setdefault(ending, entry)
            self._installed = found
        return self._installed


def of_entry(entry: EntryPoint) -> Reader:
    """Return the reader that an entry point names, whatever it raises turned into one line.

    Raises
    ------
    RecordingError
        If it cannot be loaded, or is no function.
    """
    where = f"entry point {entry.name} ({entry.value})"
    try:
        reader = entry.load()
    except Exception as error:
        told = " ".join(str(error).split()) or "no reason given"
        raise RecordingError(
            f"{where}: {type(error).__name__}: {told}. Correct the package, or remove it."
        ) from error
    if not callable(reader):
        raise RecordingError(f"{where}: is no function. Name one that reads a file.")
    return _guarded(reader, where)


def _guarded(reader: Callable[[Path, str], object], where: str) -> Reader:
    """Return a reader whose failures are one line that says where."""

    def read(path: Path, run: str) -> RawFile:
        with foreign(run, where):
            made = reader(path, run)
        if isinstance(made, RawFile):
            return made
        raise RecordingError(
            f"{run}: {where}: returned {type(made).__name__}, not a RawFile of "
            "shakerproc.recordings.raw. Correct the package."
        )

    return read


def read_dat(path: Path, run: str) -> RawFile:
    """Return the channels of a file of MDF 2 or 3, of imc FAMOS, or else of a table of text.

    These formats share the ending; their first bytes tell them apart.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    from shakerproc.recordings import famos, mdf
    from shakerproc.recordings.csv import read_csv

    with path.open("rb") as file:
        start = file.read(8)
    if start in mdf.MAGIC:
        return mdf.read_mdf(path, run)
    if start.startswith(famos.MAGIC):
        return famos.read_famos(path, run)
    return read_csv(path, run)


READERS: Final = Readers({
    ".tdms": "tdms.reader:read_tdms",
    ".csv": "csv:read_csv",
    ".txt": "csv:read_csv",
    ".dat": "readers:read_dat",
    ".lvm": "lvm:read_lvm",
    ".mat": "matlab:read_mat",
    ".npz": "numpy_file:read_npz",
    ".npy": "numpy_file:read_npy",
    ".uff": "uff:read_uff",
    ".unv": "uff:read_uff",
    ".uf58": "uff:read_uff",
    ".parquet": "parquet:read_parquet",
    ".feather": "feather:read_feather",
    ".arrow": "feather:read_feather",
    ".h5": "hdf5:read_hdf5",
    ".hdf5": "hdf5:read_hdf5",
    ".nc": "hdf5:read_hdf5",
    ".nc4": "hdf5:read_hdf5",
    ".xlsx": "xlsx:read_xlsx",
    ".mf4": "mdf:read_mdf",
    ".mdf": "mdf:read_mdf",
    ".ide": "ide:read_ide",
    ".raw": "famos:read_famos",
    ".rsp": "rpc3:read_rpc3",
    ".rpc": "rpc3:read_rpc3",
    ".rpc3": "rpc3:read_rpc3",
    ".wav": "wav:read_wav",
    ".rf64": "wav:read_wav",
    ".atfx": "atfx:read_atfx",
})
"""What opens a file, by its ending in small letters, below `shakerproc.recordings`."""
