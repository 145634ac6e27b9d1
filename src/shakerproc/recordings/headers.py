"""Names, units and rates in the headers of a file, and where a letter may be no unit."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, final

from shakerproc import units
from shakerproc.recordings.guard import shown
from shakerproc.recordings.si import parse_unit, split_header
from shakerproc.recordings.times import SECONDS

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


@final
@dataclass(frozen=True, slots=True)
class Heading:
    """What stands over a column.

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
    """Return what stands over each column of a table.

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
    beside = _Beside.of(headers)
    return tuple(
        Heading(header.strip(), unit.strip(), header)
        if unit.strip()
        else _heading(header, beside)
        for header, unit in zip(headers, of_row, strict=True)
    )


@final
@dataclass(frozen=True, slots=True)
class _Beside:
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
    def of(cls, headers: Sequence[str]) -> "_Beside":
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


def _heading(header: str, beside: _Beside) -> Heading:
    """Return what a header says beside the others."""
    name, unit = split_header(header)
    bracket = header.rstrip().endswith((")", "]"))
    doubt = (_in_brackets if bracket else _at_end)(name, unit, beside) if unit else ""
    if doubt:
        return Heading(header.strip(), "", name, doubt)
    return Heading(name, unit, header)


def _in_brackets(name: str, unit: str, beside: _Beside) -> str:
    """Return why what stands in brackets is no unit for sure; empty where it is one."""
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
    return _either(unit, "in its header") if beside.directions or contrary else ""


def _at_end(name: str, unit: str, beside: _Beside) -> str:
    """Return why a letter that ends a name is no unit for sure; empty where it is one.

    Letters are units where every header ends in one, of at least two.
    """
    known, named = parse_unit(unit), quantity_named(name)
    if unit.casefold() not in _ELSE or known is None or named == known[0]:
        return ""
    if unit == "g":
        sure = name not in beside.stems
    else:
        every = not beside.stems and "" not in beside.units and len(beside.units) > 1
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
