"""Lines above a table of text: statements about it, names and units of its columns.

Statements stand as ``Sample Rate (Hz),2000``, as ``# fs = 2000 Hz`` or as ``Interval: 0.5 ms``.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Final, final

from shakerproc.recordings.columns import RATE_NAME, RATE_WORD, STEP_NAME, STEP_WORD
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import TimeAxis, half_digit
from shakerproc.recordings.si import parse_unit, split_header
from shakerproc.recordings.times import SECONDS, iso_date

COMMENT: Final = ("#", "%", "//", "!", ";", "*", "--", "'")
"""How a line begins that is no row, and ``REM``."""

_REMARK: Final = re.compile(r"rem(?=\s|$)", re.IGNORECASE)
_SIGN: Final = re.compile(
    r"[\s\ufeff]*(?:[#%!;*']+|/{2,}|-{2,}|rem(?=\s|$))?\s*", re.IGNORECASE
)
_STATED: Final = re.compile(
    r"(?P<label>[A-Za-z_][^,;:=\t\"]*?)\s*[\"]?\s*[,;:=\t]\s*[,;:=\t\"]*\s*"
    r"(?P<value>[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?)\s*[,;\t\"]*\s*"
    r"(?P<unit>[A-Za-z\u00b5\u03bc][A-Za-z/]*|1/s)?[\s,;\t\"]*"
)
_ABOUT: Final = re.compile(
    r"rate|freq|fs|interval|delta|step|dt|start|begin|end|date|trigger|offset|samples?|points|"
    r"npts|count|channels?|number|no\.?|serial|version|gain|range|sensitivity|duration|length|"
    r"size|blocks?|run|test|record|calibration|factor|scale|temperature|abtastrate",
    re.IGNORECASE,
)
"""Words by which a line is about a table rather than a row of it."""

_DOMAIN: Final = re.compile(
    r"domain;unit=s(?:ec(?:onds?)?)?;resolution=(?P<by>\d{1,18})/(?P<per>[1-9]\d{0,17});"
    r"delta=(?P<delta>\d{1,18});origin=(?P<origin>[^;]*);starting_tick=(?P<start>-?\d{1,18});?",
    re.IGNORECASE,
)
"""The first line of the recorder of openDAQ that writes several signals."""

_HERTZ: Mapping[str, float] = MappingProxyType({
    "": 1.0, "hz": 1.0, "1/s": 1.0, "s/s": 1.0, "sps": 1.0, "khz": 1e3, "ks/s": 1e3,
    "ksps": 1e3, "mhz": 1e6, "ms/s": 1e6,
})  # fmt: skip

_WHOLE: Final = re.compile(r"\d{1,6}")
_BRACKETS: Final = re.compile(r"^(?:\[([^][]*)\]|\(([^()]*)\))$")
"""A cell that is one pair of brackets, as around a unit."""

_NAME: Final = re.compile(
    r"(?:channel|signal)?[ _]?(?:names?|labels?)|channels?", re.IGNORECASE
)
_UNIT: Final = re.compile(r"units?|einheit(?:en)?", re.IGNORECASE)
_INTERVAL: Final = re.compile(
    r"(?:sampl(?:e|ing)[ _]?)?interval|delta[ _]?[tx]|dt|time[ _]?step", re.IGNORECASE
)
_QUANTITY: Final = re.compile(r"\s*(?P<number>[-+0-9.eE,]+)\s*(?P<unit>[^\d\s]*)\s*")

SAME_STEP: Final = 0.01
"""How far the steps of a first column may be from the interval, relative, to be times [-]."""


def is_comment(line: str, delimiter: str = "") -> bool:
    """Return whether a line is a comment, whatever its sign; a delimiter is none.

    Examples
    --------
    >>> is_comment("! bench 3"), is_comment("REM bench"), is_comment("remote,ch1")
    (True, True, False)
    """
    plain = line.strip(" \t\ufeff")
    if delimiter == ";" and plain[:1] == ";":
        return False
    if plain[:2] in {"'=", "'+", "'-", "'@"}:  # kept from being run by a spreadsheet
        return False
    return plain.startswith(COMMENT) or _REMARK.match(plain) is not None


def uncommented(cell: str) -> str:
    """Return the first cell of a comment without its sign."""
    return _SIGN.sub("", cell, count=1)


def is_statement(line: str) -> bool:
    """Return whether a line says a number of the table, by the word before it.

    Examples
    --------
    >>> is_statement("Sample Rate (Hz),2000"), is_statement("start;0,5"), is_statement("x,1")
    (True, True, False)
    """
    match = _STATED.fullmatch(uncommented(line).strip().strip('"'))
    return match is not None and _ABOUT.search(match["label"]) is not None


def stated_axes(above: Sequence[str]) -> tuple[TimeAxis, ...]:
    """Return the statements of the lines above a table on the times of its rows."""
    time_axes = []
    for number, line in enumerate(above, 1):
        match = _STATED.fullmatch(uncommented(line).strip().strip('"'))
        if match is None:
            continue
        label, in_label = split_header(match["label"])
        name = re.sub(r"[\s_]+", "_", label.strip())
        unit, text = (match["unit"] or in_label).strip(), match["value"].replace(",", ".")
        where = f"line {number} ({shown(match['label'].strip(), 30)})"
        if RATE_NAME.fullmatch(name) or RATE_WORD.fullmatch(name):
            factor = _HERTZ.get(unit.casefold())
            problem = "" if factor else f"{where} gives a rate in {shown(unit, 20)}, not in Hz"
            rate = float(text) * factor if factor else None
            time_axes.append(TimeAxis(where, rate=rate, problem=problem))
        elif STEP_NAME.fullmatch(name) or STEP_WORD.fullmatch(name):
            digit = half_digit(text)
            time_axes.append(TimeAxis(where, step=float(text), unit=unit, digit=digit))
    return tuple(time_axes)


@final
@dataclass(frozen=True, slots=True)
class Domain:
    """Description of the times of a table by openDAQ.

    Attributes
    ----------
    axis : TimeAxis
        Step and start of the samples.
    unit : str
        Of the counter that may stand in a column.
    origin : datetime, optional
        When time 0 is, with its time zone.
    column : str
        Header of that column.
    """

    axis: TimeAxis
    unit: str
    origin: datetime | None
    column: str = "Domain"


def stated_domain(above: Sequence[str]) -> Domain | None:
    """Return the description of times by openDAQ above a table; None where there is none."""
    for number, line in enumerate(above, 1):
        match = _DOMAIN.fullmatch(uncommented(line).strip())
        if match is not None:
            tick = int(match["by"]) / int(match["per"])
            axis = TimeAxis(
                f"line {number} (domain)", step=int(match["delta"]) * tick,
                start=int(match["start"]) * tick, unit="s",
            )  # fmt: skip
            unit = f"s * {match['per']}" + f" / {match['by']}" * (match["by"] != "1")
            return Domain(axis, unit, iso_date(match["origin"]))
    return None


def cells_in_use(row: Sequence[str]) -> Sequence[str]:
    """Return the cells of a row up to the last one that holds something."""
    there = [i for i, cell in enumerate(row) if cell]
    return row[: there[-1] + 1] if there else []


def fitted(row: list[str], used: int, width: int) -> list[str]:
    """Return a row of names at the width of the numbers: either may end in a delimiter."""
    filled = cells_in_use(row)
    return [*filled, *[""] * (width - used)] if len(filled) == used else row


def title_rows(
    above: Sequence[list[str]], numbers: Sequence[int], width: int, comments: Sequence[bool]
) -> list[int]:
    """Return which lines are headers: the last that fits, and one before it.

    A comment is one only where no other line is, or where it holds the units of such a line.
    """
    fitting = [
        i
        for i, row in enumerate(above)
        if len(row) == width and any(row) and _may_be_title(row, numbers[i], comments[i])
    ]
    plain = [i for i in fitting if not comments[i]]
    below = plain[-1] + 1 if plain else 0
    if below in fitting and _are_units(["" if comments[below] else "?", *above[below][1:]]):
        plain.append(below)
    titles = plain or fitting
    if not titles:
        return []
    last = titles[-1]
    if numbers[last] and last - 1 in titles and not numbers[last - 1]:
        last -= 1  # a row that holds numbers, below names: the first of the table
    return [last - 1, last] if last - 1 in titles else [last]


def _may_be_title(row: Sequence[str], numbers: int, comment: bool) -> bool:  # noqa: FBT001
    """Return whether a row may hold names: numbers among them are short and whole."""
    whole = sum(_WHOLE.fullmatch(cell) is not None for cell in row)
    if numbers and comment:
        return False
    return numbers == whole and numbers < sum(map(bool, row))


def column_names(
    rows: Sequence[list[str]], titles: Sequence[int], width: int
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return names and units from the lines above the numbers."""
    if not titles:
        return numbered(width), ()
    units = tuple(_BRACKETS.sub(r"\1\2", cell) for cell in _names(rows[titles[-1]]))
    if len(titles) == 2 and _are_units(units):
        return _names(rows[titles[0]]), units
    return _names(rows[titles[-1]]), ()


