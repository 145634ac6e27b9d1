"""A draft of a test log: metadata of recordings, guesses, marks; and a small example."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Final

from shakerproc import files
from shakerproc.errors import LogError, RecordingError
from shakerproc.recordings.raw import AS_STATED, Sampling


@dataclass(frozen=True, slots=True)
class SeenRecording:
    """Contents of a recording.

    Attributes
    ----------
    path : Path
        Where it is.
    names, units : tuple of str
        Of its channels; a unit is empty where the file says none.
    rms : tuple of float
        Of its channels, in the unit that they are converted to; empty where it cannot be used
        as it is.
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

    paths = [p for p in folder.rglob("*") if p.suffix.lower() in READERS and p.is_file()]
    visible = [p for p in paths if not p.name.startswith(".")]
    if not visible:
        raise LogError(f"{folder}: no recording in it; shakerproc reads {', '.join(READERS)}")
    return sorted(visible, key=lambda path: [natural(part) for part in path.parts])


def natural(text: str) -> list[tuple[int, str]]:
    """Return the sort key of a name: its numbers in their order."""
    return [(int(p), "") if p.isdigit() else (0, p) for p in re.split(r"(\d+)", text)]


def look(path: Path, said: Sampling = AS_STATED) -> SeenRecording:
    """Return the contents of a recording; the samples are read once.

    `said` is what is known of its times.

    Raises
    ------
    RecordingError
        If it cannot be used.
    """
    import numpy as np

    from shakerproc.recordings import open_recording

    with open_recording(path, sample_rate=said) as recording:
        squares = np.zeros(len(recording.channels))
        for block in recording.blocks(size=2**17):
            squares += np.sum(np.where(np.isfinite(block), block, 0.0) ** 2, axis=1)
        rms = np.sqrt(squares / recording.n_samples)
        return SeenRecording(
            path,
            tuple(channel.name for channel in recording.channels),
            tuple(channel.source_unit or "" for channel in recording.channels),
            tuple(float(value) for value in rms),
            (recording.n_samples,) * len(recording.channels),
        )


def described(path: Path) -> SeenRecording | None:
    """Return the stated contents of an unusable recording; None where it states none.

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
    return SeenRecording(
        path,
        tuple(channel.name for channel in channels),
        tuple(channel.unit for channel in channels),
        (),
        tuple(channel.n_samples for channel in channels),
    )


def seen_of(
    path: Path,
    said: Sampling,
    warn: Callable[[str], None],
    advance: Callable[[str], None] = lambda _name: None,
) -> list[SeenRecording]:
    """Return the contents of a recording, of an unusable one at most those it states.

    `said` is what is known of its times.
    """
    seen = None
    try:
        seen = look(path, said)
    except RecordingError as error:
        warn(f"not usable yet: {error}")
        with suppress(RecordingError):
            seen = described(path)
        if seen is None:
            warn(f"left out: {path.name}")
    advance(path.name)
    return [] if seen is None else [seen]


_ON_THE_TABLE: Final = re.compile(r"control|table|base|input|drive|armature|\bref", re.I)

_ACCELERATION: Final = "m/s^2"

FORCE: Final = "N"

_IGNORE: Final = "{role: ignore}"

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
{times}
# Of each test: excitation, level and band, as in the second line here. With them the level is
# checked and only what was excited is judged. Mark one test of several levels hold_out: true.
#   - {{id: 1, recording: run_1.tdms, specimen: a, clearance: 0.05 mm, excitation: random,
#      level: 0.02 g^2/Hz, from: 20 Hz, to: 1000 Hz}}
tests:
{tests}"""

MODEL: Final = """\
# What is thought to be on the shaker: one mass on a spring and a damper. Weigh what moves with
# the sensor. k = m (2 pi f)^2 and c = 2 pi f m / Q, with f and Q of the lowest level
# (`shakerproc batch`). Both are fitted; the mass is not.

model: 1
title: one mass on a linear joint
masses: {{coupon: 1 kg}}           # ??? weigh it
elements:
  - {{kind: spring, between: [base, coupon], stiffness: 4e5 N/m}}     # ??? 100 Hz for 1 kg
  - {{kind: damper, between: [base, coupon], damping: 25 N s/m}}      # ??? Q of 25 for 1 kg
excitation: {{{excitation}}}
sensors:
{sensors}"""

_SENSOR: Final = "{at: coupon, measures: acceleration}"


def measures(name: str, unit: str) -> str:
    """Return the SI unit of a channel: of its unit, else by its name."""
    from shakerproc.recordings.columns import quantity_named
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

    controls, uses = controls_of_seen(seen), {}
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
        uses[key] = (f"{{role: {role}{own}{at}}}", note)
    return uses


