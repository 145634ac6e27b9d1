"""Tables of results: beside a reference, profiles kept, and calibrations that were valid."""

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeAlias, final

from shakerproc import units
from shakerproc.campaign.trends import SINGLE_FREQUENCY
from shakerproc.errors import TableError
from shakerproc.late import without_parquet
from shakerproc.numerals import numeral
from shakerproc.recordings.own_process import result_apart
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.summary import by_tests
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
    place = "shakerproc.campaign.agreement:parquet_cells"
    names, cells = result_apart(path, str(path), place, "pyarrow.parquet")
    rows = tuple(MappingProxyType(row) for row in cells)
    return ResultTable(path, tuple(names), rows, tuple(range(1, len(rows) + 1)))


def parquet_cells(path: Path, _: str) -> list[Any]:
    """Return the names of the columns of a Parquet table, and its rows as text."""
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    rows = [{name: _text(cell) for name, cell in row.items()} for row in table.to_pylist()]
    return [table.column_names, rows]


def _text(cell: Any) -> str:
    return "" if cell is None else str(cell)


_READERS: Final[Mapping[str, Callable[[Path], ResultTable]]] = MappingProxyType({
    ".csv": _read_csv,
    ".parquet": _read_parquet,
})


PEAK: Final = "peak_frequency"
"""Name of it in every table that holds it, whatever its column is called."""

Key: TypeAlias = tuple[str, ...]
"""What names a value: the test, its channel and the quantity, as far as a table has them."""

_NAMES: Final = ("test", "channel", "quantity")

_ENDINGS: Final = {
    "_g2_per_hz": "g^2/Hz",
    "_n_per_m": "N/m",
    "_hz": "Hz",
    "_kg": "kg",
    "_deg": "deg",
    "_m": "m",
    "_g": "g",
    "_s": "s",
}


@final
@dataclass(frozen=True, slots=True)
class ColumnTolerance:
    """How far a value may lie from the wanted one.

    Attributes
    ----------
    text : str
        As it was written: a share such as ``2 %``, or a value such as ``0.5 Hz``.
    share : float or None
        Of the wanted value [-]; None where the text is a value with a unit.
    """

    text: str
    share: float | None

    def around(self, wanted: float, unit: str) -> float:
        """Return the largest difference that is allowed, in the unit of the column.

        Raises
        ------
        ValueError
            If the tolerance has another unit than the column.
        """
        if self.share is not None:
            return self.share * abs(wanted)
        return units.from_si(units.to_si(self.text, unit), unit, unit)


@final
@dataclass(frozen=True, slots=True)
class Deviation:
    """A value that left its tolerance, or is missing.

    Attributes
    ----------
    test, channel, quantity : str
        Whose value; empty where the tables do not say.
    column, unit : str
        Which value; its unit, empty for none.
    found : float or None
        Value in the table; None where it is missing.
    wanted, allowed : float
        Value in the reference, and the largest difference that would do.
    """

    test: str
    channel: str
    quantity: str
    column: str
    unit: str
    found: float | None
    wanted: float
    allowed: float


