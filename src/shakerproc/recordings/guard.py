"""Keep what other libraries do wrong on damaged files to one line of ours.

What a library raises is turned into one line; one that may end its process, or damage its
memory, is kept apart (`apart`).
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, TypeVar

import numpy as np

from shakerproc.errors import RecordingError, ShakerprocError

T = TypeVar("T")

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


def kept_open(path: Path, run: str, read: Callable[[BinaryIO], T]) -> T:
    """Return the result of reading a file that stays open; it is closed where reading fails.

    Raises
    ------
    RecordingError
        If it cannot be opened.
    """
    file = opened(path, run)
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
