"""One test of a log as a job for a worker: what is read, what is written, and where."""

import hashlib
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final, TypeAlias

from shakerproc.data import SourceFile
from shakerproc.errors import ShakerprocError
from shakerproc.recordings.source_files import Seen
from shakerproc.testlog import Test, TestLog

RUNS: Final = "runs"
"""Folder below which each test has a folder of its own."""

SUMMARY: Final = "summary.json"

Hashed: TypeAlias = tuple[str, tuple[Seen, ...]]
"""Hash of the recording of a test, and what is known of its files on this machine."""

NOT_HASHED: Final[Hashed] = ("", ())

_NOT_INPUT: Final = ("source", "folder", "recording", "geometry")


@dataclass(frozen=True, slots=True)
class Products:
    """Files that are written for each test, beside its summary.

    Attributes
    ----------
    figures : bool
        Whether to draw.
    exports : tuple of str
        Formats of the spectra besides CSV.
    thesis : bool
        Whether to write the tables of the thesis' scripts too.
    """

    figures: bool = True
    exports: tuple[str, ...] = ()
    thesis: bool = False


@dataclass(frozen=True, slots=True)
class Job:
    """One test for a worker.

    Attributes
    ----------
    test : Test
        From the log.
    root : Path
        Folder of all results.
    folder : Path
        Where the results of this test go, below it.
    recording : str
        The file as the log names it.
    sha256 : str
        Hash that the recording had when the batch began; to be processed is that or none.
    products : Products
        What to write.
    seen : tuple of Seen
        Hashes of its files that were taken when the batch began, with the stamps they had.
    """

    test: Test
    root: Path
    folder: Path
    recording: str
    sha256: str
    products: Products
    seen: tuple[Seen, ...] = ()


def folder_names(tests: Sequence[Test]) -> dict[int | str, str]:
    """Return a folder name for each test: its id where that is harmless, else with a hash."""
    names: dict[int | str, str] = {}
    for test in tests:
        text = str(test.id)
        plain = re.sub(r"[^A-Za-z0-9._-]", "_", text)[:60]
        mark = hashlib.sha256(text.encode()).hexdigest()[:8]
        harmless = plain == text and not text.endswith(".") and text == text.lower()
        names[test.id] = f"test_{plain}" if harmless else f"test_{plain.strip('.')}_{mark}"
    return names


def relative_recording(log: TestLog, test: Test) -> str:
    """Return the path of a recording below the folder of the log's recordings.

    Raises
    ------
    LogError
        If the test names none.
    """
    if test.recording is None:
        test.require_recording()
    return Path(test.recording or "").relative_to(log.folder).as_posix()


def input_of(test: Test) -> dict[str, object]:
    """Return the entries of the log for a test, without their places in the file."""
    entries = asdict(replace(test, geometry=None))  # drawn alone, and a mesh may be large
    return {k: v for k, v in entries.items() if k not in _NOT_INPUT}


def check_recording(job: Job, recording: SourceFile) -> None:
    """Pass the recording that the batch began with, as it is opened for a job.

    Raises
    ------
    ShakerprocError
        If its bytes are others.
    """
    now = recording.first_sha256()
    if now != job.sha256:
        raise ShakerprocError(changed_since(job, now))


def changed_since(job: Job, now: str) -> str:
    """Return that a recording has another SHA-256 than when the batch began, in one line."""
    return (
        f"test {job.test.id}: the recording {job.recording} changed after the batch began "
        f"(SHA-256 {job.sha256[:12]}... then, {now[:12]}... now), so nothing is made of it. "
        "Wait until nothing changes it any more, then call again."
    )
