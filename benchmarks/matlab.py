"""MATLAB files with one bit flipped, outside the samples: what readers make of them.

python -m benchmarks.matlab

Each file is read in a process of its own, which may take 5 s of processor and 3 GB (Linux).
"""

import io
import os
import resource
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import scipy.io

from shakerproc.errors import ShakerprocError
from shakerproc.recordings.matlab import read_mat

HEAD = 128
OUTCOMES = ("read", "refused in one line", "raised something else")


def seed() -> tuple[bytes, list[int]]:
    """Return a file of two channels, and the bytes of its tags, names and sizes."""
    rng, file = np.random.default_rng(7), io.BytesIO()
    rows = rng.standard_normal((2, 300))
    scipy.io.savemat(file, {"fs": 1000.0, "a": rows[0], "b": rows[1], "names": ["a", "b"]})
    data = file.getvalue()
    samples = {
        at for row in rows for at in range(data.find(row.tobytes()), len(data))[: row.nbytes]
    }
    return data, [at for at in range(HEAD, len(data)) if at not in samples]


def outcome(reader: Callable[[Path], object], path: Path) -> str:
    """Return what became of reading a file in a process of its own."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
        resource.setrlimit(resource.RLIMIT_CPU, (5, 5))
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        try:
            reader(path)
        except ShakerprocError:
            os._exit(1)
        except BaseException:  # noqa: BLE001
            os._exit(2)
        os._exit(0)
    status = os.waitpid(child, 0)[1]
    if os.WIFSIGNALED(status):
        return "ended the process or took longer"
    return OUTCOMES[os.WEXITSTATUS(status)]


def main() -> None:
    """Print the counts of scipy's reader and of ours."""
    data, places = seed()
    found: dict[str, Counter[str]] = {scipy.__version__: Counter(), "ours": Counter()}
    with TemporaryDirectory() as folder:
        path = Path(folder) / "damaged.mat"
        for at in places:
            for bit in range(8):
                path.write_bytes(data[:at] + bytes([data[at] ^ 1 << bit]) + data[at + 1 :])
                found[scipy.__version__][outcome(scipy.io.loadmat, path)] += 1
                found["ours"][outcome(lambda one: read_mat(one, "damaged"), path)] += 1
    for name, counts in found.items():
        print(name, dict(counts))


if __name__ == "__main__":
    main()
