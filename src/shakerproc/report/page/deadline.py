"""A limit on the time of a block of Python, in whatever thread it runs."""

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class DeadlineError(Exception):
    """A block took more time than it may."""


@contextmanager
def deadline(seconds: float) -> Iterator[None]:
    """Raise within a block that takes longer than so many seconds [s].

    It is raised between two steps of the interpreter: what takes long in one step has to be
    bounded by itself.

    Raises
    ------
    DeadlineError
        Within the block.
    """
    thread, lock, over = threading.get_ident(), threading.Lock(), threading.Event()

    def end() -> None:
        with lock:
            if not over.is_set():
                _raise_in(thread, DeadlineError)

    timer = threading.Timer(seconds, end)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        with lock:
            over.set()
        timer.cancel()


def _raise_in(thread: int, kind: type[Exception]) -> None:
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))
