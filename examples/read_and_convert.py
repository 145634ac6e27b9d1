"""A recording of any format, as arrays: its channels in SI units, and a part of it as CSV."""

import tempfile
from pathlib import Path

import numpy as np

from shakerproc.recordings import WRITERS, open_recording

SAMPLE = (
    Path(__file__).parents[1] / "sample_data" / "recordings" / "Test_3" / "Acceleration.tdms"
)

with open_recording(SAMPLE) as recording:
    names = [channel.name for channel in recording.channels]
    rate = recording.sample_rate  # [Hz]
    samples = recording.samples()  # (n_channels, n_samples), m/s²
    rms = dict(zip(names, np.sqrt(np.mean(samples**2, axis=1)), strict=True))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy.csv"
        WRITERS[".csv"](copy, recording)
        header = copy.read_text(encoding="utf-8").splitlines()[0]

if __name__ == "__main__":
    print(f"{rate:g} Hz, {samples.shape[1]} samples; {header}")
    for name, value in rms.items():
        print(f"{name}: {value:.1f} m/s² rms")
