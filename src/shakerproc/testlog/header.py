"""Parts of a log besides its tests: the customer, specimens, shaker, instruments, limits."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

from shakerproc import units
from shakerproc.data import ChannelUse, calibration_days
from shakerproc.testlog.fields import MisfitError
from shakerproc.units import is_unit_of, near_miss, numbered, quoted, to_si

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
    def sentence(self) -> str:
        """A sentence part for people."""
        serial = f", serial number {self.serial}" if self.serial else ""
        return f"{self.name}{serial}{calibration_days(self.calibrated, self.valid_until)}"


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
    units_by_kind: dict[str, tuple[str, float]] = {}
    for word in words:
        if word.strip().casefold() == "si":
            units_by_kind |= {unit: (_printed(unit), 1.0) for unit in SI} | {"1": ("m/m", 1.0)}
            continue
        kind = _kind(units.spelled(word.strip()))
        units_by_kind[kind] = (
            _printed(word.strip()),
            units.to_si(f"1 {units.spelled(word)}", kind),
        )
    return units_by_kind


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


Whose: TypeAlias = Literal["response", "joint", "force", "shaker"]
Statistic: TypeAlias = Literal["peak", "rms"]

_RESPONSES: Final = ("m/s^2", "m/s", "m", "N", "rad/s^2", "rad/s", "rad", "N m")
_JOINTS: Final = ("m", "N", "rad", "N m")
_FORCES: Final = ("N", "N m")
_SHAKER: Final[Mapping[str, str]] = MappingProxyType({
    "force": "N", "displacement": "m", "velocity": "m/s", "acceleration": "m/s^2",
})  # fmt: skip
_ENDING: Final = re.compile(r"[\s_]+(peak|rms)\s*$", re.IGNORECASE)


@final
@dataclass(frozen=True, slots=True)
class Limit:
    """A value that a planned test must not exceed.

    Attributes
    ----------
    whose : {"response", "joint", "force", "shaker"}
        A channel, a joint, the force into the specimen, or the shaker.
    name : str
        Name of the channel, places of the joint as ``base-coupon``, or quantity of the shaker;
        empty for the force.
    statistic : {"peak", "rms"}
        Largest size in the whole duration, or root mean square.
    value : float
        In `unit`.
    unit : str
        SI unit of the quantity.
    key : tuple of (str or int)
        Where it stands below ``limits:`` in the log.
    """

    whose: Whose
    name: str
    statistic: Statistic
    value: float
    unit: str
    key: tuple[str | int, ...]


def limits_of(
    section: Mapping[str, object], channels: Sequence[ChannelUse]
) -> tuple[Limit, ...]:
    """Return the limits of a log.

    Parameters
    ----------
    section : mapping
        What stands below ``limits:``.
    channels : sequence of ChannelUse
        Those of the log; none where it names none.

    Raises
    ------
    MisfitError
        If a limit has no unit, or its channel is none of the log's.
    """
    limits: list[Limit] = []
    for key, written in section.items():
        if key == "shaker":
            limits += _of_shaker(written)
            continue
        whose, name, units = _named(key)
        if whose == "response":
            _check_channel(key, channels)
        if isinstance(written, list | tuple):
            limits += [
                _limit(whose, name, one, units, (key, i)) for i, one in enumerate(written)
            ]
        else:
            limits.append(_limit(whose, name, written, units, (key,)))
    return tuple(limits)


def _named(key: str) -> tuple[Whose, str, tuple[str, ...]]:
    """Return the object of a key, its name, and the units that a limit may have."""
    if key == "force":
        return "force", "", _FORCES
    if key.startswith("joint "):
        return "joint", key.removeprefix("joint ").strip(), _JOINTS
    return "response", key, _RESPONSES


def _of_shaker(written: object) -> list[Limit]:
    """Return the limits of the shaker.

    Raises
    ------
    MisfitError
        If a key is none of those that there are.
    """
    if not isinstance(written, Mapping):
        raise MisfitError(
            "expected keys such as {force: 9 kN, displacement: 25 mm, velocity: 1.8 m/s}",
            "shaker",
        )
    unknown = [str(name) for name in written if name not in _SHAKER]
    if unknown:
        known = ", ".join(_SHAKER)
        raise MisfitError(f"expected one of {known}, got {quoted(unknown[0])}", "shaker")
    return [
        _limit("shaker", str(name), value, (_SHAKER[name],), ("shaker", str(name)))
        for name, value in written.items()
    ]


def _limit(
    whose: Whose, name: str, written: object, units: Sequence[str], key: tuple[str | int, ...]
) -> Limit:
    """Return a limit in SI.

    Raises
    ------
    MisfitError
        If it is no positive number with one of the units.
    """
    text = str(written) if isinstance(written, int | float) else written
    if not isinstance(text, str):
        raise MisfitError(f"expected a limit such as 40 g peak, got {quoted(written)}", *key)
    ending = _ENDING.search(text)
    plain = text[: ending.start()] if ending else text
    unit = numbered(plain)[1].strip()
    wanted = next((one for one in units if unit != plain and is_unit_of(unit, one)), units[0])
    try:
        value = to_si(plain, wanted)
    except ValueError as error:
        raise MisfitError(str(error), *key) from error
    if not value > 0.0:
        raise MisfitError(f"expected more than 0, got {quoted(text)}", *key)
    statistic: Statistic = "rms" if ending and ending[1].lower() == "rms" else "peak"
    return Limit(whose, name, statistic, value, wanted, key)


def _check_channel(name: str, channels: Sequence[ChannelUse]) -> None:
    """Pass a channel that the log names.

    Raises
    ------
    MisfitError
        If it names others only.
    """
    used = [use for use in channels if use.role != "ignore"]
    known = [str(use.name or use.key) for use in used]
    if not known or name in {*known, *(str(use.key) for use in used)}:
        return
    meant = near_miss(name, [*known, "shaker", "force"])
    question = (
        f"; did you mean {quoted(meant)}?" if meant else f"; the log has {', '.join(known)}"
    )
    kinds = 'a channel, "joint base-coupon", force or shaker'
    raise MisfitError(f"expected {kinds}, got {quoted(name)}{question}", name)
