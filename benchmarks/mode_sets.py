"""How long modes of many nodes take to read and to correlate.

python -m benchmarks.mode_sets [--nodes 100000] [--modes 10]
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

RIGID = 6


def main() -> None:
    """Write the same modes in three formats, read each, and say how long it took."""
    from shakerproc.exchange.mode_files import read_mode_file
    from shakerproc.modal.shapes import mac

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=100_000)
    parser.add_argument("--modes", type=int, default=10)
    given = parser.parse_args()
    x = np.linspace(0.0, 1.0, given.nodes)
    frequencies = np.maximum(0.0, 50.0 * (np.arange(given.modes) - RIGID + 1.0))
    shapes = np.zeros((given.modes, given.nodes, 6))
    shapes[..., 2] = np.cos(np.pi * np.outer(np.arange(given.modes) + 1.0, x))
    with tempfile.TemporaryDirectory() as folder:
        for name, write in WRITERS.items():
            path = Path(folder) / name
            write(path, x, frequencies, shapes)
            start, work = time.perf_counter(), time.process_time()
            found = read_mode_file(path)
            worst = np.min(np.diag(mac(found.shapes.T + 0j, found.shapes.T + 0j)))
            print(
                f"{name}: {path.stat().st_size / 1e6:.0f} MB, {found.shapes.shape[0]} places, "
                f"{found.frequencies.size} modes, MAC {worst:.3f}: "
                f"{time.perf_counter() - start:.1f} s "
                f"({time.process_time() - work:.1f} s of processor)"
            )


def _frd(path: Path, x: np.ndarray, frequencies: np.ndarray, shapes: np.ndarray) -> None:
    zero = np.zeros_like(x)
    with path.open("w") as file:
        file.write(f"    1C\n    2C{x.size:30d}{1:38d}\n")
        _nodes(file.write, np.array([x, zero, zero]).T)
        for i, (frequency, shape) in enumerate(zip(frequencies, shapes, strict=True), 1):
            file.write(
                f"  100CL  101{frequency:12.5E}{x.size:12d}{'':20s} 2{i:5d}MODAL      1\n"
            )
            file.write(" -4  DISP        4    1\n")
            _nodes(file.write, shape[:, :3])


def _nodes(write: Callable[[str], object], values: np.ndarray) -> None:
    numbered = enumerate(values.tolist(), 1)
    write("".join(f" -1{i:10d}{a:12.5E}{b:12.5E}{c:12.5E}\n" for i, (a, b, c) in numbered))
    write(" -3\n")


def _punch(path: Path, _: np.ndarray, frequencies: np.ndarray, shapes: np.ndarray) -> None:
    with path.open("w") as file:
        for i, (frequency, shape) in enumerate(zip(frequencies, shapes, strict=True), 1):
            square = (2.0 * np.pi * frequency) ** 2
            file.write(
                f"$EIGENVECTOR\n$REAL OUTPUT\n$EIGENVALUE = {square:14.7E}  MODE = {i:5d}\n"
            )
            for node, row in enumerate(shape.tolist(), 1):
                numbers = [f"{value:18.6E}" for value in row]
                file.write(f"{node:10d}       G{''.join(numbers[:3])}\n")
                file.write(f"{'-CONT-':18s}{''.join(numbers[3:])}\n")


def _universal(path: Path, x: np.ndarray, frequencies: np.ndarray, shapes: np.ndarray) -> None:
    import pyuff

    same = {
        "type": 55, **{f"id{i}": "x" for i in range(1, 6)}, "model_type": 1,
        "analysis_type": 2, "data_ch": 3, "spec_data_type": 8, "data_type": 2,
        "n_data_per_node": 6, "load_case": 1, "modal_m": 1.0, "modal_damp_vis": 0.01,
        "modal_damp_his": 0.0, "node_nums": np.arange(1, x.size + 1),
    }  # fmt: skip
    for i, (frequency, shape) in enumerate(zip(frequencies, shapes, strict=True), 1):
        rows = {f"r{j}": row for j, row in enumerate(shape.T, 1)}
        pyuff.UFF(str(path)).write_sets({**same, "mode_n": i, "freq": frequency, **rows}, "add")


WRITERS = {"modes.frd": _frd, "modes.pch": _punch, "modes.unv": _universal}


if __name__ == "__main__":
    main()
