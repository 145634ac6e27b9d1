"""The pages of a Parquet file, by their headers: none may promise more than its column holds.

A page that claims 2 GB is given 2 GB before anything is found wrong with it [1]_.

References
----------
.. [1] Apache Parquet, "File format" (PageHeader in parquet.thrift); Apache Thrift, "Thrift
   compact protocol encoding".
"""

from pathlib import Path
from typing import Any, BinaryIO, Final

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN, shown

WINDOW: Final = 1 << 12
"""Bytes in which a page header is looked for; it has some 20, and more with statistics."""

UNCOMPRESSED, COMPRESSED = 2, 3
"""Fields of a page header: sizes of the page [byte]."""

DEEPEST: Final = 8
"""How far structures may stand in each other; those of a page header do three times."""

_BOOLEANS: Final = frozenset({1, 2})
_NUMBERS: Final = frozenset({4, 5, 6})
_FIXED: Final = {1: 1, 2: 1, 3: 1, 7: 8}
"""Bytes of what has a fixed length, in lists."""
_BINARY, _LIST, _SET, _STRUCT = 8, 9, 10, 12


def check_pages(path: Path, metadata: Any, run: str) -> None:
    """Pass a file whose pages are no larger than the columns that they are pieces of.

    A header that cannot be understood is left to the reader, which refuses it.

    Parameters
    ----------
    path : Path
        The file.
    metadata : pyarrow.parquet.FileMetaData
        What its footer says.
    run : str
        Opens the message.

    Raises
    ------
    RecordingError
        If a page promises more than its column holds in all.
    """
    with path.open("rb") as file:
        for group in range(metadata.num_row_groups):
            for number in range(metadata.num_columns):
                column = metadata.row_group(group).column(number)
                problem = _problem(file, column)
                if problem:
                    raise RecordingError(
                        f"{run}: a page of column {shown(column.path_in_schema)} says it holds "
                        f"{problem}. {AGAIN}"
                    )


def _problem(file: BinaryIO, column: Any) -> str:
    """Return how a page of a column contradicts its content; empty where it does not."""
    place, whole = column.data_page_offset, column.total_uncompressed_size
    if column.has_dictionary_page and column.dictionary_page_offset:
        place = min(place, column.dictionary_page_offset)
    end = place + column.total_compressed_size
    while 0 <= place < end:
        file.seek(place)
        try:
            fields, length = _page_header(file.read(WINDOW))
        except IndexError:
            return ""
        place += length
        size, compressed = fields.get(UNCOMPRESSED, 0), fields.get(COMPRESSED, -1)
        if size > whole:
            return f"{size} bytes, but the whole column of this group has {whole}"
        if compressed > end - place:
            return f"{compressed} bytes, but {end - place} are left of the column"
        if compressed < 0:
            return ""
        place += compressed
    return ""


def _page_header(data: bytes) -> tuple[dict[int, int], int]:
    """Return the whole numbers of the structure that data begin with, and its length.

    Raises
    ------
    IndexError
        If the data end before it does, or it nests too deep.
    """
    reader = _Compact(data)
    fields = reader.structure(depth=0)
    return fields, reader.place


class _Compact:
    """Thrift's compact protocol, as far as a page header needs it."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.place = 0

    def structure(self, *, depth: int) -> dict[int, int]:
        """Return the whole numbers of a structure by the number of their field.

        Raises
        ------
        IndexError
            If it does not end, or nests too deep.
        """
        if depth > DEEPEST:
            raise IndexError
        found: dict[int, int] = {}
        field = 0
        while kind := (head := self._byte()) & 15:
            field = field + (head >> 4) if head >> 4 else self._whole()
            if kind in _NUMBERS:
                found[field] = self._whole()
            elif kind not in _BOOLEANS:
                self._skip(kind, depth)
        return found

    def _byte(self) -> int:
        self.place += 1
        return self._data[self.place - 1]

    def _varint(self) -> int:
        value = 0
        for shift in range(0, 70, 7):
            byte = self._byte()
            value |= (byte & 127) << shift
            if byte < 128:
                return value
        raise IndexError

    def _whole(self) -> int:
        value = self._varint() & 0xFFFFFFFF  # sizes have 32 bits; readers drop the others
        return (value >> 1) ^ -(value & 1)

    def _skip(self, kind: int, depth: int) -> None:
        if kind == _STRUCT:
            self.structure(depth=depth + 1)
        elif kind in _NUMBERS:
            self._varint()
        elif kind == _BINARY:
            length = self._varint()
            self.place += length
        elif kind in {_LIST, _SET}:
            head = self._byte()
            for _ in range(head >> 4 if head >> 4 < 15 else self._varint()):
                self._skip(head & 15, depth + 1)
        elif kind in _FIXED:
            self.place += _FIXED[kind]
        else:
            raise IndexError