@final
@dataclass(frozen=True, slots=True)
class Agreement:
    """Result of the comparison of a table with a reference.

    Attributes
    ----------
    compared : mapping of str to int
        How many values of each column were compared.
    deviations : tuple of Deviation
        Those that left their tolerance, in the order of the reference.
    missing : tuple of str
        Tests of the reference of which the table holds no value.
    added : tuple of str
        Tests of the table that the reference does not know.
    """

    compared: Mapping[str, int]
    deviations: tuple[Deviation, ...]
    missing: tuple[str, ...]
    added: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether every value of the reference was found within its tolerance."""
        return not self.deviations and not self.missing


def read_tolerance(text: str) -> ColumnTolerance:
    """Return a tolerance written as a share (``2 %``) or as a value (``0.5 Hz``).

    Raises
    ------
    ValueError
        If the text is neither, or is negative.
    """
    plain = text.strip()
    number = plain.rstrip("%") if plain.endswith("%") else plain.partition(" ")[0]
    try:
        value = float(number)
    except ValueError:
        value = math.nan
    if not value >= 0.0 or math.isinf(value) or number == plain:
        raise ValueError(
            f"expected a share such as 2 %, or a value with its unit such as 0.5 Hz, "
            f"got {units.quoted(text)}"
        )
    return ColumnTolerance(plain, value / 100.0 if plain.endswith("%") else None)


def agreement(
    table: ResultTable, reference: ResultTable, wanted: Mapping[str, ColumnTolerance]
) -> Agreement:
    """Return the agreement of a table with a reference, within tolerances.

    In a table of peaks, the tallest peak of each response and quantity is looked at; the peak
    frequency is that of the PSD, and a test with a single sine has none.

    Parameters
    ----------
    table, reference : ResultTable
        What was found and what is wanted; the reference may hold fewer rows and columns.
    wanted : mapping of str to ColumnTolerance
        Columns to compare; `PEAK` stands for the peak frequency in any table that has it.

    Raises
    ------
    TableError
        If a column is missing, holds text, or does not name its rows uniquely.
    ValueError
        If a tolerance has another unit than its column.
    """
    tests, known = _tests(table), _tests(reference)
    compared: dict[str, int] = {}
    deviations, seen = [], set[str]()
    for column, tolerance in wanted.items():
        names = _shared_names(table, reference, column)
        table_values = _values(table, column, names)
        unit = _unit_of(column)
        expected = _values(reference, column, names)
        compared[column] = sum(value is not None for value in expected.values())
        if not compared[column]:
            raise TableError(f"{reference.path}: no value of {column}: nothing to compare with")
        for key, value in expected.items():
            if value is None:
                continue
            here, allowed = table_values.get(key), tolerance.around(value, unit)
            if here is None or not abs(here - value) <= allowed * (1.0 + 1e-12):
                place, shown = _named(names, key), "" if unit == "1" else unit
                deviations.append(Deviation(*place, column, shown, here, value, allowed))
            if here is not None:
                seen.add(key[0])
    lost = {d.test for d in deviations if d.test not in seen}
    return Agreement(
        compared,
        tuple(d for d in deviations if d.test not in lost),
        tuple(test for test in known if test in lost),
        tuple(test for test in tests if test not in known),
    )


def _tests(table: ResultTable) -> list[str]:
    return list(dict.fromkeys(row["test"] for row in table.rows))


def _named(names: Sequence[str], key: Key) -> tuple[str, str, str]:
    """Return test, channel and quantity of a value, empty where they are not told."""
    said = dict(zip(names, key, strict=True))
    return said["test"], said.get("channel", ""), said.get("quantity", "")


def _unit_of(column: str) -> str:
    """Return the unit that a header says at its end; ``1`` for none."""
    if column == PEAK:
        return "Hz"
    return next((unit for end, unit in _ENDINGS.items() if column.endswith(end)), "1")


def _shared_names(table: ResultTable, reference: ResultTable, column: str) -> tuple[str, ...]:
    """Return the columns that name a value in both tables."""
    names = _NAMES[:2] if column == PEAK else _NAMES
    return tuple(n for n in names if n in table.columns and n in reference.columns)


def _is_of_peaks(table: ResultTable) -> bool:
    return {"quantity", "rank", "frequency_hz"} <= set(table.columns)


def _column_of(table: ResultTable, column: str) -> str:
    """Return the header of the column that holds a quantity.

    Raises
    ------
    TableError
        If it has none.
    """
    if column != PEAK:
        if column in table.columns:
            return column
        meant = units.near_miss(column, table.columns)
        guess = f"; did you mean {meant}?" if meant else f"; it has {', '.join(table.columns)}"
        raise TableError(f"{table.path}:1: no column {column!r}{guess}")
    if _is_of_peaks(table):
        return "frequency_hz"
    if "peak_frequency_hz" in table.columns:
        return "peak_frequency_hz"
    raise TableError(
        f"{table.path}:1: no peak frequency (peak_frequency_hz) in it; take peaks.csv or a "
        f"table of trends/, or name other columns with --columns"
    )


def _values(table: ResultTable, column: str, names: Sequence[str]) -> dict[Key, float | None]:
    """Return the numbers of a column by the names of their rows.

    Raises
    ------
    TableError
        If a cell is no number, or two rows have one name.
    """
    header = _column_of(table, column)
    values: dict[Key, float | None] = {}
    for row, line in zip(table.rows, table.lines, strict=True):
        if not _is_meant(table, row, column):
            continue
        key = tuple(row[name] for name in names)
        value = _number(table, row[header], header, line)
        if key in values and values[key] != value:
            named = ", ".join(f"{n} {k}" for n, k in zip(names, key, strict=True))
            lacking = [n for n in _NAMES if n in table.columns and n not in names]
            more = f"; add the column {' and '.join(lacking)} to the other" if lacking else ""
            raise TableError(f"{table.path}:{line}: a second {header} of {named}{more}")
        values[key] = value
    return values


def _is_meant(table: ResultTable, row: Mapping[str, str], column: str) -> bool:
    """Return whether a row holds the compared quantity: not all rows of a table of peaks do."""
    if not _is_of_peaks(table):
        return True
    tallest = row["rank"] == "1" and row.get("role", "response") == "response"
    if column != PEAK:
        return tallest
    is_tone = row.get("excitation") in SINGLE_FREQUENCY
    return tallest and row["quantity"] == "psd" and not is_tone


def _number(table: ResultTable, cell: str, header: str, line: int) -> float | None:
    if not cell.strip():
        return None
    try:
        value = float(cell)
    except ValueError as error:
        raise TableError(
            f"{table.path}:{line}: {header}: expected a number, got {units.quoted(cell)}"
        ) from error
    return None if math.isnan(value) else value


@final
@dataclass(frozen=True, slots=True)
class BrokenLine:
    """A line of a profile that a test did not keep.

    Attributes
    ----------
    test, profile, line : str
        Which.
    exceedance_db, at_hz : float
        How far the control lies beyond it at worst [dB], and where [Hz].
    """

    test: str
    profile: str
    line: str
    exceedance_db: float
    at_hz: float

    @property
    def sentence(self) -> str:
        """A sentence for people."""
        return (
            f"test {self.test}: profile {self.profile}: {self.line} line not kept, "
            f"{self.exceedance_db:+.2f} dB beyond it at {numeral(self.at_hz, 4)} Hz"
        )


@final
@dataclass(frozen=True, slots=True)
class Worst:
    """Where a test came closest to, or farthest beyond, a line of its profile.

    Attributes
    ----------
    test, profile, line : str
        Which.
    kept : bool
        Whether the test kept every line.
    exceedance_db, at_hz : float
        How far the control lies beyond that line [dB], negative within it, and where [Hz].
    demand_rms, measured_rms : float, optional
        Of the demand and of the control [`unit`]; of random tests only.
    unit : str
        Unit of both.
    """

    test: str
    profile: str
    line: str
    kept: bool
    exceedance_db: float
    at_hz: float
    demand_rms: float | None
    measured_rms: float | None
    unit: str

    @property
    def sentence(self) -> str:
        """A sentence for people."""
        rms = ""
        if self.demand_rms is not None and self.measured_rms is not None:
            rms = (
                f"; demanded {numeral(self.demand_rms, 4)} {self.unit} rms, measured "
                f"{numeral(self.measured_rms, 4)} {self.unit} rms"
            )
        return (
            f"test {self.test}: profile {self.profile}: {'' if self.kept else 'not '}kept, "
            f"worst {self.exceedance_db:+.2f} dB beyond {self.line} at "
            f"{numeral(self.at_hz, 4)} Hz{rms}"
        )


@final
@dataclass(frozen=True, slots=True)
class Keeping:
    """How a batch kept its profiles.

    Attributes
    ----------
    path : Path
        The table that says so.
    judged : int
        Lines that were judged.
    broken : tuple of BrokenLine
        Those that were not kept.
    worst : tuple of Worst
        Of each test that was judged.
    missing : mapping
        Why tests were not judged, by test.
    """

    path: Path
    judged: int
    broken: tuple[BrokenLine, ...]
    worst: tuple[Worst, ...]
    missing: Mapping[str, str]

    @property
    def holds(self) -> bool:
        """Whether every line was judged and kept."""
        return not self.broken and not self.missing

    @property
    def sentence(self) -> str:
        """A sentence for people."""
        if self.holds:
            return f"all hold: {self.judged} lines of profiles kept"
        return (
            f"not kept: {len(self.broken)} of {self.judged} lines; "
            f"not judged: {len(self.missing)} tests"
        )


def profiles_kept(path: Path) -> Keeping:
    """Return how a batch kept the profiles of its log.

    Parameters
    ----------
    path : Path
        Folder of a batch, or its ``profile.csv``.

    Raises
    ------
    TableError
        If the folder has no such table, or it is none.
    """
    file = path / "profile.csv" if path.is_dir() else path
    if not file.is_file():
        raise TableError(
            f"{path}: no profile.csv in it, as no test of the log has a profile that could be "
            "judged; name a reference with --against"
        )
    table = read_table(file)
    by_test: dict[str, list[Mapping[str, str]]] = {}
    for row in table.rows:
        by_test.setdefault(row["test"], []).append(row)
    return Keeping(
        file,
        len(table.rows),
        tuple(_broken(row, table) for row in table.rows if not _is_kept(row, table)),
        tuple(_worst(rows, table) for rows in by_test.values()),
        _missing(file.parent / "runs.csv", set(by_test)),
    )


def _cell(row: Mapping[str, str], table: ResultTable, name: str) -> str:
    """Return a cell of a row.

    Raises
    ------
    TableError
        If the table has no such column.
    """
    if name not in row:
        raise TableError(f"{table.path}: no column {name}; name the profile.csv of a batch")
    return row[name].strip().lower() if name == "kept" else row[name]


def _is_kept(row: Mapping[str, str], table: ResultTable) -> bool:
    return _cell(row, table, "kept") == "true"


def _number_in(row: Mapping[str, str], table: ResultTable, name: str) -> float:
    """Return the number in a cell.

    Raises
    ------
    TableError
        If it holds none.
    """
    try:
        return float(_cell(row, table, name))
    except ValueError as error:
        raise TableError(
            f"{table.path}: test {row['test']}: expected numbers: {error}"
        ) from error


def _broken(row: Mapping[str, str], table: ResultTable) -> BrokenLine:
    return BrokenLine(
        row["test"],
        _cell(row, table, "profile"),
        _cell(row, table, "line"),
        _number_in(row, table, "exceedance_db"),
        _number_in(row, table, "at_hz"),
    )


def _worst(rows: Sequence[Mapping[str, str]], table: ResultTable) -> Worst:
    """Return the worst line of a test: of those that are broken, if any is."""
    broken = [row for row in rows if not _is_kept(row, table)] or rows
    row = max(broken, key=lambda row: _number_in(row, table, "exceedance_db"))
    line = _broken(row, table)
    demanded, measured = (
        _number_in(row, table, name) if row.get(name) else None
        for name in ("demand_rms", "measured_rms")
    )
    return Worst(
        line.test, line.profile, line.line, broken is rows, line.exceedance_db, line.at_hz,
        demanded, measured, row.get("unit", ""),
    )  # fmt: skip


def _missing(runs: Path, judged: set[str]) -> dict[str, str]:
    """Return why tests were not judged: those that failed, and whose flags say so."""
    if not runs.is_file():
        return {}
    texts = {}
    for row in read_table(runs).rows:
        if row["test"] in judged:
            continue
        if row.get("status") == "failed":
            texts[row["test"]] = row.get("error") or "it failed"
        elif "profile" in (row.get("flags") or "").split("; "):
            texts[row["test"]] = "no channel, or no value, that the profile is about"
    return texts


def expired_notes(table: Path) -> list[str]:
    """Return which tests used an expired calibration, as the table of runs says it."""
    runs = table.parent / "runs.csv"
    if not runs.is_file():
        return []
    note = "a calibration had expired on the day of the test; report.html says which"
    return by_tests(
        (row["test"], [note] if EXPIRED in (row.get("flags") or "").split("; ") else [])
        for row in read_table(runs).rows
        if row.get("status", "done") == "done"
    )
