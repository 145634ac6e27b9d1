"""The functions of `import shakerproc`, as a notebook uses them."""

import json
import pkgutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from nptdms import TdmsFile
from pandas import DataFrame
from tests.comparison.small_campaigns import campaign, drive, written
from tests.in_process import run

import shakerproc as sp
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Spring

SAMPLE = Path(__file__).parents[2] / "sample_data"
RECORDING = SAMPLE / "recordings" / "Test_1" / "Acceleration.tdms"
G = 9.80665


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    drives = (drive(level=3.0), drive(level=5.0, number=2))
    folder = tmp_path_factory.mktemp("campaign")
    return written(campaign(drives=drives, seconds=2.0), folder)


@pytest.fixture(scope="module")
def given(files):
    log, model = files
    return sp.read_model(model), sp.read_log(log)


@pytest.fixture
def command(capsys):
    """Run a command; return its exit status and what it printed."""

    def told(*words):
        capsys.readouterr()
        return run(*words), *capsys.readouterr()

    return told


def everything_below(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_the_import_alone_loads_nothing_slow():
    code = (
        "import sys, shakerproc; "
        "print([n for n in ('numpy', 'pandas', 'scipy', 'matplotlib') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert done.stdout.strip() == b"[]"


def test_reading_leaves_nothing_in_the_log_of_a_program_that_uses_it():
    code = (
        "import logging, sys, shakerproc as sp; logging.basicConfig(level=logging.INFO); "
        "sp.read_log(sys.argv[1]); sp.read_model(sys.argv[2])"
    )
    files = (SAMPLE / "testlog.yaml", SAMPLE / "model.yaml")
    done = subprocess.run([sys.executable, "-c", code, *files], capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")


def test_no_room_has_the_name_of_a_function():
    rooms = {module.name for module in pkgutil.iter_modules(sp.__path__)}
    assert not rooms & set(sp.API)
    for name in sp.API:
        assert callable(getattr(sp, name))
        assert callable(getattr(sp, name))
        assert name in dir(sp)
    with pytest.raises(AttributeError, match="no attribute 'unheard_of'"):
        _ = sp.unheard_of


def test_a_log_and_a_model_show_themselves_in_a_line():
    log, model = sp.read_log(SAMPLE / "testlog.yaml"), sp.read_model(SAMPLE / "model.yaml")
    assert repr(log) == (
        f"Test log {SAMPLE / 'testlog.yaml'}: Simulated coupons on radial and slot joints; "
        "15 tests, 1 of them discarded"
    )
    assert repr(model).endswith(
        "; spring between base and coupon, damper between base and coupon"
    )


def test_a_recording_is_what_another_reader_reads():
    recording = sp.open_recording(str(RECORDING))
    channels = TdmsFile.read(RECORDING).groups()[0].channels()
    table = recording.to_pandas(0.5, 1.0)
    first = round(0.5 * recording.sample_rate)
    for channel in channels:
        expected = channel[first : first + len(table)]
        np.testing.assert_allclose(table[f"{channel.name}_g"], expected, rtol=1e-12)
    assert table["time_s"].iloc[0] == pytest.approx(0.5, abs=1e-4)
    assert isinstance(sp.open_recording(RECORDING).plot(), Figure)
    assert "Acceleration.tdms" in recording._repr_html_()


def test_a_run_has_the_numbers_of_the_command(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = sp.process(sp.open_recording(RECORDING), excitation="random", segment=2048)
    assert not everything_below(tmp_path)
    words = ["process", RECORDING, "--excitation", "random", "--segment", "2048"]
    assert command(*words, "--no-figures", "--out", tmp_path / "out")[0] == 0
    text = (tmp_path / "out" / "spectra.csv").read_text(encoding="utf-8")
    assert made.to_pandas().columns.tolist() == text.splitlines()[0].split(",")
    again = sp.process(str(RECORDING), excitation="random", segment=2048, out=tmp_path / "out")
    assert (tmp_path / "out" / "psd.png").exists()
    assert DataFrame.equals(again.to_pandas(), made.to_pandas())
    assert isinstance(made.plot(), Figure)
    assert isinstance(made.plot("time"), Figure)
    assert "rms" in made._repr_html_()


def test_a_test_of_a_log_is_processed_as_the_log_says():
    made = sp.process(sp.read_log(SAMPLE / "testlog.yaml").find(1))
    assert [c.name for c in made.result.channels] == ["control 1", "control 2", "ch3", "ch4"]
    assert set(made.peaks["test"]) == {"1"}


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"from_hz": 5.0}, ["--from-hz", "5"]),
        ({"excitation": "tickling"}, ["--excitation", "tickling"]),
        ({"overlap": 4096}, ["--overlap", "4096"]),
        ({"no_crop": True, "skip_s": 1.0}, ["--no-crop", "--skip-s", "1"]),
        ({"unit": "furlong"}, ["--unit", "furlong"]),
        ({"window": "hamster"}, ["--window", "hamster"]),
    ],
)
def test_a_wrong_option_is_told_in_the_sentence_of_the_command(
    command, options, words, tmp_path
):
    with pytest.raises(sp.ArgumentError) as told:
        sp.process(RECORDING, **options)
    status, _, err = command("process", RECORDING, *words, "--out", tmp_path / "out")
    assert status == 2
    plain = "".join(c for c in err if c.isalnum())
    assert "".join(c for c in told.value.says if c.isalnum()) in plain


