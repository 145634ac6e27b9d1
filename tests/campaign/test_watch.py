"""`shakerproc watch`: each finished recording is processed once, none is lost."""

import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
from tests.campaign.watched import kill_and_compare, watch
from tests.in_process import run
from tests.small_campaign import write_campaign, write_recording

from shakerproc.campaign.jobs import Products
from shakerproc.errors import LogError, RecordingError
from shakerproc.recordings import Sampling
from shakerproc.testlog import read_testlog
from shakerproc.workflows.arguments import Machines
from shakerproc.workflows.campaign import TrendWish
from shakerproc.workflows.watching import (
    DraftedLog,
    FileStamp,
    GivenLog,
    Pace,
    Watch,
    WatchedLog,
    finished_files,
    looked,
    recordings_in,
)

QUICK = ("--settle", 0.2, "--every", 0.1, "--idle", 0.5, "--no-figures", "--workers", 1)


def test_a_file_is_finished_when_it_stands_still(tmp_path):
    path = tmp_path / "a.tdms"
    path.write_bytes(b"1")
    os.utime(path, ns=(1, 1))
    seen = looked({}, [path, tmp_path / "absent.tdms"], 10.0)
    assert finished_files(seen, 3.0, 12.9) == {}
    seen = looked(seen, [path], 12.0)
    assert list(finished_files(seen, 3.0, 13.0)) == [path]
    path.write_bytes(b"12")
    assert finished_files(looked(seen, [path], 13.0), 3.0, 15.9) == {}
    path.write_bytes(b"")  # opened by a recorder, not begun
    assert finished_files(looked(seen, [path], 20.0), 0.0, 99.0) == {}


