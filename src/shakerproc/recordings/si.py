"""From the unit that stands in a file or in the log to SI."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Final, final

from shakerproc import units
from shakerproc.data import STANDARD_GRAVITY, ChannelUse, Role
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel

UNKNOWN: Final = "?"
"""Unit of a channel whose numbers are served as they stand in the file."""

SI_UNITS: Final = ("m/s^2", "N", "m", "m/s", "V", "1")

ROLE_UNITS: Mapping[Role, str] = MappingProxyType({
    "control": "m/s^2",
    "response": "m/s^2",
    "force": "N",
    "displacement": "m",
    "velocity": "m/s",
})

_QUANTITIES: Final = {
    "m/s^2": "an acceleration",
    "N": "a force",
    "m": "a displacement",
    "m/s": "a velocity",
    "V": "a voltage",
    "1": "a ratio",
}
_EXAMPLES: Final = {"m/s^2": "g", "N": "N", "m": "mm", "m/s": "m/s"}
_SENSITIVITIES: Final = {"m/s^2": "100 mV/g", "N": "10 mV/N", "m": "1 V/mm", "m/s": "1 V/(m/s)"}

_SPELLINGS: Mapping[str, str] = MappingProxyType({
    "volt": "V",
    "volts": "V",
    "millivolts": "mV",
    "g's": "g",
    "gs": "g",
    "gn": "g",
    "g_n": "g",
    "gravity": "g",
    "newton": "N",
    "newtons": "N",
    "metre": "m",
    "meter": "m",
    "meters": "m",
    "m/s/s": "m/s^2",
    "m/s2": "m/s^2",
    "m/s**2": "m/s^2",
    "m/sec^2": "m/s^2",
    "mm/s2": "mm/s^2",
    "inch": "in",
    "inches": "in",
})
"""What measuring programs write for a unit, in small letters."""


@final
@dataclass(frozen=True, slots=True)
class Scale:
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
    plain = _SPELLINGS.get(text.strip().casefold(), text.strip())
    if plain == "g":
        return "m/s^2", STANDARD_GRAVITY
    if plain in SI_UNITS[:-1]:
        return plain, 1.0
    if not plain:
        return None
    for unit in SI_UNITS:
        try:
            return unit, units.to_si(f"1 {plain}", unit)
        except ValueError:
            continue
    return None


def scale_of(channel: RawChannel, use: ChannelUse | None, run: str) -> Scale:
    """Return how the numbers of a channel become SI.

    Raises
    ------
    RecordingError
        If the file and the log together do not say it, or contradict each other.
    """
    if use is None or use.role == "ignore":
        known = parse_unit(channel.unit)
        return (
            Scale(UNKNOWN, 1.0, channel.unit) if known is None else Scale(*known, channel.unit)
        )
    wanted = ROLE_UNITS[use.role]
    if use.sensitivity is not None:
        return _by_sensitivity(channel, use, wanted, run)
    if use.unit is not None:
        return _by_log(channel, use.unit, wanted, use, run)
    known = parse_unit(channel.unit)
    if known is not None and known[0] == wanted:
        return Scale(*known, channel.unit)
    raise RecordingError(_unusable(channel, use, wanted, run))


def _unusable(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> str:
    said = f"is in {shown(channel.unit, 30)}" if channel.unit else "has no unit"
    key = use.key if isinstance(use.key, int) else f'"{use.key}"' if ":" in use.key else use.key
    known = parse_unit(channel.unit)
    if known is not None and known[0] == "V":
        advice = f"sensitivity: {_SENSITIVITIES[wanted]}"
    else:
        advice = f"unit: {_EXAMPLES[wanted]}"
    other = next((r for r, unit in ROLE_UNITS.items() if known and unit == known[0]), None)
    instead = f", or role: {other}" if other else ""
    return (
        f"{run}: channel {shown(channel.name)} {said} but is used as {use.role}, which takes "
        f"{_QUANTITIES[wanted]}. Put what its numbers are in the log, such as "
        f"channels: {{{key}: {{role: {use.role}, {advice}}}}}{instead}."
    )


def _by_log(channel: RawChannel, text: str, wanted: str, use: ChannelUse, run: str) -> Scale:
    known = parse_unit(text)
    if known is None or known[0] != wanted:
        raise RecordingError(
            f"{run}: channel {shown(channel.name)}: the log gives the unit {shown(text, 30)}, "
            f"but role {use.role} takes {_QUANTITIES[wanted]}, such as {_EXAMPLES[wanted]}."
        )
    file = parse_unit(channel.unit)
    if file is not None and file[0] == wanted and abs(file[1] / known[1] - 1.0) > 1e-9:
        raise RecordingError(
            f"{run}: channel {shown(channel.name)} is in {shown(channel.unit, 30)} in the file "
            f"but {shown(text, 30)} in the log. Take unit out of the log, or correct it."
        )
    note = ""
    if channel.unit and (file is None or file[0] != wanted):
        note = (
            f"Channel {shown(channel.name)}: the file says {shown(channel.unit, 30)}, the log "
            f"{shown(text, 30)}; the log is followed."
        )
    return Scale(*known, text, note)


def _by_sensitivity(channel: RawChannel, use: ChannelUse, wanted: str, run: str) -> Scale:
    text = use.sensitivity or ""
    said = use.unit or channel.unit or "V"
    volts = parse_unit(said)
    if volts is None or volts[0] != "V":
        raise RecordingError(
            f"{run}: channel {shown(channel.name)} has a sensitivity of {shown(text, 30)} in "
            f"the log, but its numbers are in {shown(said, 30)}, not in volts. Take the "
            "sensitivity out of the log, or put unit: V beside it."
        )
    try:
        sensitivity = units.to_si(text, f"V/({wanted})" if "/" in wanted else f"V/{wanted}")
    except ValueError as error:
        raise RecordingError(
            f"{run}: channel {shown(channel.name)}: sensitivity: {error}. "
            f"Write it as {_SENSITIVITIES[wanted]}."
        ) from error
    if not sensitivity:
        raise RecordingError(f"{run}: channel {shown(channel.name)}: a sensitivity of 0.")
    return Scale(wanted, volts[1] / sensitivity, f"{said}, {text}")


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
