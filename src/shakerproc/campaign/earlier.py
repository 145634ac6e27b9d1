"""A campaign beside an earlier one: which peaks moved, which damping and level changed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, final

from pydantic import TypeAdapter, ValidationError
from pydantic_core import from_json

from shakerproc.errors import TableError
from shakerproc.runs.summary import PeakSummary, RunSummary
from shakerproc.runs.tables import Columns, peak_rows, quantity_of

FARTHEST: Final = 0.2
"""Distance of two peaks of one mode, over their frequency, at most [-]."""

_RUNS: Final = TypeAdapter(tuple[RunSummary, ...])


@final
@dataclass(frozen=True, slots=True)
class Earlier:
    """An earlier campaign, as its batch left it.

    Attributes
    ----------
    title, folder : str
        Title of its log, and the folder as it was named.
    runs : tuple of RunSummary
        Its tests.
    """

    title: str
    folder: str
    runs: tuple[RunSummary, ...]


@final
@dataclass(frozen=True, slots=True)
class Change:
    """A mode of a channel of a test, before and now; None where only the other has it.

    Attributes
    ----------
    test, channel, quantity : str
        Whose peak, of ``|H1|`` or ``PSD``.
    mode : int
        Number of the mode along frequency, from 1.
    before, now : PeakSummary or None
        The peaks.
    bin_hz : float
        Wider bin of the two spectra [Hz].
    level_db : float or None
        Measured level of the test over that of the earlier one [dB].
    """

    test: str
    channel: str
    quantity: str
    mode: int
    before: PeakSummary | None
    now: PeakSummary | None
    bin_hz: float
    level_db: float | None

    @property
    def shift_hz(self) -> float | None:
        """How far the peak moved [Hz]."""
        if self.before is None or self.now is None:
            return None
        return self.now.frequency_hz - self.before.frequency_hz

    @property
    def height_db(self) -> float | None:
        """Height of the peak over the earlier one [dB]."""
        if self.before is None or self.now is None:
            return None
        per_decade = 10.0 if self.quantity == "PSD" else 20.0
        return _decibels(self.now.height, self.before.height, per_decade)


@final
@dataclass(frozen=True, slots=True)
class Changes:
    """Changes since an earlier campaign.

    Attributes
    ----------
    rows : tuple of Change
        Every mode of every test that both have.
    only_now, only_before : tuple of str
        Tests that were processed in one of them alone.
    """

    rows: tuple[Change, ...]
    only_now: tuple[str, ...]
    only_before: tuple[str, ...]


def read_earlier(folder: Path) -> Earlier:
    """Return the campaign whose results a folder holds.

    Raises
    ------
    TableError
        If it holds no results of a batch.
    """
    path = folder / "report.json"
    if not path.is_file():
        raise TableError(
            f"{folder}: no report.json in it; name the folder that an earlier batch wrote"
        )
    try:
        content = from_json(path.read_bytes())
        return Earlier(
            str(content["title"]), str(folder), _RUNS.validate_python(content["runs"])
        )
    except ValidationError as error:
        where = "/".join(str(part) for part in error.errors()[0]["loc"])
        raise TableError(
            f"{path}: runs/{where} is not what this version writes; run that batch again"
        ) from error
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise TableError(
            f"{path}: not the report of a batch; name the folder that an earlier batch wrote"
        ) from error


def changes(runs: Sequence[RunSummary], earlier: Sequence[RunSummary]) -> Changes:
    """Return the differences between the tests of two campaigns, by their ids."""
    now = {run.test: run for run in runs if run.status == "done"}
    before = {run.test: run for run in earlier if run.status == "done"}
    return Changes(
        tuple(row for test in now if test in before for row in _rows(now[test], before[test])),
        tuple(test for test in now if test not in before),
        tuple(test for test in before if test not in now),
    )


def _rows(now: RunSummary, before: RunSummary) -> list[Change]:
    quantity = quantity_of(now)
    if quantity != quantity_of(before):
        return []
    width = max(run.spectrum.bin_width_hz if run.spectrum else 0.0 for run in (now, before))
    level = None
    if now.level_unit == before.level_unit and now.measured_level and before.measured_level:
        per_decade = 10.0 if now.level_unit.endswith("/Hz") else 20.0
        level = _decibels(now.measured_level, before.measured_level, per_decade)
    rows = []
    for name in dict.fromkeys(
        row.channel.name for row in (*peak_rows(now), *peak_rows(before))
    ):
        here, there = ([row.peak for row in peak_rows(run) if row.channel.name == name]
                       for run in (now, before))  # fmt: skip
        for mode, (one, other) in enumerate(_paired(here, there), 1):
            rows.append(Change(now.test, name, quantity, mode, other, one, width, level))
    return rows


def _paired(
    now: Sequence[PeakSummary], before: Sequence[PeakSummary]
) -> list[tuple[PeakSummary | None, PeakSummary | None]]:
    """Return peaks of one mode side by side, nearest first, each once; by frequency."""
    near = sorted(
        (abs(math.log(a.frequency_hz / b.frequency_hz)), i, j)
        for i, a in enumerate(now)
        for j, b in enumerate(before)
        if a.frequency_hz > 0.0 and b.frequency_hz > 0.0
    )
    of_now: dict[int, int] = {}
    for distance, i, j in near:
        if distance <= FARTHEST and i not in of_now and j not in of_now.values():
            of_now[i] = j
    pairs: list[tuple[PeakSummary | None, PeakSummary | None]] = [
        (a, before[of_now[i]] if i in of_now else None) for i, a in enumerate(now)
    ]
    pairs += [(None, b) for j, b in enumerate(before) if j not in of_now.values()]
    return sorted(pairs, key=lambda pair: (pair[0] or pair[1]).frequency_hz)  # type: ignore[union-attr]


def _decibels(value: float, over: float, per_decade: float) -> float | None:
    return per_decade * math.log10(value / over) if value > 0.0 and over > 0.0 else None


def change_columns(rows: Sequence[Change]) -> Columns:
    """Return the modes before and now as columns of a table."""
    sides = {"before": [row.before for row in rows], "now": [row.now for row in rows]}
    columns: Columns = {
        "test": [row.test for row in rows],
        "channel": [row.channel for row in rows],
        "quantity": [row.quantity for row in rows],
        "mode": [row.mode for row in rows],
    }
    for side, peaks in sides.items():
        columns[f"frequency_{side}_hz"] = [p and p.frequency_hz for p in peaks]
        columns[f"damping_ratio_{side}"] = [p and p.damping_ratio for p in peaks]
        columns[f"height_{side}"] = [p and p.height for p in peaks]
    return columns | {
        "bin_hz": [row.bin_hz for row in rows],
        "shift_hz": [row.shift_hz for row in rows],
        "height_difference_db": [row.height_db for row in rows],
        "level_difference_db": [row.level_db for row in rows],
    }
