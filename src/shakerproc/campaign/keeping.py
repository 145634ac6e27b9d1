"""Whether tests of a batch kept their profiles and used valid calibrations: of its tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from shakerproc.campaign.agreement import ResultTable, read_table
from shakerproc.errors import TableError
from shakerproc.numerals import numeral
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.summary import by_tests


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


def _number(row: Mapping[str, str], table: ResultTable, name: str) -> float:
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
        _number(row, table, "exceedance_db"),
        _number(row, table, "at_hz"),
    )


def _worst(rows: Sequence[Mapping[str, str]], table: ResultTable) -> Worst:
    """Return the worst line of a test: of those that are broken, if any is."""
    broken = [row for row in rows if not _is_kept(row, table)] or rows
    row = max(broken, key=lambda row: _number(row, table, "exceedance_db"))
    line = _broken(row, table)
    demanded, measured = (
        _number(row, table, name) if row.get(name) else None
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
    found = {}
    for row in read_table(runs).rows:
        if row["test"] in judged:
            continue
        if row.get("status") == "failed":
            found[row["test"]] = row.get("error") or "it failed"
        elif "profile" in (row.get("flags") or "").split("; "):
            found[row["test"]] = "no channel, or no value, that the profile is about"
    return found


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
