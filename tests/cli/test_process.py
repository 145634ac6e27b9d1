"""``process`` as a person meets it: sweeps up and down, a tone taken out, a cut recording."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import io, signal
from tests.in_process import completed as shakerproc

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import write_tdms

SAMPLE = Path(__file__).parents[2] / "sample_data"
RATE = 2000.0
NATURAL, DAMPING = 80.0, 0.05


def columns_of(path):
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def numbers_of(path):
    return {
        name: np.array([value or "nan" for value in values], dtype=float)
        for name, values in columns_of(path).items()
        if name not in {"direction", "excited", "incomplete"}
    }


def write_run(path, base):
    """Write a control and the response of a mass on a spring, in g; quiet at both ends."""
    base = np.concatenate([np.zeros(800), base, np.zeros(800)])
    omega = 2.0 * np.pi * NATURAL
    continuous = ([2.0 * DAMPING * omega, omega**2], [1.0, 2.0 * DAMPING * omega, omega**2])
    above, below, _ = signal.cont2discrete(continuous, 1.0 / RATE, "foh")
    response = signal.lfilter(above.ravel(), below, base)
    rows = np.array([base, base, response])
    rows += 1e-4 * np.random.default_rng(1).standard_normal(rows.shape)
    names = ("control 1", "control 2", "response 1")
    channels = [Channel(name, "m/s^2", name, "g") for name in names]
    write_tdms(path, recording_of_arrays(path.stem, channels, rows * STANDARD_GRAVITY, RATE))


def up_down_up():
    one = np.geomspace(30.0, 200.0, round(25.0 * RATE))
    frequency = np.concatenate([one, one[::-1], one])
    return np.sin(2.0 * np.pi * np.cumsum(frequency) / RATE)


@pytest.mark.slow
def test_sweeps_up_and_down_are_stitched_on_request(tmp_path):
    write_run(tmp_path / "sweep.tdms", up_down_up())
    options = ("--excitation", "sine sweep", "--from-hz", "30", "--to-hz", "200")
    swept = {}
    for name, more in (("apart", ()), ("stitched", ("--stitch",))):
        done = shakerproc(
            "process", tmp_path / "sweep.tdms", *options, *more, "--out", tmp_path / name
        )
        assert done.returncode == 0, done.stderr
        with Image.open(tmp_path / name / "sweep.png") as image:
            assert image.width == 910
        swept[name] = columns_of(tmp_path / name / "sweep.csv")
    turns = [sorted(set(one["direction"])) for one in swept.values()]
    assert turns == [["down", "up"], ["down", "up"]]
    frequency = np.array(swept["stitched"]["frequency_hz"], dtype=float)
    gain = np.array(swept["stitched"]["gain_response 1_magnitude"], dtype=float)
    peak = NATURAL * np.sqrt((np.sqrt(1.0 + 8.0 * DAMPING**2) - 1.0) / (4.0 * DAMPING**2))
    for way in ("up", "down"):
        rows = np.array([direction == way for direction in swept["stitched"]["direction"]])
        assert np.all(np.diff(frequency[rows]) >= 0.0)
        assert frequency[rows][0] < 32.0
        assert frequency[rows][-1] > 190.0
        assert abs(frequency[rows][np.argmax(gain[rows])] - peak) < 0.02 * peak
    apart = np.array([direction == "up" for direction in swept["apart"]["direction"]])
    rising = np.array(swept["apart"]["frequency_hz"], dtype=float)[apart]
    assert np.diff(rising).min() < -100.0  # two sweeps, one after the other
    for k in (2, 3, 4, 5):
        assert f"harmonic_{k}_response 1_phase_deg" in swept["apart"]


def test_a_tone_is_taken_out_and_drawn_over_two_periods(tmp_path):
    test = SAMPLE / "recordings" / "Test_14" / "Acceleration.tdms"
    done = shakerproc("process", test, "--log", SAMPLE / "testlog.yaml", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "notch" not in done.stderr
    drawn = {path.stem for path in tmp_path.glob("*.png")}
    assert {"notch", "notch_psd", "psd_and_response", "spectrogram"} <= drawn
    assert not {"response", "coherence"} & drawn  # one frequency makes no curve
    spectra, notch = (numbers_of(tmp_path / f"{name}.csv") for name in ("spectra", "notch"))
    at = np.argmin(np.abs(spectra["frequency_hz"] - 50.0))
    before, after = spectra["psd_ch4_g2_per_hz"], spectra["psd_notched_ch4_g2_per_hz"]
    assert after[at] < 1e-4 * before[at]
    third = np.argmin(np.abs(spectra["frequency_hz"] - 150.0))
    assert 0.7 < after[third] / before[third] < 1.4
    assert abs(np.ptp(notch["time_s"]) - 0.04) < 0.001


def test_a_recording_that_was_cut_says_so_in_every_table_and_figure(tmp_path):
    test = SAMPLE / "recordings" / "Test_11" / "Acceleration.tdms"
    done = shakerproc(
        "process", test, "--log", SAMPLE / "testlog.yaml", "--out", tmp_path,
        "--export", "mat,uff,parquet", "--no-figures",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "INCOMPLETE, 5 of 6.126 s" in done.stdout
    told = "5.00 of 6.13 s"
    for name in ("spectra", "sweep"):
        assert set(columns_of(tmp_path / f"{name}.csv")["incomplete"]) == {told}
    for name in ("peaks", "statistics"):
        assert set(columns_of(tmp_path / f"{name}.csv")["incomplete"]) == {"true"}
    assert io.loadmat(tmp_path / "spectra.mat")["incomplete"].item() == told
    assert f"INCOMPLETE {told}".encode() in (tmp_path / "spectra.uff").read_bytes()
    assert told.encode() in (tmp_path / "spectra.parquet").read_bytes()


def test_controls_and_units_on_the_command_line(tmp_path):
    rows = np.random.default_rng(2).standard_normal((3, 6000))
    path = tmp_path / "plain.csv"
    lines = [f"{i / 1000.0},{a},{b},{c}" for i, (a, b, c) in enumerate(rows.T)]
    path.write_text("\n".join(["time [s],table,left,right", *lines]), encoding="utf-8")
    common = ("process", path, "--no-crop", "--no-figures", "--out", tmp_path / "out")
    refused = shakerproc(*common)
    assert refused.returncode == 1
    assert refused.stderr.count("\n") == 1
    assert "has no unit" in refused.stderr
    done = shakerproc(*common, "--unit", "g", "--control", "none")
    assert done.returncode == 0, done.stderr
    assert "control" not in done.stdout
    wrong = shakerproc(*common, "--unit", "g", "--control", "top")
    assert wrong.returncode == 1
    assert "no channel 'top' to be a control" in wrong.stderr
    logged = shakerproc(*common, "--control", "table", "--log", SAMPLE / "testlog.yaml")
    assert logged.returncode == 2


def test_what_the_sample_campaign_promises_is_in_its_figures(tmp_path):
    """One test of each kind: all the figures that the kind has."""
    wanted = {
        "3": {"time", "psd", "response", "coherence", "psd_and_response", "spectrogram"},
        "13": {"time", "psd", "response", "coherence", "psd_and_response", "spectrogram",
               "sweep", "level"},
    }  # fmt: skip
    for test, figures in wanted.items():
        recording = SAMPLE / "recordings" / f"Test_{test}" / "Acceleration.tdms"
        out = tmp_path / test
        done = shakerproc("process", recording, "--log", SAMPLE / "testlog.yaml", "--out", out)
        assert done.returncode == 0, done.stderr
        assert {path.stem for path in out.glob("*.png")} == figures
        shutil.rmtree(out)
