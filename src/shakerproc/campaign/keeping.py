"""Whether the tests of a batch kept their profiles, as its tables say."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import final

from shakerproc.campaign.result_table import Table, read_table
from shakerproc.errors import TableError


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
    def told(self) -> str:
        """A sentence for people."""
        return (
            f"test {self.test}: profile {self.profile}: {self.line} line not kept, "
            f"{self.exceedance_db:+.2f} dB beyond it at {self.at_hz:.4g} Hz"
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
    missing : mapping
        Why tests were not judged, by test.
    """

    path: Path
    judged: int
    broken: tuple[BrokenLine, ...]
    missing: Mapping[str, str]

    @property
    def holds(self) -> bool:
        """Whether every line was judged and kept."""
        return not self.broken and not self.missing

    @property
    def told(self) -> str:
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
    judged = {row["test"] for row in table.rows}
    return Keeping(
        file,
        len(table.rows),
        tuple(_broken(row, table) for row in table.rows if _cell(row, table, "kept") != "true"),
        _missing(file.parent / "runs.csv", judged),
    )


def _cell(row: Mapping[str, str], table: Table, name: str) -> str:
    """Return a cell of a row.

    Raises
    ------
    TableError
        If the table has no such column.
    """
    if name not in row:
        raise TableError(f"{table.path}: no column {name}; name the profile.csv of a batch")
    return row[name].strip().lower() if name == "kept" else row[name]


def _broken(row: Mapping[str, str], table: Table) -> BrokenLine:
    """Return the broken line of a row.

    Raises
    ------
    TableError
        If a cell that should hold a number does not.
    """
    texts = [_cell(row, table, name) for name in ("exceedance_db", "at_hz")]
    try:
        worst, at = (float(text) for text in texts)
    except ValueError as error:
        raise TableError(
            f"{table.path}: test {row['test']}: expected numbers: {error}"
        ) from error
    return BrokenLine(
        row["test"], _cell(row, table, "profile"), _cell(row, table, "line"), worst, at
    )


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
