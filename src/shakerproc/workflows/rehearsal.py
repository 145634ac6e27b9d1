"""A campaign simulated: the recordings that a log describes, written where it expects them."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from shakerproc import files
from shakerproc.errors import LogError

if TYPE_CHECKING:
    from shakerproc.data import Recording
    from shakerproc.models import Model
    from shakerproc.planning import Staging
    from shakerproc.testlog import Test, TestLog


def rehearse_campaign(
    model: "Model",
    log: "TestLog",
    staging: "Staging",
    *,
    folder: Path | None = None,
    wanted: Sequence[str] = (),
    overwrite: bool = False,
    advance: Callable[[str], None] = lambda _text: None,
    warn: Callable[[str], None] = lambda _text: None,
) -> list[dict[str, object]]:
    """Write the recording of each test that has one; return what is known of each.

    Parameters
    ----------
    folder : Path, optional
        Where a copy of the log goes, and the recordings below it; by default they are written
        beside the log itself.
    wanted : sequence of str
        Ids of tests; by default all that are not discarded and whose log says what shakes them.
    overwrite : bool
        Whether recordings that are there are replaced.
    advance, warn : callable
        Called after each test, and with what may be wrong.

    Raises
    ------
    LogError
        If there is nothing to write, or a recording is there already.
    """
    from shakerproc.planning import rehearse
    from shakerproc.planning.drive import not_playable

    root = log.path.absolute().parent
    target = root if folder is None else folder.absolute()
    tests = [log.find(one) for one in wanted] if wanted else list(log.active)
    for test in tests:
        if test.recording is None:
            warn(f"test {test.id} has no recording in the log and is left out")
            advance(f"test {test.id}")
    named = [test for test in tests if test.recording is not None]
    played = [test for test in named if wanted or not not_playable(test)]
    for test in named if played else ():
        if test not in played:
            warn(f"test {test.id} is left out: {not_playable(test)}")
            advance(f"test {test.id}")
    named = played or named
    if not named:
        raise LogError(f"{log.path}: no test has a recording to write; add the key")
    paths = [_path(test, root, target) for test in named]
    _check_free(log, paths, overwrite=overwrite)
    if target != root:
        _copy_log(log, target, overwrite=overwrite)
    found = []
    for test, path in zip(named, paths, strict=True):
        made = rehearse(model, test, staging)
        write_recording(path, made.recording)
        found.append({**made.facts, "recording": path.relative_to(target).as_posix()})
        advance(f"test {test.id}")
    return found


def write_recording(path: Path, recording: "Recording") -> None:
    """Write a recording in the format of its ending, whole or not at all.

    Raises
    ------
    LogError
        If there is no such format.
    """
    from shakerproc.recordings import WRITERS

    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise LogError(
            f"{path.name}: no format {path.suffix or 'without ending'}; shakerproc writes "
            f"{', '.join(WRITERS)}. Correct recording in the log."
        )
    writer(path, recording)


def _path(test: "Test", root: Path, target: Path) -> Path:
    assert test.recording is not None  # noqa: S101 - narrows the type; the caller has checked
    return target / test.recording.relative_to(root)


def _check_free(log: "TestLog", paths: Sequence[Path], *, overwrite: bool) -> None:
    """Pass paths at which nothing stands.

    Raises
    ------
    LogError
        If a recording is there and must not be replaced.
    """
    there = [path for path in paths if path.exists()]
    if there and not overwrite:
        more = f" and {len(there) - 1} more are" if len(there) > 1 else " is"
        raise LogError(
            f"{log.path}: {there[0]}{more} there already. Give --out FOLDER for a copy of the "
            f"campaign, or --overwrite to replace what was recorded."
        )


def _copy_log(log: "TestLog", target: Path, *, overwrite: bool) -> None:
    """Copy the log, and the specimens that it names, into another folder.

    Raises
    ------
    LogError
        If another file stands there.
    """
    named = log.document.value.specimens
    sources = [log.path, *([log.path.parent / named] if isinstance(named, str) else [])]
    for source in sources:
        copy, content = target / source.relative_to(log.path.parent), source.read_bytes()
        if copy.exists() and copy.read_bytes() != content and not overwrite:
            raise LogError(f"{copy} is another file already; choose another --out")
        files.write_bytes(copy, content)
