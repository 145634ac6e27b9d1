"""A folder watched while it is measured, and its log, drafted where nobody wrote one."""

import os
import re
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias, final

from shakerproc import files
from shakerproc.campaign import result_folder
from shakerproc.campaign.batch import BatchListener, CampaignResult
from shakerproc.campaign.jobs import Products, folder_names
from shakerproc.campaign.result_folder import read_manifest
from shakerproc.errors import LogError, RecordingError, ShakerprocError
from shakerproc.recordings import READERS
from shakerproc.recordings.raw import Sampling
from shakerproc.report.page.page import Watched, tried_header
from shakerproc.runs import RunSummary
from shakerproc.testlog import TestLog, ThresholdCrop, read_testlog
from shakerproc.workflows.arguments import Machines
from shakerproc.workflows.campaign import TrendWish, run_log, units_of, write_up
from shakerproc.workflows.draft import (
    SeenRecording,
    controls_of_seen,
    crop_of,
    entries,
    log_text,
    seen_of,
    test_lines,
    unusual_channels,
)

_OURS: Final = frozenset({result_folder.LOCK, result_folder.NAME})
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
    paths = []
    for name, below, names in os.walk(folder):
        if not _OURS.isdisjoint(names):
            below.clear()
            continue
        below[:] = sorted(one for one in below if not one.startswith("."))
        paths += [
            Path(name, one)
            for one in sorted(names)
            if not one.startswith(".") and Path(one).suffix.lower() in READERS
        ]
    return paths


def looked(before: Looked, paths: Iterable[Path], now: float) -> Looked:
    """Return the stamps of files; a stamp that was seen before keeps the time of then.

    A file without content has not begun, and one that cannot be asked is not there.

    `now` is a time of the clock [s].
    """
    stamps: dict[Path, tuple[FileStamp, float]] = {}
    for path in paths:
        try:
            status = path.stat()
        except OSError:
            continue
        stamp = FileStamp(status.st_size, status.st_mtime_ns)
        if stamp.size:
            same = path in before and before[path][0] == stamp
            stamps[path] = before[path] if same else (stamp, now)
    return stamps


def finished_files(seen: Looked, settle: float, now: float) -> dict[Path, FileStamp]:
    """Return the files that have stood still for `settle` [s]."""
    return {path: stamp for path, (stamp, since) in seen.items() if now - since >= settle}


LOG: Final = "testlog.yaml"
"""Name of the log that is drafted in a watched folder."""

Still: TypeAlias = Mapping[Path, FileStamp]
"""The recordings that stand still, with their stamps."""

Logs: TypeAlias = Callable[[Still], TestLog | None]
"""From the recordings that stand still to the log as it is now; None while there is none."""

_REFRESH: Final = 2.0
"""Shortest time between two loads of the page in a browser [s]."""


@final
class WatchedLog:
    """A log as it is now; while it cannot be read, as it was.

    Parameters
    ----------
    path : Path
        The file.
    warn : callable
        Called with what is wrong.
    """

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        self.path = path
        self._warn = warn
        self._stamp: FileStamp | None = None
        self._log: TestLog | None = None

    def read(self) -> TestLog:
        """Return the log; the same object while the file stays as it is.

        Raises
        ------
        ShakerprocError
            If it cannot be read, and never could.
        """
        now = looked({}, [self.path], 0.0).get(self.path, (None, 0.0))[0]
        if self._log is not None and now == self._stamp:
            return self._log
        try:
            log = read_testlog(self.path)
            tried_header(log)  # a photo that cannot be read is an error of the log too
            self._log = log
        except ShakerprocError as error:
            if self._log is None:
                raise
            self._warn(f"{error}; until that is corrected, the log counts as it was")
        self._stamp = now
        return self._log


@final
class GivenLog:
    """A log that somebody wrote; recordings that it does not name are told once.

    Parameters
    ----------
    log : WatchedLog
        The log.
    folder : Path
        The watched folder.
    warn : callable
        Called with what is wrong.
    """

    def __init__(self, log: WatchedLog, folder: Path, warn: Callable[[str], None]) -> None:
        self._log, self._folder, self._warn = log, folder.resolve(), warn
        self._told: set[Path] = set()

    def __call__(self, still: Mapping[Path, FileStamp]) -> TestLog:
        """Return the log as it is now."""
        log = self._log.read()
        for path in _unnamed(log, still):
            if path.is_relative_to(self._folder) and path not in self._told:
                self._told.add(path)
                name = path.relative_to(self._folder)
                self._warn(f"{name} is in no test of {log.path.name}; add one to process it")
        return log


