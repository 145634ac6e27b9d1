"""Messages while the kernels are compiled: on the first run, after an update."""

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any, Final

from shakerproc.cli import output

_SAID: Final = "compiling what this command needs, once: up to a minute"

_FROM: Final = "from shakerproc.simulation import first_calls as first; "

_AHEAD: Final = (
    _FROM + "first.call_free_runs_by_series()",
    _FROM + "first.call_simulate(); first.call_along()",
)
"""What `compare` and `diagnose` need, in halves that two processes compile side by side."""


@cache
def announce() -> None:
    """Say on stderr that something is compiled, and for how long, from here on."""
    from numba.core import event

    class Teller(event.Listener):
        """Says once that something is being compiled, and now and then that it still is."""

        def __init__(self) -> None:
            self.said = threading.Lock()
            self.running = 0  # one compilation calls for others
            self.done = threading.Event()

        def on_start(self, event: Any) -> None:  # noqa: ARG002 - what numba hands over
            if self.said.acquire(blocking=False):
                output.message(_SAID)
            self.running += 1
            if self.running == 1:
                self.done = threading.Event()
                threading.Thread(target=_tell_until, args=(self.done,), daemon=True).start()

        def on_end(self, event: Any) -> None:  # noqa: ARG002
            self.running -= 1
            if self.running == 0:
                self.done.set()

    event.register("numba:compile", Teller())  # type: ignore[no-untyped-call]


def _tell_until(done: threading.Event) -> None:
    """Say now and then for how long it has been compiled."""
    began = time.monotonic()
    while not done.wait(output.TELL_EVERY):
        output.message(f"compiling: {time.monotonic() - began:.0f} s so far")


@contextmanager
def compiled_ahead() -> Iterator[Callable[[], None]]:
    """Yield a function that waits until what compares and diagnoses is compiled.

    It is compiled, or found compiled, in processes of its own, so that other cores do it in the
    meantime: threads would wait for each other. Should it fail, whoever needs it compiles it.
    """
    children = [
        subprocess.Popen(  # noqa: S603 - this program itself
            [sys.executable, "-c", part],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for part in _AHEAD
    ]

    def wait() -> None:
        began = time.monotonic()
        for child in children:
            while child.poll() is None:
                try:
                    child.wait(output.TELL_EVERY)
                except subprocess.TimeoutExpired:
                    waited = time.monotonic() - began
                    output.message(f"compiling the simulation, once: {waited:.0f} s so far")

    try:
        yield wait
    finally:
        for child in children:
            child.terminate()
        for child in children:
            child.wait()