def test_results_are_no_recordings(tmp_path):
    for name in ("day/a.tdms", "day/results/runs.csv", ".hidden/b.tdms", "c.TXT", "notes.md"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1", encoding="utf-8")
    (tmp_path / "day" / "results" / "manifest.json").write_text("{}", encoding="utf-8")
    found = [path.relative_to(tmp_path).as_posix() for path in recordings_in(tmp_path)]
    assert sorted(found) == ["c.TXT", "day/a.tdms"]


@pytest.mark.slow
def test_tests_are_run_as_they_come_and_again_when_they_change(tmp_path):
    log = write_campaign(tmp_path, 2)
    first, late = (tmp_path / "recordings" / f"test_{i}.tdms" for i in (1, 2))
    page = tmp_path / "results" / "report.html"
    late.rename(tmp_path / "kept")
    known, told, pages = read_testlog(log), [], []

    def logs(still):
        pages.append(page.read_text(encoding="utf-8") if page.exists() else "")
        if first in still and not late.exists() and "1 of 1" in pages[-1]:
            first.write_bytes(first.read_bytes()[:-15000])  # as where a recorder was stopped
            (tmp_path / "kept").rename(late)
        return known

    watched = Watch(
        tmp_path / "recordings",
        tmp_path / "results",
        logs,
        products=Products(figures=False),
        machines=Machines(1),
        wish=TrendWish(figures=False),
        tell=told.append,
    )
    watched.run(Pace(0.2, 0.1, 0.3))
    assert told[0] == "test 1 (test_1.tdms): done"
    again = (
        "test 1 (test_1.tdms) again: the recording changed: up to its last complete row: inc"
    )
    assert told[1].startswith(again)
    assert told[2:] == ["test 2 (test_2.tdms): done"]
    assert any("Waiting for the recordings of: 2." in text for text in pages)
    assert 'data-refresh="2"' in page.read_text("utf-8")
    assert watched.last()["counts"]["processed"] == 2
    assert "data-refresh" not in page.read_text("utf-8")
    assert 'http-equiv="refresh"' not in page.read_text("utf-8")


def test_a_recording_that_no_test_names_is_told_once(tmp_path):
    told = []
    given = GivenLog(
        WatchedLog(write_campaign(tmp_path, 1), told.append), tmp_path, told.append
    )
    still = dict.fromkeys(recordings_in(tmp_path))
    other = dict.fromkeys([tmp_path / "recordings" / "other.tdms"])
    for _ in range(2):
        given(still | other)
    assert told == [
        "recordings/other.tdms is in no test of testlog.yaml; add one to process it"
    ]


def test_each_new_recording_is_drafted_once_and_edits_are_kept(tmp_path):
    told, path = [], tmp_path / "testlog.yaml"
    for name, peak in (("run_1", 300.0), ("run_2", 250.0)):
        write_recording(tmp_path / f"{name}.tdms", peak, seconds=2.0)
        drafted = DraftedLog(
            tmp_path, Sampling(), told.append
        )  # as a watch that was started again
        log = drafted(dict.fromkeys(recordings_in(tmp_path), FileStamp(1, 1)))
        path.write_text(path.read_text("utf-8").replace("title: ", "title: my "), "utf-8")
    assert [str(test.id) for test in log.tests] == ["1", "2"]
    assert path.read_text("utf-8").count("my my") == 1
    path.write_text(path.read_text("utf-8") + "shaker: {}\n", "utf-8")
    write_recording(tmp_path / "run_3.tdms", 200.0, seconds=2.0)
    with pytest.raises(LogError, match=r"tests: is not there\. Move tests: to the end"):
        drafted(dict.fromkeys(recordings_in(tmp_path), FileStamp(1, 1)))


def test_a_folder_that_vanishes_is_told_in_one_line(tmp_path):
    folder = tmp_path / "in"
    folder.mkdir()

    def logs(_still):
        shutil.rmtree(folder)

    watched = Watch(
        folder,
        tmp_path / "out",
        logs,
        products=Products(),
        machines=Machines(1),
        wish=TrendWish(),
        tell=print,
    )
    with pytest.raises(RecordingError, match=r"the watched folder is gone.*call again"):
        watched.run(Pace(0.0, 0.01))
    assert watched.last() == {}


@pytest.mark.slow
def test_an_interrupt_ends_it_at_once_and_the_page_stands_still(tmp_path):
    write_campaign(tmp_path, 1)
    process = watch(tmp_path, "--log", tmp_path / "testlog.yaml")
    page, end = tmp_path / "results" / "report.html", time.monotonic() + 60.0
    while not page.exists() and time.monotonic() < end:
        time.sleep(0.05)
    assert "data-refresh" in page.read_text(encoding="utf-8")
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130, errors
    assert errors.splitlines()[-1].startswith("stopped by the user; what is done stands")
    assert "data-refresh" not in page.read_text(encoding="utf-8")


@pytest.mark.slow
def test_no_port_is_opened(tmp_path):
    """Python itself tells of every socket that is bound or connected, also in a thread."""
    write_campaign(tmp_path, 1)
    code = (
        "import sys\nseen = []\n"
        "sys.addaudithook(lambda event, _: seen.append(event) if event in"
        " {'socket.bind', 'socket.connect'} else None)\n"
        "from shakerproc.cli import main\n"
        "try: main()\nfinally: print(seen, file=sys.stderr)"
    )
    words = ("watch", tmp_path / "recordings", "--log", tmp_path / "testlog.yaml", *QUICK)
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    assert "done" in done.stdout
    assert done.stderr.splitlines()[-1] == "[]"


def test_a_log_with_an_error_counts_as_it_was_until_it_is_corrected(tmp_path):
    path, told = write_campaign(tmp_path, 1), []
    watched = WatchedLog(path, told.append)
    first, text = watched.read(), path.read_text(encoding="utf-8")
    path.write_text(text + "  - {id: 2, recordin: x.tdms}\n", encoding="utf-8")
    assert watched.read() is first
    assert watched.read() is first
    assert len(told) == 1
    assert "recordin" in told[0]
    assert "\n" not in told[0]
    (tmp_path / "photo.jpg").write_text("no picture", encoding="utf-8")
    path.write_text(text + "report: {photo: photo.jpg}\n", encoding="utf-8")
    assert watched.read() is first
    assert "no photo that can be read" in told[1]
    path.write_text(text.replace("0.0005", "0.0007"), encoding="utf-8")
    assert watched.read().tests[0].level == pytest.approx(0.0007 * 9.80665**2)


def test_results_around_the_recordings_are_refused(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    for out in (tmp_path, tmp_path / "in"):
        assert run("watch", tmp_path / "in", "--out", out, *QUICK) == 2
        assert "may not lie around the recordings" in " ".join(capsys.readouterr().err.split())


def test_a_folder_that_another_watch_has_is_locked(tmp_path):
    from shakerproc.campaign.result_folder import locked

    with locked(tmp_path / "results"):
        assert run("watch", tmp_path, *QUICK) == 75


@pytest.mark.slow
@pytest.mark.long
def test_nothing_is_lost_and_nothing_done_twice_though_it_is_killed(tmp_path):
    compared, _ = kill_and_compare(tmp_path, 2, 2, pause=0.1, most=6)
    assert compared > 6
