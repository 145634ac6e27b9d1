"""A folder of results: its manifest, by which a batch resumes; one batch at a time in it."""

import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from filelock import FileLock, Timeout
from pydantic_core import ValidationError

from shakerproc import __version__, files
from shakerproc.campaign.jobs import folder_names
from shakerproc.errors import LockedError, LogError, ShakerprocError
from shakerproc.testlog import Test

NAME: Final = "manifest.json"

SCHEMA: Final = "shakerproc-manifest/2"
"""In 1, the hash of a recording was taken before the recording was read, at another time."""

SINGLE: Final = "process"
"""Name of the only entry where a folder holds the results of a single recording."""

RESULTS: Final = frozenset({
    ".csv", ".html", ".mat", ".parquet", ".pdf", ".png", ".uff", ".unv",
})  # fmt: skip
"""Endings of files that hold results, in lower case; a document may go anywhere by `--json`."""

Status: TypeAlias = Literal["done", "failed"]


@dataclass(frozen=True, slots=True)
class Entry:
    """State of one test of the log.

    Attributes
    ----------
    status : Status
        Whether its outputs stand.
    key : str
        Hash of all that the outputs depend on: recording, options, log entry, version.
    recording_sha256 : str
        Hash of the bytes that results were first made from; empty where none were yet.
    outputs : mapping
        Hash of each file that was written, by its path in the folder; where a test failed,
        of those that an earlier batch wrote.
    cause, error, detail : str
        Why it failed: one word, one line, the traceback.
    """

    status: Status
    key: str
    recording_sha256: str
    outputs: Mapping[str, str] = field(default_factory=dict)
    cause: str = ""
    error: str = ""
    detail: str = ""


@dataclass(frozen=True, slots=True)
class Manifest:
    """Contents of a folder of results.

    Attributes
    ----------
    runs : mapping
        Entry of each test, by the folder its results are in.
    version : str
        Version of shakerproc that wrote it.
    schema : str
        What its entries mean.
    command : str
        Which command the folder belongs to.
    files : tuple of str
        What was written for no test alone, by its path in the folder.
    """

    runs: Mapping[str, Entry] = field(default_factory=dict)
    version: str = __version__
    schema: str = SCHEMA
    command: str = "batch"
    files: tuple[str, ...] = ()

    @property
    def outdated(self) -> bool:
        """Whether its hashes may be of other bytes than those that were read."""
        return self.schema != SCHEMA

    def with_entry(self, name: str, entry: Entry) -> "Manifest":
        """Return the manifest with one entry added or replaced."""
        return replace(self, runs={**self.runs, name: entry})


NOTHING: Final = Entry("failed", "", "")
"""What is known of a test that was never seen."""


def read_manifest(folder: Path) -> Manifest:
    """Return the manifest of a folder; an empty one where there is none yet.

    Raises
    ------
    LogError
        If the file is not a manifest.
    """
    path = folder / NAME
    if not path.exists():
        return Manifest()
    try:
        return _read(path.read_bytes())
    except ValidationError as error:
        raise LogError(
            f"{path}: not a manifest of shakerproc. Remove the file to compute everything "
            "again, or choose another folder with --out."
        ) from error


def _read(content: bytes) -> Manifest:
    from pydantic import TypeAdapter  # where no manifest is there yet, nothing needs it

    return TypeAdapter(Manifest).validate_json(content)


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write the manifest of a folder, whole or not at all."""
    files.write_json(folder / NAME, {"schema": SCHEMA, **fields_of(manifest)})


def fields_of(manifest: Manifest) -> dict[str, Any]:
    """Return the fields of a manifest, in an order that does not depend on who was first."""
    return {
        "version": manifest.version,
        "command": manifest.command,
        "files": sorted(manifest.files),
        "runs": dict(sorted(manifest.runs.items())),
    }


def check_result_folder(folder: Path, command: str) -> None:
    """Pass a folder that a command may write its results into, before the long work.

    Raises
    ------
    OutputError
        If nothing can be written there.
    LogError
        If it holds the results of another command.
    """
    files.checked_folder(folder)
    check_owner(folder, command)


def check_owner(folder: Path, command: str) -> None:
    """Pass a folder of which nothing is overwritten that this command did not write.

    Raises
    ------
    LogError
        If it holds the results of another command, or a file such as results have and no
        manifest of them.
    """
    if not (folder / NAME).exists():
        kept = sorted(p.name for p in folder.glob("*") if p.suffix.lower() in RESULTS)
        if kept:
            raise LogError(
                f"{folder}: holds {kept[0]}, which shakerproc did not write and may overwrite; "
                "choose another folder with --out, or move the file away."
            )
    else:
        owner = read_manifest(folder).command
        if owner != command:
            raise LogError(
                f"{folder}: holds the results of `shakerproc {owner}`; choose another folder "
                "with --out, or move this one away."
            )


def settle(folder: Path, written: Iterable[Path], command: str = "batch") -> None:
    """Register the files written now; remove those that only an earlier run wrote."""
    known = read_manifest(folder)
    inside = [path.absolute() for path in written]
    names = {
        path.relative_to(folder.absolute()).as_posix()
        for path in inside
        if path.is_relative_to(folder.absolute()) and path.is_file()
    }
    remove_outputs(folder, set(known.files) - names)
    write_manifest(folder, replace(known, command=command, files=tuple(sorted(names))))


def key_of(recording_sha256: str, description: object) -> str:
    """Return the hash of all that the outputs of one test depend on."""
    text = json.dumps(
        [__version__, recording_sha256, json.loads(files.json_text(description))],
        sort_keys=True,
    )
    return hashlib.sha256(text.encode()).hexdigest()


def hashes(folder: Path, paths: Iterable[Path]) -> dict[str, str]:
    """Return the hash of each file, by its path in the folder, in order."""
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(paths)
    }


def remove_outputs(folder: Path, names: Iterable[str]) -> None:
    """Remove files that were written below a folder once, and folders that become empty."""
    for name in names:
        path = folder / name
        if path.resolve().is_relative_to(folder.resolve()):
            path.unlink(missing_ok=True)
            with suppress(OSError):
                path.parent.rmdir()


def stands(folder: Path, entry: Entry | None, key: str) -> bool:
    """Return whether the outputs of a test are there, whole and made from the same input."""
    if entry is None or entry.status != "done" or entry.key != key or not entry.outputs:
        return False
    paths = [folder / name for name in entry.outputs]
    return all(path.is_file() for path in paths) and hashes(folder, paths) == dict(
        entry.outputs
    )


LOCK: Final = ".shakerproc.lock"


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for the block; a lock whose holder was killed is free again.

    Raises
    ------
    LockedError
        If another shakerproc holds it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = FileLock(folder / LOCK)
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
