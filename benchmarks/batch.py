"""Processor seconds of a whole batch for each test, beside scipy and matplotlib by hand.

Recordings as of `benchmarks.process`: 6 minutes, 5 channels. Every figure is the
processor's time of whole commands, their start included, over their number of tests.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from benchmarks.process import NAMES, write_long_recording, write_rattling_recording

N_TESTS: Final = 4

LOG: Final = """testlog: 1
title: benchmark
recordings: .
processing: {crop: none}
channels:
  control 1: {role: control}
  control 2: {role: control}
  response 1: {role: response}
  response 2: {role: response}
  response 3: {role: response}
tests:
"""

TEST: Final = (
    "  - {{id: {0}, recording: {0}.tdms, excitation: random, from: 5 Hz, to: 1000 Hz}}\n"
)

BY_HAND: Final = """
import sys
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import nptdms, numpy as np, scipy.signal as signal
for path in sys.argv[2:]:
    group = nptdms.TdmsFile.read(path).groups()[0]
    rows = np.array([channel[:] for channel in group.channels()])
    rate = 1.0 / group.channels()[0].properties["wf_increment"]
    of = dict(fs=rate, window="hamming", nperseg=1024, noverlap=512)
    frequency, density = signal.welch(rows, **of)
    _, cross = signal.csd(rows[1], rows, **of)
    _, coherence = signal.coherence(rows[1], rows, **of)
    if sys.argv[1] == "figures":
        drawings = {"psd": density, "gain": abs(cross / density[1]), "g2": coherence}
        for name, drawn in drawings.items():
            figure, axis = plt.subplots(figsize=(7, 4))
            axis.semilogy(frequency, drawn.T)
            figure.savefig(f"{path}.{name}.png", dpi=150)
            plt.close(figure)
        figure, axis = plt.subplots(figsize=(7, 4))
        axis.plot(rows[:, ::100].T)
        figure.savefig(f"{path}.time.png", dpi=150)
        plt.close(figure)
"""


def processor_seconds(*command: str) -> float:
    """Return the time of the processor that a command and its children took [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Print the table."""
    if len(NAMES) != LOG.count("role"):
        sys.exit("the log must say the role of each channel")
    python, ours = sys.executable, (sys.executable, "-m", "shakerproc")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        paths = [str(folder / f"{number}.tdms") for number in range(1, N_TESTS + 1)]
        write_long_recording(Path(paths[0]))
        for path in paths[1:]:
            os.link(paths[0], path)
        log = folder / "log.yaml"
        log.write_text(LOG + "".join(TEST.format(n) for n in range(1, N_TESTS + 1)))
        processor_seconds(*ours, "process", paths[0], "--no-figures", "--out", f"{name}/warm")
        rows = [("start: --version", processor_seconds(*ours, "--version"), 1)]
        rattling = folder / "rattling" / "1.tdms"  # of its peaks no damping can be given
        rattling.parent.mkdir()
        write_rattling_recording(rattling)
        how = ("--excitation", "random", "--no-figures", "--no-crop")
        for told, path in (("", paths[0]), (", play", str(rattling))):
            out = ("--out", f"{name}/p{told[2:]}")
            taken = processor_seconds(*ours, "process", path, *how, *out)
            rows.append((f"process, no figures{told}", taken, 1))
        for kind in ("no-figures", "figures"):
            out = ("--out", f"{name}/{kind}", f"--{kind}")
            rows.append((
                f"batch, {kind}",
                processor_seconds(*ours, "batch", str(log), *out),
                N_TESTS,
            ))
        for kind in ("no-figures", "figures"):
            taken = processor_seconds(python, "-c", BY_HAND, kind, *paths)
            rows.append((f"by hand, {kind}", taken, N_TESTS))
    print(f"{'':24} processor [s]  for each test [s]")
    for label, taken, tests in rows:
        print(f"{label:24} {taken:13.2f} {taken / tests:18.2f}")


if __name__ == "__main__":
    main()
