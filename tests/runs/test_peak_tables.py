"""Tables of peaks: every resolved mode, nothing where the fit failed, nothing by chance."""

import csv
import re

import numpy as np
import pytest
from scipy import signal
from tests.in_process import run
from tests.small_campaign import RATE

from shakerproc.data import STANDARD_GRAVITY, Channel, recording_of_arrays
from shakerproc.recordings import write_tdms
from shakerproc.report.runs.view import run_view
from shakerproc.runs.summary import read_summary
from shakerproc.spectra import find_peaks

CHANNELS = (Channel("control", "m/s^2", "control", "g"), Channel("ch3", "m/s^2", "ch3", "g"))


def mode(base, frequency, ratio, rate=RATE):
    """Absolute acceleration of a mass on a spring and damper, base acceleration given."""
    omega = 2.0 * np.pi * frequency
    continuous = ([2.0 * ratio * omega, omega**2], [1.0, 2.0 * ratio * omega, omega**2])
    above, below, _ = signal.cont2discrete(continuous, 1.0 / rate, "foh")
    return signal.lfilter(above.ravel(), below, base)


def processed(folder, response, base, *options):
    """Return the summary of a run of one control and one response, as `process` leaves it."""
    path = folder / "run.tdms"
    rows = np.array([base, response]) * STANDARD_GRAVITY
    write_tdms(path, recording_of_arrays("run", CHANNELS, rows, RATE))
    out = folder / "out"
    more = ("--no-figures", "--no-crop", "--control", "control", *options)
    assert run("process", path, *more, "--out", out) == 0
    with (out / "peaks.csv").open(encoding="utf-8") as file:
        return read_summary(out / "summary.json"), list(csv.DictReader(file))


def two_modes(seconds=60.0):
    """Base and response: the taller mode at 62 Hz, the other one at 240 Hz with Q = 39."""
    base = np.random.default_rng(1).standard_normal(round(seconds * RATE))
    response = mode(base, 62.0, 0.01) + 0.4 * mode(base, 240.0, 0.5 / 39.0)
    return base, response


def test_every_resolved_mode_stands_on_the_terminal_and_in_the_report(tmp_path, capfd):
    base, response = two_modes()
    summary, _ = processed(tmp_path, response, base, "--excitation", "random")
    shown = capfd.readouterr().out
    listed = [float(hz) for hz in re.findall(r"^ch3 +(\d+\.?\d*) +[>\d]", shown, re.MULTILINE)]
    found = [
        min(listed, key=lambda hz, wanted=wanted: abs(hz - wanted)) for wanted in (62, 240)
    ]
    np.testing.assert_allclose(found, [62.0, 240.0], atol=1.0)
    tables = [line for line in shown.splitlines() if line.startswith(("ch", "control"))]
    assert max(len(line) for line in tables) <= 80
    cells = run_view(summary, 1).peaks
    np.testing.assert_allclose([float(row[1]) for row in cells], [62.0, 240.0], atol=1.0)
    qualities = [float(row[5]) for row in cells]
    np.testing.assert_allclose(qualities, [50.0, 39.0], rtol=0.05)


def test_no_natural_frequency_where_no_mode_fits_the_peak(tmp_path):
    """A table on the peak: flat for 30 Hz, then steep."""
    base = np.random.default_rng(4).standard_normal(round(60.0 * RATE))
    table = signal.firwin(2001, [350.0, 380.0], pass_zero=False, fs=RATE)
    response = signal.fftconvolve(base, table, mode="same") + 0.01 * base
    options = ("--excitation", "random", "--from-hz", "5", "--to-hz", "800")
    summary, rows = processed(tmp_path, response, base, *options)
    plateau = [row for row in rows if row["quantity"] == "h1" and row["role"] == "response"]
    assert plateau
    for row in plateau:
        assert row["damping_withheld"]
        if "not resolved" not in row["damping_withheld"]:
            assert row["natural_frequency_hz"] == ""
    assert any(row["natural_frequency_hz"] == "" for row in plateau)
    (cells,) = {row[4] for row in run_view(summary, 1).peaks}
    assert cells == ""


def test_a_peak_that_the_bins_do_not_resolve_says_so_beside_its_height(tmp_path, capfd):
    """Bins of 2 Hz, a peak 1 Hz wide: a gain of 100 is read as half of that."""
    base = np.random.default_rng(2).standard_normal(round(120.0 * RATE))
    response = mode(base, 100.0, 0.005) + mode(base, 400.0, 0.06)
    summary, rows = processed(tmp_path, response, base, "--excitation", "random")
    shown = capfd.readouterr().out
    narrow, broad = (row for row in rows if row["quantity"] == "h1")
    assert float(narrow["height"]) < 60.0
    assert narrow["height_resolved"] == "false"
    assert abs(float(narrow["height_fitted"]) / 100.0 - 1.0) < 0.05
    assert broad["height_resolved"] == "true"
    assert abs(float(broad["height"]) / float(broad["height_fitted"]) - 1.0) < 0.1
    assert f"> {float(narrow['height']):.3g}" in shown
    assert "bins of 2 Hz are too coarse for these peaks: their height is at least" in shown
    assert any("too coarse" in line for line in run_view(summary, 1).withheld)


@pytest.mark.parametrize("seed", range(5))
def test_noise_has_no_resonances(tmp_path, seed):
    """A response that the base has nothing to do with, and one that copies the base."""
    rng = np.random.default_rng(seed)
    base, other = rng.standard_normal((2, 20 * int(RATE)))
    for name, response in (("apart", other), ("copy", base + 0.1 * other)):
        (tmp_path / name).mkdir()
        summary, _ = processed(tmp_path / name, response, base, "--excitation", "random")
        assert not summary.channels[1].response_peaks


def test_chance_makes_a_peak_in_one_flat_spectrum_of_twenty_at_most():
    rng, found = np.random.default_rng(7), 0
    error = 0.1
    for _ in range(200):
        values = 1.0 + error * rng.standard_normal(400)
        found += bool(
            find_peaks(np.arange(400.0), values, (0.0, 399.0), errors=np.full(400, error))
        )
    assert found <= 10


def test_two_peaks_a_few_bins_apart_are_both_found():
    frequency = np.arange(200.0)
    values = 1.0 / ((frequency - 80.0) ** 2 + 4.0) + 1.0 / ((frequency - 92.0) ** 2 + 4.0)
    peaks = find_peaks(frequency, values, (0.0, 199.0), errors=np.full(200, 0.05))
    assert sorted(peak.bin_frequency for peak in peaks) == [80.0, 92.0]
