"""A folder of results: one batch at a time in it, or one recording's alone."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from shakerproc import files
from shakerproc.campaign.jobs import folder_names
from shakerproc.campaign.manifest import (
    SINGLE,
    Entry,
    Manifest,
    check_owner,
    hashes,
    key_of,
    read_manifest,
    remove_outputs,
    write_manifest,
)
from shakerproc.errors import LockedError, ShakerprocError
from shakerproc.testlog import Test

NAME: Final = ".shakerproc.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for the block; a lock whose holder was killed is free again.

    Raises
    ------
    LockedError
        If another shakerproc holds it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / NAME)
    try:
        lock.acquire(blocking=False)
    except Timeout as error:
        raise LockedError(
            f"{folder}: another shakerproc works in this folder. Wait until it is done, or "
            "choose another folder with --out."
        ) from error
    try:
        yield
    finally:
        lock.release()


def folder_name(recording: Path, test: Test) -> str:
    """Return how the folder of one recording's results is called.

    After the test of the log; without one after the recording and the folder that it lies in,
    because some programs give every recording the same name, and what of it is processed.
    """
    if test.recording is not None:
        return f"{folder_names([test])[test.id]}_results"
    group, number = test.processing.group, test.processing.measurement
    part = [] if group is None else [re.sub(r"[^\w.-]", "_", group)[:60]]
    part += [] if number is None else [f"measurement_{number}"]
    # without "..", but as the caller names it: links are not followed
    folder = Path(os.path.abspath(recording)).parent.parts[1:][-1:]  # noqa: PTH100
    return "_".join([*folder, recording.stem, *part, "results"])


def check_folder(folder: Path, sha256: str) -> None:
    """Pass a folder that holds no results, or those of this very recording.

    Raises
    ------
    ShakerprocError
        If it holds those of another recording, or of another command.
    """
    check_owner(folder, SINGLE)
    entry = read_manifest(folder).runs.get(SINGLE)
    if entry is not None and entry.recording_sha256 != sha256:
        raise ShakerprocError(
            f"{folder}: holds the results of another recording (SHA-256 "
            f"{entry.recording_sha256[:12]}..., this one has {sha256[:12]}...); "
            "choose another folder with --out, or move this one away."
        )


def put_in_place(folder: Path, staged: Path, sha256: str, described: object) -> None:
    """Move the results of a recording into their folder, in place of those of an earlier run.

    At any moment the manifest lists whatever of them is there.
    """
    before = read_manifest(folder).runs.get(SINGLE)
    old = {} if before is None else before.outputs
    new = hashes(staged, [path for path in staged.rglob("*") if path.is_file()])
    key = key_of(sha256, described)
    underway = Entry("failed", key, sha256, {**old, **new}, "killed", "not finished")
    write_manifest(folder, Manifest({SINGLE: underway}, command=SINGLE))
    remove_outputs(folder, set(old) - set(new))
    files.move_into(folder, staged)
    done = Entry("done", key, sha256, new)
    write_manifest(folder, Manifest({SINGLE: done}, command=SINGLE))
