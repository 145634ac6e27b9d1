"""Open a file in another process, so that no damaged file harms this one or another file.

Compiled code of a library that meets a damaged file may end its process at once, never come
back, or write past its memory and end it, or change numbers, some files later. A file that is
opened apart has a process of its own until it is closed: a fork of one that has loaded the
library and opened nothing, or where there is no fork, such a process itself.

Every message between the two is its length, eight bytes, and so many bytes; samples follow
their shape as they lie in memory.
"""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib import import_module
from io import BytesIO, FileIO
from pathlib import Path
from typing import Any, Final, TypeAlias, cast, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.late import loaded
from shakerproc.recordings.guard import AGAIN, foreign, kept_open
from shakerproc.recordings.raw import RawFile

Buffer: TypeAlias = bytes | bytearray | memoryview
"""What a message is made of."""

DIED: Final = 128
"""What is added to a signal in the status of a process whose fork died of it."""

_CLOSED: Final = 64
"""Status of a fork that was told to close its file; a library may end it with any other."""


def taken(source: FileIO, size: int) -> bytearray:
    """Return so many bytes of a pipe; none where it ended before."""
    try:
        data = bytearray(size)
    except (MemoryError, OverflowError):  # the length is none: whoever wrote it is damaged
        return bytearray()
    rest = memoryview(data)
    while rest:
        count = source.readinto(rest)
        if not count:
            return bytearray()
        rest = rest[count:]
    return data


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
        place, packages, path, run = pickle.loads(order)  # noqa: S301 - of the process above
        with contextlib.suppress(Exception):  # the reader meets it again
            loaded(place)
            for package in packages:
                import_module(package)
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
        given(answers, b"closed")


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
    """Return the answer: the parts, or why there are none."""
    try:
        with foreign(run, "reading the file"):
            return does()
    except RecordingError as error:
        return (pickle.dumps(str(error)),)


def _described(made: object, kept: list[Any]) -> tuple[bytes]:
    """Return a result as a message, with a number for each source, which stays here."""
    out = BytesIO()
    pickler = pickle.Pickler(out)

    def staying(one: Any) -> int | None:
        if not isinstance(one, SampleSource):
            return None
        place = next((i for i, other in enumerate(kept) if other is one), len(kept))
        if place == len(kept):
            kept.append(one)
        return place

    pickler.persistent_id = staying  # type: ignore[method-assign]
    pickler.dump(made)
    return (out.getvalue(),)


def _slice(kept: list[Any], request: Buffer) -> tuple[Buffer, ...]:
    """Return shape and samples [unit of the file] of a requested slice."""
    place, *slices = pickle.loads(request)  # noqa: S301 - of the process above
    values = np.ascontiguousarray(kept[place].read(*slices), dtype=np.float64)
    return pickle.dumps(values.shape), values.reshape(-1).view(np.uint8).data


LONGEST_S: Final = 60.0
"""An answer that takes longer is given up [s]; the first of a process takes a third."""

_SERVE: Final = "from shakerproc.recordings.own_process import serve; serve()"

_ALONE: Final = dict.fromkeys(("OMP_NUM_THREADS", "NUMEXPR_MAX_THREADS"), "1")
"""No threads: a fork has none of them."""


def opened_apart(path: Path, run: str, reader: str, *packages: str) -> RawFile:
    """Return a file that another process reads, a slice at a time.

    Parameters
    ----------
    path : Path
        The file.
    run : str
        Opens every message.
    reader : str
        Place of the function from path and run to a `RawFile`, such as ``module:function``.
    *packages : str
        Modules that it needs, loaded once for all files where there is a fork.

    Raises
    ------
    RecordingError
        If it cannot be read, or the process died.
    """
    request = reader, packages, str(path.absolute()), run
    return kept_open(_file_apart(run), lambda file: cast("RawFile", file.asked(request)))


def result_apart(path: Path, run: str, function: str, *packages: str) -> Any:
    """Return the result of a function of path and run, numbers and texts, of another process.

    Parameters and exceptions are those of `opened_apart`.

    Raises
    ------
    RecordingError
        If the function raises one, or the process died.
    """
    file = _file_apart(run)
    try:
        return file.asked((function, packages, str(path.absolute()), run))
    finally:
        file.close()


def _file_apart(run: str) -> "_FileApart":
    """Return a process that waits for a file to open, or a new one."""
    try:
        process = _idle(os.getpid()).pop()
    except IndexError:
        process = _Process()
    return _FileApart(run, process)


def _gives_up(run: str, problem: str) -> str:
    return f"{run}: the library that reads it gives up ({problem}): it is damaged. {AGAIN}"


