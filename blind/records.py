"""Trials on disk: one JSON document a line, so that a killed run loses nothing."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from blind.trial import Trial, from_json


def read(path: Path) -> list[Trial]:
    """Return the trials of a file; a last line that was cut off is left out."""
    if not path.exists():
        return []
    trials = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            trials.append(from_json(json.loads(line)))
        except json.JSONDecodeError:
            continue
    return trials


def append(path: Path, trial: Trial) -> None:
    """Write one more line."""
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = not path.exists() or path.read_bytes()[-1:] in {b"\n", b""}
    with path.open("a", encoding="utf-8") as stream:
        line = json.dumps(trial.as_json(), default=_plain)
        stream.write(("" if whole else "\n") + line + "\n")


def left(tasks: Sequence[tuple[int, str]], done: Sequence[Trial]) -> list[tuple[int, str]]:
    """Return the tasks that no trial answers yet."""
    known = {(trial.seed, trial.kind) for trial in done}
    return [task for task in tasks if task not in known]


def _plain(value: Any) -> Any:
    """Return a number of numpy as one of Python.

    Raises
    ------
    TypeError
        If the value is none.
    """
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a record")
