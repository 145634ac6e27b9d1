"""Where results go: into pipes and devices, never over them, and looked at before the work."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import pytest
from tests.in_process import run
from tests.small_campaign import write_campaign, write_recording

from shakerproc import files
from shakerproc.campaign.result_folder import check_result_folder
from shakerproc.cli import output
from shakerproc.errors import ShakerprocError

EFFECT = ("effects", "gap", "--json")
posix = pytest.mark.skipif(sys.platform == "win32", reason="POSIX pipes and devices")


def names_of(text):
    return set(json.loads(text)["effects"])


@posix
def test_json_to_stdout_by_another_name_is_stdout_and_stays_what_it_is(tmp_path):
    name = "/dev/stdout"
    with (tmp_path / "said").open("w", encoding="utf-8") as file:
        subprocess.run(
            [sys.executable, "-m", "shakerproc", *EFFECT, name], stdout=file, check=True
        )
        assert os.fstat(file.fileno()).st_nlink == 1
    assert names_of((tmp_path / "said").read_text(encoding="utf-8")) == {"gap"}


@posix
def test_json_goes_into_a_pipe(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    assert run(*EFFECT, pipe) == 0
    reader.join(timeout=10)
    assert names_of(got[0]) == {"gap"}
    assert pipe.is_fifo()


@posix
def test_json_goes_into_a_device_which_stays_one(tmp_path, capsys):
    assert run(*EFFECT, "/dev/null") == 0
    assert Path("/dev/null").is_char_device()
    if Path("/dev/full").exists():
        assert run(*EFFECT, "/dev/full") == 1
        assert "/dev/full: No space left on device" in capsys.readouterr().err


MEMORY = Path("/dev/shm")  # noqa: S108  a file system in memory


@pytest.mark.skipif(not os.access(MEMORY, os.W_OK), reason="no file system in memory")
def test_json_in_a_file_system_in_memory_is_replaced_like_any_other():
    with tempfile.TemporaryDirectory(dir=MEMORY) as folder:
        target = Path(folder) / "effects.json"
        for _ in range(2):
            assert run(*EFFECT, target) == 0
            assert names_of(target.read_text(encoding="utf-8")) == {"gap"}


@posix
def test_json_to_a_link_is_written_where_the_link_leads(tmp_path):
    (tmp_path / "link.json").symlink_to("real.json")
    assert run(*EFFECT, tmp_path / "link.json") == 0
    assert (tmp_path / "link.json").is_symlink()
    assert names_of((tmp_path / "real.json").read_text(encoding="utf-8")) == {"gap"}


def test_json_makes_no_folder_and_says_so_before_the_work(tmp_path, capsys):
    log = write_campaign(tmp_path, 1, seconds=2.0)
    for target, said in (
        (tmp_path / "none" / "x.json", "there is no folder"),
        (tmp_path, "this is a folder"),
    ):
        assert run("batch", log, "--out", tmp_path / "out", "--json", target) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert said in line
    assert not (tmp_path / "out").exists()
    assert not (tmp_path / "none").exists()


@posix
def test_json_to_a_closed_stdout_is_one_line():
    command = f"{sys.executable} -m shakerproc effects --json - >&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)  # noqa: S602
    assert done.returncode == 1
    assert done.stderr == "error: --json -: stdout is closed. Name a file instead.\n"
    command = f"{sys.executable} -m shakerproc effects gap >&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)  # noqa: S602
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("command", ["batch", "compare", "study"])
def test_a_folder_that_cannot_be_made_is_said_before_the_work(tmp_path, capsys, command):
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    (tmp_path / "x.yaml").write_text("no document", encoding="utf-8")
    given = [tmp_path / "x.yaml"] * (2 if command == "compare" else 1)
    assert run(command, *given, "--out", tmp_path / "file" / "out") == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("file is no folder. Choose another folder for results.")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


@posix
def test_a_table_is_written_into_a_pipe_but_a_container_is_refused_there(tmp_path):
    os.mkfifo(tmp_path / "pipe.parquet")
    with (
        pytest.raises(OSError, match="no regular file"),
        files.atomic_path(tmp_path / "pipe.parquet"),
    ):
        raise AssertionError
    assert (tmp_path / "pipe.parquet").is_fifo()


def processed(*arguments):
    return run("process", *arguments, "--no-figures")


def outputs(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def test_recordings_of_one_name_get_folders_of_their_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in (1, 2):
        write_recording(
            tmp_path / f"Test_{number}" / "Acceleration.tdms", 200.0 + 50 * number, seconds=2.0
        )
        path = Path(f"Test_{number}") / "Acceleration.tdms"
        assert processed(path, "--crop-threshold", "0.2 g") == 0
    monkeypatch.chdir(tmp_path / "Test_1")  # where the path alone does not say it
    assert processed("Acceleration.tdms", "--crop-threshold", "0.2 g") == 0
    (tmp_path / "Test_2" / "deeper").mkdir()
    monkeypatch.chdir(tmp_path / "Test_2" / "deeper")
    assert processed(Path("..") / "Acceleration.tdms", "--crop-threshold", "0.2 g") == 0
    found = {path.name for path in tmp_path.glob("**/*_results")}
    assert found == {"Test_1_Acceleration_results", "Test_2_Acceleration_results"}


def test_with_a_log_the_folder_is_called_after_the_test(tmp_path, monkeypatch):
    log = write_campaign(tmp_path, 1, seconds=2.0)
    monkeypatch.chdir(tmp_path)
    assert processed(tmp_path / "recordings" / "test_1.tdms", "--log", log) == 0
    assert (tmp_path / "test_1_results" / "summary.json").exists()


def test_a_folder_of_another_recording_is_refused_untouched(tmp_path, capsys):
    log, out = write_campaign(tmp_path, 2, seconds=2.0), tmp_path / "out"
    one, two = (tmp_path / "recordings" / f"test_{i}.tdms" for i in (1, 2))
    assert processed(one, "--log", log, "--out", out) == 0
    before = {p: p.read_bytes() for p in out.iterdir()}
    capsys.readouterr()
    assert processed(two, "--log", log, "--out", out) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "holds the results of another recording (SHA-256 " in line
    assert "choose another folder with --out" in line
    assert {p: p.read_bytes() for p in out.iterdir()} == before
    assert run("batch", log, "--out", out, "--no-figures") == 1
    assert "holds the results of `shakerproc process`" in capsys.readouterr().err
    (out / "manifest.json").unlink()  # as after an older shakerproc
    assert processed(one, "--log", log, "--out", out) == 1
    assert "peaks.csv, which shakerproc did not write" in capsys.readouterr().err


def test_the_tables_of_an_earlier_run_of_the_recording_do_not_stay(tmp_path):
    log, out = write_campaign(tmp_path, 1), tmp_path / "out"
    one = tmp_path / "recordings" / "test_1.tdms"
    assert processed(one, "--log", log, "--out", out, "--notch-hz", "50") == 0
    assert "notch.csv" in outputs(out)
    (out / "note.txt").write_text("mine", encoding="utf-8")
    shutil.copy(out / "notch.csv", out / "kept.csv")
    assert processed(one, "--log", log, "--out", out) == 0
    assert outputs(out) == {
        "kept.csv", "manifest.json", "note.txt", "peaks.csv", "spectra.csv", "statistics.csv",
        "summary.json",
    }  # fmt: skip


def test_a_batch_folder_takes_no_single_recording(tmp_path, capsys):
    log, out = write_campaign(tmp_path, 1, seconds=2.0), tmp_path / "out"
    out.mkdir()
    entry = {"status": "done", "key": "k", "recording_sha256": "a", "outputs": {}}
    written = {"schema": "shakerproc-manifest/2", "runs": {"test_1": entry}}
    (out / "manifest.json").write_text(json.dumps(written), encoding="utf-8")
    assert processed(tmp_path / "recordings" / "test_1.tdms", "--log", log, "--out", out) == 1
    assert "holds the results of `shakerproc batch`" in capsys.readouterr().err


@posix
@pytest.mark.parametrize("name", ["zero.uff", "zero.npz", "zero.tdms", "zero.csv", "zero.mat"])
def test_a_recording_without_end_is_refused_at_once(tmp_path, capsys, name):
    (tmp_path / name).symlink_to("/dev/zero")
    assert run("inspect", tmp_path / name) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "is a device, not a regular file" in line


@posix
@pytest.mark.parametrize("command", ["inspect", "process"])
def test_a_pipe_is_no_recording(tmp_path, capsys, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe.tdms")
    assert run(command, tmp_path / "pipe.tdms") == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "is a pipe, not a regular file" in line
    assert outputs(tmp_path) == {"pipe.tdms"}


def test_results_of_a_command_replace_those_of_its_earlier_run_and_nothing_else(tmp_path):
    out = tmp_path / "out"
    with output.results(out, "compare"):
        files.write_text(out / "errors.csv", "old")
        files.write_text(out / "test_4" / "motion.png", "old")
    (out / "note.txt").write_text("mine", encoding="utf-8")
    with output.results(out, "compare"):
        files.write_text(out / "errors.csv", "new")
    assert outputs(out) == {"errors.csv", "manifest.json", "note.txt"}
    assert (out / "errors.csv").read_text(encoding="utf-8") == "new"
    for command in ("diagnose", "batch", "process"):
        with pytest.raises(ShakerprocError, match="holds the results of `shakerproc compare`"):
            check_result_folder(out, command)


@pytest.mark.slow
@pytest.mark.usefixtures("processes")
def test_tables_and_trends_that_a_batch_no_longer_makes_do_not_stay(tmp_path, capsys):
    log, out = write_campaign(tmp_path, 3), tmp_path / "out"
    options = ("batch", log, "--out", out, "--no-figures", "--workers", "2")
    assert run(*options, "--trend", "specimen") == 0
    before = outputs(out / "trends")
    (out / "report.pdf").write_text("of the old page", encoding="utf-8")
    assert run(*options) == 0
    assert outputs(out / "trends") < before
    assert not (out / "report.pdf").exists()
    capsys.readouterr()
    (tmp_path / "model.yaml").write_text("model: 1", encoding="utf-8")
    assert run("compare", tmp_path / "model.yaml", log, "--out", out) == 1
    assert "holds the results of `shakerproc batch`" in capsys.readouterr().err


def test_json_replaces_json_but_no_recording_no_log_and_no_model(tmp_path, capsys):
    for name, begins in (("a.tdms", b"TDSm\x0e\x00"), ("log.yaml", b"testlog: 1\n")):
        (tmp_path / name).write_bytes(begins)
        assert run(*EFFECT, tmp_path / name) == 1
        assert "this file is there, and it is no JSON" in capsys.readouterr().err
        assert (tmp_path / name).read_bytes() == begins
    for name, begins in (("empty", b""), ("old.json", b'\n{"effects": {}}')):
        (tmp_path / name).write_bytes(begins)
        assert run(*EFFECT, tmp_path / name) == 0
        assert names_of((tmp_path / name).read_text(encoding="utf-8")) == {"gap"}
