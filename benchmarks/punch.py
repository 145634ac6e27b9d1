"""How long a punch file of 40 MB takes to read.

python -m benchmarks.punch [--megabytes 40]
"""

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from tests.exchange.punch_writer import write_punch


def main() -> None:
    """Write a punch file of that size, read it, and say how long each took."""
    from shakerproc.exchange.nastran_punch import recording_of_punch

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megabytes", type=float, default=40.0)
    wanted = parser.parse_args().megabytes
    steps = int(wanted * 1e6 / (3 * 10 * 81))  # 3 quantities, 6 lines of heading and 2 nodes
    values = np.random.default_rng(1).standard_normal((2, 6, steps))
    headings = ("$DISPLACEMENTS", "$VELOCITY", "$ACCELERATION")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.pch"
        write_punch(path, dict.fromkeys(headings, values), [1, 2], np.arange(steps) * 0.002)
        start, work = time.perf_counter(), time.process_time()
        recording = recording_of_punch(path)
        taken, worked = time.perf_counter() - start, time.process_time() - work
        print(
            f"{path.stat().st_size / 1e6:.1f} MB, {len(recording.channels)} channels of "
            f"{recording.n_samples} samples: {taken:.2f} s ({worked:.2f} s of processor)"
        )


if __name__ == "__main__":
    main()