def numbered(width: int) -> tuple[str, ...]:
    """Return names of columns without one: their numbers."""
    return tuple(f"column {i + 1}" for i in range(width))


def _names(row: Sequence[str]) -> tuple[str, ...]:
    """Return the names in a row, which may be written as a comment."""
    return (uncommented(row[0]), *row[1:])


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether a row holds units rather than names: most of its words are units."""
    words = [cell for cell in cells if cell]
    known = sum(word.casefold() in SECONDS or parse_unit(word) is not None for word in words)
    return 2 * known > len(words)


def unlabelled(
    above: Sequence[list[str]], used: int, decimal: str
) -> tuple[list[list[str]], float | None] | None:
    """Return the rows above a table without their labels, and the interval [s].

    A label stands in front of the columns or over the first of them. None where names and
    units do not both have one.

    Parameters
    ----------
    above : sequence of list of str
        Cells of the rows above the numbers.
    used : int
        How many columns hold numbers.
    decimal : str
        Sign between whole and fraction.
    """
    labels = [split_header(row[0])[0] if row else "" for row in above]
    if not (any(map(_NAME.fullmatch, labels)) and any(map(_UNIT.fullmatch, labels))):
        return None
    rows: list[list[str]] = []
    interval = None
    for label, row in zip(labels, above, strict=True):
        if _INTERVAL.fullmatch(label):
            interval = _seconds(row, decimal)
            rows.append([])
        elif _NAME.fullmatch(label) or _UNIT.fullmatch(label):
            filled = cells_in_use(row)
            rows.append(list(row[1:]) if len(filled) == used + 1 else ["", *row[1:]])
        else:
            rows.append(row)
    return rows, interval


def _seconds(row: Sequence[str], decimal: str) -> float | None:
    """Return the interval of a row that states one [s]; None where it is not to be read."""
    unit = split_header(row[0])[1]
    for cell in row[1:]:
        match = _QUANTITY.fullmatch(cell)
        if match is not None:
            factor = SECONDS.get((match["unit"] or unit or "s").casefold(), 0.0)
            try:
                return float(match["number"].replace(decimal, ".")) * factor or None
            except ValueError:
                return None
    return None


def is_stepped(rows: Sequence[list[str]], interval: float | None, decimal: str) -> bool:
    """Return whether the first column of a table begins with steps of an interval [s]."""
    if interval is None or len(rows) < 2:
        return False
    try:
        first, second = (float(row[0].replace(decimal, ".")) for row in rows[:2])
    except ValueError:
        return False
    return abs((second - first) / interval - 1.0) <= SAME_STEP
