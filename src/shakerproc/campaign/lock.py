"""One batch at a time in a folder."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from filelock import FileLock, Timeout

from shakerproc.errors import LockedError

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
