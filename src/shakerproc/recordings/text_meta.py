"""Lines above a table that say a number of it rather than hold a row: a rate, a start, a count.

They stand as ``Sample Rate (Hz),2000``, as ``# fs = 2000 Hz`` or as ``Interval: 0.5 ms``.
"""

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

from shakerproc.recordings.guard import shown
from shakerproc.recordings.rates import RATE_NAME, RATE_WORD, STEP_NAME, STEP_WORD
from shakerproc.recordings.si import split_header
from shakerproc.recordings.time_axis import TimeAxis, half_digit

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

_HERTZ: Mapping[str, float] = MappingProxyType({
    "": 1.0, "hz": 1.0, "1/s": 1.0, "s/s": 1.0, "sps": 1.0, "khz": 1e3, "ks/s": 1e3,
    "ksps": 1e3, "mhz": 1e6, "ms/s": 1e6,
})  # fmt: skip


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
    """Return what the lines above a table state of the times of its rows."""
    found = []
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
            found.append(TimeAxis(where, rate=rate, problem=problem))
        elif STEP_NAME.fullmatch(name) or STEP_WORD.fullmatch(name):
            digit = half_digit(text)
            found.append(TimeAxis(where, step=float(text), unit=unit, digit=digit))
    return tuple(found)
