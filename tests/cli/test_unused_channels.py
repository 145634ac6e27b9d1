"""No channel is lost in silence: what is not used is named by every command that opens it."""

import json

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsWriter
from tests.in_process import run
from tests.small_campaign import RATE, samples, write_campaign

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.diagnosis.result import BeforeAfter, Diagnosis, Errors, Where
from shakerproc.recordings import write_tdms
from shakerproc.workflows import diagnosis

MODEL = """\
model: 1
title: one mass
masses: {coupon: 1 kg}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 5e6 N/m}
  - {kind: damper, between: [base, coupon], damping: 130 N s/m}
excitation: {base: acceleration}
sensors:
  ch3: {at: coupon, measures: acceleration}
"""


def write(path, *channels):
    """Write channels given as "name:unit"; their samples are those of the small campaign."""
    pairs = [text.partition(":")[::2] for text in channels]
    rows = np.tile(samples(250.0), (3, 1))[: len(pairs)]
    made = [Channel(name, "?", name, unit) for name, unit in pairs]
    write_tdms(path, recording_of_arrays(path.stem, made, rows, RATE))
    return path


def process(path, *options):
    common = ("--crop-threshold", "0.1 g", "--no-figures", "--out", path.parent / "o")
    return run("process", path, *common, *options)


def summary(path):
    return json.loads((path.parent / "o" / "summary.json").read_text(encoding="utf-8"))


def test_without_a_log_eight_accelerations_are_two_controls_and_six_responses(tmp_path):
    path = write(tmp_path / "r.tdms", *(f"a{i}:g" for i in range(1, 9)))
    assert process(path) == 0
    roles = {c["name"]: c["role"] for c in summary(path)["channels"]}
    assert list(roles) == ["a1", "a2", *(f"ch{i}" for i in range(3, 9))]
    assert list(roles.values()) == ["control"] * 2 + ["response"] * 6
    assert summary(path)["unused"] == []