def test_unusable_input_is_told_in_the_sentence_of_the_command(command, tmp_path, capsys):
    broken = tmp_path / "broken.tdms"
    broken.write_bytes(b"not a recording")
    bad_log = tmp_path / "log.yaml"
    bad_log.write_text(
        "testlog: 1\ntitle: x\ntests: [{id: 1, level: 3 kg}]\n", encoding="utf-8"
    )
    for call, words in (
        (lambda: sp.process(broken), ("process", broken)),
        (lambda: sp.read_log(bad_log), ("batch", bad_log)),
    ):
        with pytest.raises(sp.ShakerprocError) as told:
            call()
        assert capsys.readouterr() == ("", "")
        status, _, err = command(*words, "--out", tmp_path / "out")
        assert status == 1
        assert f"error: {told.value}" in err


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda _m, _l: sp.read_log(3), "path: expected the path of a test log, got 3"),
        (lambda _m, _l: sp.read_model("no.yaml"), "path: no file no.yaml"),
        (lambda _m, _l: sp.open_recording(SAMPLE), "path: .* is a folder"),
        (lambda m, _l: sp.compare(m, "log.yaml"), r"log: expected .* read_log\(path\) .*'log"),
        (lambda _m, log: sp.compare("m.yaml", log), r"model: expected .* read_model\(path\)"),
        (lambda m, log: sp.compare(log, m), "model: expected a model, .* an object of"),
        (lambda _m, log: sp.process(log), "recording: expected what open_recording"),
        (lambda _m, _l: sp.process(RECORDING, levle="1 g"), "levle: no such .* mean level"),
        (lambda _m, _l: sp.process(RECORDING, from_hz="5 Hz"), "from_hz: expected a number"),
        (lambda _m, _l: sp.process(RECORDING, controls="none"), "controls: expected a list"),
        (lambda _m, _l: sp.batch("log.yaml"), r"log: expected a test log, as read_log\(path\)"),
        (lambda _m, log: sp.batch(log, 3), "out: expected the path of a folder, got 3"),
        (lambda _m, log: sp.batch(log, by=["level"]), "by: goes with --trend"),
        (lambda _m, log: sp.diagnose("model.yaml", log), "model: expected a model"),
        (lambda m, log: sp.add("gapp", m, log), "effect: no effect 'gapp'; did you mean gap"),
        (lambda m, log: sp.add(m, "gap", log), "model: expected a model"),
        (
            lambda m, log: sp.add("gap", m, log, between=["rim"]),
            "between: .* has no place 'rim'",
        ),
        (lambda m, log: sp.add("gap", m, log, start={"clearance": "3 kg"}), "start: clearance"),
        (lambda m, _l: sp.simulate(m, "sine", 1e3), "excitation: expected an array"),
        (lambda m, _l: sp.simulate(m, [1.0, np.nan], 1e3), "excitation: sample 1 is nan"),
        (lambda m, _l: sp.simulate(m, [1.0, 2.0], "1 kHz"), "sample_rate: expected a number"),
    ],
)
def test_what_is_of_another_kind_is_told_what_was_expected(given, call, message):
    with pytest.raises(sp.ArgumentError, match=message):
        call(*given)


def test_a_comparison_has_the_errors_of_the_command(command, files, given, tmp_path):
    log, model = files
    found = sp.compare(*given)
    again = sp.compare(*given)
    assert found.error == again.error
    words = ["compare", model, log, "--no-figures", "--json", "-", "--out", tmp_path / "out"]
    status, out, _ = command(*words)
    assert status == 0
    assert found.as_json()["errors"] == json.loads(out)["errors"]
    assert found.to_pandas()["test"].tolist() == ["1", "2"]
    assert isinstance(found.plot(), Figure)
    assert isinstance(found.plot("error_in_time"), Figure)
    with pytest.raises(sp.ArgumentError, match="no figure 'x'; there are response_"):
        found.plot("x")
    assert found.sentence.split(".")[0] in found._repr_html_()
    assert found.sentence in repr(found)
    assert "<" not in repr(found)


