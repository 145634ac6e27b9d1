"""Turn errors of other libraries on damaged files into one line of ours.

What a library raises is turned into one line; one that may end its process, or damage its
memory, is kept apart (`own_process`).
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Protocol, TypeVar

import numpy as np

from shakerproc.errors import RecordingError, ShakerprocError


class Closable(Protocol):
    """A resource that is open until it is closed."""

    def close(self) -> object:
        """Close it."""


T = TypeVar("T")
F = TypeVar("F", bound=Closable)

AGAIN = "Copy or export the file again from the measuring computer."


def shown(text: object, limit: int = 80) -> str:
    """Return text of a file as it may stand in a message: quoted, printable, not too long."""
    plain = str(text)
    if len(plain) > limit:
        plain = plain[: limit - 3] + "..."
    return repr(plain)


def opened(path: Path, run: str) -> BinaryIO:
    """Return a file, opened to read its bytes.

    Raises
    ------
    RecordingError
        If it cannot be opened.
    """
    try:
        return path.open("rb")
    except OSError as error:
        raise RecordingError(f"{run}: cannot be opened: {error.strerror}.") from error


def first_bytes(path: Path, run: str, count: int) -> bytes:
    """Return the first bytes of a file, so many at most.

    Raises
    ------
    RecordingError
        If it cannot be opened.
    """
    with opened(path, run) as file:
        return file.read(count)


def kept_open(file: F, read: Callable[[F], T]) -> T:
    """Return the result of reading a file that stays open; it is closed where reading fails."""
    try:
        return read(file)
    except BaseException:
        file.close()
        raise


@contextmanager
def foreign(run: str, doing: str) -> Iterator[None]:
    """Turn whatever a library raises into one line.

    Raises
    ------
    RecordingError
        In place of every other exception.
    ShakerprocError
        Ours pass as they are.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except ShakerprocError:
        raise
    except Exception as error:
        cause = " ".join(str(error).split()) or "no reason given"
        raise RecordingError(
            f"{run}: {doing} failed: {type(error).__name__}: {shown(cause, 160)}. {AGAIN}"
        ) from error
