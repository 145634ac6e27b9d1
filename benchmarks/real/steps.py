"""The steps of the loop on one set, each as the command that a user types, with its seconds."""

import json
import os
import resource
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LIMIT_S = 120
"""Processor seconds that a step may take, by default [s]."""


@dataclass(frozen=True)
class Step:
    """What one command gave.

    Attributes
    ----------
    document : dict
        Its JSON; empty where it failed.
    seconds : float
        Processor time [s].
    failure : str
        Last line that it wrote to stderr; empty where it did not fail.
    """

    document: dict[str, Any]
    seconds: float
    failure: str


def modal(log: Path) -> Step:
    """Look for the modes of the tests of a log; they are written beside it."""
    target, out = log.with_suffix(".modes.json"), log.with_suffix("")
    command = ["-m", "shakerproc", "modal", str(log), "--json", str(target)]
    return _run([*command, "--out", str(out), "--no-figures"], target, LIMIT_S)


def diagnose(model: Path, log: Path, *, limit: int = LIMIT_S) -> Step:
    """Ask which effect is missing."""
    target = model.with_suffix(".diagnosis.json")
    command = ["-m", "shakerproc", "diagnose", str(model), str(log), "--json", str(target)]
    command += ["--out", str(model.with_suffix(".diagnosis"))]
    return _run(command, target, limit)


def add(effect: dict[str, Any], model: Path, log: Path, new: Path) -> Step:
    """Add an effect that was named, in its joint where one is given."""
    target = new.with_suffix(".add.json")
    command = ["-m", "shakerproc", "add", effect["kind"], str(model), str(log), "-o", str(new)]
    if effect["between"]:
        command += ["--between", ",".join(effect["between"])]
    command += ["--json", str(target)]
    return _run(command, target, LIMIT_S)


def compare(model: Path, log: Path) -> Step:
    """Say how far the model misses the tests."""
    target = model.with_suffix(".compare.json")
    command = ["-m", "shakerproc", "compare", str(model), str(log), "--json", str(target)]
    command += ["--out", str(model.with_suffix(".compare"))]
    return _run(command, target, LIMIT_S)


def _run(command: list[str], target: Path, limit: int) -> Step:
    def bounded() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))

    target.unlink(missing_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, check=False,
        preexec_fn=bounded,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode == 0 and target.exists():
        return Step(json.loads(target.read_text(encoding="utf-8")), seconds, "")
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    if done.returncode < 0:
        lines.append(f"stopped after {limit} s of processor")
    return Step({}, seconds, lines[-1] if lines else f"status {done.returncode}")
