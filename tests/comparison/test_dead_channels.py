"""Channels that did not measure: named before any computing, and left out."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.comparison.small_campaigns import campaign, drive, written
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.data import ArraySource
from shakerproc.recordings import open_recording, write_tdms

NOISE = 0.005 * 9.80665

FAULTS = {
    "zero": (lambda x, _: 0.0 * x, "is constant. Stands at exactly 0 m/s"),
    "constant": (lambda x, _: np.full_like(x, 3.3), "is constant. Stands at exactly 3.3 m/s"),
    "open": (
        lambda x, rng: NOISE * rng.standard_normal(x.size),
        "is an open input. Noise of 0.0",
    ),
    "saturated": (
        lambda x, _: np.clip(x, -0.2 * x.max(), 0.2 * x.max()),
        r"is clipped. \d+ samples stand exactly at",
    ),
    "NaN": (
        lambda x, _: np.where(np.arange(x.size) == x.size // 2, np.nan, x),
        "holds values that are NaN or infinite",
    ),
}


@pytest.fixture(scope="module")
def healthy(tmp_path_factory):
    drives = tuple(drive(number=i, level=5.0 * i) for i in (1, 2, 3))
    path = tmp_path_factory.mktemp("healthy")
    written(campaign(drives=drives, seconds=3.0), path)
    return path


def damaged(place, fault, channel, tests):
    """The campaign with one channel replaced in some tests."""
    files = sorted(place.glob("recordings/*/*.tdms"))
    before = {file: file.read_bytes() for file in files}
    for number in tests:
        file = files[number - 1]
        with open_recording(file) as recording:
            samples = recording.samples()
            row = [c.source_name for c in recording.channels].index(channel)
            samples[row] = fault(samples[row], np.random.default_rng(number))
        rows = tuple(range(len(samples)))
        write_tdms(file, replace(recording, source=ArraySource(samples), rows=rows))
    return before


def run(*arguments):
    return CliRunner().invoke(build_app(), [str(a) for a in arguments])


@pytest.fixture
def case(healthy, request):
    """Paths of a campaign in which a fault sits in a channel of these tests."""
    name, channel, tests = request.param
    before = damaged(healthy, FAULTS[name][0], channel, tests)
    yield healthy / "model.yaml", healthy / "testlog.yaml", FAULTS[name][1]
    for file, content in before.items():
        file.write_bytes(content)


ONE = [
    (name, channel, (2,))
    for name in FAULTS
    for channel in ("control 1", "control 2", "response 1")
]


@pytest.mark.parametrize("case", ONE, indirect=True, ids=lambda c: f"{c[0]} {c[1]}")
def test_compare_leaves_out_a_test_whose_channel_did_not_measure(case, tmp_path):
    model, log, sentence = case
    target = tmp_path / "found.json"
    result = run("compare", model, log, "--no-figures", "--out", tmp_path, "--json", target)
    assert result.exit_code == 0
    found = json.loads(target.read_text())
    assert [test["test"] for test in found["tests"]] == ["1", "3"]
    (told,) = found["left_out"]
    assert re.search(f"^test 2 .Acceleration.tdms. is left out: .* {sentence}", told)
    assert found["error"] < 0.2
    report = (tmp_path / "report.html").read_text()
    assert "is left out" in report
    assert "is left out" in " ".join(result.stderr.split())


SEVERAL = {
    "control 1 is constant": {"control 1": 0.0, "control 2": 0.0},
    "control 1 is an open input": {"control 1": NOISE, "control 2": NOISE},
    "ch3 holds values that are NaN or infinite": {"response 1": np.nan},
}


@pytest.mark.parametrize("sentence", SEVERAL)
def test_the_control_is_blamed_not_the_response_that_has_nothing_in_common(
    sentence, healthy, tmp_path
):
    before: dict = {}
    for channel, size in SEVERAL[sentence].items():

        def fault(x, _, size=size, seed=int(channel[-1])):
            return size * np.random.default_rng(seed).standard_normal(x.size)

        before = damaged(healthy, fault, channel, (2,)) | before
    target = tmp_path / "found.json"
    model, log = healthy / "model.yaml", healthy / "testlog.yaml"
    result = run("compare", model, log, "--no-figures", "--out", tmp_path, "--json", target)
    for file, content in before.items():
        file.write_bytes(content)
    assert result.exit_code == 0
    (told,) = json.loads(target.read_text())["left_out"]
    assert f"is left out: {sentence}" in told


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_a_response_out_of_all_proportion_is_a_wrong_unit(scale, healthy, tmp_path):
    before = damaged(healthy, lambda x, _: scale * x, "response 1", (1, 2, 3))
    result = run(
        "diagnose", healthy / "model.yaml", healthy / "testlog.yaml", "--out", tmp_path
    )
    for file, content in before.items():
        file.write_bytes(content)
    assert result.exit_code == 1
    told = str(result.exception)
    assert re.search(r"ch3 has .* m/s.2 rms, .*e[+-]1\d times the drive. Check its unit", told)


ALL = [
    ("zero", "response 1", (1, 2, 3)),
    ("open", "control 1", (1, 2, 3)),
    ("NaN", "control 2", (1, 2, 3)),
]


@pytest.mark.parametrize("command", ["compare", "diagnose", "add"])
@pytest.mark.parametrize("case", ALL, indirect=True, ids=lambda c: f"{c[0]} {c[1]}")
def test_nothing_is_computed_where_no_test_is_left(case, command, tmp_path):
    model, log, _ = case
    first = ("add", "gap") if command == "add" else (command,)
    last = ("-o", tmp_path / "new.yaml") if command == "add" else ("--out", tmp_path)
    result = run(*first, model, log, *last)
    assert result.exit_code == 1
    assert isinstance(result.exception, Exception)
    assert "no test is left to judge by. test 1 (Acceleration.tdms)" in str(result.exception)
    assert "So is each of 2 more." in str(result.exception)
    assert list(tmp_path.iterdir()) == []
