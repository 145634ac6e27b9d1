"""`shakerproc watch`: each finished recording is worked through once, none is lost."""

import os
import re
import shutil
import signal
import time

import pytest
from tests.batch.watched import kill_and_compare, watch
from tests.in_process import run
from tests.small_campaign import write_campaign, write_recording

from shakerproc.batch.arrivals import looked, recordings_in, standing
from shakerproc.batch.jobs import Products
from shakerproc.errors import RecordingError
from shakerproc.testlog import read_testlog
from shakerproc.workflows.machines import Machines
from shakerproc.workflows.watching import Pace, Watch
from shakerproc.workflows.write_up import Wish

QUICK = ("--settle", 0.2, "--every", 0.1, "--idle", 0.5, "--no-figures", "--workers", 1)


def test_a_file_is_finished_when_it_stands_still(tmp_path):
    path = tmp_path / "a.tdms"
    path.write_bytes(b"1")
    os.utime(path, ns=(1, 1))
    seen = looked({}, [path, tmp_path / "absent.tdms"], 10.0)
    assert standing(seen, 3.0, 12.9) == {}
    seen = looked(seen, [path], 12.0)
    assert list(standing(seen, 3.0, 13.0)) == [path]
    path.write_bytes(b"12")
    assert standing(looked(seen, [path], 13.0), 3.0, 15.9) == {}
    path.write_bytes(b"")  # opened by a recorder, not begun
    assert standing(looked(seen, [path], 20.0), 0.0, 99.0) == {}


def test_results_are_no_recordings(tmp_path):
    for name in ("day/a.tdms", "day/results/runs.csv", ".hidden/b.tdms", "c.TXT", "notes.md"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("1", encoding="utf-8")
    (tmp_path / "day" / "results" / "manifest.json").write_text("{}", encoding="utf-8")
    found = [path.relative_to(tmp_path).as_posix() for path in recordings_in(tmp_path)]
    assert sorted(found) == ["c.TXT", "day/a.tdms"]


@pytest.mark.slow
def test_tests_whose_recordings_have_come_are_run_and_the_others_are_named(tmp_path, capsys):
    log = write_campaign(tmp_path, 2)
    late = tmp_path / "recordings" / "test_2.tdms"
    late.rename(tmp_path / "kept")
    write_recording(tmp_path / "recordings" / "other.tdms", 300.0)
    pages = []

    def logs(still):
        page = tmp_path / "results" / "report.html"
        pages.append(page.read_text(encoding="utf-8") if page.exists() else "")
        if "test_1" in str(list(still)) and not late.exists() and "1 of 1" in pages[-1]:
            (tmp_path / "kept").rename(late)
        return known

    known, told = read_testlog(log), []
    watched = Watch(
        tmp_path / "recordings",
        tmp_path / "results",
        logs,
        products=Products(figures=False),
        machines=Machines(1),
        wish=Wish(figures=False),
        tell=told.append,
    )
    watched.run(Pace(0.2, 0.1, 0.6))
    assert [re.match(r"test \d", line)[0] for line in told] == ["test 1", "test 2"]
    assert any("Waiting for the recordings of: 2." in page for page in pages)
    assert 'data-refresh="2"' in (tmp_path / "results" / "report.html").read_text("utf-8")
    assert watched.last()["counts"]["processed"] == 2
    last = (tmp_path / "results" / "report.html").read_text("utf-8")
    assert "data-refresh" not in last
    assert 'http-equiv="refresh"' not in last
    # a recording that is cut off, and changes: read up to its last complete row, told
    late.write_bytes(late.read_bytes()[:-15000])
    assert run("watch", tmp_path / "recordings", "--log", log, *QUICK) == 0
    shown = capsys.readouterr()
    assert "1 reused" in shown.out
    assert "test 2 (test_2.tdms) again: the recording changed: up to its last" in shown.out
    assert "other.tdms is in no test of testlog.yaml" in shown.err


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
        wish=Wish(),
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
    assert errors.splitlines()[-1].startswith("interrupted; what is done stands")
    assert "data-refresh" not in page.read_text(encoding="utf-8")


def test_a_log_with_an_error_counts_as_it_was_until_it_is_corrected(tmp_path):
    from shakerproc.cli.watched_log import WatchedLog

    path, told = write_campaign(tmp_path, 1), []
    watched = WatchedLog(path, told.append)
    first, text = watched.read(), path.read_text(encoding="utf-8")
    path.write_text(text + "  - {id: 2, recordin: x.tdms}\n", encoding="utf-8")
    assert watched.read() is first
    assert watched.read() is first
    assert len(told) == 1
    assert "recordin" in told[0]
    assert "\n" not in told[0]
    path.write_text(text.replace("0.0005", "0.0007"), encoding="utf-8")
    assert watched.read().tests[0].level == pytest.approx(0.0007 * 9.80665**2)


def test_a_folder_that_another_watch_has_is_locked(tmp_path):
    from shakerproc.batch.lock import locked

    with locked(tmp_path / "results"):
        assert run("watch", tmp_path, *QUICK) == 75


@pytest.mark.slow
def test_nothing_is_lost_and_nothing_done_twice_though_it_is_killed(tmp_path):
    assert kill_and_compare(tmp_path, 2, 2)[0] > 6
