"""Work that goes wrong in every way; its own file, because worker processes import it."""

import os
import signal
import time
from pathlib import Path


class UnpicklableError(Exception):
    def __init__(self, first, second):
        super().__init__(first)
        self.handle = lambda: second  # neither pickles nor rebuilds from its arguments


def work(argument):
    kind = argument["kind"]
    if kind == "raise":
        raise RuntimeError("no luck")
    if kind == "unpicklable":
        raise UnpicklableError("cannot cross", "a pipe")
    if kind == "killed":
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "hang":
        time.sleep(1000.0)
    if kind == "memory":
        return {"hog": len(bytearray(5_000_000_000))}
    if kind == "exit":
        raise SystemExit(3)
    if kind == "not json":
        return {"value": object()}
    if kind == "killed once" and not Path(argument["marker"]).exists():
        Path(argument["marker"]).write_text("was here", encoding="utf-8")
        os.kill(os.getpid(), signal.SIGKILL)
    return {"kind": kind, "number": argument["number"] ** 2}
