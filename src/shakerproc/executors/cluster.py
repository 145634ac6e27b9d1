"""The machines of a dask.distributed cluster."""

import json
import queue
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final
from urllib.parse import ParseResult, urlparse

from shakerproc import __version__
from shakerproc.errors import ClusterError
from shakerproc.executors import AbstractExecutor, Task, TaskOutcome, Work
from shakerproc.executors.processes import (
    NO_MORE,
    Child,
    Limits,
    packed_task,
    packed_work,
    wait,
)

if TYPE_CHECKING:
    from distributed import Client, Future

_DECIDING: Final = ("numpy", "scipy", "numba", "pandas", "pyarrow", "matplotlib", "nptdms")
"""Packages on whose version the last digit, or the bytes of a file, may depend."""

_CONNECT: Final = 15.0  # [s]
_ANSWER: Final = 5.0
"""How long a scheduler may take to send its first byte, which it does by itself [s]."""
_WITHOUT_WORKERS: Final = 60.0
"""How long a cluster may have no worker while there is something to do [s]."""
_LOOK: Final = 2.0  # [s]
_FETCH: Final = 120.0
"""How long the files of one test may be on their way before one looks what is wrong [s]."""
_HOW: Final = (
    "Start one with `dask scheduler` and workers with `dask worker ADDRESS`, and give the "
    "ADDRESS that it prints, such as tcp://10.0.0.1:8786."
)
_LOST: Final = (
    "the scheduler at {} is gone. Start it and its workers again and call again; what is done "
    "stands."
)


def versions() -> dict[str, str]:
    """Return the version of everything that may decide the last digit of a result."""
    texts = {"shakerproc": __version__}
    for name in _DECIDING:
        try:
            texts[name] = version(name)
        except PackageNotFoundError:
            texts[name] = "none"
    return texts


class _WorkerChild(threading.local):
    """The child process of this thread of the worker, and its orders."""

    child: Child | None = None
    orders: bytes = b""
    limits: Limits | None = None


_KEPT: Final = _WorkerChild()


def attempt(
    name: str, orders: bytes, argument: bytes, limits: Limits, wanted: Mapping[str, str]
) -> dict[str, Any]:
    """Return the outcome of a task as plain data, whatever happens in it.

    The child process stays for the next task of this thread. Where it was killed from outside,
    the task is tried once more in another one.

    Parameters
    ----------
    name : str
        Name of the task.
    orders, argument : bytes
        What is to be done with what, as the child process takes it.
    limits : Limits
        What the task may take.
    wanted : mapping of str to str
        The versions of the machine that asks.
    """
    other = [
        f"{n} {v} here, {wanted[n]} there" for n, v in versions().items() if wanted[n] != v
    ]
    if other:
        error = (
            f"the worker has other versions than the machine that asks: {', '.join(other)}; "
            "the results would not be the same to the last digit. Install the same on both."
        )
        return asdict(TaskOutcome(name, cause="error", error=error))
    outcome = _done(name, orders, argument, limits)
    if outcome.cause == "killed":
        outcome = _done(name, orders, argument, limits)
    return asdict(outcome)


def _done(name: str, orders: bytes, argument: bytes, limits: Limits) -> TaskOutcome:
    child = _child(orders, limits)
    child.give(name, argument)
    while True:
        wait([child])
        outcome = child.look()
        if outcome is not None:
            return outcome


def _child(orders: bytes, limits: Limits) -> Child:
    """Return the process of this thread, with its orders; a new one where there is none."""
    kept = _KEPT.child
    usable = kept is not None and not kept.ended and kept.alive
    if kept is None or not usable or _KEPT.limits != limits:
        if kept is not None and not kept.ended:
            kept.kill()
        _KEPT.child, _KEPT.orders, _KEPT.limits = Child(limits, orders), orders, limits
        return _KEPT.child
    if _KEPT.orders != orders:
        kept.order(orders)
        _KEPT.orders = orders
    return kept


@final
@dataclass(frozen=True, slots=True)
class ClusterExecutor(AbstractExecutor):
    """Workers of a cluster, each task in a process of its own there.

    A task whose worker dies goes to another one; after the fourth, it is named as the one that
    kills. Time and memory limits hold as on one machine.

    Attributes
    ----------
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``; or its file (``--scheduler-file``).
    limits : Limits
        What one task may take.
    prepare : callable, optional
        What a new process does before its first task.
    """

    address: str
    limits: Limits = NO_MORE
    prepare: Callable[[], None] | None = None

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[TaskOutcome]:
        """Yield the outcome of each task as it ends, in any order, one for each task.

        Raises
        ------
        ClusterError
            If there is no such cluster, or it is lost on the way.
        """
        if not tasks:
            return
        with _client(self.address) as client:
            ended: queue.SimpleQueue[Future] = queue.SimpleQueue()
            watch = _Watch(client, self.address)
            orders, here = packed_work(work, self.prepare), versions()
            names: dict[str, str] = {}
            for task in tasks:
                argument = packed_task(task.argument)
                future = client.submit(
                    attempt, task.name, orders, argument, self.limits, here, pure=False
                )
                names[future.key] = task.name
                future.add_done_callback(ended.put)
            for _ in tasks:
                future = _next(ended, watch)
                yield _outcome(future, names[future.key], watch, self.address)


