"""Read Feather (Arrow files of version 2): columns as of Parquet, a batch at a time."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, final

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import first_bytes, foreign, kept_open
from shakerproc.recordings.parquet import file_of_table
from shakerproc.recordings.raw import RawFile

_VERSION_1: Final = b"FEA1"


def read_feather(path: Path, run: str) -> RawFile:
    """Return the columns of a Feather file as channels.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    if first_bytes(path, run, 4) == _VERSION_1:
        raise RecordingError(f"{run}: Feather of version 1. Write it again as version 2.")
    with foreign(run, "opening the table"):
        table = ArrowFile(path)
    with foreign(run, "reading the table"):
        return kept_open(table, lambda table: file_of_table(table, run))


@final
class ArrowFile:
    """An Arrow file with the members of a Parquet file; it unpacks columns when asked for them.

    Parameters
    ----------
    path : Path
        The file.
    """

    def __init__(self, path: Path) -> None:
        from pyarrow import OSFile, ipc

        self._file = OSFile(str(path))
        try:
            reader = ipc.open_file(self._file)
            self.schema_arrow = reader.schema
            self.num_row_groups: int = reader.num_record_batches
            first = self._reader([0] if reader.schema.names else [])
            self.sizes = [first.get_batch(i).num_rows for i in range(self.num_row_groups)]
        except BaseException:
            self._file.close()
            raise

    def _reader(self, columns: Sequence[int], *, threads: bool = False) -> Any:
        from pyarrow import ipc

        options = ipc.IpcReadOptions(included_fields=list(columns), use_threads=threads)
        return ipc.open_file(self._file, options=options)

    @property
    def n_rows(self) -> int:
        """Rows of all batches."""
        return sum(self.sizes)

    def iter_batches(
        self,
        *,
        batch_size: int,
        columns: Sequence[str],
        row_groups: Sequence[int] | None = None,
        use_threads: bool = False,
    ) -> Iterator[Any]:
        """Yield the rows of batches in pieces of a size at most."""
        numbers = [self.schema_arrow.get_field_index(name) for name in columns]
        reader = self._reader(numbers, threads=use_threads)
        for group in range(self.num_row_groups) if row_groups is None else row_groups:
            batch = reader.get_batch(group)
            for at in range(0, batch.num_rows, batch_size):
                yield batch.slice(at, batch_size)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