def test_without_a_log_what_is_no_motion_is_named_on_terminal_and_in_the_summary(
    tmp_path, capsys
):
    path = write(tmp_path / "r.tdms", "a:g", "b:g", "c:g", "T:Deg C", "tacho:V")
    assert process(path) == 0
    why = "no role fits its unit; a log can give it one"
    assert f"note: not used: T, tacho ({why})" in capsys.readouterr().err
    assert summary(path)["unused"] == [{"name": n, "why": why} for n in ("T", "tacho")]


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Two tests whose files hold two channels more than the log uses."""
    folder = tmp_path_factory.mktemp("campaign")
    log = write_campaign(folder, 2)
    names = ["control 1:g", "control 2:g", "response 1:g", "response 2:g", "spare:g", "T:Deg C"]
    for number in (1, 2):
        write(folder / "recordings" / f"test_{number}.tdms", *names)
    text = log.read_text(encoding="utf-8").replace("at: rim}", "at: rim}\n  T: {role: ignore}")
    log.write_text(text, encoding="utf-8")
    (folder / "model.yaml").write_text(MODEL, encoding="utf-8")
    return folder


SPARE = "not used: spare (not named in the log)"
IGNORED = "not used: T (role: ignore in the log)"


def test_a_batch_names_channels_that_the_log_leaves_out_once_for_all_tests(campaign, capsys):
    assert run("batch", campaign / "testlog.yaml", "--no-figures", "--workers", "1") == 0
    told = capsys.readouterr().err.splitlines()
    assert told.count(f"every test: {SPARE}") == 1
    assert told.count(f"every test: {IGNORED}") == 1
    folder = campaign / "results"
    found = json.loads((folder / "runs" / "test_1" / "summary.json").read_text("utf-8"))
    assert [c["name"] for c in found["unused"]] == ["spare", "T"]
    assert (folder / "report.html").read_text("utf-8").count(f"N{SPARE[1:]}") == 2
    assert "unused" in json.loads((folder / "report.json").read_text("utf-8"))["runs"][0]


def test_a_batch_for_a_channel_that_is_not_there_says_what_is(campaign, tmp_path, capsys):
    words = ("--out", tmp_path / "o", "--channel", "ch9")
    assert run("batch", campaign / "testlog.yaml", *words) == 2
    told = " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert "no channel 'ch9'. The tests have control 1, control 2, ch3, ch4" in told
    assert not (tmp_path / "o").exists()  # before any work


def test_a_batch_whose_files_alone_know_the_channels_says_so_after_them(tmp_path, capsys):
    log = write_campaign(tmp_path, 1)
    head, _, rest = log.read_text(encoding="utf-8").partition("channels:")
    log.write_text(head + "processing:" + rest.partition("processing:")[2], encoding="utf-8")
    words = ("--no-figures", "--workers", "1")
    assert run("batch", log, *words, "--channel", "ch9") == 1
    assert "no channel 'ch9'" in capsys.readouterr().err
    assert run("batch", log, *words, "--channel", "response 2") == 0
    assert "peak frequency of response 2" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["compare", "diagnose"])
def test_a_model_names_channels_that_it_does_not_need(campaign, command, capsys, monkeypatch):
    monkeypatch.chdir(campaign)
    if command == "diagnose":
        _judge_nothing(monkeypatch)
    status = run(command, "model.yaml", "testlog.yaml", "--out", command)
    assert status == 0
    told = capsys.readouterr().err
    assert "every test: not used: ch4 (neither drives the model nor is a sensor of it)" in told
    assert f"every test: {SPARE}" in told
    assert f"every test: {IGNORED}" in told
    page = (campaign / command / "report.html").read_text("utf-8")
    assert f"Every test: {SPARE}." in page


def _judge_nothing(monkeypatch):
    """Let a diagnosis end at once: what is told of channels does not depend on it."""
    none = Errors(BeforeAfter(1.0, 1.0), BeforeAfter(1.0, 1.0), 1.0)
    found = Diagnosis("cannot tell", "Nothing was tried.", (), (), none, (), Where(), ())
    monkeypatch.setattr(diagnosis, "diagnose_tests", lambda *_, **__: found)


def test_inspect_names_what_holds_no_numbers(tmp_path, capsys):
    table = "time [s],a [g],b [g],remark\n" + "".join(
        f"{i / 100},{i},{i},\n" for i in range(50)
    )
    path = tmp_path / "r.csv"
    path.write_text(table, encoding="utf-8")
    assert run("inspect", path) == 0
    assert "note: not used: remark (it holds no numbers)" in capsys.readouterr().out


def test_channels_of_another_group_are_named(tmp_path, capsys):
    path = tmp_path / "r.tdms"
    told = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
    with TdmsWriter(path) as file:
        for group, name in (("fast", "a"), ("fast", "b"), ("slow", "T")):
            file.write_segment([ChannelObject(group, name, samples(250.0)[2], told)])
    assert process(path, "--group", "fast") == 0
    assert "not used: slow/T (in another group)" in capsys.readouterr().err


def test_a_text_channel_in_front_does_not_shift_the_numbers_of_the_others(tmp_path):
    path = tmp_path / "r.tdms"
    told = {"wf_increment": 1.0 / RATE, "unit_string": "g"}
    with TdmsWriter(path) as file:
        rows = samples(250.0)
        file.write_segment([
            ChannelObject("g", "remarks", ["one", "two"]),
            *(ChannelObject("g", name, rows[i], told) for i, name in enumerate("abc")),
        ])
    assert process(path) == 0
    assert [c["name"] for c in summary(path)["channels"]] == ["a", "b", "ch3"]
    assert summary(path)["unused"] == [{"name": "remarks", "why": "it holds text"}]


HAMMER = """\
testlog: 1
recordings: .
channels:
  table: {role: control}
  tip: {role: response}
processing: {crop: none}
tests:
  - {id: 1, recording: shaken.npz, excitation: random, level: 1 g rms, from: 5 Hz, to: 400 Hz}
  - {id: 2, recording: struck.npz, excitation: random, level: 1 g rms, from: 5 Hz, to: 400 Hz,
     channels: {cell: {role: force}}}
"""


def test_one_log_holds_tests_of_other_channels_and_tells_what_each_goes_without(
    tmp_path, capsys
):
    rng = np.random.default_rng(1)
    for name, first in (("shaken", "table [m/s^2]"), ("struck", "cell [N]")):
        arrays = {first: rng.standard_normal(9000), "tip [m/s^2]": rng.standard_normal(9000)}
        np.savez(tmp_path / f"{name}.npz", **arrays, fs=1000.0)
    (tmp_path / "log.yaml").write_text(HAMMER, encoding="utf-8")
    words = ("--no-figures", "--workers", 1, "--out", tmp_path / "out")
    assert run("batch", tmp_path / "log.yaml", *words) == 0
    told = capsys.readouterr()
    assert "2 processed" in told.out
    lines = [x for x in told.err.splitlines() if "were left out: 'table'" in x]
    assert len(lines) == 1
    assert lines[0].startswith("test 2: ")


def test_a_slip_of_the_pen_is_no_channel_that_a_test_goes_without(tmp_path, capsys):
    np.savez(tmp_path / "shaken.npz", **{"tabel [m/s^2]": np.ones(99), "tip": np.ones(99)})
    (tmp_path / "log.yaml").write_text(HAMMER, encoding="utf-8")
    words = ("--log", tmp_path / "log.yaml", "--out", tmp_path / "out")
    assert run("process", tmp_path / "shaken.npz", *words) == 1
    assert "no channel 'table'; did you mean 'tabel'" in capsys.readouterr().err
