"""A campaign of short recordings in the files' own format, made in a fraction of a second."""

from pathlib import Path

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import write_tdms

RATE = 2048.0
CHANNELS = (
    Channel("control 1", "m/s^2", "control 1", "g"),
    Channel("control 2", "m/s^2", "control 2", "g"),
    Channel("response 1", "m/s^2", "response 1", "g"),
    Channel("response 2", "m/s^2", "response 2", "g"),
)
HEAD = """\
testlog: 1
title: {title}
recordings: recordings
channels:
  control 1: {{role: control}}
  control 2: {{role: control}}
  response 1: {{role: response, name: ch3, at: coupon}}
  response 2: {{role: response, name: ch4, at: rim}}
processing:
  crop: {{channel: control 2, threshold: 0.2 g}}
  welch: {{segment: 512, overlap: 256}}
tests:
"""
ROW = (
    "  - {{id: {id}, recording: {file}, joint: {joint}, specimen: {specimen}, "
    "clearance: {clearance} mm, orientation: out of plane, excitation: random, "
    "level: 0.0005 g^2/Hz, from: 5 Hz, to: 800 Hz{more}}}\n"
)


def samples(resonance, *, damping=0.03, seconds=6.0, seed=1):
    """Random base motion in g, quiet at both ends, and an oscillator on it; (4, n) m/s^2."""
    rng = np.random.default_rng(seed)
    n = int(seconds * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    spectrum = rng.standard_normal(frequency.size) + 1j * rng.standard_normal(frequency.size)
    spectrum[(frequency < 5.0) | (frequency > 800.0)] = 0.0
    base = np.fft.irfft(spectrum, n)
    base *= np.sqrt(0.0005 * 795.0) / np.std(base)
    base *= np.clip(np.minimum(np.arange(n), np.arange(n)[::-1]) / RATE * 4.0 - 1.0, 0.0, 1.0)
    r = frequency / resonance
    response = np.fft.irfft(
        np.fft.rfft(base) * (1 + 2j * damping * r) / (1 - r**2 + 2j * damping * r), n
    )
    rows = [base, base, response, 0.6 * response + 0.4 * base]
    noise = 1e-3 * rng.standard_normal((4, n))
    return (np.array(rows) + noise) * STANDARD_GRAVITY


def write_recording(path: Path, resonance, **how):
    path.parent.mkdir(parents=True, exist_ok=True)
    write_tdms(path, recording_of_arrays(path.stem, CHANNELS, samples(resonance, **how), RATE))
    return path


def write_campaign(folder: Path, n_tests=4, *, title="A small campaign", more="", **how):
    """Write a log of so many tests, whose peak frequency falls with clearance."""
    rows = []
    for i in range(n_tests):
        step = i % 3
        name = f"test_{i + 1}.tdms"
        write_recording(folder / "recordings" / name, 360.0 - 50.0 * step, seed=i, **how)
        rows.append(
            ROW.format(
                id=i + 1,
                file=name,
                joint=("radial", "slot")[(i // 3) % 2],
                specimen=f"a_0_{5 * step:02d}",
                clearance=f"{0.05 * step:.2f}",
                more=more,
            )
        )
    log = folder / "testlog.yaml"
    log.write_text(HEAD.format(title=title) + "".join(rows), encoding="utf-8")
    return log
