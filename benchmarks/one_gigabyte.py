"""Seconds and memory of reading 1 GB, by format.

``python -m benchmarks.one_gigabyte`` writes one file after the other into a temporary folder,
reads it in pieces of 65,536 rows in a process of its own, and prints the time of that process
and of those that it starts, and their largest memory above that of a file of a hundredth;
``--only wav npy`` takes some, ``--megabytes 100`` smaller ones.
"""

import argparse
import json
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
from tests.recordings.recorder_files import (
    atfx,
    atfx_component,
    rpc3_bytes,
    write_famos,
    write_ide,
    write_mdf,
)

from shakerproc.data import Channel, Recording, recording_of_arrays
from shakerproc.recordings.writers import WRITERS

CHANNELS, RATE, PIECE = 4, 10_000.0, 1 << 16
NAMES = tuple(f"ch{number + 1}" for number in range(CHANNELS))

_READ = """
import json, os, re, sys, time
from pathlib import Path
from shakerproc.recordings import open_recording

def tree():
    every = {int(p.name): p for p in Path("/proc").iterdir() if p.name.isdecimal()}
    above = {}
    for number, place in every.items():
        try:
            above[number] = int((place / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            pass
    found = [os.getpid()]
    for one in found:
        found += [number for number, parent in above.items() if parent == one]
    return [every[number] for number in found]

def used():
    ticks, peak = 0, 0
    for place in tree():
        fields = (place / "stat").read_text().rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
        peak += int(re.search(r"VmHWM:\\s+(\\d+)", (place / "status").read_text())[1])
    return ticks / os.sysconf("SC_CLK_TCK"), peak / 1024.0

start, before = time.perf_counter(), used()[0]
with open_recording(sys.argv[1], sample_rate=float(sys.argv[2]) or None) as found:
    for first in range(0, found.n_samples, 65536):
        found.source.read(found.rows, first, min(first + 65536, found.n_samples))
    rows, (own, peak) = found.n_samples, used()
print(json.dumps([rows, own - before, time.perf_counter() - start, peak]))
"""


def _pieces(n: int, dtype: str) -> Iterator[np.ndarray]:
    """Yield samples of all channels, a piece at a time: one piece of noise again and again."""
    noise = np.random.default_rng(1).standard_normal((PIECE, CHANNELS), dtype=np.float32)
    piece = (noise * 1000.0).astype(dtype)
    for first in range(0, n, PIECE):
        yield piece[: n - first]


def _whole(n: int) -> np.ndarray:
    return np.concatenate(list(_pieces(n, "f8"))).T


def _wav(path: Path, size: int) -> None:
    n = size // (4 * CHANNELS)
    data, width = n * 4 * CHANNELS, 4 * CHANNELS
    form = struct.pack("<HHIIHH", 3, CHANNELS, int(RATE), int(RATE) * width, width, 32)
    with path.open("wb") as file:
        file.write(struct.pack("<4sI4s4sI", b"RIFF", 36 + data, b"WAVE", b"fmt ", 16) + form)
        file.write(struct.pack("<4sI", b"data", data))
        for piece in _pieces(n, "<f4"):
            file.write(piece.tobytes())


def _npy(path: Path, size: int) -> None:
    n = size // (8 * CHANNELS)
    held = np.lib.format.open_memmap(path, "w+", np.float64, (n, CHANNELS))
    for number, piece in enumerate(_pieces(n, "f8")):
        held[number * PIECE :][: len(piece)] = piece


def _hdf5(path: Path, size: int) -> None:
    n = size // (8 * CHANNELS)
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = RATE
        sets = [file.create_dataset(name, n, "f8") for name in NAMES]
        for number, piece in enumerate(_pieces(n, "f8")):
            for data, line in zip(sets, piece.T, strict=True):
                data[number * PIECE : number * PIECE + len(line)] = line


def _recording(n: int) -> Recording:
    channels = [Channel(name, "m/s^2", name, "g") for name in NAMES]
    values = np.concatenate(list(_pieces(n, "f4"))).T
    return recording_of_arrays("run", channels, values, RATE)


