"""Named columns of numbers in memory, with names, units and rates as headers say them."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc import units
from shakerproc.data import ArraySource, FloatArray, SampleSource
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis, Times
from shakerproc.recordings.si import parse_unit, split_header
from shakerproc.recordings.times import SECONDS, axis_of_column, like_time, time_columns

RATE_NAME: Final = re.compile(
    r"(?:.*_)?(?:fs|sr|f_?sample|samp(?:le|ling)_?(?:rate|freq(?:uency)?)|(?:scan|data)_?rate)"
    r"(?:_hz)?",
    re.IGNORECASE,
)
STEP_NAME: Final = re.compile(
    r"(?:.*_)?(?:dt|delta_?[tx]|t_?s|ts_?s|increment|time_?step)", re.I
)

RATE_WORD: Final = re.compile(
    r"(?:data_?|scan_?|acquisition_?)?rate|samples?_?(?:per_?|/)s(?:ec(?:ond)?)?|sps|abtastrate|"
    r"sampl(?:e|ing)_?rate|sampl(?:e|ing)_?freq(?:uency)?",
    re.IGNORECASE,
)
STEP_WORD: Final = re.compile(
    r"(?:sampl(?:e|ing)_?)?(?:interval|period|step)|sampl(?:e|ing)_?time", re.IGNORECASE
)
"""How a line of text or an attribute calls them, which is about a recording and no variable."""

_QUANTITY_WORDS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    "N": ("force", "kraft", "load", "thrust", "hammer", "impact", "fuerza", "forza"),
    "m": (
        "disp", "displacement", "position", "weg", "stroke", "deflection", "distance", "gap",
        "laser", "lvdt", "verschiebung", "deplacement", "spostamento", "desplazamiento",
    ),
    "V": ("volt", "voltage", "spannung", "drive", "output"),
    "m/s^2": ("acc", "accel", "acceleration", "beschleunigung", "acel", "aceleracion"),
    "m/s": ("vel", "velocity", "speed", "geschwindigkeit", "vitesse", "velocidad"),
    "Pa": ("pressure", "druck", "mic", "microphone", "sound"),
})  # fmt: skip
"""How the words begin that name a quantity, by its SI unit, in small letters."""

_ELSE: Mapping[str, str] = MappingProxyType({
    "n": "a direction (north)",
    "m": "a position (middle)",
    "v": "a direction (vertical)",
    "g": "a position (ground)",
})
"""What a letter that is a unit may be else."""

_LETTER: Final = re.compile(r"(?P<stem>.+)_(?P<letter>[A-Za-z])")
_RANGE: Final = re.compile(r"(?:\u00b1|\+/?-|[-+<>~])?\s*\d+(?!\s*/\s*[A-Za-z]).*", re.DOTALL)
"""A number with what follows, but for ``1/s``: a full scale, a sensitivity, a serial number."""
_DIRECTION: Final = re.compile(
    r"[-+]?(?:r?[xyz]|[a-z])[-+]?|(?:north|south|east|west|up|down|vertical|horizontal|lateral|"
    r"axial|radial|tangential|longitudinal|transversal|left|right|top|bottom|front|rear|back|"
    r"middle|cent(?:er|re)|inner|outer)",
    re.IGNORECASE,
)

FREQUENCIES: Final = frozenset({
    "frequency",
    "freq",
    "freq.",
    "frequenz",
    "hz",
    "frecuencia",
    "fr\u00e9quence",
})
"""What the frequencies of spectra are called, in small letters."""

NO_NUMBERS: Final = "it holds no numbers"


@final
@dataclass(frozen=True, slots=True)
class Heading:
    """The heading of a column.

    Attributes
    ----------
    name : str
        Of the channel.
    unit : str
        As it stands there; empty where none does, or what does may be none.
    alias : str
        Another name that the channel answers to.
    doubt : str
        What may be a unit and is not taken for one, and why; empty for nothing.
    """

    name: str
    unit: str
    alias: str
    doubt: str = ""


def headings(headers: Sequence[str], unit_row: Sequence[str] = ()) -> tuple[Heading, ...]:
    """Return the heading of each column of a table.

    Parameters
    ----------
    headers : sequence of str
        Such as ``ch3 [g]`` or ``ch3_g``.
    unit_row : sequence of str
        Units, where they stand in a row of their own; else empty.

    Examples
    --------
    >>> [(h.name, h.unit) for h in headings(["time_s", "force_n", "ch3_g"])]
    [('time', 's'), ('force', 'N'), ('ch3', 'g')]
    >>> [(h.name, h.unit) for h in headings(["acc_N", "acc_E", "X (40g)"])]
    [('acc_N', ''), ('acc_E', ''), ('X (40g)', '')]
    """
    of_row = list(unit_row) or [""] * len(headers)
    endings = _HeaderEndings.of(headers)
    return tuple(
        Heading(header.strip(), unit.strip(), header)
        if unit.strip()
        else _heading(header, endings)
        for header, unit in zip(headers, of_row, strict=True)
    )


@final
@dataclass(frozen=True, slots=True)
class _HeaderEndings:
    """How the headers of a file end.

    Attributes
    ----------
    stems : frozenset of str
        What stands before a letter that ends a header and is no unit.
    units : frozenset of str
        Units that headers say; one is empty where a header says none.
    directions : bool
        Whether letters that are no units stand alone in brackets.
    """

    stems: frozenset[str]
    units: frozenset[str]
    directions: bool

    @classmethod
    def of(cls, headers: Sequence[str]) -> "_HeaderEndings":
        """Return how headers end."""
        ends = [match for h in headers if (match := _LETTER.fullmatch(h.strip()))]
        said = frozenset(split_header(header)[1] for header in headers)
        return cls(
            frozenset(e["stem"] for e in ends if e["letter"].casefold() not in {*_ELSE, "s"}),
            said,
            any(
                len(unit) == 1 and unit not in SECONDS and units.problem_of_unit(unit)
                for unit in said
            ),
        )


def _heading(header: str, endings: _HeaderEndings) -> Heading:
    """Return the heading of a column, read beside the other headers."""
    name, unit = split_header(header)
    bracket = header.rstrip().endswith((")", "]"))
    doubt = (_in_brackets if bracket else _at_end)(name, unit, endings) if unit else ""
    if doubt:
        return Heading(header.strip(), "", name, doubt)
    return Heading(name, unit, header)


def _in_brackets(name: str, unit: str, endings: _HeaderEndings) -> str:
    """Return why the text in brackets is no unit for sure; empty where it is one."""
    known, named = parse_unit(unit), quantity_named(name)
    if unit != "1" and _RANGE.fullmatch(unit):  # that is how a bare number is written
        return f"{shown(unit, 30)} in its header is taken for a range"
    if known is None:
        is_direction = (
            _DIRECTION.fullmatch(unit)
            and unit.casefold() not in _ELSE
            and units.problem_of_unit(unit)
        )
        return (
            f"{shown(unit, 30)} in its header is taken for a direction" if is_direction else ""
        )
    if unit.casefold() not in _ELSE or named == known[0]:
        return ""
    contrary = known[0] not in {"m/s^2", "V"} and named  # any quantity may be there in volts
    return _either(unit, "in its header") if endings.directions or contrary else ""


def _at_end(name: str, unit: str, endings: _HeaderEndings) -> str:
    """Return why a letter that ends a name is no unit for sure; empty where it is one.

    Letters are units where every header ends in one, of at least two.
    """
    known, named = parse_unit(unit), quantity_named(name)
    if unit.casefold() not in _ELSE or known is None or named == known[0]:
        return ""
    if unit == "g":
        sure = name not in endings.stems
    else:
        every = not endings.stems and "" not in endings.units and len(endings.units) > 1
        sure = every and not named
    return "" if sure else _either(unit, "at the end of its name")


def _either(unit: str, where: str) -> str:
    return f"{shown(unit)} {where} may be a unit or {_ELSE[unit.casefold()]}"


def quantity_named(name: str) -> str:
    """Return the SI unit of the quantity that a name says; empty where it says none.

    Examples
    --------
    >>> quantity_named("Kraft 1"), quantity_named("accX"), quantity_named("left")
    ('N', 'm/s^2', '')
    """
    words = re.findall(r"[a-z]+", name.casefold())
    return next(
        (
            unit
            for unit, starts in _QUANTITY_WORDS.items()
            for word in words
            if any(word == s or (len(s) > 2 and word.startswith(s)) for s in starts)
        ),
        "",
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class Columns:
    """A table.

    Attributes
    ----------
    headers : sequence of str
        What stands over each column, such as ``ch3 [g]``.
    values : (n_columns, n_rows) array
        Not a number where nothing stood.
    units : sequence of str
        Where they stand in a row of their own; else empty.
    """

    headers: Sequence[str]
    values: FloatArray
    units: Sequence[str] = ()


def file_of_columns(
    table: Columns,
    *,
    axes: Sequence[TimeAxis] = (),
    times: Mapping[int, Times] | None = None,
    start_time: datetime | None = None,
    cut: str = "",
    lengths: Sequence[int] = (),
    source: SampleSource | None = None,
    notes: Sequence[str] = (),
) -> RawFile:
    """Return a table as a file of one group; time columns are no channels.

    Where there are several, each is that of the columns behind it.

    Parameters
    ----------
    table : Columns
        The table.
    axes : sequence of TimeAxis
        What the file states of its times elsewhere.
    times : mapping, optional
        The times of a column, where the table holds only the first of them.
    start_time : datetime, optional
        When time 0 of the time columns is.
    cut : str
        How the file stops short; empty where it is whole.
    lengths : sequence of int
        Values of each column, where the table holds only the first of them.
    source : SampleSource, optional
        Where they come from then.
    notes : sequence of str
        What is odd about the file.
    """
    units = list(table.units) or [""] * len(table.headers)
    lengths = lengths or [length_of(row) for row in table.values]
    stated = _stated_rates(table, lengths)
    said = (*axes, *(
        TimeAxis(f"column {shown(table.headers[row])}", rate=rate)
        for row, rate in stated.items()
    ))  # fmt: skip
    timed = {
        row: (*said, axis_of_column(
            table.headers[row], units[row],
            (times or {}).get(row, table.values[row, : lengths[row]]),
        ))
        for row in time_columns(table.headers, units)
    }  # fmt: skip
    if not timed and is_frequency(table.headers[0], units[0], table.values[0, : lengths[0]]):
        where = f"column {shown(table.headers[0], 40)}"
        said = (*said, TimeAxis(where, quantity="Frequency", unit="Hz"))
    over = headings(table.headers, units if any(units) else ())
    reading = _Reading(table, over, units, lengths, timed, stated, said, start_time, bool(cut))
    channels = [reading.channel(row) for row in range(len(units)) if row not in timed]
    remarks = [remark for channel in channels if (remark := reading.remark(channel))]
    notes = [*notes, *([f"The file is not whole: {cut}."] if cut else []), *remarks]
    return RawFile(
        (RawGroup("", tuple(channels)),), source or ArraySource(table.values), tuple(notes)
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Reading:
    """A table whose columns become channels.

    Attributes
    ----------
    table : Columns
        The table.
    headings : sequence of Heading
        What stands over each column.
    units, lengths : sequence
        Unit and number of values of each column.
    timed : mapping
        What the file states of the times of the columns behind each time column.
    stated : mapping
        Columns that hold nothing but the sample rate, each with it [Hz].
    said : tuple of TimeAxis
        What it states without a time column.
    start_time : datetime, optional
        When time 0 of the time columns is.
    cut : bool
        Whether the file stops short.
    """

    table: Columns
    headings: Sequence[Heading]
    units: Sequence[str]
    lengths: Sequence[int]
    timed: Mapping[int, tuple[TimeAxis, ...]]
    stated: Mapping[int, float]
    said: tuple[TimeAxis, ...]
    start_time: datetime | None
    cut: bool

    def channel(self, row: int) -> RawChannel:
        """Return a column as a channel, with its problems."""
        heading, time = self.headings[row], self.time_of(row)
        return RawChannel(
            name=heading.name or f"column {row + 1}",
            row=row,
            n_samples=self.lengths[row],
            promised=self.until(row) + self.cut,
            unit=heading.unit,
            start_time=self.start_time,
            problem=self.problem(row),
            alias=heading.alias,
            unit_doubt=heading.doubt,
            axes=self.said if time is None else self.timed[time],
        )

    def time_of(self, row: int) -> int | None:
        """Return the time column before a column; where there is none, the first."""
        before = [time for time in self.timed if time < row]
        return next(iter(before[-1:] or list(self.timed)[:1]), None)

    def until(self, row: int) -> int:
        """Return how many values a column should hold: as many as its time column."""
        time, length = self.time_of(row), self.lengths[row]
        return max(self.lengths[time], length) if time is not None and length else length

    def problem(self, row: int) -> str:
        """Return why a column is no channel; empty where it is one."""
        if row in self.stated:
            return f"it says the sample rate, {self.stated[row]:g} Hz"
        length = self.lengths[row]
        if not length:
            return NO_NUMBERS
        header = self.table.headers[row] or f"column {row + 1}"
        return like_time(header, self.units[row], self.table.values[row, :length])

    def remark(self, channel: RawChannel) -> str:
        """Return a remark on a channel; empty where it is as it should be."""
        length, until = channel.n_samples, self.until(channel.row)
        if channel.problem and length:
            return f"{shown(channel.name)} is no channel: {channel.problem}."
        if length < until:
            return f"{shown(channel.name)} ends after {length} of {until} rows."
        return ""


def is_frequency(header: str, unit: str, values: FloatArray) -> bool:
    """Return whether a column is the abscissa of spectra: called a frequency, and it rises.

    `values` are in the unit, or in that of the header.
    """
    name, in_header = split_header(header)
    said = (unit.strip() or in_header).casefold()
    named = name.strip().casefold() in ({"f", "x", ""} if said == "hz" else set()) | FREQUENCIES
    return (
        named
        and said in {"", "hz", "khz"}
        and values.size > 1
        and bool(np.all(np.diff(values) > 0.0))
    )


def _stated_rates(table: Columns, lengths: Sequence[int]) -> dict[int, float]:
    """Return the columns that hold nothing but the sample rate, each with it [Hz]."""
    rates = {}
    for row, header in enumerate(table.headers):
        if RATE_NAME.fullmatch(split_header(header)[0].strip()):
            values = table.values[row, : lengths[row]]
            there = values[~np.isnan(values)]
            if there.size and there[0] > 0.0 and np.all(there == there[0]):
                rates[row] = float(there[0])
    return rates


def length_of(values: FloatArray) -> int:
    """Return the number of values up to the last one that is there.

    `values` may be in any unit.
    """
    there = np.flatnonzero(~np.isnan(values))
    return int(there[-1]) + 1 if there.size else 0


def is_number(text: str, decimal: str = ".") -> bool:
    """Return whether a cell holds a number."""
    if decimal == "," and "." in text:
        return False
    try:
        return not math.isinf(float(text.strip().replace(decimal, ".")))
    except ValueError:
        return False
