"""The commands inspect and convert, run as a user runs them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, TdmsWriter
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording, sha256, write_tdms

NASTY = "evil\x1b[31m\u202ename"


@pytest.fixture
def recording(tmp_path):
    rng = np.random.default_rng(1)
    channels = [
        Channel("control 1", "m/s^2", "control 1", "g"),
        Channel(NASTY, "m/s^2", "x", "g"),
    ]
    samples = rng.standard_normal((2, 20_000))
    samples[1, 5000:5100] = 0.0
    path = tmp_path / "run.tdms"
    write_tdms(path, recording_of_arrays("run", channels, samples, 1000.0))
    with TdmsWriter(str(path), mode="a") as writer:  # the smallest of every 100, as copies
        about = {"DecimationLevel": 1, "IntervalIndex": 0}
        writer.write_segment([
            GroupObject("Decimated Data_Level1", about),
            *(
                ChannelObject(
                    "Decimated Data_Level1", c.name, line[::100], {"wf_increment": 0.1}
                )
                for c, line in zip(channels, samples, strict=True)
            ),
        ])
    return path


def run(*arguments):
    return CliRunner().invoke(build_app(), [str(a) for a in arguments])


def test_inspect_prints_channels_groups_and_health(recording):
    result = run("inspect", recording)
    assert result.exit_code == 0
    assert "2 channels, 20 s, 20000 samples at 1000 Hz" in result.stdout
    assert sha256(recording) in result.stdout
    assert "control 1" in result.stdout
    assert "decimated copies" in result.stdout
    assert "dropout" in result.stdout
    assert all(line.isprintable() for line in result.stdout.splitlines())


def test_inspect_as_json(recording):
    result = run("inspect", recording, "--json", "-")
    found = json.loads(result.stdout)
    assert found["schema"] == "shakerproc-inspect/1"
    assert found["sample_rate_hz"] == 1000.0
    assert found["samples"] == 20_000
    assert [c["name"] for c in found["channels"]] == ["control 1", NASTY]
    assert found["channels"][0]["source_unit"] == "g"
    assert [(f["kind"], f["start"]) for f in found["flags"]] == [("dropout", 5.0)]
    assert found["sha256"] == sha256(recording)
    assert found["levels"][0]["rms"] == pytest.approx(1.0, rel=0.05)
    assert found["error"] is None


def test_inspect_without_looking_at_the_samples(recording):
    result = run("inspect", recording, "--no-health")
    assert "health" not in result.stdout
    assert "dropout" not in result.stdout


def test_inspect_shows_what_an_unusable_file_holds(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text("a [g],b\n1,2\n3,4\n5,6\n")
    result = run("inspect", path, "--json", tmp_path / "out.json")
    assert isinstance(result.exception, RecordingError)
    assert "2 channels, 3 samples" in result.stdout
    found = json.loads((tmp_path / "out.json").read_text())
    assert "processing: {sample_rate" in found["error"]
    assert found["groups"][0]["channels"][0]["unit"] == "g"
    result = run("inspect", path, "--sample-rate-hz", "50")
    assert result.exit_code == 0
    assert "note: The sample rate of 50 Hz is taken as given" in result.stdout


def test_inspect_marks_what_stops_short(tmp_path):
    samples = np.random.default_rng(1).standard_normal((1, 1000))
    one = recording_of_arrays("run", [Channel("a", "m/s^2", "a", "g")], samples, 100.0)
    write_tdms(tmp_path / "run.tdms", replace(one, expected_samples=5000))
    result = run("inspect", tmp_path / "run.tdms")
    assert "INCOMPLETE: 10 s of 50 s" in result.stdout


@pytest.mark.parametrize("ending", [".csv", ".mat", ".uff", ".parquet", ".tdms"])
def test_convert(recording, tmp_path, ending):
    out = tmp_path / f"out{ending}"
    result = run("convert", recording, out)
    assert result.exit_code == 0
    assert result.stdout == ""
    assert "2 channels, 20000 samples at 1000 Hz" in result.stderr
    with open_recording(recording) as before, open_recording(out) as after:
        np.testing.assert_allclose(after.samples(), before.samples(), rtol=1e-14)


def test_convert_warns_of_what_stops_short(recording, tmp_path):
    recording.write_bytes(recording.read_bytes()[:200_000])
    result = run("convert", recording, tmp_path / "out.csv")
    assert result.exit_code == 0
    assert "warning: run.tdms is incomplete, and so is out.csv" in result.stderr


def test_convert_to_nothing_known_is_wrong_usage(recording, tmp_path):
    result = run("convert", recording, tmp_path / "out.xlsx")
    assert result.exit_code == 2
    assert "no format '.xlsx'" in result.stderr
    assert run("convert", recording, recording).exit_code == 2