def _written(path: Path, size: int) -> None:
    """As `convert` writes it; text takes some 20 bytes a number."""
    width = {".csv": 20}.get(path.suffix, 8)
    WRITERS[path.suffix](path, _recording(size // (width * CHANNELS)))


def _xlsx(path: Path, size: int) -> None:
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("run")
    sheet.append(["time [s]", *(f"{name} [g]" for name in NAMES)])
    number = 0
    for piece in _pieces(min(size // 50, 1_000_000), "f8"):  # a sheet has 1,048,576 rows
        for row in piece:
            sheet.append([number / RATE, *row.tolist()])
            number += 1
    book.save(path)


def _feather(path: Path, size: int) -> None:
    import pandas as pd

    values = _whole(size // (8 * (CHANNELS + 1)))
    columns = {"time [s]": np.arange(values.shape[1]) / RATE}
    columns |= {f"{name} [g]": line for name, line in zip(NAMES, values, strict=True)}
    pd.DataFrame(columns).to_feather(path, compression="uncompressed")


def _mdf(path: Path, size: int) -> None:
    values = _whole(size // (8 * (CHANNELS + 1)))
    times = np.arange(values.shape[1]) / RATE
    write_mdf(path, [[(n, "g", times, line) for n, line in zip(NAMES, values, strict=True)]])


def _ide(path: Path, size: int) -> None:
    values = _whole(size // (4 * CHANNELS)).astype("f4")
    write_ide(path, [(8, "A", "g", NAMES, RATE, values)], 1714979289, block=4096)


def _famos(path: Path, size: int) -> None:
    values = _whole(size // (8 * CHANNELS))
    channels = [(name, "g", line) for name, line in zip(NAMES, values, strict=True)]
    write_famos(path, channels, 1.0 / RATE, (6, 5, 2024, 7, 8, 9.25))


def _rpc3(path: Path, size: int) -> None:
    per_group = 1024
    groups = size // (2 * CHANNELS * per_group)
    said = {"FRAMES": groups, "SAMPLES": groups * per_group}
    scales = [0.001] * CHANNELS
    one = np.zeros((CHANNELS, per_group), int)
    head = rpc3_bytes(one, scales, 1.0 / RATE, per_group=per_group, changed=said)[: 8 * 512]
    with path.open("wb") as file:
        file.write(head)
        for piece in _pieces(groups * per_group, "<i2"):
            file.write(piece.tobytes())  # which channel is which is no matter for the time


def _ods(path: Path, size: int) -> None:
    n = size // (4 * CHANNELS)
    with path.with_suffix(".btf").open("wb") as file:
        for piece in _pieces(n, "<f4"):
            file.write(piece.tobytes())
    columns = [("time", "s", "Time", (0.0, 1.0 / RATE))]
    for number, name in enumerate(NAMES):
        there = atfx_component("B", "ieeefloat4", n, 4 * number, 4 * CHANNELS, 0)
        columns.append((
            name,
            "g",
            "acceleration",
            f"<Art>explicit</Art><Werte>{there}</Werte>",
        ))
    path.write_text(atfx([("part", n, columns)], files={"B": f"{path.stem}.btf"}))


FORMATS: dict[str, tuple[str, Callable[[Path, int], None]]] = {
    "WAV": ("a.wav", _wav), "npy": ("a.npy", _npy), "HDF5": ("a.h5", _hdf5),
    "Feather": ("a.feather", _feather), "MDF": ("a.mf4", _mdf), "IDE": ("a.ide", _ide),
    "FAMOS": ("a.raw", _famos), "RPC III": ("a.rsp", _rpc3), "ATFX": ("a.atfx", _ods),
    "TDMS": ("a.tdms", _written), "UFF 58, binary": ("a.uff", _written),
    "Parquet": ("a.parquet", _written), "MATLAB 5": ("a.mat", _written),
    "CSV": ("a.csv", _written), "XLSX": ("a.xlsx", _xlsx),
}  # fmt: skip


def read(path: Path) -> list[float]:
    """Return rows, own and elapsed seconds and largest memory [MB] of a process that reads.

    Raises
    ------
    SystemExit
        If it fails.
    """
    rate = RATE if path.suffix == ".npy" else 0.0
    done = subprocess.run(
        [sys.executable, "-c", _READ, str(path), str(rate)], capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(done.stderr[-500:])
    return json.loads(done.stdout.splitlines()[-1])


def main() -> None:
    """Print a line for each format."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--megabytes", type=int, default=1000)
    options = parser.parse_args()
    print("| format | MB | rows | seconds of the process | MB/s | MB above a small file |")
    print("|---|---|---|---|---|---|")
    for kind, (name, write) in FORMATS.items():
        if options.only and kind.lower() not in {one.lower() for one in options.only}:
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / name
            write(path, options.megabytes * 10_000)
            small = read(path)[3]
            write(path, options.megabytes * 1_000_000)
            size = sum(one.stat().st_size for one in Path(folder).iterdir()) / 1e6
            rows, own, _, peak = read(path)
        print(
            f"| {kind} | {size:.0f} | {rows:.0f} | {own:.1f} | {size / own:.0f} | "
            f"{max(0.0, peak - small):.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