@final
class _Process:
    """A process that opens one file after the other, until it dies of one or we end."""

    def __init__(self) -> None:
        self._late = False
        self._process = subprocess.Popen(  # noqa: S603 - this interpreter, with lines of ours
            [sys.executable, "-P", "-c", _SERVE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
            process_group=0 if hasattr(os, "killpg") else None,  # its fork is killed with it
            cwd=Path(sys.executable).parent,  # no folder of the user's is kept in use
            env={**os.environ, **_ALONE, "PYTHONPATH": _places()},
        )
        self.end = weakref.finalize(self, _end, self._process)

    def ask(self, request: object = None) -> bytearray:
        """Return the next message of the process, asked or not; empty where it died."""
        timer = threading.Timer(LONGEST_S, self._give_up)
        timer.start()
        try:
            with contextlib.suppress(OSError):  # it is dead: nothing is answered
                if request is not None:
                    given(cast("FileIO", self._process.stdin), pickle.dumps(request))
            return message(cast("FileIO", self._process.stdout))
        except BaseException:
            self.end()  # its answer is still to come
            raise
        finally:
            timer.cancel()

    def leave(self) -> bool:
        """Wait until the file that it reads is closed; return whether it takes another."""
        with contextlib.suppress(OSError):
            given(cast("FileIO", self._process.stdin), b"")
            return bool(message(cast("FileIO", self._process.stdout)))
        return False

    def how_it_died(self) -> str:
        """Return the signal or the status; empty where it ended like any program."""
        status = self._process.wait()
        if self._late:
            return f"no answer for {LONGEST_S:g} s"
        if status in {0, 1}:
            return ""
        known = {int(one): one.name for one in signal.Signals}
        return known.get(max(-status, status - DIED), f"status {status}")

    def _give_up(self) -> None:
        self._late = True
        _kill(self._process)


@final
class _FileApart:
    """A file in another process, which serves no other one meanwhile.

    Parameters
    ----------
    run : str
        Opens every message.
    process : _Process
        The process.
    """

    def __init__(self, run: str, process: _Process) -> None:
        self._run = run
        self._process: _Process | None = process
        self._lock = threading.Lock()

    def asked(self, request: tuple[object, ...]) -> Any:
        """Return the answer to a request: a `RawFile`, or samples [unit of the file].

        Raises
        ------
        RecordingError
            If it is closed, the process died, or it says what is wrong with the file.
        """
        with self._lock:
            process = self._process
            if process is None:
                raise RecordingError(f"{self._run}: the recording is closed. Open it again.")
            try:
                answer = _Answer(process.ask(request), self).load()
                if isinstance(answer, tuple):
                    return np.frombuffer(process.ask()).reshape(answer)
            except (EOFError, ValueError, TypeError, pickle.UnpicklingError) as error:
                self._process = None
                text = process.how_it_died() or "it has ended"
                raise RecordingError(_gives_up(self._run, text)) from error
        if isinstance(answer, str):
            raise RecordingError(answer)
        return answer

    def close(self) -> None:
        """Let the process go on with another file."""
        with self._lock:
            process, self._process = self._process, None
            if process is None:
                return
            if process.leave():
                _idle(os.getpid()).append(process)
            else:
                process.end()


@final
class _Answer(pickle.Unpickler):  # noqa: S301 - of a process of ours
    """Answer of a process about a file; samples stay there until they are asked for."""

    def __init__(self, answer: bytearray, file: _FileApart) -> None:
        super().__init__(BytesIO(answer))
        self._file = file

    def persistent_load(self, pid: int) -> "SourceApart":
        return SourceApart(self._file, pid)


@final
@dataclass(frozen=True, slots=True, eq=False)
class SourceApart(SampleSource):
    """Samples of a file that another process reads.

    Attributes
    ----------
    file : _FileApart
        The file.
    place : int
        Number of the source there.
    """

    file: _FileApart
    place: int

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        asked: FloatArray = self.file.asked((self.place, list(rows), start, stop))
        return asked

    def close(self) -> None:
        """Close the file."""
        self.file.close()


def _places() -> str:
    """Return where this process finds modules."""
    return os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)


@lru_cache(maxsize=1)
def _idle(_: int) -> list[_Process]:
    """Return the processes of this one that wait for a file to open."""
    return []


def _end(process: "subprocess.Popen[bytes]") -> None:
    with process:
        _kill(process)


def _kill(process: "subprocess.Popen[bytes]") -> None:
    """Kill a process that was not waited for yet, and its fork."""
    if hasattr(os, "killpg") and process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
