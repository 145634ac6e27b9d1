"""The log of a watched folder: read again when it changes, drafted where nobody wrote one."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final, final

from shakerproc import files
from shakerproc.campaign.arrivals import FileStamp, looked
from shakerproc.errors import LogError, ShakerprocError
from shakerproc.recordings.raw import Sampling
from shakerproc.report.page.page import tried_header
from shakerproc.testlog import TestLog, ThresholdCrop, read_testlog
from shakerproc.workflows.draft_channels import controls_of_seen, crop_of, entries, own_channels
from shakerproc.workflows.draft_log import log_text, test_lines
from shakerproc.workflows.recordings_seen import SeenRecording, seen_of

LOG: Final = "testlog.yaml"
"""Name of the log that is drafted in a watched folder."""


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
        own = {
            path: own_channels(one, usual, controls_of_seen(one), "none") + _own_crop(log, one)
            for path, one in seen.items()
        }
        lines = test_lines(own, log.folder, {str(test.id) for test in log.tests})
        return text.rstrip("\n") + "\n" + lines

    def _usual(self, log: TestLog) -> Mapping[str, tuple[str, str]]:
        """Return the draft entries of the channels of the first recording that is there."""
        for test in log.tests:
            if test.recording is not None and test.recording.is_file():
                first = seen_of(test.recording, self._said, lambda _text: None)
                return entries(first[0]) if first else {}
        return {}


def _own_crop(log: TestLog, seen: SeenRecording) -> str:
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
