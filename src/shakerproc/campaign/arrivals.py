"""Which recordings of a folder are finished: those whose size and time stand still."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias, final

from shakerproc.campaign import manifest, result_folder
from shakerproc.recordings import READERS

_OURS: Final = frozenset({result_folder.NAME, manifest.NAME})
"""A folder with one of these holds results, of which some have the ending of a recording."""


@final
@dataclass(frozen=True, slots=True)
class FileStamp:
    """Size and time of a file, by which a change is seen.

    Attributes
    ----------
    size : int
        Length [byte].
    modified : int
        Time of the last change, as the file system has it [ns].
    """

    size: int
    modified: int


Looked: TypeAlias = Mapping[Path, tuple[FileStamp, float]]
"""The stamp of each file, and when it was first seen so, by the clock of whoever looks [s]."""


def recordings_in(folder: Path) -> list[Path]:
    """Return the recordings in a folder and the folders in it, but for folders of results."""
    found = []
    for name, below, names in os.walk(folder):
        if not _OURS.isdisjoint(names):
            below.clear()
            continue
        below[:] = sorted(one for one in below if not one.startswith("."))
        found += [
            Path(name, one)
            for one in sorted(names)
            if not one.startswith(".") and Path(one).suffix.lower() in READERS
        ]
    return found


def looked(before: Looked, paths: Iterable[Path], now: float) -> Looked:
    """Return the stamps of files; a stamp that was seen before keeps the time of then.

    A file without content has not begun, and one that cannot be asked is not there.

    `now` is a time of the clock [s].
    """
    found: dict[Path, tuple[FileStamp, float]] = {}
    for path in paths:
        try:
            status = path.stat()
        except OSError:
            continue
        stamp = FileStamp(status.st_size, status.st_mtime_ns)
        if stamp.size:
            same = path in before and before[path][0] == stamp
            found[path] = before[path] if same else (stamp, now)
    return found


def standing(seen: Looked, settle: float, now: float) -> dict[Path, FileStamp]:
    """Return the files that have stood still for `settle` [s]."""
    return {path: stamp for path, (stamp, since) in seen.items() if now - since >= settle}
