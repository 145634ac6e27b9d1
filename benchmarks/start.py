"""How long a warm command takes from the start of its process to its first computing.

python -m benchmarks.start [--repeats 7]

Each command runs in a fresh process, on the files of `shakerproc init` and one small model, and
is stopped where its computing starts: with everything imported and read that comes before, and
with the compiled stepper loaded where that is what it calls. Median, and the least.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

PLAY = """\
model: 1
title: a coupon with play
masses: {coupon: 28.6 g}
elements:
  - {kind: gap, between: [base, coupon], stiffness: 1e5 N/m, clearance: 0.05 mm}
  - {kind: damper, between: [base, coupon], damping: 3.2 N s/m}
excitation: {base: acceleration}
sensors:
  response: {at: coupon, measures: acceleration}
"""

STARTS = {  # where its computing starts, and what the command is given
    "process": ("shakerproc.runs", "process_recording", "{demo}/recordings/test_1.tdms"),
    "simulate": (
        "shakerproc.simulation.response",
        "integrate",
        "{play} {demo}/testlog.yaml --out {out}",
    ),
    "response": (
        "shakerproc.simulation.kernels.harmonic",
        "piecewise_linear_balance",
        "{play} --level 1g --out {out}",
    ),
    "compare": (
        "shakerproc.comparison",
        "compare_tests",
        "{demo}/model.yaml {demo}/testlog.yaml",
    ),
    "diagnose": (
        "shakerproc.diagnosis",
        "diagnose_tests",
        "{demo}/model.yaml {demo}/testlog.yaml",
    ),
}

CHILD = """
import importlib, os, sys, time
from shakerproc import cli
module, name = sys.argv[1:3]
build = cli.build_app
def build_app(*names):
    home = importlib.import_module(module)
    held = getattr(home, name)
    def started(*given, **named):
        if hasattr(held, "py_func"):  # numba loads what it has compiled at the first call
            import numba
            held.compile(tuple(numba.typeof(one) for one in given))
        print(time.process_time(), time.time(), file=sys.stderr, flush=True)
        os._exit(0)
    setattr(home, name, started)
    return build(*names)
cli.build_app = build_app
sys.argv[:3] = ["shakerproc"]
cli.main()
"""


def environment(folder: Path) -> dict[str, str]:
    """Return an environment in which Python keeps what it has compiled, as it usually does."""
    kept = {n: v for n, v in os.environ.items() if n != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, "PYTHONPYCACHEPREFIX": str(folder / "bytecode")}


def start(command: str, folder: Path) -> tuple[float, float]:
    """Return processor and wall time until a command computes, in a process of its own [s]."""
    module, function, given = STARTS[command]
    places = {"demo": folder / "demo", "play": folder / "play.yaml", "out": folder / "out"}
    arguments = [one.format(**places) for one in given.split()]
    began = time.time()
    done = subprocess.run(
        [sys.executable, "-c", CHILD, module, function, command, *arguments],
        capture_output=True,
        text=True,
        cwd=folder,
        check=True,
        env=environment(folder),
    )
    processor, now = (float(one) for one in done.stderr.splitlines()[-1].split())
    return processor, now - began


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    repeats = parser.parse_args(arguments).repeats
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "play.yaml").write_text(PLAY)
        subprocess.run(
            [sys.executable, "-m", "shakerproc", "init", "demo"],
            cwd=folder,
            check=True,
            capture_output=True,
        )
        print(f"{'until it computes':20}{'processor [s]':>20}{'wall [s]':>20}")
        for command in STARTS:
            start(command, folder)  # compiles what is not compiled yet
            found = [start(command, folder) for _ in range(repeats)]
            told = (
                f"{statistics.median(t):.2f} ({min(t):.2f})" for t in zip(*found, strict=True)
            )
            print(f"{command:20}" + "".join(f"{text:>20}" for text in told), flush=True)


if __name__ == "__main__":
    main()
