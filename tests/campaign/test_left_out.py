"""Tests whose channels did not measure: flagged, and no part of any trend."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from tests.small_campaign import write_campaign
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.data import ArraySource
from shakerproc.recordings import open_recording, write_tdms


def spoiled(path, channel, change):
    """Rewrite one channel of a recording."""
    with open_recording(path) as recording:
        samples = recording.samples()
        row = [c.source_name for c in recording.channels].index(channel)
        samples[row] = change(samples[row])
    rows = tuple(range(len(samples)))
    write_tdms(path, replace(recording, source=ArraySource(samples), rows=rows))


def noise(samples):
    return 0.049 * np.random.default_rng(5).standard_normal(samples.size)


def clipped(samples):
    return np.clip(samples, -0.1 * samples.max(), 0.1 * samples.max())


def clipped_at_times(samples):
    limit = np.quantile(np.abs(samples), 0.9)
    return np.clip(samples, -limit, limit)


ALL = "takes no part in trends, compare, diagnose and add; to use"
SOME = "takes no part in trends and compare (diagnose and add leave the clipped samples out);"
CASES = {
    "constant": ("response 1", np.zeros_like, "ch3 is constant", ALL),
    "open": ("response 2", noise, "ch4 is an open input", ALL),
    "saturated": ("response 1", clipped, "ch3 is clipped", ALL),
    "saturated at times": ("response 1", clipped_at_times, "ch3 is clipped", SOME),
    "dead control": ("control 1", noise, "control 1 is an open input", ALL),
}


@pytest.mark.parametrize("case", CASES)
def test_a_test_with_a_dead_channel_is_flagged_and_takes_no_part_in_trends(case, tmp_path):
    channel, change, why, without = CASES[case]
    log = write_campaign(tmp_path, 3)
    spoiled(tmp_path / "recordings" / "test_2.tdms", channel, change)
    root = tmp_path / "out"
    arguments = ["batch", str(log), "--out", str(root), "--no-figures", "--workers", "1"]
    result = CliRunner().invoke(build_app(), arguments)
    assert result.exit_code == 0
    sentence = f"test 2 takes no part in trends: {why}"
    assert sentence in " ".join(result.stderr.split())
    document = json.loads((root / "report.json").read_text())
    assert document["left_out_of_trends"] == [sentence]
    assert {p["test"] for t in document["trends"] for s in t["series"].values() for p in s} == {
        "1",
        "3",
    }
    (run,) = [run for run in document["runs"] if run["test"] == "2"]
    (flag,) = [flag for flag in run["flags"] if flag["unusable"]]
    assert without in flag["message"]
    assert sentence in (root / "report.html").read_text()
    with (root / "runs.csv").open() as table:
        rows = {row["test"]: row["flags"] for row in csv.DictReader(table)}
    assert flag["kind"] in rows["2"]
    assert rows["1"] == rows["3"] == ""
