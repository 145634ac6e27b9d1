"""Keep what other libraries do wrong on damaged files to one line of ours.

What a library raises is turned into one line; a library that may end its process opens the file
first in a process that may die.
"""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import IO, BinaryIO, Final, TypeVar, cast, final

import numpy as np

from shakerproc.errors import RecordingError, ShakerprocError

T = TypeVar("T")

AGAIN = "Copy or export the file again from the measuring computer."

LONGEST_S: Final = 60.0
"""A trial that takes longer is given up [s]; the first of a process takes a third."""

_SERVE: Final = """
import importlib, json, os, signal, sys
from pathlib import Path
signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends when its standard input does
answers = os.dup(1)
os.dup2(2, 1)
for line in sys.stdin.buffer:
    place, path = json.loads(line)
    module, _, name = place.partition(":")
    try:
        getattr(importlib.import_module(module), name)(Path(path))
    except BaseException:
        pass  # the caller meets it again, and says it
    os.write(answers, b".")
"""

_ONE_AT_A_TIME: Final = threading.Lock()


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


def check_survived(path: Path, run: str, trial: str) -> None:
    """Pass a file whose opening does not end the process that opens it.

    Parameters
    ----------
    path : Path
        The file.
    run : str
        Opens the message.
    trial : str
        Place of the function of the path that may die, such as ``module:function``. Whatever
        it raises is no matter here.

    Raises
    ------
    RecordingError
        If the process died, with the signal.
    """
    stamp = path.stat()
    problem = _death(path.absolute(), (stamp.st_mtime_ns, stamp.st_size), trial)
    if problem:
        raise RecordingError(
            f"{run}: the library that reads it gives up ({problem}): it is damaged. {AGAIN}"
        )


@lru_cache(maxsize=256)
def _death(path: Path, _: tuple[int, int], trial: str) -> str:
    """Return how the process died that opened a file; empty where it did not.

    Only a process that has opened nothing before bears witness against a file: another may
    die of what an earlier one has done to its memory.
    """
    places = os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)
    with _ONE_AT_A_TIME:
        while True:
            process = _process(os.getpid(), places)
            fresh = not process.used
            if process.survives(path, trial):
                return ""
            _process.cache_clear()
            if fresh:
                return process.how_it_died()


@final
class _Process:
    """A process that opens one file after the other, until it dies of one or we end."""

    def __init__(self, places: str) -> None:
        self.used = False
        self._late = False
        self._process = subprocess.Popen(  # noqa: S603 - this interpreter, with lines of ours
            [sys.executable, "-P", "-c", _SERVE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            cwd=Path(sys.executable).parent,  # no folder of the user's is kept in use
            env={**os.environ, "PYTHONPATH": places, "OMP_NUM_THREADS": "1"},
        )
        weakref.finalize(self, _end, self._process)

    def survives(self, path: Path, trial: str) -> bool:
        """Return whether it lives on after opening a file."""
        self.used = True
        order = json.dumps([trial, str(path)]).encode() + b"\n"
        stdin, stdout = (
            cast("IO[bytes]", p) for p in (self._process.stdin, self._process.stdout)
        )
        timer = threading.Timer(LONGEST_S, self._give_up)
        timer.start()
        try:
            with contextlib.suppress(OSError):  # it is dead: nothing is answered
                stdin.write(order)
            return bool(stdout.read(1))
        except BaseException:
            _process.cache_clear()  # its answer is still to come
            raise
        finally:
            timer.cancel()

    def how_it_died(self) -> str:
        """Return the signal or the status; empty where it ended like any program."""
        status = self._process.wait()
        if self._late:
            return f"no answer for {LONGEST_S:g} s"
        if status in {0, 1}:
            return ""
        known = {int(one): one.name for one in signal.Signals}
        return known.get(-status, f"status {status}")

    def _give_up(self) -> None:
        self._late = True
        self._process.kill()


@lru_cache(maxsize=1)
def _process(_: int, places: str) -> _Process:
    """Return the process of this one, which finds modules in some places."""
    return _Process(places)


def _end(process: "subprocess.Popen[bytes]") -> None:
    with process:
        process.kill()
