"""The file of a recording: fetched from elsewhere, its fingerprint of the very bytes read."""

import hashlib
import os
import stat
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO, Final, NoReturn, TypeVar, final

from shakerproc.data import SourceFile
from shakerproc.errors import RecordingError

T = TypeVar("T")

_TICK: Final = 10_000_000
"""Longest step [ns] of the clock by which a kernel stamps files (100 Hz)."""

_KINDS: Final = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def is_url(source: str) -> bool:
    """Return whether a place is a URL and no folder."""
    return "://" in source


def fetch(source: str, relative: str, folder: Path) -> Path:
    """Return where a recording lies on this machine, brought there where it is behind a URL.

    Parameters
    ----------
    source : str
        Folder or URL of the recordings.
    relative : str
        Path of the recording below it, as the log has it.
    folder : Path
        Where to put it if it has to be fetched.

    Raises
    ------
    RecordingError
        If it is not there, or cannot be fetched.
    """
    if not is_url(source):
        return _on_path(Path(source), relative)
    path = folder.joinpath(*PurePosixPath(relative).parts)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        file_system, root = _opened(source)
        file_system.get_file(f"{root.rstrip('/')}/{relative}", str(path))
    except FileNotFoundError as error:
        raise RecordingError(
            f"{relative}: no such recording at {source}; put it there, or correct --recordings."
        ) from error
    except RecordingError:
        raise
    except Exception as error:
        cause = " ".join(f"{type(error).__name__}: {error}".split())[:200]
        raise RecordingError(f"{relative}: cannot be fetched from {source}: {cause}") from error
    return path


def _on_path(folder: Path, relative: str) -> Path:
    path = folder / relative
    if not path.is_file():
        raise RecordingError(
            f"{relative}: this machine sees no {path}; put the recordings on a path that every "
            "worker sees, or say where they are with --recordings."
        )
    if not path.resolve().is_relative_to(folder.resolve()):
        raise RecordingError(
            f"{relative}: a link to outside {folder}; put the file itself there."
        )
    return path


def _opened(source: str) -> tuple[Any, str]:
    """Return the file system of a URL and the path on it.

    Raises
    ------
    RecordingError
        If fsspec, or what it needs for this kind of URL, is not installed.
    """
    kind = source.partition("://")[0]
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise RecordingError(
            f"{source}: needs fsspec, which is not installed; "
            'install it with: pip install "shakerproc[cluster]"'
        ) from error
    try:
        file_system, root = url_to_fs(source)
    except (ImportError, ValueError) as error:
        raise RecordingError(
            f"{source}: fsspec cannot open {kind}:// here: {' '.join(str(error).split())}"
        ) from error
    return file_system, str(root)


@final
@dataclass(frozen=True, slots=True)
class Stamp:
    """Notes of the system on a file; nobody can set the time of the last change back."""

    device: int
    number: int
    size: int
    modified: int
    changed: int


@final
@dataclass(frozen=True, slots=True)
class FileHash:
    """The SHA-256 of a file, and the stamp that it had before it was read for that."""

    sha256: str
    stamp: Stamp


@final
class WatchedFile(SourceFile):
    """A file that is kept open while it is read, by whatever reads it by its path.

    A change is seen in the stamp that the system gives the file; its bytes are hashed once.

    Parameters
    ----------
    path : Path
        The file.
    run : str
        Opens every message.
    hashed : bool or sequence of Seen
        Whether to hash it at once, before anything of it is read, or hashes that are known: one
        of this file with the stamp that it has now is taken.

    Raises
    ------
    RecordingError
        If it is no regular file, or cannot be read.
    """

    def __init__(self, path: Path, run: str, *, hashed: bool | Sequence[FileHash]) -> None:
        self._path = path
        self._run = run
        self._file = open_regular(path, run)
        self._first = ""
        try:
            self._stamp = _stamp_of(os.fstat(self._file.fileno()))
            if hashed is not False:
                known = () if hashed is True else hashed
                self._first = next((s.sha256 for s in known if s.stamp == self._stamp), "")
                if not self._first:
                    self._let_the_clock_step()
                    self._first = self._digest()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> "WatchedFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    def first_sha256(self) -> str:
        if not self._first:
            self._first = self._digest()
        return self._first

    def sha256(self) -> str:
        digest = self.first_sha256()
        self.check()
        return digest

    def fingerprint(self) -> FileHash:
        """Return its SHA-256 with its stamp, for whoever opens it again."""
        return FileHash(self.sha256(), self._stamp)

    def check(self) -> None:
        now = _stamp_of(os.fstat(self._file.fileno()))
        if now.size != self._stamp.size:
            self._fail(f"it had {self._stamp.size} bytes and now has {now.size}")
        try:
            there = _stamp_of(self._path.stat())
        except OSError:
            self._fail("it is no longer there")
        if (there.device, there.number) != (now.device, now.number):
            self._fail("another file has taken its place")
        if not now == there == self._stamp:
            self._fail("it was written to or moved")

    def _fail(self, how: str) -> NoReturn:
        raise RecordingError(
            f"{self._run}: the file changed while it was read: {how}. Wait until nothing "
            "changes it any more, then call again."
        )

    def _digest(self) -> str:
        try:
            self._file.seek(0)
            return hashlib.file_digest(self._file, "sha256").hexdigest()  # type: ignore[arg-type]
        except OSError as error:
            raise RecordingError(f"{self._run}: cannot be read: {error.strerror}.") from error

    def _let_the_clock_step(self) -> None:
        """Wait until a change would get another time than the last one got."""
        age = time.time_ns() - max(self._stamp.modified, self._stamp.changed)
        if age < _TICK:
            time.sleep(min(_TICK - age, _TICK) * 1e-9)


def _stamp_of(status: os.stat_result) -> Stamp:
    return Stamp(
        status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns
    )


def open_regular(path: Path, run: str) -> BinaryIO:
    """Return a file, open; one without end, or that waits for a writer, is refused.

    Raises
    ------
    RecordingError
        If it is no regular file, or cannot be opened.
    """
    try:
        kind = stat.S_IFMT(path.stat().st_mode)
        if kind == stat.S_IFREG:
            return path.open("rb", buffering=0)
    except OSError as error:
        raise RecordingError(f"{run}: cannot be read: {error.strerror}.") from error
    raise RecordingError(
        f"{run}: {path} is {_KINDS.get(kind, 'something else')}, not a regular file. Give a "
        "file that lies on a disk."
    )


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file as 64 hexadecimal digits.

    Raises
    ------
    RecordingError
        If it is no regular file, or cannot be read.
    """
    with WatchedFile(path, path.name, hashed=False) as file:
        return file.first_sha256()


def read_hashed(read: Callable[[Path], T], path: Path) -> tuple[T, str]:
    """Return the result of reading a file, and the SHA-256 of the bytes read.

    Raises
    ------
    RecordingError
        If the file changed in the meantime.
    """
    with WatchedFile(path, path.name, hashed=True) as file:
        value = read(path)
        return value, file.sha256()
