"""`compare` of campaigns that are large: wall and processor time, and peak of the memory.

python -m benchmarks.large_comparisons [--cases many,long,chain]

many: 16 tests of 1.4 million samples; long: one of 22 million; chain: 200 masses with 8
sensors, two tests of 100,000 samples. Base acceleration and responses are noise, through one
mass but for the chain: time and memory depend on nothing else.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import yaml
from scipy import signal

RATE = 5000.0
CASES = {"many": (16, 1_400_000, 1), "long": (1, 22_000_000, 1), "chain": (2, 100_000, 200)}
"""Tests, samples of each, masses."""


def write(folder: Path, n_tests: int, n_samples: int, n_masses: int) -> tuple[Path, Path]:
    """Write model, log and recordings; return the paths of model and log."""
    names = [f"m{i}" for i in range(n_masses)]
    sensors = {f"a{i}": names[i] for i in range(0, n_masses, max(n_masses // 8, 1))}
    joints = list(zip(["base", *names], names, strict=False))
    stiffness = 4e5 * n_masses**2
    elements = [
        {"kind": kind, "between": list(joint), key: value}
        for joint in joints
        for kind, key, value in (
            ("spring", "stiffness", f"{stiffness:g} N/m"),
            ("damper", "damping", f"{2e-2 * np.sqrt(stiffness):g} N s/m"),
        )
    ]
    model = {
        "model": 1, "title": "large", "masses": dict.fromkeys(names, "1 kg"),
        "elements": elements, "excitation": {"base": "acceleration"},
        "sensors": {name: {"at": at} for name, at in sensors.items()},
    }  # fmt: skip
    channels = {"c": {"role": "control", "unit": "m/s^2"}}
    channels |= {name: {"role": "response", "unit": "m/s^2"} for name in sensors}
    tests = [
        {"id": i + 1, "recording": f"{i}.npz", "excitation": "random", "from": "20 Hz",
         "to": "400 Hz"}
        for i in range(n_tests)
    ]  # fmt: skip
    log = {"testlog": 1, "recordings": ".", "channels": channels,
           "processing": {"crop": "none"}, "tests": tests}  # fmt: skip
    omega = np.sqrt(stiffness)
    law = ([2e-2 * omega, omega**2], [1.0, 2e-2 * omega, omega**2])
    above, below, _ = signal.cont2discrete(law, 1.0 / RATE, "foh")
    for i in range(n_tests):
        rng = np.random.default_rng(i)
        base = rng.standard_normal(n_samples)
        through = signal.lfilter(above.ravel(), below, base) if n_masses == 1 else base
        rows = {name: through + 0.1 * rng.standard_normal(n_samples) for name in sensors}
        np.savez(folder / f"{i}.npz", c=base, **rows, fs=RATE)
    (folder / "model.yaml").write_text(yaml.safe_dump(model, sort_keys=False), "utf-8")
    (folder / "log.yaml").write_text(yaml.safe_dump(log, sort_keys=False), "utf-8")
    return folder / "model.yaml", folder / "log.yaml"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print time and memory of each case; the peak is of all cases so far."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", default=",".join(CASES))
    options = parser.parse_args(arguments)
    for name in options.cases.split(","):
        with tempfile.TemporaryDirectory() as place:
            files = [str(path) for path in write(Path(place), *CASES[name])]
            words = ["-m", "shakerproc", "compare", *files, "--out", f"{place}/out"]
            begun, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
            done = subprocess.run(
                [sys.executable, *words], check=False, capture_output=True, text=True
            )
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            processor = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
            said = done.stdout.strip().splitlines() if not done.returncode else []
            wall, peak = time.perf_counter() - begun, used.ru_maxrss / 1024.0
            print(
                f"{name:6s} wall {wall:.0f} s, processor {processor:.0f} s, peak {peak:.0f} MB"
            )
            print(said[0] if said else done.stderr[-300:], flush=True)


if __name__ == "__main__":
    main()
