"""A test log of 5,000 rows: reading it beside libyaml alone.

python -m benchmarks.long_log

Prints the processor seconds that the program takes to read and check the log, those in which
libyaml parses the same text, and their ratio in this run.
"""

import tempfile
from collections import deque
from pathlib import Path

import yaml

from benchmarks.response import best_of
from shakerproc.testlog import read_testlog

ROWS = 5000


def main() -> None:
    """Print both times and their ratio."""
    rows = "".join(
        f"  - {{id: {n}, recording: Test_{n}/Acceleration.tdms, joint: radial,\n"
        "     specimen: a_0_00, clearance: 0.00 mm, orientation: out of plane,\n"
        "     excitation: sine sweep, level: 0.5 g, from: 5 Hz, to: 500 Hz, rate: 1 oct/min}\n"
        for n in range(ROWS)
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "testlog.yaml"
        path.write_text("testlog: 1\ntests:\n" + rows, encoding="utf-8")
        text = path.read_text(encoding="utf-8")
        _, bare = best_of(3, lambda: deque(yaml.parse(text, yaml.CSafeLoader), maxlen=0))
        _, ours = best_of(3, lambda: read_testlog(path))
    print(f"{ROWS} rows: {ours:.2f} s, libyaml {bare:.2f} s, ratio {ours / bare:.1f}")


if __name__ == "__main__":
    main()
