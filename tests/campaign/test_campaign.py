import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.campaign.chaos import FORKED, chaos
from tests.campaign.light_work import light_work
from tests.small_campaign import HEAD, ROW, write_campaign, write_recording

from shakerproc.campaign.batch import BatchListener, Execution, run_batch
from shakerproc.campaign.jobs import Products, folder_names
from shakerproc.campaign.result_folder import locked, read_manifest
from shakerproc.errors import LockedError, LogError
from shakerproc.executors import AbstractExecutor, Limits, ProcessExecutor, TaskOutcome
from shakerproc.testlog import Test, read_testlog


class HereExecutor(AbstractExecutor):
    """Runs tasks in this process; only for tasks that behave."""

    def run(self, work, tasks):
        for task in tasks:
            yield TaskOutcome(task.name, work(task.argument))


def batch(log, out, **options):
    products = options.pop("products", Products())
    told = {name: options.pop(name) for name in list(options) if name.startswith("on_")}
    how = {"work": light_work, "executor": HereExecutor()}
    how |= {name: options.pop(name) for name in list(options) if name in {*how, "hashes"}}
    progress = BatchListener(**told)
    return run_batch(
        read_testlog(log), out, products, Execution(**how), progress=progress, **options
    )


def write_big_campaign(folder, n_tests=92):
    """So many copies of one recording."""
    source = write_recording(folder / "one.tdms", 300.0, seconds=0.5)
    rows = []
    for i in range(1, n_tests + 1):
        (folder / "recordings").mkdir(exist_ok=True)
        shutil.copy(source, folder / "recordings" / f"t{i}.tdms")
        rows.append(
            ROW.format(
                id=i, file=f"t{i}.tdms", joint="radial", specimen="a", clearance="0.05", more=""
            )
        )
    log = folder / "testlog.yaml"
    log.write_text(HEAD.format(title="Big") + "".join(rows), encoding="utf-8")
    return log


def test_the_second_batch_recomputes_nothing(tmp_path):
    log = write_campaign(tmp_path, 3)
    first = batch(log, tmp_path / "out")
    assert (first.computed, first.kept) == (3, 0)
    second = batch(log, tmp_path / "out")
    assert (second.computed, second.kept) == (0, 3)
    assert second.runs == first.runs


def lose_output(_log, out):
    (out / "runs" / "test_2" / "a.csv").unlink()


def edit_output(_log, out):
    (out / "runs" / "test_2" / "a.csv").write_text("edited", encoding="utf-8")


def change_option(log, _out):
    text = log.read_text(encoding="utf-8")
    log.write_text(text.replace("segment: 512", "segment: 600"), encoding="utf-8")


def add_comment(log, _out):
    log.write_text("# a comment more\n" + log.read_text(encoding="utf-8"), encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "computed"),
    [(lose_output, 1), (edit_output, 1), (change_option, 3), (add_comment, 0)],
)
def test_what_changed_is_computed_again_and_nothing_else(tmp_path, change, computed):
    log = write_campaign(tmp_path, 3)
    batch(log, tmp_path / "out")
    change(log, tmp_path / "out")
    assert batch(log, tmp_path / "out").computed == computed


def test_other_products_are_other_results(tmp_path):
    log = write_campaign(tmp_path, 2)
    batch(log, tmp_path / "out")
    assert batch(log, tmp_path / "out", products=Products(exports=("mat",))).computed == 2


def test_a_recording_that_changed_since_is_an_error_until_it_is_accepted(tmp_path):
    log = write_campaign(tmp_path, 2)
    batch(log, tmp_path / "out")
    write_recording(tmp_path / "recordings" / "test_2.tdms", 200.0, seed=9)
    for _ in range(2):  # also the second time: what was seen first stays first
        changed = batch(log, tmp_path / "out")
        assert [run.status for run in changed.runs] == ["done", "failed"]
        assert "has changed since it was first processed" in changed.runs[1].error
        assert "--accept-changed" in changed.runs[1].error
    accepted = batch(log, tmp_path / "out", accept_changed=True)
    assert [run.status for run in accepted.runs] == ["done", "done"]
    assert batch(log, tmp_path / "out").computed == 0


