"""Memory and speed from TDMS to the cross-spectral matrix, whatever the layout of the file.

``python -m benchmarks memory_tdms`` writes 2 GB of 8 channels in each layout to a temporary
folder, runs `shakerproc process` on it, figures and all, and prints the peak memory of that
process; then the time from file to matrix over the time of the same from memory, on a file of
256 MB.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from tests.recordings import tdms_bytes
from tests.recordings.tdms_bytes import AS_BEFORE, INTERLEAVED, METADATA, NEW_LIST, RAW

CHANNELS = 8
RATE = 5688.9
BLOCK = 1 << 20
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}

LAYOUTS = {
    # number type, samples of a segment (0: all in one), interleaved
    "segments of 1 s, float64": ("f8", 5689, False),
    "33,000 segments, float64": ("f8", 1000, False),
    "one chunk, float64": ("f8", 0, False),
    "one segment, interleaved int16": ("i2", 0, True),
}


def write(path: Path, layout: str, size: int) -> int:
    """Write a file of about this size [bytes]; return the samples of a channel."""
    dtype, length, interleaved = LAYOUTS[layout]
    width = np.dtype(dtype).itemsize
    n = size // (CHANNELS * width)
    length = length or n
    flags = RAW | (INTERLEAVED if interleaved else 0)
    with path.open("wb") as file:
        for segment in range(n // length):
            meta = metadata(dtype, length) if segment == 0 else again()
            first = METADATA | (NEW_LIST if segment == 0 else 0)
            raw = CHANNELS * width * length
            file.write(tdms_bytes.segment(meta, b"", flags | first, to_next=len(meta) + raw))
            for piece in noise(dtype, CHANNELS * length, segment):
                file.write(piece)
    return n // length * length


def metadata(dtype: str, length: int) -> bytes:
    """Return the metadata of the first segment."""
    said = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
    if dtype == "i2":
        said |= {
            "NI_Number_Of_Scales": 1,
            "NI_Scale[0]_Scale_Type": "Linear",
            "NI_Scale[0]_Linear_Slope": 1e-3,
            "NI_Scale[0]_Linear_Y_Intercept": 0.0,
        }
    index = tdms_bytes.index(dtype, length)
    paths = [f"/'run - All Data'/'ch{i + 1}'" for i in range(CHANNELS)]
    return tdms_bytes.metadata([tdms_bytes.listed(path, index, said) for path in paths])


def again() -> bytes:
    """Return the metadata of a segment like the one before."""
    paths = [f"/'run - All Data'/'ch{i + 1}'" for i in range(CHANNELS)]
    return tdms_bytes.metadata([tdms_bytes.listed(path, AS_BEFORE) for path in paths])


def noise(dtype: str, count: int, seed: int) -> Iterator[bytes]:
    """Yield so many samples in blocks, as they are stored."""
    rng = np.random.default_rng(seed % 16)
    numbers = rng.standard_normal(min(count, BLOCK)) * (1000.0 if dtype == "i2" else 1.0)
    stored = numbers.astype(dtype).tobytes()
    for start in range(0, count, BLOCK):
        yield stored[: min(BLOCK, count - start) * np.dtype(dtype).itemsize]


LOG = """testlog: 1
recordings: .
channels:
{channels}
processing: {{crop: none}}
tests:
  - {{id: 1, recording: big.tdms, excitation: random, from: 5 Hz, to: 1000 Hz}}
"""


def work(path: Path) -> dict[str, float]:
    """Run `shakerproc process` with all it does; return time [s] and its peak memory [MB]."""
    import resource

    log = path.with_name("log.yaml")
    roles = ["control", "control", *["response"] * (CHANNELS - 2)]
    lines = [f"  {i}: {{role: {role}}}" for i, role in enumerate(roles, 1)]
    log.write_text(LOG.format(channels="\n".join(lines)))
    command = [sys.executable, "-m", "shakerproc", "process", str(path), "--log", str(log)]
    start = time.perf_counter()
    subprocess.run([*command, "--out", str(path.parent / "results")], **QUIET, check=True)
    seconds = time.perf_counter() - start
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e6
    return {"seconds": seconds, "peak_mb": peak}


def ratio(path: Path) -> dict[str, float]:
    """Return the times from file and from memory to the matrix [s], the best of three."""
    from shakerproc.data import recording_of_arrays
    from shakerproc.recordings import open_recording
    from shakerproc.spectra import cross_spectra

    with open_recording(path) as recording:
        held = recording_of_arrays(
            "held", recording.channels, recording.samples(), recording.sample_rate
        )
    times: dict[str, list[float]] = {"file_s": [], "memory_s": [], "blocks_s": []}
    for _ in range(3):
        start = time.perf_counter()
        with open_recording(path) as recording:
            cross_spectra(recording.blocks(), recording.sample_rate)
        times["file_s"].append(time.perf_counter() - start)
        start = time.perf_counter()
        cross_spectra(held.blocks(), held.sample_rate)
        times["memory_s"].append(time.perf_counter() - start)
        start = time.perf_counter()
        with open_recording(path) as recording:
            for _block in recording.blocks():
                pass
        times["blocks_s"].append(time.perf_counter() - start)
    return {name: min(values) for name, values in times.items()}


def in_its_own_process(job: str, path: Path) -> dict[str, float]:
    """Return what a job needs of memory and time where nothing else runs."""
    command = [
        sys.executable,
        "-m",
        "benchmarks.memory_tdms",
        "--job",
        job,
        "--file",
        str(path),
    ]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megabytes", type=int, default=2048)
    parser.add_argument("--only", default="", help="layouts whose name holds this")
    parser.add_argument("--job", choices=["work", "ratio"])
    parser.add_argument("--file", type=Path)
    options = parser.parse_args()
    if options.job:
        print(json.dumps({"work": work, "ratio": ratio}[options.job](options.file)))
        return
    print("| layout | MB | s | MB/s | peak MB | file / memory | blocks alone MB/s |")
    print("|---|---|---|---|---|---|---|")
    for layout in (name for name in LAYOUTS if options.only in name):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "big.tdms"
            write(path, layout, options.megabytes << 20)
            size = path.stat().st_size / 2**20
            big = in_its_own_process("work", path)
            small_size = 256 if LAYOUTS[layout][0] == "f8" else 64
            write(path, layout, small_size << 20)
            small = in_its_own_process("ratio", path)
        print(
            f"| {layout} | {size:.0f} | {big['seconds']:.1f} | {size / big['seconds']:.0f} | "
            f"{big['peak_mb']:.0f} | {small['file_s'] / small['memory_s']:.2f} | "
            f"{small_size / small['blocks_s']:.0f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
