"""Parts of a log besides its tests: the customer, specimens, shaker, instruments, units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from shakerproc import units
from shakerproc.data import told_days
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


@final
@dataclass(frozen=True, slots=True)
class Shaker:
    """Limits of the shaker, zero to peak; None is not known.

    Attributes
    ----------
    stroke : float, optional
        Travel of the table from end to end [m].
    velocity : float, optional
        [m/s].
    acceleration : float, optional
        [m/s²].
    force : float, optional
        [N].
    moving_mass : float, optional
        Armature, fixture and specimen, which the force has to move [kg].
    """

    stroke: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    force: float | None = None
    moving_mass: float | None = None


@final
@dataclass(frozen=True, slots=True)
class Specimen:
    """Measured dimensions of a coupon and the bushing it was tested with.

    Attributes
    ----------
    joint, name : str
        As the tests name it.
    nominal : float, optional
        Clearance on the drawing, hole less bushing [m].
    actual : float, optional
        Clearance as measured, hole less bushing [m]; play either way is half of it.
    actual_axial : float, optional
        Play out of plane as measured, bushing less coupon thickness [m].
    material, comment : str
        What else is known.
    """

    joint: str
    name: str
    nominal: float | None = None
    actual: float | None = None
    actual_axial: float | None = None
    material: str = ""
    comment: str = ""


@final
@dataclass(frozen=True, slots=True)
class Instrument:
    """An instrument and its calibration.

    Attributes
    ----------
    name : str
        What it is.
    serial : str
        Its serial number.
    calibrated, valid_until : str
        Days, as 2026-03-31; empty where the log says none.
    """

    name: str
    serial: str = ""
    calibrated: str = ""
    valid_until: str = ""

    @property
    def told(self) -> str:
        """A sentence part for people."""
        serial = f", serial number {self.serial}" if self.serial else ""
        return f"{self.name}{serial}{told_days(self.calibrated, self.valid_until)}"


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
    return _checked(path, "photo", MOST_BYTES, "; save it smaller")


def checked_template(path: Path) -> Path:
    """Return the path of a template that is there and not too large.

    Raises
    ------
    ValueError
        If it is not.
    """
    return _checked(path, "template", MOST_OF_TEMPLATE, "")


def _checked(path: Path, what: str, most: int, advice: str) -> Path:
    """Return the path of a file that is there and has at most so many bytes.

    Raises
    ------
    ValueError
        If it is not.
    """
    if not path.is_file():
        raise ValueError(f"no file {path}; put the {what} there, or take the key out")
    size = path.stat().st_size
    if size > most:
        raise ValueError(
            f"expected a {what} of at most {most / 1e6:g} MB, {path.name} has "
            f"{size / 1e6:.1f} MB{advice}"
        )
    return path