@final
class DraftedLog:
    """A log in the watched folder itself, to which each new recording adds a test.

    Parameters
    ----------
    folder : Path
        The watched folder.
    said : Sampling
        What is said of the times of the recordings.
    warn : callable
        Called with what is wrong.
    """

    def __init__(self, folder: Path, said: Sampling, warn: Callable[[str], None]) -> None:
        self._folder, self._said, self._warn = folder.resolve(), said, warn
        self._path = self._folder / LOG
        self._log = WatchedLog(self._path, warn)
        self._tried: dict[Path, FileStamp] = {}

    def __call__(self, still: Mapping[Path, FileStamp]) -> TestLog | None:
        """Return the log with a test for each recording that stands still; None without any.

        Raises
        ------
        LogError
            If the log of the folder is laid out so that no test can be added at its end.
        """
        log = self._log.read() if self._path.exists() else None
        named = still if log is None else _unnamed(log, still)
        new = [path for path in named if self._tried.get(path) != still[path]]
        self._tried |= {path: still[path] for path in new}
        seen = [one for path in new for one in seen_of(path, self._said, self._warn)]
        if not seen:
            return log
        seen.sort(key=lambda one: not one.rms)  # what can be used speaks first
        if log is None:
            text = log_text(self._folder, self._folder, seen, self._said, self._warn)
        else:
            text = self._longer(log, {one.path: one for one in seen})
        files.write_text(self._path, text)
        return self._log.read()

    def _longer(self, log: TestLog, seen: Mapping[Path, SeenRecording]) -> str:
        """Return the text of the log with a line for each further recording.

        Raises
        ------
        LogError
            If its last key is not the list of tests.
        """
        text = self._path.read_text(encoding="utf-8")
        keys = re.findall(r"^([^\s#-][^:\n]*):(.*)$", text, re.MULTILINE)
        if not keys or keys[-1][0] != "tests" or keys[-1][1].partition("#")[0].strip():
            raise LogError(
                f"{self._path}: a new recording gets its test at the end of the file, and "
                "tests: is not there. Move tests: to the end, or name the log with --log."
            )
        usual = self._usual(log)
        channel_lines = {
            path: unusual_channels(one, usual, controls_of_seen(one), "none")
            + _quiet_crop(log, one)
            for path, one in seen.items()
        }
        lines = test_lines(channel_lines, log.folder, {str(test.id) for test in log.tests})
        return text.rstrip("\n") + "\n" + lines

    def _usual(self, log: TestLog) -> Mapping[str, tuple[str, str]]:
        """Return the draft entries of the channels of the first recording that is there."""
        for test in log.tests:
            if test.recording is not None and test.recording.is_file():
                first = seen_of(test.recording, self._said, lambda _text: None)
                return entries(first[0]) if first else {}
        return {}


def _quiet_crop(log: TestLog, seen: SeenRecording) -> str:
    """Return the threshold of a recording that is too quiet for that of the log."""
    crop = log.tests[0].processing.crop if log.tests else None
    controls = controls_of_seen(seen)
    if not (isinstance(crop, ThresholdCrop) and controls and seen.rms):
        return ""
    if 0.5 * seen.rms[seen.names.index(controls[0])] >= crop.threshold:
        return ""
    own = crop_of([seen], controls).partition("#")[0].strip()
    return f", processing: {{crop: {own}}}"


def _unnamed(log: TestLog, still: Mapping[Path, FileStamp]) -> list[Path]:
    """Return the recordings that no test of a log has, discarded ones included."""
    named = {path.resolve() for test in log.tests for path in test.files}
    return [path for path in still if path not in named]


@final
@dataclass(frozen=True, slots=True)
class Pace:
    """How often a folder is looked at.

    Attributes
    ----------
    settle : float
        Time for which size and time of a file must stand still for it to be finished [s].
    every : float
        Time between two checks of the folder [s].
    idle : float, optional
        Time without anything new after which the watch ends [s]; by default never.
    """

    settle: float = 3.0
    every: float = 1.0
    idle: float | None = None


