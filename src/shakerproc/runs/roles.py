"""Roles of channels where no log states them, and the unit that an option gives them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import Channel, ChannelUse, Recording, Role
from shakerproc.errors import LogError, SpectrumError
from shakerproc.recordings.choosing import with_numbers
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel, RawGroup
from shakerproc.recordings.si import contradicts, parse_unit, quantity_of
from shakerproc.testlog import Test
from shakerproc.units import near_miss, numbered

ALONG: Final = 0.9
"""Least cosine between two directions that are one, about 25 degrees [-]: a sensor turned so
far still measures nine tenths of the motion along the blow, and logs give round directions."""

NEAR: Final = 1e-3
"""Distance up to which two positions are one place [m]: logs give them in whole millimetres."""

Triple: TypeAlias = tuple[float, float, float]

Place: TypeAlias = tuple[Triple | None, Triple | None]
"""Position [m] and direction [-] of a channel, None where the log does not say them."""

_CONTROL_WORDS: Final = ("control", "ctrl", "drive", "table", "base", "shaker")
_BY_UNIT: Mapping[str, Role] = MappingProxyType({
    "N": "force",
    "m": "displacement",
    "m/s": "velocity",
    "Pa": "pressure",
})


def sense_of(first: Place, second: Place) -> float:
    """Return 1 where two channels sit in one place along one line, and -1 where against it.

    0 where they do not, or where a position is not known. A direction that is not known is that
    of the other.
    """
    (where, along), (there, other) = first, second
    if where is None or there is None:
        return 0.0
    if np.linalg.norm(np.subtract(where, there)) > NEAR:
        return 0.0
    if along is None or other is None:
        return 1.0
    cosine = float(np.dot(along, other))
    return float(np.sign(cosine)) if abs(cosine) >= ALONG else 0.0


@final
@dataclass(frozen=True, slots=True)
class UnitOption:
    """A unit for the channels of a recording.

    Attributes
    ----------
    unit : str
        Such as ``g``.
    override : bool
        Whether it counts where the file says another.
    """

    unit: str
    override: bool = False


_TACHOMETER: Final[Role] = "tachometer"
_NOT_MOVING: Final[frozenset[Role]] = frozenset({"control", "force", _TACHOMETER})


def uses_of(recording: Recording, test: Test) -> list[ChannelUse]:
    """Return the log's use of each channel of a recording; empty where it names none."""
    return uses_of_channels(recording.channels, test)


def uses_of_channels(channels: Sequence[Channel], test: Test) -> list[ChannelUse]:
    """Return the log's use of each channel of a run; empty where it names none."""
    roles = {channel.role for channel in channels}
    said = [*test.channels, *(use for one in test.beside for use in one.channels)]
    names = {channel.source_name for channel in channels}
    used = [u for u in said if u.role in roles and (not u.default or u.key in names)]
    return used if len(used) == len(channels) else []


def is_called(channel: Channel, name: str | int) -> bool:
    """Return whether a name of the log means a channel: its own, or that in the recording."""
    return name in {channel.name, channel.source_name}


def row_named(channels: Sequence[Channel], name: str | int) -> int | None:
    """Return the first row of a channel of some name; None where there is none."""
    return next((i for i, channel in enumerate(channels) if is_called(channel, name)), None)


def row_asked_for(
    channels: Sequence[Channel],
    name: str,
    key: str,
    *,
    besides: Sequence[str] = (),
    todo: str = "Name one of them",
) -> int:
    """Return the row of a channel that a key of the log names.

    Parameters
    ----------
    channels : sequence of Channel
        Those of the run.
    name : str
        What the log says.
    key : str
        Of the log, for the message.
    besides : sequence of str
        What else may be named.
    todo : str
        What to do, for people.

    Raises
    ------
    SpectrumError
        If there is no such channel.
    """
    row = row_named(channels, name)
    if row is None:
        there = ", ".join([*(channel.name for channel in channels), *besides])
        raise SpectrumError(f"{key}: no channel {name!r}; the run has {there}. {todo}")
    return row