def test_calls_in_threads_are_those_one_after_the_other(given):
    def one(_):
        found = sp.compare(*given)
        found.plot().savefig("/dev/null", format="png")
        return found.error, sp.process(RECORDING).to_pandas()

    alone = one(0)
    with ThreadPoolExecutor(4) as pool:
        for error, spectra in pool.map(one, range(4)):
            assert error == alone[0]
            assert DataFrame.equals(spectra, alone[1])


@pytest.mark.usefixtures("processes")
def test_a_batch_in_memory_is_that_of_the_folder_and_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log = sp.read_log(SAMPLE / "testlog.yaml")
    few = replace(log, tests=(*log.tests[:2], log.find(6)))
    found = sp.batch(few)
    assert not everything_below(tmp_path)
    filed = sp.batch(few, tmp_path / "out", figures=False, workers=1)
    assert (filed.folder / "report.html").exists()
    assert found.runs == filed.runs
    assert DataFrame.equals(found.peaks, filed.peaks)
    assert found.to_pandas()["status"].tolist() == ["done", "done", "discarded"]
    assert isinstance(found.plot(), Figure)
    assert found.sentence in found._repr_html_()
    with pytest.raises(sp.ArgumentError, match="no trend 'x'; there are"):
        found.plot("x")
    with pytest.raises(sp.ShakerprocError, match="weather"):
        _ = sp.batch(few, trend=["weather"]).trends


def test_a_test_that_cannot_be_used_is_in_the_batch_with_the_reason(tmp_path):
    log = sp.read_log(SAMPLE / "testlog.yaml")
    first = log.find(1)
    broken = tmp_path / "broken.tdms"
    broken.write_bytes(b"not a recording")
    found = sp.batch(replace(log, tests=(replace(first, recording=broken), log.find(2))))
    assert [run.status for run in found.runs] == ["failed", "done"]
    assert "broken.tdms" in found.runs[0].error
    assert "test 1 failed" in found._repr_html_()


def test_a_response_is_that_of_a_mass_on_a_spring():
    """Oracle: the closed form of a mass on a spring, pushed by a force of 1 N from rest."""
    mass, frequency, rate = 0.4, 20.0, 5000.0
    stiffness = mass * (2.0 * np.pi * frequency) ** 2
    joint = (Element(Spring(stiffness), ("base", "coupon")),)
    shaken = Model(
        "coupon", {"coupon": mass}, joint, Excitation("force", "coupon"),
        {"ch3": Sensor("coupon", "relative displacement")},
    )  # fmt: skip
    found = sp.simulate(shaken, np.ones_like, rate, duration=0.2)
    table = sp.simulate(shaken, np.ones_like, rate, duration=0.2).to_pandas()
    expected = (1.0 - np.cos(2.0 * np.pi * frequency * found.found.time)) / stiffness
    np.testing.assert_allclose(table["ch3_m"], expected, atol=1e-9 / stiffness)
    assert isinstance(found.plot(), Figure)
    assert "switchings" in found._repr_html_()


def test_the_effects_are_those_of_the_command(command):
    listed = sp.effects()
    _, out, _ = command("effects", "--json", "-")
    assert json.loads(out)["effects"] == json.loads(json.dumps(dict(sp.effects())))
    assert set(listed.to_pandas()["is"]) == {"effect", "fault"}
    assert "clearance [m]" in listed._repr_html_()
    assert isinstance(listed.plot("gap"), Figure)
    assert listed.plot("gap")._repr_png_().startswith(b"\x89PNG")


def test_a_place_that_cannot_be_written_is_told_before_the_work(tmp_path):
    taken = tmp_path / "taken"
    taken.write_bytes(b"")
    with pytest.raises(sp.ShakerprocError, match="taken is no folder"):
        sp.process(RECORDING, out=taken)
    with pytest.raises(sp.ShakerprocError, match="taken is no folder"):
        sp.batch(sp.read_log(SAMPLE / "testlog.yaml"), taken / "out")
    sp.process(RECORDING, out=tmp_path / "one", figures=False)
    with pytest.raises(sp.ShakerprocError, match="holds"):
        sp.batch(sp.read_log(SAMPLE / "testlog.yaml"), tmp_path / "one")