@final
class Watch:
    """A folder whose recordings are processed as they are finished.

    What is done is in the manifest of the results, as of a batch, so a watch that was killed
    goes on where it stopped. Hold the folder of the results with `locked` around it.

    Parameters
    ----------
    folder, root : Path
        What is watched, and where the results go.
    logs : callable
        The log, asked for at each look.
    products, machines, wish
        As of a batch.
    tell : callable
        Called with a line about each test that ended.
    after : callable, optional
        Called with the log after tests have ended.
    """

    def __init__(
        self,
        folder: Path,
        root: Path,
        logs: Logs,
        *,
        products: Products,
        machines: Machines,
        wish: TrendWish,
        tell: Callable[[str], None],
        after: Callable[[TestLog], None] | None = None,
    ) -> None:
        self.folder = folder.resolve()
        self.root = root
        self.log: TestLog | None = None
        self._logs = logs
        self._products, self._machines, self._wish, self._tell = products, machines, wish, tell
        self._after = after
        self._tried: dict[int | str, tuple[FileStamp, ...]] = {}

    def run(self, pace: Pace) -> None:
        """Look again and again, until nothing new has come for `pace.idle`.

        Raises
        ------
        RecordingError
            If the folder vanishes.
        """
        seen: Looked = {}
        changed = time.monotonic()
        while True:
            self._check_folder()
            before = seen
            paths = {*recordings_in(self.folder), *self._files()}
            now = time.monotonic()
            seen = looked(before, paths, now)
            still = finished_files(seen, pace.settle, now)
            if self._look(still, pace) or len(still) < len(seen):
                changed = time.monotonic()
            if pace.idle is not None and time.monotonic() - changed >= pace.idle:
                return
            time.sleep(pace.every)

    def last(self) -> dict[str, Any]:
        """Write tables and page as a batch does; return the content of report.json.

        That is nothing where no test was ever looked at, or the folder of the results is gone.
        """
        if self.log is None or not self.root.is_dir():
            return {}
        return self._round(self.log, (), None)

    def _look(self, still: Still, pace: Pace) -> bool:
        """Process new recordings; return whether there was one."""
        log = self._logs(still)
        if log is None:
            return False
        other = log is not self.log
        if other:
            self._tried, self.log = {}, log
            self._wish = replace(self._wish, header=tried_header(log), units=units_of(log))
        arrivals = {
            test.id: tuple(still[path] for path in files)
            for test in log.active
            if (files := _resolved(test.files)) and all(path in still for path in files)
        }
        due = {test: now for test, now in arrivals.items() if self._tried.get(test) != now}
        if other or due:
            refresh = max(_REFRESH, pace.every)
            self._round(log, due, refresh)
            self._tried |= due
        if due and self._after is not None:
            there = [test for test in log.active if test.id in arrivals]
            self._after(replace(log, tests=tuple(there)))
        return bool(due)

    def _round(
        self, log: TestLog, due: Collection[int | str], refresh: float | None
    ) -> dict[str, Any]:
        """Process tests, write tables and page; with a refresh, a page that is watched."""
        before = _read_from(self.root, log)
        ended: list[str] = []
        campaign = run_log(
            log,
            self.root,
            self._products,
            self._machines,
            accept_changed=True,
            only=due,
            progress=BatchListener(on_end=ended.append),
        )
        if campaign.kept:
            self._tell(f"{campaign.kept} reused from an earlier watch or batch")
        wanted = {str(test) for test in due}
        for run in campaign.runs:
            if run.test in ended or (run.test in wanted and run.status == "failed"):
                self._tell(_sentence(run, before.get(run.test, "")))
        watched = None if refresh is None else Watched(refresh, _waiting(log, campaign))
        wish = replace(self._wish, watched=watched)
        return write_up(log.title, campaign, self.root, wish)

    def _files(self) -> Collection[Path]:
        tests = () if self.log is None else self.log.active
        return {path for test in tests for path in _resolved(test.files)}

    def _check_folder(self) -> None:
        if not self.folder.is_dir():
            raise RecordingError(
                f"{self.folder}: the watched folder is gone. What is done stands in "
                f"{self.root}; bring the folder back and call again to go on."
            )


def _resolved(paths: Collection[Path]) -> tuple[Path, ...]:
    return tuple(path.resolve() for path in paths)


def _read_from(root: Path, log: TestLog) -> dict[str, str]:
    """Return the SHA-256 of the recording that the results of each test are made from."""
    names, known = folder_names(log.tests), read_manifest(root).runs
    return {
        str(test): entry.recording_sha256
        for test, name in names.items()
        if (entry := known.get(name)) is not None and entry.status == "done"
    }


def _sentence(run: RunSummary, before: str) -> str:
    """Return the result of a test in one line."""
    if run.status == "failed":
        return f"test {run.test} failed: {run.error}"
    again = " again: the recording changed" if before and before != run.sha256 else ""
    state = "up to its last complete row: " if run.incomplete else ""
    odd = ", ".join(dict.fromkeys(flag.kind for flag in run.flags))
    how = f"{state}{run.status_text}" if run.incomplete else run.status_text
    return f"test {run.test} ({run.recording}){again}: {how}{f'; flags: {odd}' if odd else ''}"


def _waiting(log: TestLog, campaign: CampaignResult) -> tuple[str, ...]:
    """Return the tests whose recordings have not come yet."""
    known = {run.test for run in campaign.runs}
    return tuple(str(test.id) for test in log.active if str(test.id) not in known)
