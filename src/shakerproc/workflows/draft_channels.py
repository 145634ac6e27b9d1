"""Channels in the draft of a log: units, roles, guesses."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from shakerproc.workflows.recordings_seen import SeenRecording

_ON_THE_TABLE: Final = re.compile(r"control|table|base|input|drive|armature|\bref", re.I)

_ACCELERATION: Final = "m/s^2"

FORCE: Final = "N"

_IGNORE: Final = "{role: ignore}"


def measures(name: str, unit: str) -> str:
    """Return the SI unit of a channel: of its unit, else of what its name says it measures."""
    from shakerproc.recordings.headers import quantity_named
    from shakerproc.recordings.si import quantity_of

    said, stated = quantity_named(name), quantity_of(unit)
    return said if stated == "V" and said == FORCE else stated or said


def ignored(name: str, unit: str, length: int, seen: SeenRecording) -> str:
    """Return why a channel is of no use here; empty where it is."""
    usual = max(set(seen.lengths), key=seen.lengths.count)
    if length != usual:
        return f"{length} samples, others have {usual}"
    quantity = measures(name, unit)
    if quantity not in {"", "V", _ACCELERATION, FORCE}:
        return f"{unit or 'by its name it'} is no acceleration"
    pairs = zip(seen.names, seen.units, strict=True)
    accelerations = sum(measures(*pair) == _ACCELERATION for pair in pairs)
    if quantity not in {_ACCELERATION, FORCE} and accelerations > 1:
        return f"{unit or quantity or 'no unit'}, others are accelerations"
    return ""


def is_struck(seen: SeenRecording) -> bool:
    """Return whether a force drives a recording and no channel is on a table."""
    pairs = zip(seen.names, seen.units, strict=True)
    return any(measures(*pair) == FORCE for pair in pairs) and not controls_of_seen(seen)


def controls_of(names: Sequence[str]) -> list[str]:
    """Return the channels that sit on the table, by their names; else the first."""
    return [name for name in names if _ON_THE_TABLE.search(name)] or list(names[:1])


def controls_of_seen(seen: SeenRecording) -> list[str]:
    """Return the channels of a recording that sit on the table, of those that are of use.

    Where a force drives the test, only a name says that there is a table.
    """
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    useful = [(name, unit) for name, unit, n in channels if not ignored(name, unit, n, seen)]
    moving = [name for name, unit in useful if measures(name, unit) != FORCE]
    if len(moving) < len(useful):
        return [name for name in moving if _ON_THE_TABLE.search(name)]
    return controls_of(moving or seen.names)


def entries(seen: SeenRecording) -> dict[str, tuple[str, str]]:
    """Return the log's entry of each channel of a recording, and why, by its key there.

    The key is the name or, of several channels of one name, the number, and a name beside it.
    """
    from shakerproc.recordings.si import quantity_of

    controls, found = controls_of_seen(seen), {}
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    for number, (name, unit, n) in enumerate(channels, 1):
        quantity = measures(name, unit)
        role = "control" if name in controls else "force" if quantity == FORCE else "response"
        at = "" if name in controls else ", at: coupon"
        volts = "unit: V, sensitivity: " + ("10 mV/N" if role == "force" else "100 mV/g")
        note = "(guess)"
        if why := ignored(name, unit, n, seen):
            role, at, note = "ignore", "", f"(guess) {why}"
        elif not quantity_of(unit):
            plain = "N" if role == "force" else "g"
            note += f" ??? no unit in the file: add unit: {plain}, or {volts}"
        elif quantity_of(unit) == "V":
            note += f" ??? volts: add {volts.removeprefix('unit: V, ')}"
        key, own = quoted(name), ""
        if seen.names.count(name) > 1:
            key, own = str(number), f", name: {quoted(f'{name} {number}')}"
        found[key] = (f"{{role: {role}{own}{at}}}", note)
    return found


def own_channels(
    seen: SeenRecording,
    usual: Mapping[str, tuple[str, str]],
    controls: Sequence[str],
    crop: str,
) -> str:
    """Return the entries of a test for its channels where they are not the usual ones."""
    mine = entries(seen)
    uses = {key: use for key, (use, _) in mine.items() if usual.get(key, ("",))[0] != use}
    absent = [key for key, (use, _) in usual.items() if key not in mine and use != _IGNORE]
    uses |= dict.fromkeys(absent, _IGNORE)
    if not uses:
        return ""
    told = f", channels: {{{', '.join(f'{key}: {use}' for key, use in uses.items())}}}"
    if crop.startswith("{") and controls[0] not in seen.names:
        name = quoted((controls_of_seen(seen) or controls_of(seen.names))[0])
        told += f", processing: {{crop: {{channel: {name}}}}}"
    return told


def crop_of(seen: Sequence[SeenRecording], controls: Sequence[str]) -> str:
    """Return a threshold that the quietest run passes, where the unit is known."""
    from shakerproc.data import STANDARD_GRAVITY
    from shakerproc.recordings.si import quantity_of

    first = seen[0]
    if not controls:
        return "none                    # a force drives it; or {from: 2 s, to: 40 s}"
    at = first.names.index(controls[0])
    if not first.rms or quantity_of(first.units[at]) != _ACCELERATION:
        return "none                    # ??? or {channel: NAME, threshold: 0.3 g}"
    name = controls[0]
    levels = [one.rms[one.names.index(name)] for one in seen if one.rms and name in one.names]
    threshold = 0.5 * min(levels) / STANDARD_GRAVITY
    return (
        f"{{channel: {quoted(name)}, threshold: {threshold:.2g} g}}   "
        f"# (guess) half the smallest rms"
    )


def quoted(text: str) -> str:
    """Return text as YAML that reads back as it is, whatever it holds."""
    from shakerproc.model_files.writing import text_of

    return text_of(text)
