"""Messages beside a result: that kernels are compiled, and the next step in words to type."""

import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from shakerproc.cli import output

if TYPE_CHECKING:
    from shakerproc.diagnosis.result import Diagnosis


_SAID: Final = "compiling what this command needs, once: up to a minute"

_FROM: Final = (
    # a compiler makes millions of objects and little garbage: seldom is as quick as never, with
    # 190 MB less
    "import gc; gc.set_threshold(200_000, 20, 100); "
    "from shakerproc.simulation import first_calls as first; "
)

_AHEAD: Final = (
    _FROM + "first.call_free_runs_by_series()",
    _FROM + "first.call_propagators(); first.call_along()",
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
    """Yield a function that waits until the kernels of `compare` and `diagnose` are compiled.

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


def after_processing(recording: Path, log: Path | None) -> None:
    """Print the step after one recording: the whole log, or the beginning of one."""
    if log is None:
        folder = recording.parent
        output.next_step(
            "begin a log of these recordings", "init", "campaign", "--recordings", folder
        )
    else:
        output.next_step("process every test of the log", "batch", log)


def after_batch(log: Path) -> None:
    """Print the step after a batch: comparing the model beside the log, where there is one."""
    model = _model_of_folder(log)
    if model is None:
        text = "write a model, as `shakerproc init FOLDER` shows, and compare it"
        output.next_step(text, "compare", "MODEL", log)
    else:
        output.next_step("compare the model with the tests", "compare", model, log)


def after_comparing(model: Path, log: Path, *, explained: bool) -> None:
    """Print the step after a comparison: the search for a missing effect, or nothing."""
    if explained:
        output.next_step("nothing to add, the model explains every test")
    else:
        output.next_step("ask which effect is missing", "diagnose", model, log)


def after_diagnosis(diagnosis: "Diagnosis", model: Path, log: Path) -> None:
    """Print the step after a diagnosis: adding its effect, or removing the obstacle."""
    if diagnosis.verdict == "effect found":
        effect = max(diagnosis.effects, key=lambda e: len(e.between))  # faults have one place
        new = model.with_name(f"{model.stem}-with-{effect.kind}.yaml")
        places = ("--between", ",".join(effect.between))
        add = ("add", effect.kind, model, log, *places, "-o", new)
        output.next_step("add it to the model", *add)
    elif diagnosis.verdict == "measurement fault":
        text = "repair the sensor, or declare the fault in the log; then"
        output.next_step(text, "diagnose", model, log)
    elif diagnosis.verdict == "outside library":
        new = model.with_name(f"{model.stem}-with-table.yaml")
        output.next_step("write the missing force into a model, without a name",
            "add", "table", model, log, "-o", new)  # fmt: skip
    elif diagnosis.verdict == "nothing missing":
        output.next_step("nothing to add")
    else:
        text = "run the next test above and enter it in the log" if diagnosis.next_test else (
            "settle what is said above"
        )  # fmt: skip
        output.next_step(f"{text}; then", "diagnose", model, log)


def _model_of_folder(log: Path) -> Path | None:
    """Return the model in the folder of a log: model.yaml before others, by name."""
    files: Sequence[Path] = sorted(
        (*log.parent.glob("*.yaml"), *log.parent.glob("*.yml")),
        key=lambda path: (path.stem != "model", path.name),
    )
    return next((path for path in files if _is_model(path)), None)


def _is_model(path: Path) -> bool:
    """Return whether a file begins as a model does: its first key is ``model``."""
    try:
        with path.open("rb") as file:
            beginning = file.read(4096).decode("utf-8", "replace")
    except OSError:
        return False
    return bool(re.match(r"(\s*(#.*)?\n|---\n)*model\s*:", beginning))