@contextmanager
def _client(address: str) -> Iterator["Client"]:
    """Yield a connection to the scheduler; unfinished tasks are cancelled at the end.

    Raises
    ------
    ClusterError
        If dask.distributed is missing here, or nothing answers at the address.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise ClusterError(
            "--scheduler needs dask.distributed, which is not installed; "
            'install it with: pip install "shakerproc[cluster]"'
        ) from error
    where = _address(address)
    try:
        # distributed would go on trying, and leave a client behind that cannot be closed
        _check_answers(where)
        client = Client(where.geturl(), timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError, MemoryError) as error:
        raise ClusterError(
            f"no scheduler answers at {address}: {' '.join(str(error).split())}. {_HOW}"
        ) from error
    try:
        yield client
    finally:
        client.close(timeout=_CONNECT)


def _check_answers(where: ParseResult) -> None:
    """Pass an address that sends something; a scheduler does so before it is asked.

    Raises
    ------
    OSError
        If nothing accepts the connection, or what does sends nothing.
    """
    with socket.create_connection((where.hostname, where.port), _ANSWER) as connection:
        if where.scheme != "tcp":
            return
        try:
            said = connection.recv(1)
        except TimeoutError as error:
            raise OSError(
                f"the port is open, but sends nothing within {_ANSWER:g} s"
            ) from error
        if not said:
            raise OSError("the port is open, but closes the connection")


def _address(text: str) -> ParseResult:
    """Return the address of a scheduler, from a scheduler file where one is named.

    Raises
    ------
    ClusterError
        If it is none.
    """
    written = text
    if Path(text).is_file():
        try:
            written = json.loads(Path(text).read_text(encoding="utf-8"))["address"]
        except (ValueError, KeyError, TypeError) as error:
            raise ClusterError(f"{text}: not a scheduler file of dask. {_HOW}") from error
    parsed = urlparse(written if "://" in written else f"tcp://{written}")
    try:
        usable = bool(parsed.hostname and parsed.port)
    except ValueError:  # a port that is no number
        usable = False
    if not usable:
        raise ClusterError(f"{text!r} is no address of a scheduler. {_HOW}")
    return parsed


@final
class _Watch:
    """Looks whether the cluster is still there while something is waited for."""

    def __init__(self, client: "Client", address: str) -> None:
        self._client = client
        self._address = address
        self._alone_since: float | None = None

    def look(self) -> None:
        """Pass while there is hope.

        Raises
        ------
        ClusterError
            If the scheduler is gone, or has had no worker for long.
        """
        if self._client.status != "running":
            raise ClusterError(_LOST.format(self._address))
        if self._n_workers():
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
        elif time.monotonic() - self._alone_since > _WITHOUT_WORKERS:
            raise ClusterError(
                f"the cluster at {self._address} has had no worker for {_WITHOUT_WORKERS:g} s. "
                "Start some (`dask worker`) and call again; what is done "
                "stands."
            )

    def _n_workers(self) -> int:
        try:
            return len(self._client.nthreads())
        except OSError:  # the connection is being lost; the status will tell
            return 0


def _next(ended: "queue.SimpleQueue[Future]", watch: _Watch) -> "Future":
    """Return the next task that ends."""
    while True:
        try:
            return ended.get(timeout=_LOOK)
        except queue.Empty:
            watch.look()


def _outcome(future: "Future", name: str, watch: _Watch, address: str) -> TaskOutcome:
    """Return the outcome of a task.

    Raises
    ------
    ClusterError
        If it was called off because the scheduler is gone.
    """
    from distributed import CancelledError, KilledWorker

    while True:
        try:
            report: dict[str, Any] = future.result(timeout=_FETCH)
        except TimeoutError:  # its worker died before the result was fetched; another has it
            watch.look()
        except CancelledError as error:
            raise ClusterError(_LOST.format(address)) from error
        except KilledWorker:
            text = "the workers that took it died, one after the other"
            return TaskOutcome(name, cause="killed", error=text)
        except Exception as error:  # noqa: BLE001 - such as a worker without shakerproc
            line = " ".join(f"{type(error).__name__}: {error}".split())
            return TaskOutcome(name, cause="error", error=f"the worker could not begin: {line}")
        else:
            future.release()
            return TaskOutcome(**report)
