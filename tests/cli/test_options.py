"""Options that make no sense are refused before any work: status 2 and one line."""

import dataclasses
import json
from typing import get_args, get_type_hints

import pytest
import typer
from tests.in_process import run
from tests.small_campaign import write_campaign
from typer.testing import CliRunner

from shakerproc.cli import options
from shakerproc.cli.commands import COMMANDS
from shakerproc.documents import kind_of_file
from shakerproc.workflows.processing_options import Options

MODEL = """model: 1
title: coupon
masses: {coupon: 28.6 g}
elements:
  - {kind: spring, between: [base, coupon], stiffness: 1.5e5 N/m}
  - {kind: damper, between: [base, coupon], damping: 2.6 N s/m}
excitation: {base: acceleration}
sensors: {ch3: {at: coupon, measures: acceleration}}
"""
CHECKED = ("process", "batch", "convert", "inspect", "compare", "check", "plan", "init")
MAY_BE_ZERO = {"--crop-hold-s", "--skip-s", "--overlap"}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A log, a model and a recording; what each command needs beside its options."""
    folder = tmp_path_factory.mktemp("options")
    log = write_campaign(folder, 1)
    (folder / "model.yaml").write_text(MODEL)
    (folder / "table.csv").write_text("test,peak_frequency_hz\n1,300.0\n")
    recording = folder / "recordings" / "test_1.tdms"
    model, table, out = folder / "model.yaml", folder / "table.csv", folder / "out"
    return {
        "process": (recording, "--no-figures", "--crop-threshold", "0.2 g", "--out", out),
        "batch": (log, "--no-figures", "--out", out),
        "convert": (recording, folder / "new.csv"),
        "inspect": (recording,),
        "compare": (model, log, "--out", out),
        "check": (table, "--against", table),
        "plan": (log, "--out", out),
        "init": (folder / "begun",),
        "add": ("gap", model, log, "-o", folder / "new.yaml"),
        "diagnose": (model, log, "--out", out),
        "simulate": (model, log, "--out", out),
        "log": log,
        "model": model,
        "recording": recording,
        "out": out,
    }


def numeric_options():
    """Every option of the commands that takes a number, with what is wrong for it."""
    for command in CHECKED:
        hints = get_type_hints(COMMANDS[command], include_extras=True)
        for name, hint in hints.items():
            value, *more = get_args(hint) or (hint,)
            kind = next((k for k in (float, int) if k in {value, *get_args(value)}), None)
            if kind is None:
                continue
            declared = [text for text in more[0].param_decls or () if "--" in text]
            option = declared[0] if declared else f"--{name.replace('_', '-')}"
            wrong = ["-1", "x", ""]
            wrong += ["nan", "inf", "-inf"] if kind is float else ["1.5", "1e99"]
            wrong += [] if option in MAY_BE_ZERO else ["0"]
            yield from ((command, option, value) for value in wrong)


def refused(capsys, *words):
    """What the command line says of words that it refuses."""
    assert run(*words) == 2, words
    told = capsys.readouterr()
    assert told.out == ""
    lines = told.err.splitlines()
    assert len(lines) == 1, told.err
    assert lines[0].startswith("error: ")
    return lines[0]


@pytest.mark.parametrize(("command", "option", "value"), list(numeric_options()))
def test_a_number_that_makes_no_sense_is_refused(files, capsys, command, option, value):
    assert option in refused(capsys, command, *files[command], option, value)
    assert not files["out"].exists()


PROCESS = [
    (["--window", "kaiser"], "there are rectangular, hann, hamming"),
    (["--detrend", "linear"], "none, mean, segment mean"),
    (["--excitation", "hum"], "sine sweep, random, sine"),
    (["--export", "xls"], "shakerproc writes mat"),
    (["--level", "0.02 g2/Hz"], "write g^2/Hz"),
    (["--level", "0.5"], "the unit is missing"),
    (["--level", "-1 g"], "more than 0"),
    (["--level", "1 s"], "such as 0.5 g"),
    (["--excitation", "random", "--level", "1 g"], "as a density, such as 0.0002 g^2/Hz"),
    (["--excitation", "sine", "--level", "0.02 g^2/Hz"], "as an amplitude"),
    (["--from-hz", "1000", "--to-hz", "20"], "from 1000 to 20 Hz does not rise"),
    (["--from-hz", "20", "--to-hz", "20"], "does not rise"),
    (["--from-hz", "20"], "give --to-hz too"),
    (["--to-hz", "20"], "give --from-hz too"),
    (["--excitation", "sine", "--from-hz", "20", "--to-hz", "50"], "one frequency"),
    (["--crop-threshold", "nan g"], "--crop-threshold"),
    (["--crop-threshold", "0 g"], "more than 0"),
    (["--no-crop"], "--no-crop: contradicts --crop-threshold"),
    (["--segment", "512", "--overlap", "512"], "512 samples do not fit a segment of 512"),
    (["--test", "1"], "goes with --log"),
    (["--unit", "furlong"], "--unit"),
    (["--bad-rows", "guess"], "refuse or skip"),
]


@pytest.mark.parametrize(("words", "told"), PROCESS)
def test_process_refuses_what_contradicts_itself(files, capsys, words, told):
    assert told in refused(capsys, "process", *files["process"], *words)


@pytest.mark.parametrize(
    "option", [["--skip-s", "1"], ["--crop-hold-s", "0"], ["--crop-absolute"]]
)
def test_no_crop_contradicts_every_option_of_the_crop(files, capsys, option):
    words = ("process", files["recording"], "--no-crop", *option, "--out", files["out"])
    assert f"contradicts {option[0]}" in refused(capsys, *words)


@pytest.mark.parametrize(
    ("crop", "told"),
    [("none", "does not crop"), ("{from: 1 s, to: 2 s}", "crops from one time to another")],
)
def test_options_of_a_threshold_need_one(files, capsys, crop, told):
    text = files["log"].read_text()
    log = files["log"].with_name(f"crop_{len(crop)}.yaml")
    log.write_text(text.replace("{channel: control 2, threshold: 0.2 g}", crop))
    words = ("process", files["recording"], "--log", log, "--skip-s", "1")
    said = refused(capsys, *words, "--out", files["out"])
    assert f"the log {told}; give --crop-threshold too" in said


OTHERS = [
    ("batch", ["--trend", "moon"], "no column 'moon' in the log"),
    ("batch", ["--trend", "joint", "--by", "moon"], "--by: no column 'moon'"),
    ("batch", ["--by", "joint"], "goes with --trend"),
    ("batch", ["--workers", "2", "--scheduler", "tcp://x:1"], "contradicts --scheduler"),
    ("batch", ["--window", "kaiser"], "there are rectangular"),
    ("check", ["--tolerance", "nan %"], "a share such as 2 %"),
    ("check", ["--tolerance", "-1 %"], "a share such as 2 %"),
    ("check", ["--tolerance", "2"], "a share such as 2 %"),
    ("check", ["--tolerance", "1 mm"], "--tolerance"),
    ("check", ["--columns", ","], "name a column"),
    ("plan", ["--clearance", "real"], "actual, nominal"),
    ("plan", ["--joint", "base,coupon"], "needs --model"),
    ("plan", ["--temperature", "-40 degC"], "go together"),
    ("plan", ["--rehearse"], "needs --model"),
    ("init", ["--sample-rate-hz", "100"], "goes with --recordings"),
    ("add", ["--between", "moon,mars"], "has no place 'moon'; there are base, coupon"),
    ("add", ["--between", "base"], "two places such as base,coupon"),
    ("add", ["--between", "base,base"], "two places such as base,coupon"),
]


@pytest.mark.parametrize(("command", "words", "told"), OTHERS)
def test_other_commands_refuse_what_they_do_not_know(files, capsys, command, words, told):
    assert told in refused(capsys, command, *files[command], *words)


@pytest.mark.parametrize("typed", ["gapp", "gpa", "Gap"])
def test_an_unknown_effect_is_refused_with_the_one_that_was_meant(files, capsys, typed):
    words = ("add", typed, *files["add"][1:])
    assert f"no effect '{typed}'; did you mean gap?" in refused(capsys, *words)


@pytest.mark.parametrize("command", ["compare", "diagnose", "add", "simulate"])
def test_a_model_and_a_log_in_the_wrong_order_are_told_apart(files, capsys, command):
    first = ("gap",) if command == "add" else ()
    last = ("-o", files["out"]) if command == "add" else ()
    words = (command, *first, files["log"], files["model"], *last)
    assert "the first file is a test log, the second a model: swap them" in refused(
        capsys, *words
    )
    words = (command, *first, files["model"], files["model"], *last)
    assert "is a model, not a test log" in refused(capsys, *words)


def test_a_model_is_no_log_and_a_log_no_model(files, capsys):
    assert kind_of_file(files["model"]) == "a model"
    for words, told in (
        (("batch", files["model"]), "expected a test log, and this is a model"),
        (
            ("plan", files["log"], "--model", files["log"]),
            "expected a model, and this is a test",
        ),
    ):
        assert run(*words) == 1
        assert told in capsys.readouterr().err


def test_an_option_of_zero_overrules_the_log(files, tmp_path):
    text = files["log"].read_text()
    log = files["log"].with_name("skip.yaml")
    log.write_text(text.replace("threshold: 0.2 g}", "threshold: 0.2 g, skip: 3 s}"))
    words = ("process", files["recording"], "--log", log, "--no-figures")
    starts = []
    for number, more in enumerate(([], ["--skip-s", "0"])):
        summary = tmp_path / f"{number}.json"
        assert run(*words, *more, "--out", tmp_path / str(number), "--json", summary) == 0
        starts.append(float(summary.read_text().split('"crop_s": [')[1].split(",")[0]))
    assert starts[0] >= 3.0
    assert starts[1] < 1.0


def test_one_end_of_the_band_leaves_a_sweep_down_one(files, tmp_path):
    text = files["log"].read_text()
    log = files["log"].with_name("down.yaml")
    log.write_text(
        text.replace(
            "excitation: random, level: 0.0005 g^2/Hz", "excitation: sine sweep"
        ).replace("from: 5 Hz, to: 800 Hz", "from: 800 Hz, to: 5 Hz, rate: 60 oct/min")
    )
    summary = tmp_path / "summary.json"
    words = ("process", files["recording"], "--log", log, "--no-figures", "--from-hz", "50")
    assert run(*words, "--out", tmp_path / "o", "--json", summary) == 0
    assert json.loads(summary.read_text())["spectrum"]["band_hz"] == [50.0, 800.0]


def test_every_option_of_the_api_on_a_test_is_one_of_the_command_line():
    fields = {field.name for field in dataclasses.fields(options.ProcessingOptions)}
    assert fields == set(Options.__annotations__)


def test_a_group_of_options_reaches_the_command_as_one_value():
    taken = []

    def command(name: str, *, times: options.TimeOptions) -> None:
        taken.append((name, times))

    run_grouped = options.grouped(command)
    app = typer.Typer()
    app.command()(run_grouped)
    done = CliRunner().invoke(app, ["a", "--sample-rate-hz", "512", "--ignore-starts"])
    assert done.exit_code == 0, done.output
    assert taken == [("a", options.TimeOptions(sample_rate_hz=512.0, ignore_starts=True))]
