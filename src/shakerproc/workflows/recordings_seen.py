"""Contents of the recordings in a folder, by their headers."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

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

    found = [p for p in folder.rglob("*") if p.suffix.lower() in READERS and p.is_file()]
    visible = [p for p in found if not p.name.startswith(".")]
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
    found = None
    try:
        found = look(path, said)
    except RecordingError as error:
        warn(f"not usable yet: {error}")
        with suppress(RecordingError):
            found = described(path)
        if found is None:
            warn(f"left out: {path.name}")
    advance(path.name)
    return [] if found is None else [found]
