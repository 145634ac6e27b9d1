"""A log with hammer tests, processed: tables, report, one line for a bad one."""

import csv
import re

import numpy as np
import pytest
from tests.in_process import run
from tests.struck import RATE, struck

LOG = """\
testlog: 1
recordings: .
channels:
  f: {role: force, unit: N, position: [0 mm, 0 mm, 0 mm]}
  a: {role: response, unit: m/s^2, position: [0 mm, 0 mm, 0 mm]}
  b: {role: response, unit: m/s^2}
processing:
  hammer: {length: 0.8 s, force_window: 10 ms, exponential: 1 %}
tests:
  - {id: 1, recording: good.npz, excitation: hammer, level: 150 N, from: 20 Hz, to: 350 Hz}
  - {id: 2, recording: quiet.npz, excitation: hammer, from: 20 Hz, to: 350 Hz}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The results of a batch over a test that was struck, and one that was not."""
    folder = tmp_path_factory.mktemp("hammer")
    blows = [(0.3, 120.0), (1.3, 100.0), (1.35, 40.0), (2.3, 140.0)]
    for name, times in (("good", blows), ("quiet", [])):
        rows = struck(times, 3.3, noise=(0.05, 0.005))
        np.savez(folder / f"{name}.npz", **dict(zip("fab", rows, strict=True)), fs=RATE)
    (folder / "log.yaml").write_text(LOG)
    assert run("batch", folder / "log.yaml", "--out", folder / "out", "--no-figures") == 1
    return folder / "out"


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_the_table_of_blows_holds_all_with_the_reason(results):
    rows = rows_of(results / "blows.csv")
    assert [row["kept"] for row in rows] == ["true", "false", "true"]
    assert re.match(r"double hit: (39|40|41)% of its force 5\d", rows[1]["reason"])
    assert float(rows[2]["force_n"]) == pytest.approx(140.0, rel=0.04)  # sampled beside its top


def test_resonances_and_the_driving_point_stand_in_tables(results):
    found = [row for row in rows_of(results / "resonances.csv") if row["function"] == "a / f"]
    frequencies = [float(row["natural_frequency_hz"]) for row in found[:2]]
    assert frequencies == pytest.approx([62.0, 143.0], rel=1e-3)
    (point,) = rows_of(results / "driving_point.csv")
    assert float(point["power_in_percent"]) > 99.0


def test_the_report_draws_them(results):
    page = (results / "report.html").read_text(encoding="utf-8")
    for text in (
        "Blows: 2 of 3 averaged",
        "% of its force 5",
        "Force of the blows that are averaged",
        "Coherence of the response functions",
        "ISO 7626-5",
    ):
        assert text in page


def test_a_test_without_a_blow_is_one_line_and_costs_the_other_nothing(results):
    (failed,) = [row for row in rows_of(results / "runs.csv") if row["error"]]
    assert failed["test"] == "2"
    assert "no blow found: the largest force" in failed["error"]


def test_the_table_of_peaks_has_the_resonances_over_the_force(results):
    """The oscillators of `struck`: 62 and 143 Hz."""
    rows = [r for r in rows_of(results / "peaks.csv") if r["quantity"] == "h1 a / f"]
    found = sorted(float(row["natural_frequency_hz"]) for row in rows)
    assert found[:2] == pytest.approx([62.0, 143.0], rel=1e-3)
    assert {row["channel"] for row in rows} == {"a"}
    assert [row["rank"] for row in rows] == [str(i + 1) for i in range(len(rows))]
