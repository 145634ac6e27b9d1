"""The head of a report for a customer: who asked for the tests, instruments, units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from shakerproc import units
from shakerproc.testlog.equipment import Instrument
from shakerproc.units import quoted

ChosenUnits = Mapping[str, tuple[str, float]]
"""Name of a unit and its size in SI, by the SI unit of the quantity."""

SI: Final = ("m/s^2", "m/s", "m", "N", "Pa", "V")
"""SI units of the quantities whose unit may be chosen, besides strain."""

_STRAIN: Final = ("µm/m", "m/m", "%")

MOST_BYTES: Final = 20_000_000
"""Largest photo of a specimen [byte]."""

MOST_OF_TEMPLATE: Final = 1_000_000
"""Largest template of a report [byte]."""


def chosen_units(words: Sequence[str]) -> ChosenUnits:
    """Return the units that a report shows.

    Parameters
    ----------
    words : sequence of str
        ``SI`` for all of it, or a unit for each quantity; a later one counts.

    Raises
    ------
    ValueError
        If a word is no unit of acceleration, velocity, displacement, force, pressure, voltage
        or strain.
    """
    found: dict[str, tuple[str, float]] = {}
    for word in words:
        if word.strip().casefold() == "si":
            found |= {unit: (_printed(unit), 1.0) for unit in SI} | {"1": ("m/m", 1.0)}
            continue
        kind = _kind(units.spelled(word.strip()))
        found[kind] = (_printed(word.strip()), units.to_si(f"1 {units.spelled(word)}", kind))
    return found


def _kind(unit: str) -> str:
    if unit in _STRAIN:
        return "1"
    known = [kind for kind in SI if units.problem_of_unit(unit) is None
             and units.is_unit_of(unit, kind)]  # fmt: skip
    if not known:
        raise ValueError(
            "expected SI, or units of acceleration, velocity, displacement, force, pressure, "
            f"voltage or strain such as g, in/s, mil, got {quoted(unit)}"
        )
    return known[0]


def _printed(unit: str) -> str:
    """Return a unit as people write it: ``in/s²`` for ``in/s^2``, ``µm`` for ``um``."""
    return {"um": "µm"}.get(unit, unit.replace("^2", "²").replace("s2", "s²"))


@final
@dataclass(frozen=True, slots=True)
class Header:
    """Entries of the log for the top of the report; empty text where it has none.

    Attributes
    ----------
    client, order, specimen, operator, standard : str
        One line each.
    photo : Path, optional
        Picture of the specimen.
    template : Path, optional
        Template of the report, in place of the usual one.
    instruments : tuple of Instrument
        In the order of the log.
    units : mapping
        Units that the report shows, as `chosen_units` returns them; empty for the usual ones.
    """

    client: str = ""
    order: str = ""
    specimen: str = ""
    operator: str = ""
    standard: str = ""
    photo: Path | None = None
    template: Path | None = None
    instruments: tuple[Instrument, ...] = ()
    units: ChosenUnits = field(default_factory=dict)


def checked_photo(path: Path) -> Path:
    """Return the path of a photo that is there and not too large.

    Raises
    ------
    ValueError
        If it is not.
    """
    if not path.is_file():
        raise ValueError(f"no file {path}; put the photo there, or take the key out")
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise ValueError(
            f"expected a photo of at most {MOST_BYTES / 1e6:g} MB, {path.name} has "
            f"{size / 1e6:.1f} MB; save it smaller"
        )
    return path


def checked_template(path: Path) -> Path:
    """Return the path of a template that is there and not too large.

    Raises
    ------
    ValueError
        If it is not.
    """
    if not path.is_file():
        raise ValueError(f"no file {path}; put the template there, or take the key out")
    size = path.stat().st_size
    if size > MOST_OF_TEMPLATE:
        raise ValueError(
            f"expected a template of at most {MOST_OF_TEMPLATE / 1e6:g} MB, {path.name} has "
            f"{size / 1e6:.1f} MB"
        )
    return path
