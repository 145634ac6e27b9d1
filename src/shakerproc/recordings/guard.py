"""Keep what other libraries do wrong on damaged files to one line of ours."""

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from shakerproc.errors import RecordingError, ShakerprocError

AGAIN = "Copy or export the file again from the measuring computer."


def shown(text: object, limit: int = 80) -> str:
    """Return text of a file as it may stand in a message: quoted, printable, not too long."""
    plain = str(text)
    if len(plain) > limit:
        plain = plain[: limit - 3] + "..."
    return repr(plain)


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
