"""A table of results, read from CSV or Parquet."""

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

from shakerproc.errors import TableError
from shakerproc.late import without_parquet
from shakerproc.recordings.apart import check_survived
from shakerproc.runs.tables import former_note, present_name


@final
@dataclass(frozen=True, slots=True)
class ResultTable:
    """A table of runs, every cell as text.

    Attributes
    ----------
    path : Path
        Where it stands.
    columns : tuple of str
        Its headers.
    rows : tuple of mapping
        Cells by header.
    lines : tuple of int
        Line of the file in which each row stands.
    notes : tuple of str
        What to say of it: columns by former names.
    """

    path: Path
    columns: tuple[str, ...]
    rows: tuple[Mapping[str, str], ...]
    lines: tuple[int, ...]
    notes: tuple[str, ...] = ()


def read_table(path: Path) -> ResultTable:
    """Return a table that a batch has written (CSV or Parquet), or one like it.

    Raises
    ------
    TableError
        If the file is no such table.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise TableError(f"{path}: expected a table, {' or '.join(_READERS)}")
    table = _renamed(reader(path))
    if "test" not in table.columns:
        has = ", ".join(table.columns[:6]) or "none"
        raise TableError(
            f"{path}:1: no column test; it has {has}. A batch writes peaks.csv, runs.csv, "
            f"statistics.csv and trends/, which have it."
        )
    return table


def _renamed(table: ResultTable) -> ResultTable:
    """Return a table with the present names of its columns."""
    notes = tuple(filter(None, (former_note(name, str(table.path)) for name in table.columns)))
    if not notes:
        return table
    rows = tuple(
        MappingProxyType({present_name(name): cell for name, cell in row.items()})
        for row in table.rows
    )
    return replace(
        table, columns=tuple(map(present_name, table.columns)), rows=rows, notes=notes
    )


def _read_csv(path: Path) -> ResultTable:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise TableError(f"{path}: not UTF-8 text at byte {error.start}; save it so") from error
    reader = csv.reader(text.splitlines(), strict=True)
    header: list[str] = []
    rows, lines = [], []
    try:
        header = next(reader, [])
        for row in reader:
            if not row:
                continue
            if len(row) != len(header):
                raise TableError(
                    f"{path}:{reader.line_num}: {len(row)} cells, but the header has "
                    f"{len(header)}; write every cell, empty ones too"
                )
            rows.append(MappingProxyType(dict(zip(header, row, strict=True))))
            lines.append(reader.line_num)
    except csv.Error as error:
        raise TableError(f"{path}:{reader.line_num}: no CSV: {error}") from error
    return ResultTable(path, tuple(header), tuple(rows), tuple(lines))


def _read_parquet(path: Path) -> ResultTable:
    if lacks := without_parquet():
        raise TableError(f"{path}: {lacks}")
    import pyarrow as pa
    import pyarrow.parquet as pq

    check_survived(path, str(path), "pyarrow.parquet:read_table")
    try:
        table = pq.read_table(path)
    except pa.ArrowInvalid as error:
        raise TableError(f"{path}: no Parquet file: {str(error).splitlines()[0]}") from error
    rows = tuple(
        MappingProxyType({name: _text(cell) for name, cell in row.items()})
        for row in table.to_pylist()
    )
    return ResultTable(path, tuple(table.column_names), rows, tuple(range(1, len(rows) + 1)))


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell)


_READERS: Final[Mapping[str, Callable[[Path], ResultTable]]] = MappingProxyType({
    ".csv": _read_csv,
    ".parquet": _read_parquet,
})