def test_discarded_and_missing_tests_do_not_stop_the_others(tmp_path):
    log = write_campaign(tmp_path, 3)
    (tmp_path / "recordings" / "test_1.tdms").unlink()
    text = log.read_text(encoding="utf-8").replace("{id: 3,", "{id: 3, discarded: true,")
    log.write_text(text, encoding="utf-8")
    runs = batch(log, tmp_path / "out").runs
    assert [run.status for run in runs] == ["failed", "done", "discarded"]
    assert "no recording" in runs[0].error


def test_a_folder_is_locked_while_another_works_in_it(tmp_path):
    words = "another shakerproc works in this folder"
    with locked(tmp_path), pytest.raises(LockedError, match=words):
        lock_again(tmp_path)
    lock_again(tmp_path)


def lock_again(folder):
    """Lock from a lock object of its own, as a second process would."""
    with locked(folder):
        pass


def test_folder_names_are_harmless_and_distinct():
    ids = [1, "2b", "2B", "../../etc", "..", "con.", "a/b", "a_b", "ü", "x" * 200]
    names = folder_names([Test(i) for i in ids])
    assert len({name.lower() for name in names.values()}) == len(ids)
    for name in names.values():
        assert name.startswith("test_")
        assert re.fullmatch(r"[A-Za-z0-9._-]+", name)
        assert len(name) < 90
        assert not name.endswith(".")


def test_a_damaged_manifest_says_what_to_do(tmp_path):
    (tmp_path / "manifest.json").write_text("{]", encoding="utf-8")
    with pytest.raises(LogError, match=r"manifest.json: not a manifest.*Remove the file"):
        read_manifest(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "count"), [("raise", 12), ("killed", 92), ("hang", 12), ("memory", 12)]
)
def test_one_bad_run_of_many_leaves_the_others_done(tmp_path, monkeypatch, kind, count):
    log = write_big_campaign(tmp_path, count)
    monkeypatch.setenv("BAD_WORK", kind)
    limits = ProcessExecutor(2, Limits(2.0, 1e9))
    runs = batch(log, tmp_path / "out", executor=limits).runs
    assert sum(run.status == "done" for run in runs) == count - 1
    (bad,) = [run for run in runs if run.status != "done"]
    assert (bad.test, bad.status) == ("4", "failed")
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["runs"]["test_4"]["cause"] in {
        "error", "killed", "time limit", "memory limit",
    }  # fmt: skip
    monkeypatch.delenv("BAD_WORK")
    again = batch(log, tmp_path / "out")
    assert (again.computed, again.kept) == (1, count - 1)
    assert {run.status for run in again.runs} == {"done"}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX processes")
def test_kills_at_random_moments_leave_every_output_as_undisturbed(tmp_path):
    """Ten kills, no worker; `make chaos` has five hundred, and two."""
    kills, stood, compared = chaos(tmp_path, 10, command=FORKED, n_tests=3, resumed=0.2)
    assert kills == 10
    assert stood > 5
    assert compared > 20


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_ctrl_c_ends_a_batch_at_once_with_130(tmp_path):
    log = write_campaign(tmp_path, 4)
    out = tmp_path / "o"
    process = subprocess.Popen(
        [sys.executable, "-m", "shakerproc", "batch", str(log), "--out", str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # a shell that runs its tests in the background has them ignore Ctrl-C
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),  # noqa: PLW1509
    )
    until = time.monotonic() + 60.0
    while not (out / "manifest.json").exists() and time.monotonic() < until:
        time.sleep(0.05)
    time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=30)  # the machine may be busy; a batch would hang
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert not [p for p in Path("/proc").glob("[0-9]*/cmdline") if _belongs(p, tmp_path)]


def _belongs(cmdline, folder):
    try:
        return str(folder).encode() in cmdline.read_bytes()
    except OSError:
        return False
