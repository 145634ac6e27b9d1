"""Every test of a log through an executor: finished tests are kept, failed ones named."""

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final, TypeAlias

from shakerproc import __version__, files
from shakerproc.campaign.jobs import (
    NOT_HASHED,
    RUNS,
    SUMMARY,
    Hashed,
    Job,
    Products,
    changed_since,
    folder_names,
    input_of,
    relative_recording,
)
from shakerproc.campaign.result_folder import (
    NOTHING,
    Entry,
    Manifest,
    check_owner,
    key_of,
    read_manifest,
    remove_outputs,
    stands,
    write_manifest,
)
from shakerproc.errors import ShakerprocError
from shakerproc.executors import AbstractExecutor, Task, TaskOutcome, Work
from shakerproc.runs import RunSummary, read_summary
from shakerproc.runs.joining import combined, seen_files
from shakerproc.testlog import Test, TestLog, facts_of


@dataclass(frozen=True, slots=True)
class CampaignResult:
    """Result of a batch.

    Attributes
    ----------
    runs : tuple of RunSummary
        Every test of the log in order, discarded and failed ones included.
    computed, kept : int
        Tests that were processed now, and those whose results stood already.
    """

    runs: tuple[RunSummary, ...]
    computed: int
    kept: int


Hashes: TypeAlias = Callable[[TestLog], Sequence[Hashed | ShakerprocError]]
"""From a log to the hash of the recording of each active test, or why there is none."""


@dataclass(frozen=True, slots=True)
class Execution:
    """How tests are processed.

    Attributes
    ----------
    work : callable
        From a `Job` to ``{"outputs": {path below root: SHA-256}, "sha256": of the bytes of the
        recording that they are made from}``.
    executor : AbstractExecutor
        Where it runs.
    hashes : callable, optional
        Where the hashes of the recordings are from; by default from the files of the log.
    """

    work: Work
    executor: AbstractExecutor
    hashes: Hashes | None = None


@dataclass(frozen=True, slots=True)
class BatchListener:
    """Functions that are told the progress of a batch.

    Attributes
    ----------
    on_start : callable
        Called with the number of tests to do and of those kept.
    on_outdated : callable
        Called with the number of tests that were done and are to do again though their
        recordings are the same, if there are such, and with what has changed, a sentence part.
    on_end : callable
        Called with the id of each test as it ends.
    """

    on_start: Callable[[int, int], object] = lambda _to_do, _kept: None
    on_outdated: Callable[[int, str], object] = lambda _count, _why: None
    on_end: Callable[[str], object] = lambda _test: None


UNTOLD: Final = BatchListener()


def run_batch(
    log: TestLog,
    root: Path,
    products: Products,
    execution: Execution,
    *,
    accept_changed: bool = False,
    only: Collection[int | str] | None = None,
    progress: BatchListener = UNTOLD,
) -> CampaignResult:
    """Process every test of a log that is not discarded and whose results do not stand.

    The manifest is written after each test, so that whatever ends this, the next call goes on
    where it stopped. Hold the folder with `locked` around it.

    Parameters
    ----------
    log : TestLog
        The log.
    root : Path
        Folder of the results.
    products : Products
        What to write for each test.
    execution : Execution
        How and where it is done.
    accept_changed : bool
        Whether a recording may differ from what was seen first.
    only : collection of ids, optional
        Tests to process now; what is known of the others stays as it is, and those that
        were never processed are not in the result. By default all.
    progress : BatchListener
        What is told meanwhile; by default nothing.

    Returns
    -------
    Campaign
        How every test went.
    """
    files.remove_leftovers(root)
    names = folder_names(log.tests)
    known = _known(root, set(names.values()), progress.on_outdated)
    chosen = log if only is None else _part(log, only)
    hashes = (execution.hashes or _hashes)(chosen)
    ready, manifest = _ready(
        chosen, root, known, products, hashes=hashes, accept_changed=accept_changed
    )
    if only is not None:
        manifest = replace(manifest, runs=_merged(log, names, known, manifest))
    to_do = {
        job.folder.name: (job, key)
        for job, key in ready
        if not stands(root, known.runs.get(job.folder.name), key)
    }
    again = sum(known.runs.get(name, NOTHING).status == "done" for name in to_do)
    if again:
        progress.on_outdated(again, _changes(known))
    write_manifest(root, manifest)
    progress.on_start(len(to_do), len(ready) - len(to_do))
    tasks = [Task(name, job) for name, (job, _) in to_do.items()]
    for outcome in execution.executor.run(execution.work, tasks):
        job, key = to_do[outcome.name]
        before = known.runs.get(outcome.name, NOTHING)
        entry = _entry(outcome, job, key, "" if accept_changed else before.recording_sha256)
        remove_outputs(root, set(before.outputs) - set(entry.outputs))
        manifest = manifest.with_entry(outcome.name, entry)
        write_manifest(root, manifest)
        progress.on_end(str(job.test.id))
    runs = tuple(
        _summary(test, root / RUNS / names[test.id], manifest)
        for test in log.tests
        if test.discarded or manifest.runs.get(names[test.id], NOTHING).key
    )
    return CampaignResult(runs, len(to_do), len(ready) - len(to_do))


