"""Numbers, labels and sentences of a report in the units that a person chose for it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, final

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.runs.result import shown_ratio, shown_unit
from shakerproc.testlog import ChosenUnits

WRITTEN: Final = {
    "m/s²": ("m/s^2", 1.0), "m/s^2": ("m/s^2", 1.0), "g": ("m/s^2", STANDARD_GRAVITY),
    "mm/s": ("m/s", 1e-3), "m/s": ("m/s", 1.0), "µm/m": ("1", 1e-6), "mm": ("m", 1e-3),
    "µm": ("m", 1e-6), "nm": ("m", 1e-9), "m": ("m", 1.0), "N m": ("N m", 1.0), "N": ("N", 1.0),
    "Pa": ("Pa", 1.0), "V": ("V", 1.0), "rad/s²": ("rad/s^2", 1.0), "rad/s^2": ("rad/s^2", 1.0),
    "rad/s": ("rad/s", 1.0), "mrad": ("rad", 1e-3), "rad": ("rad", 1.0),
    "m/m": ("1", 1.0),
}  # fmt: skip
"""What the program writes for units: the SI unit of the quantity, and the size in it."""

READ: Final = {"m": ("mm", 1e-3), "rad": ("mrad", 1e-3)}
"""Units of motion that people read where none is chosen, by what tables have: name and size."""

_ATOM: Final = (
    "(?<![A-Za-zµ])(?:"
    + "|".join(re.escape(unit) for unit in sorted(WRITTEN, key=len, reverse=True))
    + ")(?![A-Za-z])"
)
_FACTOR: Final = re.compile(
    rf"(?P<over>/)?(?P<open>\()?(?P<atom>{_ATOM})(?P<close>\))?(?P<power>²|\^[\d.]+)?"
)
_UNIT: Final = rf"\(?{_ATOM}\)?(?:²|\^\d[\d.]*)?(?:/\(?[A-Za-zµ²/]+\)?²?)*(?![\w/²^])"
_NUMBER: Final = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_QUANTITY: Final = rf"(?<![\w.])(?P<first>{_NUMBER})(?: (?P<word>to|and) (?P<last>[+-]?{_NUMBER}))? (?P<unit>{_UNIT})"  # noqa: E501
_LABEL: Final = re.compile(r"\[([^\]]*)\]$")

LEAST_DIGITS: Final = 4
"""Digits of a number of a sentence in another unit, at least."""


@final
@dataclass(frozen=True, slots=True)
class ShownUnits:
    """The units of a report.

    Attributes
    ----------
    chosen : mapping
        As `chosen_units` returns them; a quantity without one keeps its own, but for `READ`.
    """

    chosen: ChosenUnits = field(default_factory=dict)

    def unit(self, unit: str) -> tuple[str, float]:
        """Return the unit that a report writes for one of these, and its number in one of it.

        Powers and ratios follow: ``g²/Hz`` becomes ``(m/s²)²/Hz``, 96.17 of them.
        """
        factor = 1.0

        def other(match: re.Match[str]) -> str:
            nonlocal factor
            kind, size = WRITTEN[match["atom"]]
            own = READ.get(match["atom"], (match["atom"], size))
            name, wanted = self.chosen.get(kind, own)
            if name == match["atom"]:
                return match[0]
            raised = _power(match["power"] or "")
            factor *= (size / wanted) ** (-raised if match["over"] else raised)
            both = match["open"] and match["close"]
            beside = both or match["power"] or match["over"] or unit[match.end() :][:1] == "/"
            composed = "/" in name and bool(beside)
            name = f"({name})" if composed else name
            ends = ("", "") if both else (match["open"] or "", match["close"] or "")
            return f"{match['over'] or ''}{ends[0]}{name}{ends[1]}{match['power'] or ''}"

        return _FACTOR.sub(other, unit), factor

    def label(self, label: str) -> tuple[str, float]:
        """Return a label with its unit in brackets at the end, and the factor to that unit."""
        match = _LABEL.search(label)
        if match is None:
            return label, 1.0
        unit, factor = self.unit(match[1])
        return f"{label[: match.start()]}[{unit}]", factor

    def text(self, text: str, kept: Sequence[str] = ()) -> str:
        """Return a sentence with its quantities in the units of the report.

        Parameters
        ----------
        text : str
            What the program wrote, such as ``0.5 g at 20 Hz``.
        kept : sequence of str
            Words of the log in it, such as names of channels, that stay as they are.
        """
        names = "|".join(re.escape(n) for n in sorted(set(kept), key=len, reverse=True) if n)
        whole = rf"(?P<kept>(?<!\w)(?:{names})(?!\w))|{_QUANTITY}" if names else _QUANTITY
        return re.sub(whole, self._quantity, text)

    def _quantity(self, match: re.Match[str]) -> str:
        if match["unit"] is None:
            return match[0]
        unit, factor = self.unit(match["unit"])
        if unit == match["unit"]:
            return match[0]
        first = _scaled(match["first"], factor)
        if match["last"] is None:
            return f"{first} {unit}"
        return f"{first} {match['word']} {_scaled(match['last'], factor)} {unit}"


USUAL: Final = ShownUnits()
"""No unit is chosen: g, m/s, mm and what the tables have."""


def read_unit(unit: str) -> tuple[str, float]:
    """Return the unit that figures have for an SI unit, and the factor to it."""
    table, factor = shown_unit(unit)
    shown, further = USUAL.unit(table)
    return shown, factor * further


def read_ratio(output: str, over: str) -> tuple[str, float]:
    """Return the unit that figures have for one SI unit over another, and the factor to it.

    Empty where both are the same.
    """
    table, factor = shown_ratio(output, over)
    shown, further = USUAL.unit(table)
    return shown, factor * further


def _power(written: str) -> float:
    """Return the power that stands behind a unit: ``²``, ``^6.4`` or nothing."""
    if written.startswith("^"):
        return float(written[1:])
    return 2.0 if written else 1.0


def _scaled(number: str, factor: float) -> str:
    digits = sum(c.isdigit() for c in number.partition("e")[0].lstrip("0."))
    return f"{float(number) * factor:.{max(digits, LEAST_DIGITS)}g}"
