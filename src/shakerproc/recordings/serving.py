"""The process that opens files for another one: what `apart` starts, and what both say.

Every message is its length, eight bytes, and so many bytes; samples follow their shape as they
lie in memory.
"""

import os
import pickle
import signal
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib import import_module
from io import BytesIO, FileIO
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.late import loaded
from shakerproc.recordings.guard import foreign
from shakerproc.recordings.raw import RawFile, Times

Buffer: TypeAlias = bytes | bytearray | memoryview
"""What a message is made of."""

DIED: Final = 128
"""What is added to a signal in the status of a process whose fork died of it."""

_CLOSED: Final = 64
"""Status of a fork that was told to close its file; a library may end it with any other."""

_COPIES: Final = (np.ndarray, np.generic)
"""Numbers in memory, which are handed over as they are."""


def taken(source: FileIO, size: int) -> bytearray:
    """Return so many bytes of a pipe; none where it ended before."""
    try:
        found = bytearray(size)
    except (MemoryError, OverflowError):  # the length is none: whoever wrote it is damaged
        return bytearray()
    rest = memoryview(found)
    while rest:
        count = source.readinto(rest)
        if not count:
            return bytearray()
        rest = rest[count:]
    return found


def message(source: FileIO) -> bytearray:
    """Return the next message of a pipe; empty where it ended."""
    return taken(source, int.from_bytes(taken(source, 8), "little"))


def given(sink: FileIO, *parts: Buffer) -> None:
    """Write messages into a pipe."""
    for part in parts:
        view = memoryview(part)
        for piece in (memoryview(view.nbytes.to_bytes(8, "little")), view):
            rest = piece
            while rest:
                rest = rest[sink.write(rest) :]


def serve() -> None:
    """Open files until standard input ends, one after the other."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends when its standard input does
    orders, answers = FileIO(0), FileIO(os.dup(1), "w")
    os.dup2(2, 1)
    while order := message(orders):
        place, library, path, run = pickle.loads(order)  # noqa: S301 - of the process above
        if run is None:
            with suppress(BaseException):  # the caller meets it again, and says it
                loaded(place)(Path(path))
            given(answers, b"survived")
            continue
        with suppress(Exception):  # the reader meets it again
            import_module(library)
        if not hasattr(os, "fork"):
            _serve_file(loaded(place), (path, run), orders, answers)
            return
        one = os.fork()
        if not one:
            _serve_file(loaded(place), (path, run), orders, answers)
            os._exit(_CLOSED)
        status = os.waitstatus_to_exitcode(os.waitpid(one, 0)[1])
        if status != _CLOSED:
            os._exit(DIED - status if status < 0 else status)


def _serve_file(
    reader: Callable[[Path, str], RawFile],
    file: tuple[str, str],
    orders: FileIO,
    answers: FileIO,
) -> None:
    """Open a file and hand over slices of it, until an empty message closes it."""
    path, run = file
    kept: list[Any] = []
    given(answers, *_answer(run, lambda: _described(reader(Path(path), run), kept)))
    while request := message(orders):
        given(answers, *_answer(run, partial(_slice, kept, request)))


def _answer(run: str, does: Callable[[], tuple[Buffer, ...]]) -> tuple[Buffer, ...]:
    """Return what is answered: the parts, or why there are none."""
    try:
        with foreign(run, "reading the file"):
            return does()
    except RecordingError as error:
        return (pickle.dumps(str(error)),)


def _described(raw: RawFile, kept: list[Any]) -> tuple[bytes]:
    """Return a file as a message, with a number for each thing that stays here."""
    out = BytesIO()
    pickler = pickle.Pickler(out)

    def staying(one: Any) -> tuple[int, int] | None:
        times = isinstance(one, Times) and not isinstance(one, _COPIES)
        if not times and not isinstance(one, SampleSource):
            return None
        place = next((i for i, other in enumerate(kept) if other is one), len(kept))
        if place == len(kept):
            kept.append(one)
        return place, int(one.size) if times else -1

    pickler.persistent_id = staying  # type: ignore[method-assign]
    pickler.dump(raw)
    return (out.getvalue(),)


def _slice(kept: list[Any], request: Buffer) -> tuple[Buffer, ...]:
    """Return shape and samples [unit of the file] of what was asked for."""
    place, rows, start, stop = pickle.loads(request)  # noqa: S301 - of the process above
    one = kept[place]
    read: FloatArray = one[start:stop] if rows is None else one.read(rows, start, stop)
    values = np.ascontiguousarray(read, dtype=np.float64)
    return pickle.dumps(values.shape), values.reshape(-1).view(np.uint8).data
