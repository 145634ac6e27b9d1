"""From the unit that stands in a file or in the log to SI."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Final, final

from shakerproc import units
from shakerproc.data import ROLE_UNITS, STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel

UNKNOWN: Final = "?"
"""Unit of a channel whose numbers are kept as they stand in the file."""

SI_UNITS: Final = (
    "m/s^2", "N", "m", "m/s", "V", "Pa", "C", "rad/s^2", "N m", "rad", "rad/s", "1"
)  # fmt: skip
"""Units that recordings are served in; a bare number stands last."""

_QUANTITIES: Final = {
    "m/s^2": "an acceleration",
    "N": "a force",
    "m": "a displacement",
    "m/s": "a velocity",
    "V": "a voltage",
    "Pa": "a pressure",
    "C": "a charge",
    "rad/s^2": "an angular acceleration",
    "N m": "a torque",
    "rad": "an angle",
    "rad/s": "an angular velocity",
    "1": "a strain",
}
_EXAMPLES: Final = {
    "m/s^2": "g", "N": "N", "m": "mm", "m/s": "m/s", "V": "V", "Pa": "Pa", "1": "µm/m",
    "rad/s^2": "rad/s^2", "N m": "N m", "rad": "deg", "rad/s": "rpm",
}  # fmt: skip
_SENSITIVITIES: Final = {
    "m/s^2": "100 mV/g", "N": "10 mV/N", "m": "1 V/mm", "m/s": "1 V/(m/s)", "V": "10 V/V",
    "Pa": "50 mV/Pa", "1": "1 V/(mm/m)", "rad/s^2": "1 mV/(rad/s^2)", "N m": "10 mV/(N m)",
    "rad": "1 V/rad", "rad/s": "1 mV/(rad/s)",
}  # fmt: skip

_USUAL: Final = (
    "g", "mg", "m/s^2", "mm/s^2", "m/s", "mm/s", "mm", "µm", "um", "m", "kN", "N", "mV", "V",
    "kPa", "Pa",
)  # fmt: skip
"""Units that measuring programs write in capital letters too."""

_NO_UNIT: Final = frozenset({
    "-", "--", "?", "a.u.", "amplitude", "arb", "au", "eu", "n/a", "na", "none", "unit",
    "units", "unknown", "value",
})  # fmt: skip
"""What measuring programs write where they know no unit, in small letters."""

_NAMES: Mapping[str, str] = MappingProxyType({
    "acceleration": "m/s^2",
    "accel": "m/s^2",
    "force": "N",
    "displacement": "m",
    "position": "m",
    "velocity": "m/s",
    "voltage": "V",
    "pressure": "Pa",
    "strain": "1",
    "torque": "N m",
    "moment": "N m",
    "angle": "rad",
    "rotation": "rad",
    "angular velocity": "rad/s",
    "angular acceleration": "rad/s^2",
})
"""Quantities that stand where a unit should, and the SI unit of each."""


@final
@dataclass(frozen=True, slots=True)
class UnitScale:
    """How numbers of a file become SI.

    Attributes
    ----------
    unit : str
        SI unit, or `UNKNOWN`.
    factor : float
        SI units in a unit of the file.
    said : str
        The unit of the numbers, as the file or the log has it.
    note : str
        What had to be decided; empty where nothing had.
    """

    unit: str
    factor: float
    said: str
    note: str = ""


@lru_cache(maxsize=256)
def parse_unit(text: str) -> tuple[str, float] | None:
    """Return SI unit and factor of a unit, or None where it measures nothing known here."""
    plain = units.spelled(text)
    if plain == "g":
        return "m/s^2", STANDARD_GRAVITY
    if plain in SI_UNITS[:-1]:
        return plain, 1.0
    if not plain or not units.is_linear(plain):
        return None
    for unit in SI_UNITS:
        try:
            return unit, units.to_si(f"1 {plain}", unit)
        except ValueError:
            continue
    return None


def parse_numbered(text: str) -> tuple[str, float] | None:
    """Return SI unit and factor of a count by the log, such as ``g`` or ``10 V``.

    Only a log speaks so: with a number before it, what a file says is the range of a channel.
    """
    number, unit = units.numbered(text)
    known = parse_unit(unit)
    return None if known is None else (known[0], number * known[1])


def likely_unit(text: str) -> str:
    """Return the unit that one in other letters stands for; empty where it may be none.

    Examples
    --------
    >>> likely_unit("G"), likely_unit("KN"), likely_unit("Deg C"), likely_unit("kN")
    ('g', 'kN', '', '')
    """
    plain = text.strip()
    if not plain or parse_unit(plain) is not None:
        return ""
    return next((u for u in _USUAL if u.casefold() == plain.casefold()), "")


def quantity_of(text: str) -> str:
    """Return the SI unit of a text that stands for a unit in a file.

    Empty where it says nothing, `UNKNOWN` where it says what is not known here.

    Examples
    --------
    >>> quantity_of("g"), quantity_of("Acceleration"), quantity_of("EU"), quantity_of("lx")
    ('m/s^2', 'm/s^2', '', '?')
    """
    word, known = text.strip().casefold(), parse_unit(text)
    if not word or word in _NO_UNIT:
        return ""
    return _NAMES.get(word, UNKNOWN) if known is None else known[0]


def contradicts(file: str, unit: str) -> bool:
    """Return whether numbers cannot be in a unit if the file is right about theirs.

    A file that says none, or only what is measured, leaves the unit open.

    Examples
    --------
    >>> contradicts("m/s2", "m/s^2"), contradicts("EU", "g"), contradicts("Acceleration", "g")
    (False, False, False)
    >>> contradicts("g", "m/s^2"), contradicts("Pa", "g"), contradicts("Deg C", "g")
    (True, True, True)
    >>> contradicts("G", "g"), contradicts("G", "m/s^2")
    (False, True)
    >>> contradicts("V", "10 V")
    True
    """
    file = likely_unit(file) or file
    file_unit, other, quantity = parse_unit(file), parse_numbered(unit), quantity_of(file)
    if not quantity or other is None:
        return False
    return quantity != other[0] or (
        file_unit is not None and abs(file_unit[1] / other[1] - 1.0) > 1e-9
    )


def scale_of(channel: RawChannel, use: ChannelUse | None, run: str) -> UnitScale:
    """Return how the numbers of a channel become SI.

    Raises
    ------
    RecordingError
        If the file and the log together do not say it, or contradict each other.
    """
    if use is None or use.role == "ignore":
        known = parse_unit(channel.unit)
        return (
            UnitScale(UNKNOWN, 1.0, channel.unit)
            if known is None
            else UnitScale(*known, channel.unit)
        )
    wanted = _unit_of_role(channel, use)
    if use.sensitivity is None and use.unit is None:
        known = parse_unit(channel.unit)
        if known is None or known[0] != wanted:
            raise RecordingError(_unusable(channel, use, wanted, run))
        return UnitScale(*known, channel.unit)
    given = _by_unit if use.sensitivity is None else _by_sensitivity
    scale = given(channel, use, wanted, run)
    if contradicts(channel.unit, use.unit or scale.said) and not use.override:
        raise RecordingError(_contradiction(channel, use, wanted, run))
    return replace(scale, note=_followed(channel, use, scale.said))


def _unit_of_role(channel: RawChannel, use: ChannelUse) -> str:
    """Return which of the SI units of its role a channel measures, by log and file.

    The first, of translation, where neither says one of them.
    """
    fit = ROLE_UNITS[use.role]
    if use.sensitivity is not None:
        return next((u for u in fit if units.fits_sensitivity(use.sensitivity, u)), fit[0])
    known = parse_numbered(use.unit) if use.unit else parse_unit(channel.unit)
    return known[0] if known is not None and known[0] in fit else fit[0]


def _is_electrical(unit: str) -> bool:
    known = parse_unit(unit)
    return known is not None and known[0] in {"V", "C"}


def _entry(use: ChannelUse, *what: str) -> str:
    """Return an entry of the log for a channel, with these keys beside its role."""
    key = use.key if isinstance(use.key, int) else f'"{use.key}"' if ":" in use.key else use.key
    return f"channels: {{{key}: {{{', '.join((f'role: {use.role}', *what))}}}}}"


def _unit_of_log(use: ChannelUse) -> list[str]:
    """Return unit and sensitivity as they stand in the log."""
    pairs = (("unit", use.unit), ("sensitivity", use.sensitivity))
    return [f"{key}: {value}" for key, value in pairs if value is not None]


def _contradiction(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> str:
    given = _unit_of_log(use)
    return (
        f"{run}: channel {shown(channel.name)} is in {shown(channel.unit, 30)} in the file but "
        f"{', '.join(given)} in the log. In the log, {_by_the_file(channel, use, wanted)}; or, "
        f"where the file is wrong, write {_entry(use, *given, 'override: true')}."
    )


def _by_the_file(channel: RawChannel, use: ChannelUse, wanted: str) -> str:
    """Return the remedy in the log for the case that the file is right."""
    known, given = (
        parse_unit(channel.unit),
        [text.partition(":")[0] for text in _unit_of_log(use)],
    )
    if known is not None and known[0] == wanted:
        return f"take {' and '.join(given)} out"
    if _is_electrical(channel.unit) and use.sensitivity is not None:
        return "take unit out"
    if known is not None and known[0] == "V":
        entry = _entry(use, f"sensitivity: {_SENSITIVITIES[wanted]}")
        return f"say what a volt stands for, such as {entry}"
    fitting = [
        role
        for role, fit in ROLE_UNITS.items()
        if known is not None and known[0] in fit and role != "condition"  # that is any quantity
    ]
    return "give it " + " or ".join(f"role: {role}" for role in [*fitting, "ignore"])


def _followed(channel: RawChannel, use: ChannelUse, said: str) -> str:
    """Return a note where the file does not say the same as the log in other words."""
    if not channel.unit.strip():
        return ""
    known = parse_unit(channel.unit)
    if known is not None and not contradicts(channel.unit, said):
        return ""
    return (
        f"Channel {shown(channel.name)}: the file says {shown(channel.unit, 30)}, the log says "
        f"{', '.join(_unit_of_log(use))}; the log is followed."
    )


def _unusable(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> str:
    said = f"is in {shown(channel.unit, 30)}" if channel.unit else "has no unit"
    doubt = channel.unit_doubt or _offered(channel.unit)
    said += f" ({doubt})" if doubt else ""
    unit = f"unit: {_EXAMPLES[wanted]}"
    if contradicts(channel.unit, _EXAMPLES[wanted]):
        entry = _entry(use, unit, "override: true")
        advice = (
            f"In the log, {_by_the_file(channel, use, wanted)}; or, where the file is wrong, "
            f"say what its numbers are, such as {entry}"
        )
    else:
        advice = (
            f"Put what its numbers are in the log, such as {_entry(use, unit)}, or "
            f"unit: V, sensitivity: {_SENSITIVITIES[wanted]} for volts"
        )
    if channel.unit.strip().casefold().startswith("db"):
        said += ", which no time samples are,"
    return (
        f"{run}: channel {shown(channel.name)} {said} but is used as {use.role}, which takes "
        f"{_QUANTITIES[wanted]}. {advice}."
    )


def doubtful_units(chosen: Sequence[tuple[RawChannel, ChannelUse | None]]) -> list[str]:
    """Return a note for each way in which channels that nobody gives a unit may have one."""
    by_doubt: dict[str, list[str]] = {}
    for channel, use in chosen:
        doubt = channel.unit_doubt or _offered(channel.unit)
        if doubt and (use is None or use.role == "ignore"):
            by_doubt.setdefault(doubt, []).append(shown(channel.name))
    return [
        f"No known unit: {', '.join(names[:8])}"
        f"{f' and {len(names) - 8} more' if len(names) > 8 else ''} ({doubt}). Say the unit in "
        "the log, or with --unit."
        for doubt, names in by_doubt.items()
    ]


def _offered(unit: str) -> str:
    """Return the likely meaning of an unknown unit; empty where no unit is near."""
    likely = likely_unit(unit)
    if likely:
        return f"{shown(unit, 30)} may be {likely}"
    first = unit.split(maxsplit=1)[0] if " " in unit.strip() else ""
    if parse_unit(unit) is None and parse_unit(first) is not None:
        return f"{shown(unit, 30)} may be {first}"
    return ""


def _by_unit(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> UnitScale:
    text = use.unit or ""
    known = parse_numbered(text)
    if known is None or known[0] != wanted:
        volts = known is not None and known[0] == "V"
        more = f"; for volts add sensitivity: {_SENSITIVITIES[wanted]}" if volts else ""
        raise RecordingError(
            f"{run}: channel {shown(channel.name)}: the log gives the unit {shown(text, 30)}, "
            f"but role {use.role} takes {_QUANTITIES[wanted]}, such as {_EXAMPLES[wanted]}"
            f"{more}."
        )
    return UnitScale(*known, units.numbered(text)[1])


def _by_sensitivity(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> UnitScale:
    text = use.sensitivity or ""
    try:
        electrical, sensitivity = units.sensitivity(text, wanted)
    except ValueError as error:
        raise RecordingError(
            f"{run}: channel {shown(channel.name)}: sensitivity: {error}. "
            f"Write it as {_SENSITIVITIES[wanted]}."
        ) from error
    if not sensitivity:
        raise RecordingError(f"{run}: channel {shown(channel.name)}: a sensitivity of 0.")
    said = use.unit or (channel.unit if _is_electrical(channel.unit) else electrical)
    output = parse_numbered(said)
    if output is None or output[0] != electrical:
        raise RecordingError(
            f"{run}: channel {shown(channel.name)}: the log gives its scale twice, unit: "
            f"{said} and sensitivity: {text}. Take the sensitivity out if the numbers are in "
            f"{said}; write unit: {electrical} beside it if they are "
            f"{'volts' if electrical == 'V' else 'a charge'}."
        )
    return UnitScale(wanted, output[1] / sensitivity, units.numbered(said)[1])


_IN_BRACKETS: Final = re.compile(
    r"(?P<name>.*?)\s*[\[(]\s*(?P<unit>[^\[\]()]*)\s*[\])]\s*", re.DOTALL
)
_SUFFIXES: Mapping[str, str] = MappingProxyType({
    "_m_per_s2": "m/s^2",
    "_mm_per_s2": "mm/s^2",
    "_m_per_s": "m/s",
    "_mm_per_s": "mm/s",
    "_um": "um",
    "_mm": "mm",
    "_kn": "kN",
    "_mv": "mV",
    "_g": "g",
    "_m": "m",
    "_n": "N",
    "_v": "V",
    "_ms": "ms",
    "_s": "s",
})


@lru_cache(maxsize=1 << 16)
def split_header(header: str) -> tuple[str, str]:
    """Return name and unit of a header such as ``ch3 [g]`` or ``ch3_g``; unit may be empty.

    Examples
    --------
    >>> split_header("control 1 [g]"), split_header("ch3_m_per_s2"), split_header("ch3")
    (('control 1', 'g'), ('ch3', 'm/s^2'), ('ch3', ''))
    """
    match = _IN_BRACKETS.fullmatch(header)
    if match and match["name"].strip():
        return match["name"].strip(), match["unit"].strip()
    for suffix, unit in _SUFFIXES.items():
        if header.casefold().endswith(suffix) and len(header) > len(suffix):
            return header[: -len(suffix)], unit
    return header.strip(), ""
