"""One campaign recorded by five recorders: the same signals give the same tables."""

import csv

import numpy as np
import pytest
import scipy.signal
from scipy.io import wavfile
from tests.in_process import run
from tests.recordings.recorder_files import write_ide, write_mdf

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings.writers import write_hdf5, write_tdms

RATE, N = 5000.0, 40_000
NAMED = "{control 1: {role: control}, ch3: {role: response}}"
CHANNELS = {
    "run.tdms": NAMED,
    "run.mf4": NAMED,
    "run.h5": NAMED,
    "run.wav": "{channel 1: {role: control, name: control 1, unit: g}, "
    "channel 2: {role: response, name: ch3, unit: g}}",
    "run.ide": "{X: {role: control, name: control 1}, Y: {role: response, name: ch3}}",
}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    pytest.importorskip("asammdf", reason="needs the extra recorders")
    pytest.importorskip("idelib", reason="needs the extra recorders")
    folder = tmp_path_factory.mktemp("five")
    rng = np.random.default_rng(8)
    table = rng.standard_normal(N)
    answer = table + scipy.signal.lfilter(
        *scipy.signal.iirpeak(310.0, 15.0, fs=RATE), 4 * table
    )
    values = np.array([table, answer]).astype(np.float32)  # what each format holds exactly
    plain, times = values.astype(float), np.arange(N) / RATE
    channels = [Channel(n, "m/s^2", n, "g") for n in ("control 1", "ch3")]
    recording = recording_of_arrays("run", channels, plain * STANDARD_GRAVITY, RATE)
    write_tdms(folder / "run.tdms", recording)
    write_hdf5(folder / "run.h5", recording)
    named = zip(("control 1", "ch3"), plain, strict=True)
    write_mdf(folder / "run.mf4", [[(name, "g", times, one) for name, one in named]])
    wavfile.write(folder / "run.wav", int(RATE), values.T)
    sensor = (8, "Accelerometer", "g", ("X", "Y"), RATE, values)
    write_ide(folder / "run.ide", [sensor], 1714979289)
    tests = "".join(
        f"  - {{id: {number}, recording: {name}, channels: {channels}, excitation: random, "
        "level: 1 g rms, from: 20 Hz, to: 2000 Hz}\n"
        for number, (name, channels) in enumerate(CHANNELS.items(), 1)
    )
    (folder / "log.yaml").write_text(
        f"testlog: 1\nrecordings: .\nprocessing: {{crop: none}}\ntests:\n{tests}"
    )
    out = folder / "out"
    assert (
        run("batch", folder / "log.yaml", "--out", out, "--no-figures", "--workers", "1") == 0
    )
    return out


def of_tests(out, name):
    """The rows of each test: of a table of its own, or of that of all tests, unnamed."""
    if name == "spectra.csv":
        for path in sorted(out.glob("**/spectra.csv")):
            yield list(csv.reader(path.read_text().splitlines()))
        return
    head, *rows = csv.reader((out / name).read_text().splitlines())
    said = {"test", "recording", "file", "start_time", "sha256"} & set(head)
    kept = [i for i, column in enumerate(head) if column not in said]
    for number in range(1, len(CHANNELS) + 1):
        own = [row for row in rows if row[head.index("test")] == str(number)]
        yield [[row[i] for i in kept] for row in own]


@pytest.mark.parametrize("name", ["spectra.csv", "peaks.csv", "statistics.csv"])
def test_five_recorders_of_one_campaign_give_the_same_tables(results, name):
    first, *others = of_tests(results, name)
    assert len(first) > 1
    assert len(others) == len(CHANNELS) - 1
    for rows in others:
        assert len(rows) == len(first)
        for row, expected in zip(rows, first, strict=True):
            for cell, other in zip(row, expected, strict=True):
                if cell != other:
                    assert float(cell) == pytest.approx(float(other), rel=1e-9)
