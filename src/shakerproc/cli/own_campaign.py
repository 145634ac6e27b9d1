"""A test log and a model begun from a folder of recordings: what the files say, and guesses."""

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from shakerproc import files
from shakerproc.errors import LogError, RecordingError

_ON_THE_TABLE: Final = re.compile(r"control|table|base|input|drive|armature|\bref", re.I)

LOG: Final = """\
# The log sheet of a campaign: what was on the shaker, test by test. Begun by `shakerproc init`
# from the files; what it could not know is marked with ???, what it guessed with (guess).

testlog: 1
title: {title}
recordings: {folder}          # folder beside this file; nothing outside it is ever read

channels:                       # role: control sits on the table; or response, force, ignore
{channels}
processing:
  crop: {crop}
{rate}
# Of each test: excitation, level and band, as in the second line here. With them the level is
# checked and only what was excited is judged. Mark one test of several levels hold_out: true.
#   - {{id: 1, recording: run_1.tdms, specimen: a, clearance: 0.05 mm, excitation: random,
#      level: 0.02 g^2/Hz, from: 20 Hz, to: 1000 Hz}}
tests:
{tests}"""

MODEL: Final = """\
# What is thought to be on the shaker: one mass on a spring and a damper. Weigh what moves with
# the sensor; k = m (2 pi f)^2 and c = 2 pi f m / Q, with f and Q of the lowest level, from
# `shakerproc batch`. Both are fitted; the mass is not.

model: 1
title: one mass on a linear joint
masses: {{coupon: 1 kg}}           # ??? weigh it
elements:
  - {{kind: spring, between: [base, coupon], stiffness: 4e5 N/m}}     # ??? 100 Hz for 1 kg
  - {{kind: damper, between: [base, coupon], damping: 25 N s/m}}      # ??? Q of 25 for 1 kg
excitation: {{{excitation}}}
sensors:
{sensors}"""