def unusual_channels(
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
    text = f", channels: {{{', '.join(f'{key}: {use}' for key, use in uses.items())}}}"
    if crop.startswith("{") and controls[0] not in seen.names:
        name = quoted((controls_of_seen(seen) or controls_of(seen.names))[0])
        text += f", processing: {{crop: {{channel: {name}}}}}"
    return text


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


def log_text(
    folder: Path,
    recordings: Path,
    seen: Sequence[SeenRecording],
    said: Sampling,
    warn: Callable[[str], None],
) -> str:
    """Return the draft of a log for recordings, of which one that can be used comes first.

    Parameters
    ----------
    folder, recordings : Path
        Where the log goes, and the folder in it that holds the recordings.
    seen : sequence of SeenRecording
        The recordings.
    said : Sampling
        What is said of the times of the recordings.
    warn : callable
        Called with what may be wrong.
    """
    controls = controls_of_seen(seen[0])
    usual, crop = entries(seen[0]), crop_of(seen, controls)
    channel_lines = {one.path: unusual_channels(one, usual, controls, crop) for one in seen}
    first = seen[0].path.relative_to(recordings).as_posix()
    for path in (path for path, text in channel_lines.items() if text):
        name = path.relative_to(recordings).as_posix()
        warn(f"{name} has other channels than {first}; its line in tests: says which")
    below = recordings.resolve().relative_to(folder.resolve()).as_posix() or "."
    return LOG.format(
        title=quoted(folder.resolve().name),
        folder=quoted(below),
        channels="".join(f"  {key}: {use}   # {note}\n" for key, (use, note) in usual.items()),
        crop=crop,
        times=_times(said),
        tests=test_lines(channel_lines, recordings, ()),
    )


def _times(said: Sampling) -> str:
    """Return the lines of `processing` that say the same of the times."""
    rate = f"{said.rate:.10g} Hz" if said.rate else ""
    resample = f"{said.resample:.10g} Hz" if said.resample else ""
    given = {
        "sample_rate": f"{{value: {rate}, override: true}}" if said.override else rate,
        "time_unit": said.unit,
        "resample": resample,
        "starts": "ignore" if said.ignore_starts else "",
    }
    return "".join(f"  {key}: {value}\n" for key, value in given.items() if value)


def test_lines(
    channel_lines: Mapping[Path, str], recordings: Path, taken: Collection[str]
) -> str:
    """Return a line for each recording, under the number in its name where that is unique.

    Parameters
    ----------
    channel_lines : mapping
        What each recording says of its channels, by its path.
    recordings : Path
        The folder that the log names.
    taken : collection of str
        Ids that other tests have already.
    """
    paths = sorted(channel_lines, key=lambda path: [natural(part) for part in path.parts])
    below = [path.relative_to(recordings).as_posix() for path in paths]
    numbers = [re.findall(r"\d+", path.removesuffix(Path(path).suffix)) for path in below]
    ids = [found[-1].lstrip("0") or "0" if found else "" for found in numbers]
    if len({*ids, *taken}) < len(ids) + len(taken) or "" in ids:
        begin = 1 + max((int(one) for one in taken if one.isdecimal()), default=0)
        ids = [str(i) for i in range(begin, begin + len(below))]
    wanted = "# ??? excitation, level, from, to"
    return "".join(
        f"  - {{id: {i}, recording: {quoted(name)}{channel_lines[path]}}}   {wanted}\n"
        for i, name, path in zip(ids, below, paths, strict=True)
    )


def begin(
    folder: Path,
    recordings: Path,
    said: Sampling,
    advance: Callable[[str], None],
    warn: Callable[[str], None],
) -> tuple[Path, Path]:
    """Write a log and a model for the recordings in a folder; return their paths.

    Parameters
    ----------
    folder, recordings : Path
        Where the files go, and the folder in it that holds the recordings.
    said : Sampling
        What is said of the times of the recordings.
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
    paths = recordings_below(recordings)
    seen = [one for path in paths for one in seen_of(path, said, warn, advance)]
    if not seen:
        raise LogError(f"{recordings}: none of the recordings can be read; nothing was written")
    # what can be used speaks first, and of that what a shaker drives
    seen.sort(key=lambda one: (not one.rms, is_struck(one)))
    files.write_text(log, log_text(folder, recordings, seen, said, warn))
    files.write_text(model, _model_text(seen[0]))
    return log, model


def _model_text(seen: SeenRecording) -> str:
    """Return a model whose sensors are the responses of a recording."""
    counts, controls = Counter(seen.names), controls_of_seen(seen)
    channels = zip(seen.names, seen.units, seen.lengths, strict=True)
    responses = [
        name if counts[name] == 1 else f"{name} {number}"
        for number, (name, unit, n) in enumerate(channels, 1)
        if name not in controls
        and not ignored(name, unit, n, seen)
        and measures(name, unit) != FORCE
    ]
    sensors = "".join(f"  {quoted(n)}: {_SENSOR}\n" for n in responses)
    excitation = "base: acceleration" if controls else "force on: coupon"
    return MODEL.format(sensors=sensors, excitation=excitation)


def write_example(folder: Path) -> tuple[Path, Path]:
    """Write recordings, a log and a model of them that lacks the gap; return log and model.

    They were simulated once, by `sample_data/make_example.py`.
    """
    shipped = resources.files("shakerproc.workflows") / "example_campaign"
    recordings = folder / "recordings"
    recordings.mkdir(parents=True, exist_ok=True)
    for recording in (shipped / "recordings").iterdir():
        files.write_bytes(recordings / recording.name, recording.read_bytes())
    log, model = folder / "testlog.yaml", folder / "model.yaml"
    for path in (log, model):
        files.write_text(path, (shipped / path.name).read_text(encoding="utf-8"))
    return log, model
