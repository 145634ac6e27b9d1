"""Recordings of many channels: processor time and memory of each, beside those of fewer.

python -m benchmarks.many_channels

Prints, for text of 50, 200 and 400 channels and of 3,000 and 30,000 columns, the processor
seconds and the peak of the memory of a process that inspects or processes it. Both grow with
the channels, not with their square: from 200 to 400 they do not grow by more than twice.
"""

import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

RATE = 1000.0
SIZES = ((50, 20_000), (200, 20_000), (400, 20_000), (3_000, 100), (30_000, 100))
"""Channels and samples of each."""


def main() -> None:
    """Print time and memory of both commands for each recording."""
    with tempfile.TemporaryDirectory() as folder:
        for channels, samples in SIZES:
            path = Path(folder) / f"of_{channels}.csv"
            write(path, channels, samples)
            commands = [["inspect", str(path)]]
            if samples > RATE:
                out = str(path.with_suffix(""))
                options = ["--no-figures", "--no-crop", "--control", "a0", "--out", out]
                commands.append(["process", str(path), *options])
            for command in commands:
                seconds, peak = measured(command)
                told = f"{seconds:.1f} s, {peak:.0f} MB"
                print(f"{command[0]} {channels} channels x {samples}: {told}")


def write(path: Path, channels: int, samples: int) -> None:
    """Write channels [m/s²] that share a motion, each with noise of its own."""
    generator = np.random.default_rng(1)
    rows = generator.standard_normal(samples) + 0.1 * generator.standard_normal((
        channels,
        samples,
    ))
    names = ",".join(["Time (s)", *(f"a{i} (m/s^2)" for i in range(channels))])
    table = np.column_stack([np.arange(samples) / RATE, rows.T])
    np.savetxt(path, table, fmt="%.7g", delimiter=",", header=names, comments="")


def measured(command: list[str]) -> tuple[float, float]:
    """Return processor time [s] and the peak of the memory [MB] of the program."""
    program = (
        "import resource, runpy, sys\n"
        "try:\n    runpy.run_module('shakerproc', run_name='__main__')\n"
        "finally:\n"
        "    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, file=sys.stderr)\n"
    )
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(
        [sys.executable, "-c", program, *command], capture_output=True, text=True, check=True
    )
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return seconds, float(done.stderr.split()[-1]) / 1024.0


if __name__ == "__main__":
    main()
