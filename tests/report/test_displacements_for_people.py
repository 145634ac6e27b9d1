"""Displacements are read in millimetres, and stay in metres in files for programs."""

import csv
import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import completed

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import write_tdms
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.testlog import chosen_units

G, RATE, PER_G = 9.80665, 1000.0, 12.5e-6
"""The laser sees 12.5 µm for each g of the table, at every frequency."""

LOG = """\
testlog: 1
title: laser
recordings: .
channels:
  table: {role: control}
  laser: {role: displacement}
processing:
  crop: none
  welch: {segment: 512}
  response_functions: [{input: controls, output: laser}]
tests:
  - {id: 1, recording: run.tdms, excitation: sine sweep, level: 2 g,
     from: 20 Hz, to: 200 Hz, rate: 10 oct/min}
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A batch of one sweep: its folder, and what the processing of it alone prints."""
    folder = tmp_path_factory.mktemp("laser")
    seconds = 60.0 * np.log2(10.0) / 10.0
    time = np.arange(int(seconds * RATE)) / RATE
    rate = np.log(10.0) / seconds
    table = 2.0 * np.sin(2.0 * np.pi * 20.0 * np.expm1(rate * time) / rate)
    rows = np.array([G * table, PER_G * table])
    channels = [Channel(n, u, n, u) for n, u in (("table", "m/s^2"), ("laser", "m"))]
    write_tdms(folder / "run.tdms", recording_of_arrays("run", channels, rows, RATE))
    (folder / "log.yaml").write_text(LOG)
    batch = completed("batch", folder / "log.yaml", "--out", folder / "out")
    assert batch.returncode == 0, batch.stderr
    run = completed(
        "process", folder / "run.tdms", "--log", folder / "log.yaml", "--out", folder / "one"
    )
    assert run.returncode == 0, run.stderr
    return folder, run.stdout


def rows_of(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_page_and_terminal_say_millimetres(made):
    folder, printed = made
    page = (folder / "out" / "report.html").read_text(encoding="utf-8")
    # the largest value of a sine of 2 g is 25 µm; the gain is 12.5 µm/g
    assert "0.025 mm" in page
    assert "mm²/Hz" in page
    assert "laser up 0.0125 mm/g at" in page
    (laser,) = [line for line in printed.splitlines() if line.startswith("laser    disp")]
    name, role, rms, unit, *_ = laser.split()
    assert (name, role, unit) == ("laser", "displacement", "mm")
    assert float(rms) == pytest.approx(0.025 / np.sqrt(2.0), rel=0.01)


def test_tables_and_json_for_programs_stay_in_metres(made):
    folder, _ = made
    out = folder / "out"
    (laser,) = [r for r in rows_of(out / "statistics.csv") if r["channel"] == "laser"]
    assert laser["unit"] == "m"
    assert float(laser["maximum"]) == pytest.approx(2.0 * PER_G, rel=1e-3)
    (run,) = json.loads((out / "report.json").read_text(encoding="utf-8"))["runs"]
    assert [c["unit"] for c in run["channels"]] == ["g", "m"]
    assert [c["maximum"] for c in run["channels"]] == pytest.approx([2.0, 2.0 * PER_G], 1e-3)


def test_a_swept_response_says_its_unit_and_is_what_h1_is(made):
    """The gain along the sweep, too, is in the shown unit over g: not in m over m/s²."""
    folder, _ = made
    sweep = rows_of(folder / "out" / "runs" / "test_1" / "sweep.csv")
    gain = np.array([float(row["gain_laser_magnitude_m_per_g"]) for row in sweep])
    assert_allclose(gain, PER_G, rtol=1e-3)
    peaks = [
        r for r in rows_of(folder / "out" / "peaks.csv")
        if r["channel"] == "laser" and r["quantity"] == "sweep up"
    ]  # fmt: skip
    assert [r["height_unit"] for r in peaks] == ["m/g"]
    assert float(peaks[0]["height"]) == pytest.approx(PER_G, rel=1e-3)


@pytest.mark.parametrize(
    ("unit", "wanted", "factor"),
    [
        ("m", "mm", 1e3),
        ("m²/Hz", "mm²/Hz", 1e6),
        ("m/g", "mm/g", 1e3),
        ("N/m", "N/mm", 1e-3),
        ("rad", "mrad", 1e3),
        ("(m/s)²/Hz", "(m/s)²/Hz", 1.0),
        ("rad/s^2", "rad/s^2", 1.0),
        ("N m", "N m", 1.0),
        ("rad/(N m)", "mrad/(N m)", 1e3),
        ("µm", "µm", 1.0),
        ("µm/m", "µm/m", 1.0),
    ],
)
def test_only_lengths_and_angles_change_where_no_unit_is_chosen(unit, wanted, factor):
    assert USUAL.unit(unit) == (wanted, pytest.approx(factor))


def test_a_chosen_unit_counts_more_and_a_torque_is_no_force():
    assert ShownUnits(chosen_units(["SI"])).unit("m") == ("m", 1.0)
    assert ShownUnits(chosen_units(["lbf"])).text("3 N m and 3 N") == "3 N m and 0.6744 lbf"
