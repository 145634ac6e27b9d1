import json
import re
import runpy
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.few_effects import seek_few
from typer.testing import CliRunner

import shakerproc
from shakerproc.cli import build_app, messages
from shakerproc.data import recording_of_arrays
from shakerproc.model_files import read_model
from shakerproc.recordings import open_recording, write_tdms
from shakerproc.runs import process_test
from shakerproc.simulation import first_calls
from shakerproc.testlog import read_testlog
from shakerproc.workflows import draft
from shakerproc.workflows.draft import write_example

SCRIPT = Path(__file__).resolve().parents[2] / "sample_data" / "make_example.py"
PLAY = 5e-5  # what the script simulates [m]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign") / "new"
    done = CliRunner().invoke(build_app(), ["init", str(folder)])
    assert done.exit_code == 0, done.output
    assert "shakerproc diagnose" in done.stdout
    return folder


@pytest.mark.slow
def test_init_leaves_a_log_and_a_model_that_are_read(campaign):
    log = read_testlog(campaign / "testlog.yaml", strict=True)
    model = read_model(campaign / "model.yaml")
    assert [test.hold_out for test in log.tests] == [False, False, False, True]
    assert {element.effect.kind for element in model.elements} == {"spring", "damper"}
    for name in ("testlog.yaml", "model.yaml"):
        assert (campaign / name).read_text(encoding="utf-8").count("#") >= 5


@pytest.mark.slow
def test_the_play_of_the_example_shows_in_its_level(campaign):
    log = read_testlog(campaign / "testlog.yaml")
    quiet, loud = process_test(log, log.tests[0]), process_test(log, log.tests[2])
    peaks = [run.averages.psd_peaks[2][0].peak.frequency for run in (quiet, loud)]
    assert peaks[1] > 1.05 * peaks[0]
    assert quiet.flags == ()
    assert loud.averages.measured_level.value == pytest.approx(log.tests[2].level, rel=0.1)


@pytest.mark.slow
def test_the_recordings_of_the_example_are_those_of_the_script(campaign):
    script = runpy.run_path(str(SCRIPT))
    test = script["TESTS"][0]
    made = script["recorded"](test).samples()
    with open_recording(campaign / "recordings" / "test_1.tdms") as shipped:
        assert_allclose(shipped.samples(), made, atol=1e-6 * np.abs(made).max())


def test_init_writes_into_no_folder_that_holds_something(tmp_path):
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    done = CliRunner().invoke(build_app(), ["init", str(tmp_path)])
    assert done.exit_code != 0
    assert "not empty" in str(done.exception)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.skipif(
    not Path(shakerproc.__file__).is_relative_to(Path(__file__).parents[2] / "src"),
    reason="the program is installed, and no checkout",
)
def test_the_sample_data_are_found_beside_the_checkout():
    assert import_module("shakerproc.cli.commands.demo").sample_log() is not None


def write_short_example(folder):
    written = write_example(folder)
    for path in (folder / "recordings").iterdir():
        with open_recording(path) as whole:
            samples = whole.samples()[:, : round(4.5 * whole.sample_rate)]
            part = recording_of_arrays(whole.run, whole.channels, samples, whole.sample_rate)
        write_tdms(path, part)
    return written


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_demo_finds_the_hidden_gap_and_the_error_falls(tmp_path, monkeypatch):
    seek_few(monkeypatch, {"gap", "cubic_stiffness"})
    monkeypatch.setattr(draft, "write_example", write_short_example)
    called = re.findall(r"first\.(\w+)\(", "".join(messages._AHEAD))
    assert len(called) >= len(messages._AHEAD)
    assert all(hasattr(first_calls, name) for name in called)  # they are compiled here already
    monkeypatch.setattr(messages, "_AHEAD", ("pass",) * len(messages._AHEAD))
    module = import_module("shakerproc.cli.commands.demo")  # the name is the function's too
    monkeypatch.setattr(module, "sample_log", lambda: None)
    target = tmp_path / "demo.json"
    options = ["demo", str(tmp_path / "out"), "--no-figures", "--json", str(target)]
    done = CliRunner().invoke(build_app(), options)
    assert done.exit_code == 0, done.output
    loop = json.loads(target.read_text(encoding="utf-8"))["loop"]
    (effect,) = loop["diagnosis"]["effects"]
    assert effect["kind"] == "gap"
    assert effect["parameters"]["clearance"]["value"] == pytest.approx(PLAY, rel=0.03)
    assert loop["held_out_after"] < 0.1 * loop["held_out_before"]
    last = done.stdout.strip().splitlines()
    assert last[-1].startswith(
        "The model left out a gap between base and coupon: clearance 0.0"
    )
    assert "mm in total; the log says 0.10 mm)" in last[-1]
    report = tmp_path / "out" / "hidden_gap" / "results" / "report.html"
    assert last[-2] == f"report: {report}"
    page = report.read_text(encoding="utf-8")
    for words in (
        "Where the model fails",
        "What is missing",
        "Errors of the models that were tried",
        "with gap",
    ):
        assert words in page