def without_tachometers(recording: Recording) -> Recording:
    """Return a recording without its tachometers, whose pulses are no vibration.

    Raises
    ------
    SpectrumError
        If nothing is left.
    """
    rows = [i for i, c in enumerate(recording.channels) if c.role != _TACHOMETER]
    if not rows:
        raise SpectrumError(
            "every channel is a tachometer; give the role response to what measures vibration"
        )
    return recording.select(rows) if len(rows) < len(recording.channels) else recording


def moving(recording: Recording) -> Recording:
    """Return the channels on the structure: neither those that drive it nor tachometers."""
    rows = [i for i, c in enumerate(recording.channels) if c.role not in _NOT_MOVING]
    return recording.select(rows)


def usual_roles(
    names: Sequence[str], units: Sequence[str], controls: Sequence[int] | None = None
) -> tuple[Role, ...]:
    """Return the roles of channels of which no log speaks.

    What is in newtons, metres, metres per second or pascals is a force, a displacement, a
    velocity or a pressure.
    Of the others those whose name speaks of control are controls. Where no name does, the first
    two are (of two channels the first, of one none), unless a force drives the test. All others
    are responses, but for those that measure something else, which are ignored.

    Parameters
    ----------
    names : sequence of str
        Names of the channels in the file.
    units : sequence of str
        Their units as they stand there; empty where it says none.
    controls : sequence of int, optional
        Which are the controls, from 0, where somebody says it.

    Examples
    --------
    >>> usual_roles(["a", "b", "c", "d"], ["g", "g", "g", "Deg C"])
    ('control', 'control', 'response', 'ignore')
    """
    quantities = [quantity_of(unit) for unit in units]
    rest = [i for i, quantity in enumerate(quantities) if quantity not in _BY_UNIT]
    fit = [i for i in rest if quantities[i] in {"", "m/s^2"}] or rest
    if controls is None:
        controls = _controls(names, rest, fit, forced="N" in quantities)
    return tuple(
        "control"
        if i in controls
        else _BY_UNIT.get(quantity, "response" if i in fit else "ignore")
        for i, quantity in enumerate(quantities)
    )


