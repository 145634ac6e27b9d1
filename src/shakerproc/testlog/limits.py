"""Limits that planned tests must not exceed, as the log writes them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

from shakerproc.data import ChannelUse
from shakerproc.testlog.misfit import MisfitError
from shakerproc.units import is_unit_of, near_miss, numbered, quoted, to_si

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
    found: list[Limit] = []
    for key, written in section.items():
        if key == "shaker":
            found += _of_shaker(written)
            continue
        whose, name, units = _named(key)
        if whose == "response":
            _check_channel(key, channels)
        if isinstance(written, list | tuple):
            found += [
                _limit(whose, name, one, units, (key, i)) for i, one in enumerate(written)
            ]
        else:
            found.append(_limit(whose, name, written, units, (key,)))
    return tuple(found)


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