@dataclass(frozen=True, slots=True)
class Seen:
    """What a recording holds.

    Attributes
    ----------
    path : Path
        Where it is.
    names, units : tuple of str
        Of its channels; a unit is empty where the file says none.
    rms : tuple of float
        Of its channels, in the unit that they are served in; empty where it cannot be used as
        it is.
    lengths : tuple of int
        Samples of its channels.
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    rms: tuple[float, ...]
    lengths: tuple[int, ...]


def recordings_below(folder: Path) -> list[Path]:
    """Return the recordings in a folder and the folders in it, numbers in their order.

    Raises
    ------
    LogError
        If there are none.
    """
    from shakerproc.recordings import READERS

    found = [p for p in folder.rglob("*") if p.suffix.lower() in READERS and p.is_file()]
    visible = [p for p in found if not p.name.startswith(".")]
    if not visible:
        raise LogError(f"{folder}: no recording in it; shakerproc reads {', '.join(READERS)}")
    return sorted(visible, key=lambda path: [_natural(part) for part in path.parts])


def _natural(text: str) -> list[tuple[int, str]]:
    return [(int(p), "") if p.isdigit() else (0, p) for p in re.split(r"(\d+)", text)]


def look(path: Path, sample_rate: float | None = None) -> Seen:
    """Return what a recording holds; the samples are read once.

    Raises
    ------
    RecordingError
        If it cannot be used.
    """
    import numpy as np

    from shakerproc.recordings import open_recording

    with open_recording(path, sample_rate=sample_rate) as recording:
        squares = np.zeros(len(recording.channels))
        for block in recording.blocks(size=2**17):
            squares += np.sum(np.where(np.isfinite(block), block, 0.0) ** 2, axis=1)
        rms = np.sqrt(squares / recording.n_samples)
        return Seen(
            path,
            tuple(channel.name for channel in recording.channels),
            tuple(channel.source_unit or "" for channel in recording.channels),
            tuple(float(value) for value in rms),
            (recording.n_samples,) * len(recording.channels),
        )


def described(path: Path) -> Seen | None:
    """Return what an unusable recording says it holds; None where that is nothing.

    Raises
    ------
    RecordingError
        If it cannot be read at all.
    """
    from shakerproc.recordings import contents

    groups = [group for group in contents(path)[0] if group.channels and not group.reduced]
    if not groups:
        return None
    channels = max(groups, key=lambda group: len(group.channels)).channels
    return Seen(
        path,
        tuple(channel.name for channel in channels),
        tuple(channel.unit for channel in channels),
        (),
        tuple(channel.n_samples for channel in channels),
    )


def begin(
    folder: Path,
    recordings: Path,
    sample_rate: float | None,
    advance: Callable[[str], None],
    warn: Callable[[str], None],
) -> tuple[Path, Path]:
    """Write a log and a model for the recordings in a folder; return their paths.

    Parameters
    ----------
    folder, recordings : Path
        Where the files go, and the folder in it that holds the recordings.
    sample_rate : float, optional
        Of recordings that do not say it [Hz].
    advance, warn : callable
        Called after each recording, and with what may be wrong.

    Raises
    ------
    LogError
        If a log or a model is there already, or the recordings lie elsewhere, or none of them
        can be read.
    """
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    for path in (log, model):
        if path.exists():
            raise LogError(f"{path}: it is there already; nothing was written")
    if not recordings.resolve().is_relative_to(folder.resolve()):
        raise LogError(
            f"{recordings}: not below {folder}. A log reads nothing outside its own folder: "
            f"name a folder that holds the recordings, or move them."
        )
    seen: list[Seen] = []
    for path in recordings_below(recordings):
        try:
            seen.append(look(path, sample_rate))
        except RecordingError as error:
            warn(f"not usable yet: {error}")
            seen += _described_or_left_out(path, warn)
        advance(path.name)
    if not seen:
        raise LogError(f"{recordings}: none of the recordings can be read; nothing was written")
    seen.sort(key=lambda one: not one.rms)  # what can be used speaks first
    controls = _controls(seen[0])
    usual, crop = entries(seen[0]), _crop(seen, controls)
    own = {one.path: _own(one, usual, controls, crop) for one in seen}
    first = seen[0].path.relative_to(recordings).as_posix()
    for path in (path for path, text in own.items() if text):
        name = path.relative_to(recordings).as_posix()
        warn(f"{name} has other channels than {first}; its line in tests: says which")
    below = recordings.resolve().relative_to(folder.resolve()).as_posix() or "."
    content = LOG.format(
        title=_quoted(folder.resolve().name),
        folder=_quoted(below),
        channels="".join(f"  {key}: {use}   # {note}\n" for key, (use, note) in usual.items()),
        crop=crop,
        rate=f"  sample_rate: {sample_rate:.10g} Hz\n" if sample_rate else "",
        tests=_tests({p: own[p] for p in recordings_below(recordings) if p in own}, recordings),
    )
    files.write_text(log, content)
    counts = Counter(seen[0].names)
    responses = [
        name if counts[name] == 1 else f"{name} {number}"
        for number, (name, unit, n) in enumerate(
            zip(seen[0].names, seen[0].units, seen[0].lengths, strict=True), 1
        )
        if name not in controls
        and not _ignored(name, unit, n, seen[0])
        and _measures(name, unit) != _FORCE
    ]
    sensors = "".join(f"  {_quoted(n)}: {_SENSOR}\n" for n in responses)
    excitation = "base: acceleration" if controls else "force on: coupon"
    files.write_text(model, MODEL.format(sensors=sensors, excitation=excitation))
    return log, model


def _described_or_left_out(path: Path, warn: Callable[[str], None]) -> list[Seen]:
    try:
        found = described(path)
    except RecordingError:
        found = None
    if found is None:
        warn(f"left out: {path.name}")
    return [] if found is None else [found]


def _measures(name: str, unit: str) -> str:
    """Return the SI unit of a channel: of its unit, else of what its name says it measures."""
    from shakerproc.recordings.si import quantity_of

    match = _SAYS.match(name)
    return quantity_of(unit) or (_QUANTITIES[match[0].lower()] if match else "")


def _ignored(name: str, unit: str, length: int, seen: Seen) -> str:
    """Return why a channel is of no use here; empty where it is."""
    usual = max(set(seen.lengths), key=seen.lengths.count)
    if length != usual:
        return f"{length} samples, others have {usual}"
    quantity = _measures(name, unit)
    if quantity not in {"", "V", _ACCELERATION, _FORCE}:
        return f"{unit or 'by its name it'} is no acceleration"
    pairs = zip(seen.names, seen.units, strict=True)
    accelerations = sum(_measures(*pair) == _ACCELERATION for pair in pairs)
    if quantity not in {_ACCELERATION, _FORCE} and accelerations > 1:
        return f"{unit or quantity or 'no unit'}, others are accelerations"
    return ""


_ACCELERATION: Final = "m/s^2"
_FORCE: Final = "N"
_QUANTITIES: Final = {
    "acc": _ACCELERATION,
    "force": _FORCE,
    "hammer": _FORCE,
    "load": _FORCE,
    "disp": "m",
    "velocity": "m/s",
    "volt": "V",
}
"""What a name that begins so measures, where the file says no unit."""

_SAYS: Final = re.compile("|".join(_QUANTITIES), re.IGNORECASE)
_IGNORE: Final = "{role: ignore}"
_SENSOR: Final = "{at: coupon, measures: acceleration}"


def controls_of(names: Sequence[str]) -> list[str]:
    """Return the channels that sit on the table, by their names; else the first."""
    return [name for name in names if _ON_THE_TABLE.search(name)] or list(names[:1])


def _controls(seen: Seen) -> list[str]:
    """Return the channels of a recording that sit on the table, of those that are of use.

    Where a force drives the test, only a name says that there is a table.
    """
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    useful = [(name, unit) for name, unit, n in channels if not _ignored(name, unit, n, seen)]
    moving = [name for name, unit in useful if _measures(name, unit) != _FORCE]
    if len(moving) < len(useful):
        return [name for name in moving if _ON_THE_TABLE.search(name)]
    return controls_of(moving or seen.names)


def entries(seen: Seen) -> dict[str, tuple[str, str]]:
    """Return what the log says of each channel of a recording, and why, by its key there.

    The key is the name or, of several channels of one name, the number, and a name beside it.
    """
    from shakerproc.recordings.si import quantity_of

    controls, found = _controls(seen), {}
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    for number, (name, unit, n) in enumerate(channels, 1):
        quantity = _measures(name, unit)
        role = "control" if name in controls else "force" if quantity == _FORCE else "response"
        at = "" if name in controls else ", at: coupon"
        volts = "unit: V, sensitivity: " + ("10 mV/N" if role == "force" else "100 mV/g")
        note = "(guess)"
        if why := _ignored(name, unit, n, seen):
            role, at, note = "ignore", "", f"(guess) {why}"
        elif not quantity_of(unit):
            plain = "N" if role == "force" else "g"
            note += f" ??? no unit in the file: add unit: {plain}, or {volts}"
        elif quantity_of(unit) == "V":
            note += f" ??? volts: add {volts.removeprefix('unit: V, ')}"
        key, own = _quoted(name), ""
        if seen.names.count(name) > 1:
            key, own = str(number), f", name: {_quoted(f'{name} {number}')}"
        found[key] = (f"{{role: {role}{own}{at}}}", note)
    return found


def _own(
    seen: Seen, usual: Mapping[str, tuple[str, str]], controls: Sequence[str], crop: str
) -> str:
    """Return what a test says of its channels where they are not the usual ones."""
    mine = entries(seen)
    uses = {key: use for key, (use, _) in mine.items() if usual.get(key, ("",))[0] != use}
    absent = [key for key, (use, _) in usual.items() if key not in mine and use != _IGNORE]
    uses |= dict.fromkeys(absent, _IGNORE)
    if not uses:
        return ""
    told = f", channels: {{{', '.join(f'{key}: {use}' for key, use in uses.items())}}}"
    if crop.startswith("{") and controls[0] not in seen.names:
        name = _quoted((_controls(seen) or controls_of(seen.names))[0])
        told += f", processing: {{crop: {{channel: {name}}}}}"
    return told


def _crop(seen: Sequence[Seen], controls: Sequence[str]) -> str:
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
        f"{{channel: {_quoted(name)}, threshold: {threshold:.2g} g}}   "
        f"# (guess) half the smallest rms"
    )


def _tests(own: Mapping[Path, str], recordings: Path) -> str:
    """Return a line for each recording, under the number in its name where that is unique."""
    below = [path.relative_to(recordings).as_posix() for path in own]
    numbers = [re.findall(r"\d+", path.removesuffix(Path(path).suffix)) for path in below]
    ids = [found[-1].lstrip("0") or "0" if found else "" for found in numbers]
    if len(set(ids)) < len(ids) or "" in ids:
        ids = [str(i) for i in range(1, len(below) + 1)]
    wanted = "# ??? excitation, level, from, to"
    return "".join(
        f"  - {{id: {i}, recording: {_quoted(path)}{more}}}   {wanted}\n"
        for i, path, more in zip(ids, below, own.values(), strict=True)
    )


def _quoted(text: str) -> str:
    """Return text as YAML that reads back as it is, whatever it holds."""
    from shakerproc.model_files.writing import text_of

    return text_of(text)
