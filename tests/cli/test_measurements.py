"""Of several measurements or groups in a file, the one that is meant, from inspect to batch."""

import json

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from tests.in_process import run
from tests.small_campaign import RATE, samples

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.testlog import read_testlog

NAMES = ("control 1", "control 2", "response 1", "response 2")
RESONANCES = (150.0, 350.0)
CROP = ("--crop-threshold", "0.2 g", "--no-figures")


def write(path, groups=("g", "g")):
    """Write two measurements an hour apart; their resonances tell them."""
    with TdmsWriter(path) as file:
        for number, (group, resonance) in enumerate(zip(groups, RESONANCES, strict=True)):
            told = {
                "wf_start_time": np.datetime64(f"2024-06-05T0{number + 7}:00:00", "us"),
                "wf_increment": 1.0 / RATE,
                "unit_string": "g",
            }
            rows = samples(resonance) / STANDARD_GRAVITY
            file.write_segment([
                ChannelObject(group, name, row, told)
                for name, row in zip(NAMES, rows, strict=True)
            ])
    return path


def peak_of(folder):
    found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    response = next(c for c in found["channels"] if c["name"] == "response 1")
    return response["response_peaks"][0]["frequency_hz"]


@pytest.mark.parametrize(
    ("groups", "options"),
    [
        (("g", "g"), (("--measurement", "1"), ("--measurement", "2"))),
        (("one", "two"), (("--group", "one"), ("--group", "two"))),
    ],
)
def test_each_part_of_a_file_is_processed_into_a_folder_of_its_own(
    tmp_path, capsys, monkeypatch, groups, options
):
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path / "r.tdms", groups)
    assert run("process", path, *CROP) == 1
    assert "Say which:" in capsys.readouterr().err
    before = set(tmp_path.glob("*_results"))
    for option, resonance in zip(options, RESONANCES, strict=True):
        assert run("process", path, *CROP, *option) == 0
        (made,) = set(tmp_path.glob("*_results")) - before
        before.add(made)
        assert abs(peak_of(made) - resonance) < RATE / 1024


def test_inspect_lists_the_measurements_and_shows_the_one_that_is_asked_for(tmp_path, capsys):
    path = write(tmp_path / "r.tdms")
    assert run("inspect", path) == 1
    shown = capsys.readouterr()
    assert (
        "measurement 1: from 2024-06-05 07:00:00, 12288 samples at 2048 Hz in 'g'" in shown.out
    )
    assert "measurement 2: from 2024-06-05 08:00:00" in shown.out
    assert "or --measurement 1, or all if they are one" in shown.err
    assert run("inspect", path, "--measurement", "2", "--json", tmp_path / "i.json") == 0
    found = json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))
    assert (found["samples"], found["start_time"][:16]) == (12288, "2024-06-05T08:00")
    assert run("inspect", path, "--measurement", "0") == 2


def test_convert_writes_the_measurement_that_is_asked_for(tmp_path):
    path = write(tmp_path / "r.tdms")
    assert run("convert", path, tmp_path / "r.csv") == 1
    assert run("convert", path, tmp_path / "r.csv", "--measurement", "2") == 0
    lines = (tmp_path / "r.csv").read_text(encoding="utf-8").splitlines()
    assert len([line for line in lines if line[0] in "0123456789"]) == 12288


def test_a_log_chooses_measurement_and_group_test_by_test(tmp_path):
    (tmp_path / "recordings").mkdir()
    write(tmp_path / "recordings" / "twice.tdms")
    write(tmp_path / "recordings" / "groups.tdms", ("one", "two"))
    channels = "".join(f"  {name}: {{role: {name.split()[0]}}}\n" for name in NAMES)
    log = tmp_path / "testlog.yaml"
    log.write_text(
        f"testlog: 1\nchannels:\n{channels}"
        "processing: {crop: {channel: control 2, threshold: 0.2 g}}\ntests:\n"
        "  - {id: 1, recording: twice.tdms, processing: {measurement: 1}}\n"
        "  - {id: 2, recording: twice.tdms, processing: {measurement: 2}}\n"
        "  - {id: 3, recording: groups.tdms, processing: {group: one}}\n"
        "  - {id: 4, recording: groups.tdms, processing: {group: two}}\n"
        "  - {id: 5, recording: twice.tdms}\n",
        encoding="utf-8",
    )
    assert [test.processing.measurement for test in read_testlog(log).tests][:2] == [1, 2]
    assert run("batch", log, "--no-figures", "--workers", "1") == 1  # one test does not say
    runs = tmp_path / "results" / "runs"
    for number, resonance in zip((1, 2, 3, 4), RESONANCES * 2, strict=True):
        assert abs(peak_of(runs / f"test_{number}") - resonance) < RATE / 1024
    assert not (runs / "test_5" / "summary.json").exists()
