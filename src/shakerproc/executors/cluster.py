"""The machines of a dask.distributed cluster."""

import queue
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

from shakerproc.errors import ClusterError
from shakerproc.executors.base import AbstractExecutor, Outcome, Task, Work
from shakerproc.executors.processes import NO_MORE, Limits, packed_task, packed_work
from shakerproc.executors.remote import attempt, versions

if TYPE_CHECKING:
    from distributed import Client, Future

_CONNECT: Final = 15.0  # [s]
_WITHOUT_WORKERS: Final = 60.0
"""How long a cluster may have no worker while there is something to do [s]."""
_LOOK: Final = 2.0  # [s]
_LOST: Final = (
    "the scheduler at {} is gone. Start it and its workers again and call again; what is done "
    "stands."
)


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

    def run(self, work: Work, tasks: Sequence[Task]) -> Iterator[Outcome]:
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
                future = _next(ended, client, self.address)
                yield _outcome(future, names[future.key], self.address)


@contextmanager
def _client(address: str) -> Iterator["Client"]:
    """Yield a connection to the scheduler; what is not done at the end is called off.

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
    where = {"scheduler_file": address} if Path(address).is_file() else {"address": address}
    try:
        client = Client(**where, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"no scheduler answers at {address} within {_CONNECT:g} s. Start one with "
            "`dask scheduler`, workers with `dask worker ADDRESS`, and give the ADDRESS that "
            "it prints, such as tcp://10.0.0.1:8786."
        ) from error
    try:
        yield client
    finally:
        client.close(timeout=5.0)


def _next(ended: "queue.SimpleQueue[Future]", client: "Client", address: str) -> "Future":
    """Return the next task that ends.

    Raises
    ------
    ClusterError
        If the scheduler is gone, or has no worker for long.
    """
    alone_since = None
    while True:
        try:
            return ended.get(timeout=_LOOK)
        except queue.Empty:
            pass
        if client.status != "running":
            raise ClusterError(_LOST.format(address))
        if _n_workers(client):
            alone_since = None
        elif alone_since is None:
            alone_since = time.monotonic()
        elif time.monotonic() - alone_since > _WITHOUT_WORKERS:
            raise ClusterError(
                f"the cluster at {address} has had no worker for {_WITHOUT_WORKERS:g} s. Start "
                f"some with `dask worker {address}` and call again; what is done stands."
            )


def _n_workers(client: "Client") -> int:
    try:
        return len(client.nthreads())
    except OSError:  # the connection is being lost; the status will tell
        return 0


def _outcome(future: "Future", name: str, address: str) -> Outcome:
    """Return the outcome of a task.

    Raises
    ------
    ClusterError
        If it was called off because the scheduler is gone.
    """
    from distributed import KilledWorker

    if future.status == "finished":
        report: dict[str, Any] = future.result()
        future.release()
        return Outcome(**report)
    if future.status != "error":
        raise ClusterError(_LOST.format(address))
    error = future.exception()
    if isinstance(error, KilledWorker):
        told = "the workers that took it died, one after the other"
        return Outcome(name, cause="killed", error=told)
    line = " ".join(f"{type(error).__name__}: {error}".split())
    return Outcome(name, cause="error", error=f"the worker could not begin: {line}")
