"""Tasks in a child process: one after the other, every failure put into words."""

import json
import os
import pickle
import signal
import sys
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from shakerproc.errors import ShakerprocError
from shakerproc.executors.base import limit_memory
from shakerproc.late import seek_garbage_seldom


def main() -> None:
    """Serve the connection whose handle the command line says, within its limit of memory."""
    seek_garbage_seldom()
    handle, memory_limit = map(int, sys.argv[1:])
    if sys.platform == "win32":
        from multiprocessing.connection import PipeConnection

        serve(PipeConnection(handle), memory_limit)
    else:
        serve(Connection(handle), memory_limit)


def serve(connection: Connection, memory_limit: int) -> None:
    """Do what is ordered with each argument that comes, until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    work: Callable[[Any], object] = _nothing
    limited = False
    while True:
        try:
            kind, content = connection.recv()
        except EOFError:
            return
        if kind == "task":
            connection.send_bytes(_attempt(work, content))
            continue
        work = _ordered(content)
        if not limited:
            limit_memory(memory_limit)
            limited = True
        connection.send_bytes(b"ready")


def _nothing(_: object) -> dict[str, object]:
    return {}


def _ordered(content: bytes) -> Callable[[Any], object]:
    """Return the work that is ordered, all made ready for it; or what says why it cannot be."""
    try:
        work, prepare = pickle.loads(content)  # noqa: S301 - from our parent, by its own pipe
        if prepare is not None:
            prepare()
    except Exception as error:  # noqa: BLE001 - each task is to say it
        problem = error

        def fail(_: object) -> object:
            raise problem

        return fail
    return work  # type: ignore[no-any-return]


def _end_with_parent() -> None:
    """End at once when the parent is gone, even if it was killed: standard input ends then."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    os._exit(1)


def _attempt(work: Callable[[Any], object], argument: bytes) -> bytes:
    """Return the report on one task as JSON, whatever happens in it."""
    try:
        given = pickle.loads(argument)  # noqa: S301 - from our parent, by its own pipe
        report = {"value": work(given), "cause": "", "error": "", "detail": ""}
        return json.dumps(report, allow_nan=False).encode()
    except MemoryError:
        return _failure(
            "memory limit", "stopped at the memory limit; allow more with --memory-limit", ""
        )
    except ShakerprocError as error:
        return _failure("input", str(error), "")
    except BaseException as error:  # noqa: BLE001 - what a run does must not end the batch
        line = traceback.format_exception_only(error)[-1].strip()
        return _failure("error", line, traceback.format_exc())


def _failure(cause: str, error: str, detail: str) -> bytes:
    return json.dumps({"value": {}, "cause": cause, "error": error, "detail": detail}).encode()
