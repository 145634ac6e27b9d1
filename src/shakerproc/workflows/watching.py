"""A folder watched while it is measured: each finished recording goes through `run_log`."""

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias, final

from shakerproc.campaign.arrivals import FileStamp, Looked, looked, recordings_in, standing
from shakerproc.campaign.batch import CampaignResult, Progress
from shakerproc.campaign.jobs import Products, folder_names
from shakerproc.campaign.manifest import read_manifest
from shakerproc.errors import RecordingError
from shakerproc.report.page.page import Watched, tried_header
from shakerproc.runs import RunSummary
from shakerproc.testlog import TestLog
from shakerproc.workflows.log_runs import run_log
from shakerproc.workflows.machines import Machines
from shakerproc.workflows.write_up import TrendWish, units_of, write_up

Still: TypeAlias = Mapping[Path, FileStamp]
"""The recordings that stand still, with their stamps."""

Logs: TypeAlias = Callable[[Still], TestLog | None]
"""From the recordings that stand still to the log as it is now; None while there is none."""

_REFRESH: Final = 2.0
"""Shortest time between two loads of the page in a browser [s]."""


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
            still = standing(seen, pace.settle, now)
            if self._look(still, pace) or len(still) < len(seen):
                changed = time.monotonic()
            if pace.idle is not None and time.monotonic() - changed >= pace.idle:
                return
            time.sleep(pace.every)

    def last(self) -> dict[str, Any]:
        """Write tables and page as a batch leaves them; return what report.json holds.

        That is nothing where no test was ever looked at, or the folder of the results is gone.
        """
        if self.log is None or not self.root.is_dir():
            return {}
        return self._round(self.log, (), None)

    def _look(self, still: Still, pace: Pace) -> bool:
        """Work what is new through; return whether something was."""
        log = self._logs(still)
        if log is None:
            return False
        other = log is not self.log
        if other:
            self._tried, self.log = {}, log
            self._wish = replace(self._wish, header=tried_header(log), units=units_of(log))
        arrived = {
            test.id: tuple(still[path] for path in files)
            for test in log.active
            if (files := _resolved(test.files)) and all(path in still for path in files)
        }
        due = {test: now for test, now in arrived.items() if self._tried.get(test) != now}
        if other or due:
            refresh = max(_REFRESH, pace.every)
            self._round(log, due, refresh)
            self._tried |= due
        if due and self._after is not None:
            there = [test for test in log.active if test.id in arrived]
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
            progress=Progress(on_end=ended.append),
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
    how = f"{state}{run.told_status}" if run.incomplete else run.told_status
    return f"test {run.test} ({run.recording}){again}: {how}{f'; flags: {odd}' if odd else ''}"


def _waiting(log: TestLog, campaign: CampaignResult) -> tuple[str, ...]:
    """Return the tests whose recordings have not come yet."""
    known = {run.test for run in campaign.runs}
    return tuple(str(test.id) for test in log.active if str(test.id) not in known)