def _controls(
    names: Sequence[str], rest: Sequence[int], fit: Sequence[int], *, forced: bool
) -> Sequence[int]:
    spoken = [i for i in rest if _speaks_of_control(names[i])]
    if spoken:
        return [i for i in spoken if i in fit] or spoken
    return () if forced else rest[: 2 if len(rest) > 2 else len(rest) // 2]


def _speaks_of_control(name: str) -> bool:
    return any(word in name.lower() for word in _CONTROL_WORDS)


def usual_uses(
    group: RawGroup, run: str, controls: Sequence[str] | None, said: UnitOption | None
) -> tuple[ChannelUse, ...]:
    """Return the uses of the channels of a group where no log states them.

    Responses keep the numbers ch3, ch4, ... of the thesis where only their place tells which
    channels are controls.

    Parameters
    ----------
    group : RawGroup
        The group.
    run : str
        Opens every message.
    controls : sequence of str, optional
        Names or numbers of the controls, where somebody says them.
    said : UnitOption, optional
        Unit of the channels that say none.

    Raises
    ------
    LogError
        If there is no such control, or the unit contradicts the file.
    """
    held = with_numbers(group)
    names = [channel.name for channel in held]
    units = [_unit(channel, said) for channel in held]
    roles = usual_roles(names, units, _named(run, names, controls))
    guessed = controls is None and not any(map(_speaks_of_control, names))
    numbered = guessed and "control" in roles
    uses = tuple(
        ChannelUse(
            _key(channel, group),
            role,
            name=f"ch{i}" if numbered and role == "response" else None,
        )
        for i, (channel, role) in enumerate(zip(held, roles, strict=True), 1)
    )
    return uses if said is None else with_unit(uses, group, said, run)


def _key(channel: RawChannel, group: RawGroup) -> str | int:
    """Return the key of a channel in a log: its name, or its number if names repeat."""
    names = [other.name for other in group.channels]
    unique = names.count(channel.name) == 1
    return channel.name if unique else group.channels.index(channel) + 1


def _named(
    run: str, names: Sequence[str], controls: Sequence[str] | None
) -> tuple[int, ...] | None:
    """Return which channels are controls, given by name or number.

    Raises
    ------
    LogError
        If there is no such channel.
    """
    if controls is None:
        return None
    for wanted in controls:
        if wanted not in names and not (wanted.isdigit() and 1 <= int(wanted) <= len(names)):
            there = ", ".join(names)
            near = near_miss(wanted, list(names))
            meant = f" Did you mean {near!r}?" if near else ""
            raise LogError(
                f"{run}: no channel {wanted!r} to be a control.{meant} It has {there}; name "
                "one of these, or give its number."
            )
    return tuple(i for i, name in enumerate(names) if {name, str(i + 1)} & set(controls))


def _unit(channel: RawChannel, said: UnitOption | None) -> str:
    """Return the unit that decides the role of a channel: the file's, or the option's."""
    quantity = quantity_of(channel.unit)
    if said is None or quantity in _BY_UNIT:
        return channel.unit
    return said.unit if said.override or not quantity else channel.unit


def with_unit(
    uses: Sequence[ChannelUse], group: RawGroup, said: UnitOption, run: str
) -> tuple[ChannelUse, ...]:
    """Return uses with a unit where neither the file nor the log says one.

    Raises
    ------
    LogError
        If the unit contradicts the log, or the file and does not override it.
    """
    by_key = {channel.name: channel for channel in group.channels} | dict(
        enumerate(group.channels, 1)
    )
    channel_uses, against = [], []
    for use in uses:
        channel = by_key.get(use.key)
        if use.role == "ignore" or channel is None:
            channel_uses.append(use)
            continue
        _check_log(use, said, run)
        quantity = quantity_of(channel.unit)
        foreign = quantity in _BY_UNIT and quantity != quantity_of(said.unit)
        if contradicts(channel.unit, said.unit) and not foreign:
            against.append(channel)
            channel_uses.append(replace(use, unit=said.unit, override=True))
        else:
            silent = parse_unit(channel.unit) is None
            channel_uses.append(replace(use, unit=said.unit) if silent else use)
    if against and not said.override:
        raise LogError(_against(run, against, said.unit))
    return tuple(channel_uses)


def _check_log(use: ChannelUse, said: UnitOption, run: str) -> None:
    """Pass a channel of which the log says no other unit.

    Raises
    ------
    LogError
        If it does.
    """
    other = f"sensitivity: {use.sensitivity}" if use.sensitivity else f"unit: {use.unit}"
    if use.sensitivity or (use.unit is not None and contradicts(use.unit, said.unit)):
        raise LogError(
            f"{run}: the log says {other} for channel {use.key}, --unit says {said.unit}. Take "
            "one of them out."
        )


def _against(run: str, channels: Sequence[RawChannel], unit: str) -> str:
    text = ", ".join(f"{shown(c.name)} in {shown(c.unit, 30)}" for c in channels[:8])
    more = f" and {len(channels) - 8} more" if len(channels) > 8 else ""
    return (
        f"{run}: --unit says {unit}, the file says {text}{more}. Take --unit out or, where the "
        "file is wrong, add --override-unit."
    )


def by_sheet(uses: Sequence[ChannelUse], group: RawGroup) -> tuple[ChannelUse, ...]:
    """Return channels with the sensitivities of the sheet, where the file holds volts.

    What a recorder has scaled already stays so, and what the log says itself counts.
    """
    units: dict[str | int, str] = {c.name: c.unit for c in group.channels}
    units |= {number: c.unit for number, c in enumerate(group.channels, 1)}
    return tuple(
        replace(use, sensitivity=use.calibration.sensitivity)
        if use.calibration is not None
        and use.sensitivity is None
        and quantity_of(numbered(use.unit)[1] if use.unit else units.get(use.key, ""))
        in {"", "V"}
        else use
        for use in uses
    )