def _part(log: TestLog, only: Collection[int | str]) -> TestLog:
    return replace(log, tests=tuple(test for test in log.tests if test.id in only))


def _merged(
    log: TestLog, names: Mapping[int | str, str], known: Manifest, now: Manifest
) -> Mapping[str, Entry]:
    """Return the entries of every test of a log, of which some are processed now."""
    both = {**known.runs, **now.runs}
    return {names[t.id]: both[names[t.id]] for t in log.active if names[t.id] in both}


def _ready(
    log: TestLog,
    root: Path,
    known: Manifest,
    products: Products,
    *,
    hashes: Sequence[Hashed | ShakerprocError],
    accept_changed: bool,
) -> tuple[list[tuple[Job, str]], Manifest]:
    """Return the tests whose recording is there, with their keys, and a manifest of all."""
    ready, entries, names = [], {}, folder_names(log.tests)
    for test, hashed in zip(log.active, hashes, strict=True):
        name = names[test.id]
        before = known.runs.get(name)
        problem = hashed if isinstance(hashed, ShakerprocError) else None
        digest, seen = NOT_HASHED if isinstance(hashed, ShakerprocError) else hashed
        if problem is None and before and before.recording_sha256 and not accept_changed:
            problem = _changed(test, before.recording_sha256, digest)
            digest = before.recording_sha256
        key = key_of(digest, [input_of(test), asdict(products)])
        if problem is not None:
            earlier = {} if before is None else before.outputs
            entries[name] = Entry("failed", key, digest, earlier, "input", str(problem))
            continue
        recording = relative_recording(log, test)
        folder = root / RUNS / name
        ready.append((Job(test, root, folder, recording, digest, products, seen), key))
        if before is not None:
            entries[name] = before
    return ready, Manifest(entries, files=known.files)


def _hashes(log: TestLog) -> Sequence[Hashed | ShakerprocError]:
    with ThreadPoolExecutor(max_workers=min(4, os.cpu_count() or 1)) as pool:
        return list(pool.map(_hash, log.active))


def _hash(test: Test) -> Hashed | ShakerprocError:
    try:
        seen = seen_files(test.require_recordings())
    except ShakerprocError as error:
        return error
    return combined([one.sha256 for one in seen]), seen


def _changed(test: Test, first: str, now: str) -> ShakerprocError | None:
    if first == now:
        return None
    return ShakerprocError(
        f"test {test.id}: the recording has changed since it was first processed (SHA-256 "
        f"{first[:12]}... then, {now[:12]}... now). Restore it, or accept the new one with "
        "--accept-changed."
    )


def _known(
    root: Path, names: Collection[str], on_outdated: Callable[[int, str], object]
) -> Manifest:
    """Return the earlier entries of a folder; of results that are not relied on, only files."""
    check_owner(root, "batch")
    known = read_manifest(root)
    if not known.outdated:
        return known
    done = [n for n, entry in known.runs.items() if entry.status == "done" and n in names]
    if done:
        on_outdated(
            len(done),
            "an older shakerproc took the SHA-256 at another time than it read the recording",
        )
    files_only = {n: replace(NOTHING, outputs=e.outputs) for n, e in known.runs.items()}
    return Manifest(files_only, files=known.files)


def _changes(known: Manifest) -> str:
    """Return why results of unchanged recordings are stale, as a part of a sentence."""
    if known.version != __version__:
        return f"they are of shakerproc {known.version}, this is {__version__}"
    return "what the log or the options say of them has changed, or a file of results is gone"


def _entry(outcome: TaskOutcome, job: Job, key: str, first: str) -> Entry:
    """Return the entry of a test; a failure keeps the hash that was known before."""
    cause, error = outcome.cause, outcome.error
    digest = outcome.value.get("sha256", "")
    if not cause and digest != job.sha256:
        cause, error = "input", changed_since(job, digest)
    if cause:
        return Entry("failed", key, first, cause=cause, error=error, detail=outcome.detail)
    return Entry("done", key, digest, outputs=dict(outcome.value["outputs"]))


def _summary(test: Test, folder: Path, manifest: Manifest) -> RunSummary:
    """Return the summary of a test after the batch."""
    recording = "" if test.recording is None else test.recording.name
    base = RunSummary(str(test.id), "discarded", facts_of(test), recording)
    if test.discarded:
        return base
    entry = manifest.runs[folder.name]
    if entry.status == "done":
        return read_summary(folder / SUMMARY)
    return replace(
        base,
        status="failed",
        error=entry.error,
        detail=entry.detail,
        sha256=entry.recording_sha256,
    )
