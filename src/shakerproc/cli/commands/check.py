"""``shakerproc check``."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from shakerproc.cli import options, output

if TYPE_CHECKING:
    from collections.abc import Mapping

    from shakerproc.campaign.agreement import ColumnTolerance, Deviation, ResultTable


def check(
    table: Annotated[
        Path,
        typer.Argument(
            metavar="TABLE",
            help="Table that a batch wrote (CSV or Parquet), or its folder for peaks.csv.",
            exists=True,
        ),
    ],
    against: Annotated[
        Path | None,
        typer.Option(
            "--against",
            metavar="REFERENCE",
            help="Reference table of the same form.",
            exists=True,
            show_default="the profiles of the log",
        ),
    ] = None,
    tolerance: Annotated[
        str,
        typer.Option(metavar="TOLERANCE", help='A share, "2 %", or a value, "0.5 Hz".'),
    ] = "2 %",
    columns: Annotated[
        str,
        typer.Option(
            metavar="COLUMNS",
            help="Columns to compare, separated by commas, each with its own tolerance if "
            'needed: "peak_frequency, quality=20 %".',
        ),
    ] = "peak_frequency",
    json: output.JsonOption = None,
) -> None:
    """Compare a table of runs with a reference, within tolerances.

    Exit status 1 if a value is outside its tolerance or a run is missing, with one line for
    each. Of peaks, the tallest of each response is compared. A reference may have fewer rows
    and columns. Without one, every test that has a profile must keep its lines: profile.csv of
    the folder says so. A note names tests that used what had an expired calibration.
    """
    if against is None:
        _check_profiles(table, json)
        return
    from shakerproc.campaign.agreement import agreement, expired_notes, read_table

    wanted = _tolerances(columns, tolerance)
    table_read, reference = (read_table(_file_of(path)) for path in (table, against))
    with options.refused("--tolerance"):
        result = agreement(table_read, reference, wanted)
    reasons = {test: _reason(table_read, test) for test in result.missing}
    output.write_json(
        {
            "schema": "shakerproc-check/1",
            "table": table_read.path,
            "against": reference.path,
            "tolerances": {name: one.text for name, one in wanted.items()},
            "holds": result.holds,
            "compared": result.compared,
            "deviations": result.deviations,
            "missing": [{"test": test, "reason": why} for test, why in reasons.items()],
            "added": result.added,
        },
        json,
    )
    for deviation in result.deviations:
        text = _line(deviation, wanted[deviation.column])
        output.data(text)
    for test, why in reasons.items():
        text = f"test {test}: missing from {table_read.path}, wanted by {reference.path}{why}"
        output.data(text)
    for note in dict.fromkeys((
        *table_read.notes,
        *reference.notes,
        *expired_notes(table_read.path),
    )):
        output.message(f"note: {note}")
    for test in result.added:
        output.message(f"note: test {test} is not in {reference.path}, and was not compared")
    summary = _sum(result.compared, wanted, len(result.deviations), len(reasons))
    output.data(summary)
    if not result.holds:
        output.finish(1)


def _check_profiles(table: Path, json: str | None) -> None:
    """Print every line of a profile that was broken or could not be judged."""
    from shakerproc.campaign.agreement import expired_notes, profiles_kept

    result = profiles_kept(table)
    output.write_json(
        {
            "schema": "shakerproc-check/1",
            "table": result.path,
            "holds": result.holds,
            "compared": {"lines": result.judged},
            "broken": result.broken,
            "worst": result.worst,
            "missing": [{"test": test, "reason": why} for test, why in result.missing.items()],
        },
        json,
    )
    for line in result.broken:
        output.data(line.sentence)
    for one in result.worst:
        output.data(one.sentence)
    for test, why in result.missing.items():
        output.data(f"test {test}: not judged: {why}")
    for note in expired_notes(result.path):
        output.message(f"note: {note}")
    output.data(result.sentence)
    if not result.holds:
        output.finish(1)


def _file_of(path: Path) -> Path:
    """Return the table that is meant: of a folder, its peaks.

    Raises
    ------
    TableError
        If a folder has none.
    """
    from shakerproc.errors import TableError

    if not path.is_dir():
        return path
    peaks = path / "peaks.csv"
    if not peaks.is_file():
        raise TableError(f"{path}: no peaks.csv in it; name the folder that a batch wrote")
    return peaks


def _tolerances(columns: str, tolerance: str) -> "dict[str, ColumnTolerance]":
    """Return the tolerance of each column.

    Raises
    ------
    typer.BadParameter
        If there is no column, or a tolerance cannot be read.
    """
    from shakerproc.campaign.agreement import read_tolerance
    from shakerproc.runs.tables import former_note, present_name

    wanted = {}
    for part in columns.split(","):
        name, _, own = (word.strip() for word in part.partition("="))
        if name:
            hint = "--columns" if own else "--tolerance"
            note = former_note(name, "--columns")
            if note:
                output.message(f"note: {note}")
            with options.refused(hint):
                wanted[present_name(name)] = read_tolerance(own or tolerance)
    if not wanted:
        raise typer.BadParameter(
            "name a column, such as peak_frequency", param_hint="--columns"
        )
    return wanted


def _reason(table: "ResultTable", test: str) -> str:
    """Return why a run is missing, where the table of runs beside it says so."""
    from shakerproc.campaign.agreement import read_table
    from shakerproc.errors import TableError

    runs = table.path.parent / "runs.csv"
    try:
        rows = read_table(runs).rows if runs.is_file() else ()
    except TableError:
        return ""
    row = next((row for row in rows if row["test"] == test), None)
    if row is None or row.get("status", "done") == "done":
        return ""
    return f" ({': '.join(filter(None, (row['status'], row.get('error'))))})"


def _line(off: "Deviation", tolerance: "ColumnTolerance") -> str:
    """Return one deviation as a line of text."""
    from shakerproc.runs.levels import rounded_within

    place = [f"test {off.test}", off.channel, off.quantity]
    unit = f" {off.unit}" if off.unit else ""
    value = "missing" if off.found is None else f"found {off.found:.6g}{unit}"
    by = ""
    if off.found is None or not math.isfinite(off.found):
        pass
    elif tolerance.share is not None and off.wanted != 0.0:
        percent = 100.0 * (off.found - off.wanted) / abs(off.wanted)
        by = f", off by {rounded_within(percent, 100.0 * tolerance.share, 2)} %"
    else:
        decimals = max(0, 2 - math.floor(math.log10(abs(off.found - off.wanted))))
        by = f", off by {rounded_within(off.found - off.wanted, off.allowed, decimals)}{unit}"
    where = ", ".join(filter(None, place))
    return (
        f"{where}: {off.column}: {value}, wanted {off.wanted:.6g}{unit} +- {tolerance.text}{by}"
    )


def _sum(
    compared: "Mapping[str, int]",
    wanted: "Mapping[str, ColumnTolerance]",
    off: int,
    missing: int,
) -> str:
    agree = not off and not missing
    text = ", ".join(
        f"{n} {'value' if n == 1 else 'values'} of {name} {'within' if agree else 'at'} "
        f"{wanted[name].text}"
        for name, n in compared.items()
    )
    if agree:
        return f"all hold: {text}"
    parts = [f"{off} {'value is' if off == 1 else 'values are'} off"] if off else []
    parts += (
        [f"{missing} {'run is' if missing == 1 else 'runs are'} missing"] if missing else []
    )
    return f"{', '.join(parts)}; compared: {text}"
