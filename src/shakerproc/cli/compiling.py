"""What is said while the kernels are compiled: on the first run, and after an update."""

import threading
from functools import cache
from typing import Any, Final

from shakerproc.cli import output

_SAID: Final = "compiling what this command needs, once: up to a minute"


@cache
def announce() -> None:
    """Say so on stderr, once, should anything have to be compiled from here on."""
    from numba.core import event

    said = threading.Lock()

    class Teller(event.Listener):
        """Says once that something is being compiled."""

        def on_start(self, event: Any) -> None:  # noqa: ARG002 - what numba hands over
            if said.acquire(blocking=False):
                output.message(_SAID)

        def on_end(self, event: Any) -> None:
            """Say nothing."""

    event.register("numba:compile", Teller())  # type: ignore[no-untyped-call]
