"""One test of a log as a job: its inputs and outputs, here or without a shared folder."""

import base64
import hashlib
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias, final

from shakerproc import files
from shakerproc.data import SourceFile
from shakerproc.errors import RecordingError, ShakerprocError
from shakerproc.executors import AbstractExecutor, Task, TaskOutcome, Work
from shakerproc.recordings import fetch, sha256
from shakerproc.recordings.source_files import FileHash
from shakerproc.testlog import Test, TestLog

RUNS: Final = "runs"
"""Folder below which each test has a folder of its own."""

SUMMARY: Final = "summary.json"

Hashed: TypeAlias = tuple[str, tuple[FileHash, ...]]
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
    seen: tuple[FileHash, ...] = ()


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


@contextmanager
def at_hand(log: TestLog, source: str | None) -> Iterator[TestLog]:
    """Yield a log whose recordings this machine sees; fetched copies go with the block.

    Raises
    ------
    RecordingError
        If a recording is not at the source.
    """
    if source is None:
        yield log
        return
    with tempfile.TemporaryDirectory(prefix="shakerproc-") as name:
        here = Path(name).resolve() / log.folder.name
        yield replace(log, tests=tuple(_moved(log, test, source, here) for test in log.tests))


def _moved(log: TestLog, test: Test, source: str, here: Path) -> Test:
    if test.discarded or test.recording is None:
        return test
    try:
        path = fetch(source, _lone_recording(log, test), here)
    except RecordingError as error:
        raise RecordingError(_about(test, str(error))) from error
    return replace(test, recording=path, folder=None)


def _lone_recording(log: TestLog, test: Test) -> str:
    """Return the path of the only file of a test below the folder of the log's recordings.

    Raises
    ------
    RecordingError
        If the test has several.
    """
    if test.continued or any(one.recording for one in test.beside):
        raise RecordingError(
            "has several files, which are joined only where the recordings lie beside the log; "
            "take --recordings out"
        )
    return relative_recording(log, test)


@dataclass(frozen=True, slots=True)
class Order:
    """One test for a remote worker.

    Attributes
    ----------
    work : callable
        What is to be done with the job.
    job : Job
        As for a worker of this machine.
    source : str
        Folder or URL of the recordings, as the worker sees it.
    """

    work: Work
    job: Job
    source: str


def work_remotely(order: Order) -> Mapping[str, Any]:
    """Process a test in a temporary folder; return the files written, and their hashes.

    Raises
    ------
    RecordingError
        If the recording is not the one that the batch was begun with.
    """
    job = order.job
    with tempfile.TemporaryDirectory(prefix="shakerproc-") as name:
        here = Path(name).resolve()
        path = fetch(order.source, job.recording, here / "recordings")
        if sha256(path) != job.sha256:
            raise RecordingError(
                f"{job.recording}: the recording at {order.source} is not the one that "
                "the batch began with (another SHA-256); give all machines the same recordings."
            )
        test = replace(job.test, recording=path, folder=None)
        root = here / "results"
        value = order.work(
            replace(job, test=test, root=root, folder=root / RUNS / job.folder.name)
        )
        content = {
            output: base64.b64encode((root / output).read_bytes()).decode("ascii")
            for output in value["outputs"]
        }
    return {"outputs": value["outputs"], "sha256": value["sha256"], "content": content}


@final
@dataclass(frozen=True, slots=True)
class RemoteExecutor(AbstractExecutor):
    """Another executor, whose workers need not see the folder of results.

    Attributes
    ----------
    executor : AbstractExecutor
        Where tasks run.
    source : str
        Folder or URL of the recordings, as its workers see it.
    """

    executor: AbstractExecutor
    source: str

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[TaskOutcome]:
        jobs = {task.name: task.argument for task in tasks}
        orders = [Task(name, Order(work, job, self.source)) for name, job in jobs.items()]
        for outcome in self.executor.run(work_remotely, orders):
            yield outcome if outcome.cause else _received(outcome, jobs[outcome.name])


def _received(outcome: TaskOutcome, job: Job) -> TaskOutcome:
    """Return the outcome with its files written below the root."""
    expected = dict(outcome.value["outputs"])
    for name, text in outcome.value["content"].items():
        content = base64.b64decode(text)
        path = (job.root / name).resolve()
        inside = path.is_relative_to(job.folder.resolve())
        if not inside or hashlib.sha256(content).hexdigest() != expected.get(name):
            return TaskOutcome(outcome.name, cause="error", error=f"{name} came back damaged")
        files.write_bytes(job.root / name, content)
    return TaskOutcome(outcome.name, {"outputs": expected, "sha256": outcome.value["sha256"]})


@final
@dataclass(frozen=True, slots=True)
class RemoteHashes:
    """The hashes of recordings, taken where they are.

    Attributes
    ----------
    executor : AbstractExecutor
        Where hashes are taken.
    source : str
        Folder or URL of the recordings, as its workers see it.
    """

    executor: AbstractExecutor
    source: str

    def __call__(self, log: TestLog) -> list[Hashed | ShakerprocError]:
        """Return the hash of the recording of each test, or why there is none."""
        hashes: dict[str, Hashed | ShakerprocError] = {}
        tasks = []
        for number, test in enumerate(log.active):
            try:
                relative = _lone_recording(log, test)
            except ShakerprocError as error:
                hashes[str(number)] = error
            else:
                tasks.append(Task(str(number), (self.source, relative)))
        for outcome in self.executor.run(hash_remotely, tasks):
            hashes[outcome.name] = (
                ShakerprocError(_about(log.active[int(outcome.name)], outcome.error))
                if outcome.cause
                else (outcome.value["sha256"], ())
            )
        return [hashes[str(number)] for number in range(len(log.active))]


def _about(test: Test, error: str) -> str:
    return f"{test.source}: test {test.id}: {error}"


def hash_remotely(place: tuple[str, str]) -> Mapping[str, str]:
    """Return the hash of a recording at a source and a path below it."""
    with tempfile.TemporaryDirectory(prefix="shakerproc-") as name:
        return {"sha256": sha256(fetch(*place, Path(name)))}
