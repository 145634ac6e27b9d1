"""Choose the group, the channels and the sample rate; everything that a test log may ask."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from shakerproc import units
from shakerproc.data import ChannelUse, Measurement, UnusedChannel
from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import shown
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup

Chosen = tuple[RawChannel, ChannelUse | None]


class ChannelNotFoundError(RecordingError):
    """A recording lacks a channel.

    Attributes
    ----------
    wanted : str or int
        Name or number that was asked for.
    present : tuple of str
        Names the recording has.
    """

    def __init__(self, wanted: str | int, present: tuple[str, ...], run: str) -> None:
        self.wanted = wanted
        self.present = present
        super().__init__(
            f"{run}: no channel {shown(wanted)}{_meant(wanted, present)} The recording has "
            f"{_listed(present)}. Correct the name in the log, or choose one of these."
        )


def _meant(wanted: str | int, present: tuple[str, ...]) -> str:
    near = units.near_miss(wanted, present) if isinstance(wanted, str) else None
    return f"; did you mean {shown(near)}?" if near else "."


def _listed(names: Sequence[str], most: int = 40) -> str:
    text = ", ".join(shown(name) for name in names[:most])
    return text + (f" and {len(names) - most} more" if len(names) > most else "")


@final
@dataclass(frozen=True, slots=True)
class FilePart:
    """Which part of a file that holds several.

    Attributes
    ----------
    group : str, optional
        Name of the group.
    measurement : int or "all", optional
        Which of several measurements that follow each other in the same channels, from 1.
    """

    group: str | None = None
    measurement: Measurement | None = None


ANOTHER_GROUP: Final = "in another group"
"""Why a channel is not used that stands in a group that was not chosen."""

WHOLE: Final = FilePart()


def choose_part(
    file: RawFile, part: FilePart, uses: Sequence[ChannelUse] | None, run: str
) -> tuple[RawGroup, str]:
    """Return the measurement of the group that is meant, and a note where there are several.

    Raises
    ------
    RecordingError
        If there is none, or no telling which.
    """
    return choose_measurement(choose_group(file, part.group, uses, run), part.measurement, run)


def choose_group(
    file: RawFile, group: str | None, uses: Sequence[ChannelUse] | None, run: str
) -> RawGroup:
    """Return the group that is meant: by name, by its channels, or because it is the only one.

    Raises
    ------
    RecordingError
        If there is none, or no telling which.
    """
    if group is not None:
        return _named_group(file, group, run)
    full = [g for g in file.groups if any(c.promised > 0 and not c.problem for c in g.channels)]
    candidates = [g for g in full if not g.reduced] or full
    if not candidates:
        every = [c for g in file.groups for c in g.channels if c.time.spectrum]
        spectrum = next((c for c in every if c.problem == c.time.problem), None)
        if spectrum is not None:
            raise RecordingError(
                f"{run}: channel {shown(spectrum.name)} is no recording: {spectrum.problem}. "
                "Export the samples over time; modal and compare take response functions."
            )
        raise RecordingError(
            f"{run}: the file holds no samples{_listed_notes(file)}. "
            "Measure or export it again."
        )
    if len(candidates) == 1:
        return candidates[0]
    wanted = {
        use.key for use in uses or () if isinstance(use.key, str) and use.role != "ignore"
    }
    fitting = [g for g in candidates if wanted and wanted <= _names(g)]
    if len(fitting) == 1:
        return fitting[0]
    raise RecordingError(
        f"{run}: {len(candidates)} groups hold data: "
        f"{'; '.join(_described(g) for g in candidates[:8])}. Say which: group in the log "
        f'(processing: {{group: "{_plain(candidates[0].name)}"}}) or --group.'
    )


def choose_measurement(
    group: RawGroup, wanted: Measurement | None, run: str
) -> tuple[RawGroup, str]:
    """Return the measurement of a group that is meant, and a note where there are several.

    Raises
    ------
    RecordingError
        If there are several and none is said, there is no such one, or they cannot be one.
    """
    count = len(group.measurements) + group.more or 1
    if count == 1:
        if wanted not in {None, 1, "all"}:
            raise RecordingError(
                f"{run}: no measurement {wanted}: the file holds one. Take measurement out."
            )
        return group, ""
    if wanted is None:
        raise RecordingError(_several(group, count, run))
    if wanted == "all":
        differs = sorted(set(group.differs) - {"time"})
        if differs:
            raise RecordingError(
                f"{run}: {count} measurements that differ in {' and '.join(differs)} cannot be "
                "read as one. Choose one, such as measurement: 1."
            )
        return (
            group,
            f"{count} measurements are read as one, in spite of the time between them.",
        )
    if not 1 <= wanted <= len(group.measurements):
        raise RecordingError(
            f"{run}: no measurement {wanted}: choose from 1 to {len(group.measurements)}."
        )
    return group.measurements[wanted - 1], f"Measurement {wanted} of {count} in the file."


def _several(group: RawGroup, count: int, run: str) -> str:
    text = "; ".join(
        f"{number} ({measurement_text(part)})"
        for number, part in enumerate(group.measurements[:4], 1)
    )
    more = f"; and {count - 4} more" if count > 4 else ""
    as_one = ", or all if they are one" if set(group.differs) == {"time"} else ""
    return (
        f"{run}: {count} measurements follow each other in the same channels: {text}{more}. "
        f"Say which: processing: {{measurement: 1}} in the log or --measurement 1{as_one}."
    )


def measurement_text(part: RawGroup) -> str:
    """Return when a measurement was taken, how long it is, its rate and units."""
    channels = [channel for channel in part.channels if channel.n_samples]
    if not channels:
        return "no samples"
    starts = [channel.start_time for channel in channels if channel.start_time is not None]
    rates = sorted({channel.sample_rate for channel in channels if channel.sample_rate})
    units_there = dict.fromkeys(channel.unit for channel in channels if channel.unit)
    parts = [f"from {min(starts):%Y-%m-%d %H:%M:%S},"] if starts else []
    parts.append(f"{max(channel.n_samples for channel in channels)} samples")
    if rates:
        parts.append(f"at {', '.join(f'{rate:.6g}' for rate in rates[:3])} Hz")
    if units_there:
        parts.append(f"in {', '.join(shown(unit, 20) for unit in list(units_there)[:4])}")
    return " ".join(parts)


def _listed_notes(file: RawFile) -> str:
    return f" ({' '.join(file.notes).rstrip('.')})" if file.notes else ""


def _plain(name: str) -> str:
    return shown(name)[1:-1]


def _names(group: RawGroup) -> set[str]:
    return {c.name for c in group.channels} | {c.alias for c in group.channels if c.alias}


def _described(group: RawGroup) -> str:
    rates = {c.sample_rate for c in group.channels if c.promised}
    rate = rates.pop() if len(rates) == 1 else None
    at = f" at {rate:.6g} Hz" if rate else ""
    n = len(group.channels)
    return f"{shown(group.name)} ({n} channel{'s' * (n != 1)}{at})"


def _named_group(file: RawFile, wanted: str, run: str) -> RawGroup:
    names = tuple(group.name for group in file.groups)
    if wanted in names:
        return file.groups[names.index(wanted)]
    raise RecordingError(
        f"{run}: no group {shown(wanted)}{_meant(wanted, names)} The recording has "
        f"{_listed(names) or 'no groups'}."
    )


def choose_channels(
    group: RawGroup, uses: Sequence[ChannelUse] | None, run: str
) -> tuple[Chosen, ...]:
    """Return the channels that are used, in the order of the log, else all that hold numbers.

    Raises
    ------
    ChannelNotFoundError
        If one is missing.
    RecordingError
        If one holds no numbers, or is used twice.
    """
    if uses is None:
        chosen: tuple[Chosen, ...] = tuple((c, None) for c in with_numbers(group))
    else:
        without = missing_channels(group, uses)
        used = (u for u in uses if u.role != "ignore" and u not in without)
        chosen = tuple((_find(group, u.key, run), u) for u in used)
    if not chosen:
        raise RecordingError(
            f"{run}: no channel is used. Give at least one a role other than ignore in the log."
        )
    _check_distinct(chosen, run)
    return chosen


def missing_channels(group: RawGroup, uses: Sequence[ChannelUse]) -> tuple[ChannelUse, ...]:
    """Return the channels of every test in the log that this recording lacks.

    A name that nearly is that of a channel is a slip of the pen and no such channel, and a
    recording that has none of them is another one.
    """
    names = tuple(channel.name for channel in group.channels)
    used = [use for use in uses if use.role != "ignore"]
    absent = tuple(
        use
        for use in used
        if use.default
        and isinstance(use.key, str)
        and use.key not in names
        and units.near_miss(use.key, [n for n in names if all(n != u.key for u in uses)])
        is None
    )
    return absent if len(absent) < len(used) else ()


def with_numbers(group: RawGroup) -> tuple[RawChannel, ...]:
    """Return the channels of a group that hold numbers."""
    return tuple(c for c in group.channels if c.promised > 0 and not c.problem)


def unused_channels(
    file: RawFile,
    group: RawGroup,
    chosen: Sequence[Chosen],
    uses: Sequence[ChannelUse] | None,
    ignored: str,
) -> tuple[UnusedChannel, ...]:
    """Return every channel of a file that is not chosen, and why.

    Decimated copies of the channels of another group are left out: they hold nothing else.

    Parameters
    ----------
    file : RawFile
        The file.
    group : RawGroup
        The group that was chosen.
    chosen : sequence of Chosen
        Its channels that are used.
    uses : sequence of ChannelUse, optional
        What is said of its channels.
    ignored : str
        Why those with the role ignore are.
    """
    used = {id(channel) for channel, _ in chosen}
    keys = {use.key for use in uses or () if use.role == "ignore"}
    unused = []
    for number, channel in enumerate(group.channels, 1):
        if id(channel) in used:
            continue
        why = channel.problem or ("" if channel.promised else "it holds no samples")
        if {channel.name, channel.alias, number} & keys:
            why = why or ignored
        unused.append(UnusedChannel(channel.name, why or "not named in the log"))
    others = [g for g in file.groups if g.name != group.name and not g.reduced]
    return tuple(unused) + tuple(
        UnusedChannel(f"{other.name}/{channel.name}", ANOTHER_GROUP)
        for other in others
        for channel in other.channels
        if channel.promised > 0
    )


def _find(group: RawGroup, key: str | int, run: str) -> RawChannel:
    present = tuple(channel.name for channel in group.channels)
    if isinstance(key, int):
        if not 1 <= key <= len(present):
            raise ChannelNotFoundError(key, present, run)
        raw_channel = group.channels[key - 1]
    else:
        named = [c for c in group.channels if c.name == key]
        named = named or [c for c in group.channels if c.alias == key]
        if not named:
            raise ChannelNotFoundError(key, present, run)
        if len(named) > 1:
            raise RecordingError(
                f"{run}: {len(named)} channels are called {shown(key)}. Use their numbers in "
                "the log instead of the name."
            )
        raw_channel = named[0]
    if raw_channel.problem:
        raise RecordingError(
            f"{run}: channel {shown(raw_channel.name)} cannot be used: {raw_channel.problem}. "
            "Take it out of the log, or give it role: ignore."
        )
    return raw_channel


def _check_distinct(chosen: Sequence[Chosen], run: str) -> None:
    seen: dict[int, str] = {}
    names: set[str] = set()
    for channel, use in chosen:
        if channel.row in seen:
            raise RecordingError(
                f"{run}: channel {shown(channel.name)} is used twice. Take one out of the log."
            )
        seen[channel.row] = channel.name
        name = (use.name if use else None) or channel.name
        if name in names and use is not None:
            raise RecordingError(
                f"{run}: two channels are named {shown(name)}. Give one another name in the "
                "log."
            )
        names.add(name)
