"""Files that are opened first by a process that may die: a library that ends its process."""

import os
import signal
import subprocess
import sys
from functools import lru_cache
from pathlib import Path
from typing import Final

from shakerproc.errors import RecordingError
from shakerproc.recordings.guard import AGAIN

LONGEST_S: Final = 60.0
"""A trial that takes longer is given up [s]; it takes a third of a second."""

_TRY: Final = """
import importlib, sys
from pathlib import Path
module, _, name = sys.argv[1].partition(":")
try:
    getattr(importlib.import_module(module), name)(Path(sys.argv[2]))
except BaseException:
    sys.exit(1)  # the caller meets it again, and says it
"""


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
    """Return how the process died that opened a file; empty where it did not."""
    places = os.pathsep.join(entry or str(Path.cwd()) for entry in sys.path)
    try:
        status = subprocess.run(  # noqa: S603 - this interpreter, with names of ours and a path
            [sys.executable, "-P", "-c", _TRY, trial, str(path)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": places, "OMP_NUM_THREADS": "1"},
            timeout=LONGEST_S,
            check=False,
        ).returncode
    except subprocess.TimeoutExpired:
        return f"no answer for {LONGEST_S:g} s"
    if status in {0, 1}:
        return ""
    known = {int(one): one.name for one in signal.Signals}
    return known.get(-status, f"status {status}")
