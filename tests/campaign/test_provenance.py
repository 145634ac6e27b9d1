"""What a result is filed under is the hash of the bytes that it was made from."""

import hashlib
import json
import os
import shutil

import pytest
from tests.campaign.exchanges import exchanges, trusting_work
from tests.campaign.light_work import light_work
from tests.campaign.test_campaign import HereExecutor, batch
from tests.small_campaign import write_campaign, write_recording

import shakerproc
from shakerproc.campaign.jobs import Products
from shakerproc.cli.batch_output import tell_outdated
from shakerproc.data import SourceFile
from shakerproc.errors import RecordingError
from shakerproc.recordings import WatchedFile, open_recording, read_hashed
from shakerproc.runs import open_test
from shakerproc.testlog import read_testlog
from shakerproc.workflows import worker


def hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def manifest_of(out):
    return json.loads((out / "manifest.json").read_text(encoding="utf-8"))


def test_a_recording_exchanged_after_the_batch_began_is_an_error_and_computed_once_it_is_back(
    tmp_path,
):
    log, out = write_campaign(tmp_path, 3, seconds=0.5), tmp_path / "out"
    recordings = tmp_path / "recordings"
    shutil.copy2(recordings / "test_3.tdms", tmp_path / "kept.tdms")

    def exchanging(job):
        value = light_work(job)
        if job.test.id == 1:
            shutil.copy(recordings / "test_1.tdms", recordings / "test_3.tdms")
        return value

    class Careful(HereExecutor):
        def run(self, work, tasks):
            for task in tasks:
                yield guarded(work, task)

    first = batch(log, out, work=exchanging, executor=Careful())
    assert [one.status for one in first.runs] == ["done", "done", "failed"]
    assert "changed after the batch began" in first.runs[2].error
    assert manifest_of(out)["runs"]["test_3"]["recording_sha256"] == ""
    shutil.copy(tmp_path / "kept.tdms", recordings / "test_3.tdms")
    second = batch(log, out)
    assert (second.computed, second.kept) == (1, 2)
    assert second.runs[2].sha256 == hash_of(recordings / "test_3.tdms")


def guarded(work, task):
    from shakerproc.errors import ShakerprocError
    from shakerproc.executors import TaskOutcome

    try:
        return TaskOutcome(task.name, work(task.argument))
    except ShakerprocError as error:
        return TaskOutcome(task.name, cause="input", error=str(error))


def cut_short(path, _other):
    with path.open("rb+") as file:
        file.truncate(path.stat().st_size // 2)


def replaced(path, other):
    shutil.copy(other, path.with_suffix(".new"))
    path.with_suffix(".new").replace(path)


def written_over(path, other):
    before = path.stat()
    path.write_bytes(other.read_bytes())
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def exchanged_and_put_back(path, other):
    path.rename(path.with_suffix(".aside"))
    shutil.copy(other, path)
    path.with_suffix(".aside").replace(path)


def written_over_and_back(path, other):
    content, before = path.read_bytes(), path.stat()
    path.write_bytes(other.read_bytes())
    path.write_bytes(content)
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))


def removed(path, _other):
    path.unlink()


CHANGES = (
    cut_short, replaced, written_over, exchanged_and_put_back, written_over_and_back, removed,
)  # fmt: skip


@pytest.mark.parametrize("change", CHANGES)
def test_a_recording_that_changes_while_it_is_worked_through_leaves_no_result(
    tmp_path, monkeypatch, change
):
    log, out = write_campaign(tmp_path, 1, seconds=2.0), tmp_path / "out"
    path = tmp_path / "recordings" / "test_1.tdms"
    other = write_recording(tmp_path / "other.tdms", 200.0, seed=9, seconds=2.0)
    shutil.copy2(path, tmp_path / "kept.tdms")
    process = worker.process_recording

    def process_meanwhile(recording, test, **how):
        result = process(recording, test, **how)
        change(path, other)
        return result

    monkeypatch.setattr(worker, "process_recording", process_meanwhile)
    products = Products(figures=False)
    with pytest.raises(RecordingError, match=r"test 1 .*changed while it was read"):
        batch(log, out, work=worker.work_through, products=products)
    assert not list((out / "runs").rglob("*"))
    monkeypatch.undo()
    shutil.copy2(tmp_path / "kept.tdms", path)
    (one,) = batch(log, out, work=worker.work_through, products=products).runs
    assert one.sha256 == hash_of(path) == manifest_of(out)["runs"]["test_1"]["recording_sha256"]


@pytest.mark.parametrize("change", CHANGES)
def test_leaving_a_recording_that_changed_meanwhile_is_an_error(tmp_path, change):
    path = write_recording(tmp_path / "one.tdms", 300.0, seconds=0.5)
    other = write_recording(tmp_path / "two.tdms", 200.0, seconds=0.4)
    with (
        pytest.raises(RecordingError, match=r"one.tdms: the file changed while it was read"),
        open_recording(path),
    ):
        change(path, other)


def test_an_undisturbed_recording_has_the_hash_of_its_file(tmp_path):
    log = write_campaign(tmp_path, 1, seconds=0.5)
    (test,) = read_testlog(log).tests
    with open_test(read_testlog(log), test) as recording:
        recording.samples()
        assert isinstance(recording.file, SourceFile)
        assert recording.sha256() == hash_of(tmp_path / "recordings" / "test_1.tdms")


def test_a_batch_hashes_a_recording_once_and_again_where_it_was_touched(tmp_path, monkeypatch):
    log, out = write_campaign(tmp_path, 2, seconds=2.0), tmp_path / "out"
    recordings = tmp_path / "recordings"
    names, digest = [], WatchedFile._digest
    monkeypatch.setattr(
        WatchedFile, "_digest", lambda file: (names.append(file._path.name), digest(file))[1]
    )

    def touching(job):
        if job.test.id == 1:
            os.utime(recordings / "test_2.tdms")
        return worker.work_through(job)

    found = batch(log, out, work=touching, products=Products(figures=False)).runs
    assert [one.status for one in found] == ["done", "done"]
    assert sorted(names) == ["test_1.tdms", "test_2.tdms", "test_2.tdms"]
    assert [one.sha256 for one in found] == [
        hash_of(recordings / one.recording) for one in found
    ]


def test_a_document_that_changes_while_it_is_read_is_an_error(tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text("a", encoding="utf-8")
    assert read_hashed(lambda one: one.read_text(encoding="utf-8"), path) == (
        "a", hashlib.sha256(b"a").hexdigest(),
    )  # fmt: skip
    with pytest.raises(RecordingError, match=r"model.yaml: .* changed while it was read"):
        read_hashed(lambda one: one.write_text("b", encoding="utf-8"), path)


def test_tests_of_an_older_manifest_are_computed_again_and_it_is_said(tmp_path, capsys):
    log, out = write_campaign(tmp_path, 2, seconds=0.5), tmp_path / "out"
    batch(log, out)
    old = manifest_of(out) | {"schema": "shakerproc-manifest/1"}
    (out / "manifest.json").write_text(json.dumps(old), encoding="utf-8")
    again = batch(log, out, on_outdated=tell_outdated)
    assert (again.computed, again.kept) == (2, 0)
    assert capsys.readouterr().err.startswith(
        "2 tests computed again: an older shakerproc took the SHA-256"
    )
    third = batch(log, out, on_outdated=tell_outdated)
    assert (third.computed, third.kept) == (0, 2)
    assert capsys.readouterr().err == ""


def test_tests_of_another_version_or_log_are_computed_again_and_it_is_said(tmp_path, capsys):
    log, out = write_campaign(tmp_path, 2, seconds=0.5), tmp_path / "out"
    batch(log, out)
    path, version = out / "manifest.json", shakerproc.__version__
    path.write_text(path.read_text().replace(f'"{version}"', '"0.0.9"'), encoding="utf-8")
    for entry in json.loads(path.read_text())["runs"].values():  # the version is in each key
        stale = path.read_text().replace(entry["key"], entry["key"][::-1])
        path.write_text(stale, encoding="utf-8")
    batch(log, out, on_outdated=tell_outdated)
    told = f"2 tests computed again: they are of shakerproc 0.0.9, this is {version}\n"
    assert capsys.readouterr().err == told
    batch(log, out, products=Products(figures=False), on_outdated=tell_outdated)
    assert "2 tests computed again: what the log or the options say" in capsys.readouterr().err
    next((out / "runs" / "test_1").iterdir()).unlink()
    batch(log, out, products=Products(figures=False), on_outdated=tell_outdated)
    assert capsys.readouterr().err.startswith("1 test computed again: ")


def test_what_a_test_no_longer_makes_does_not_stay_beside_what_it_makes_now(tmp_path):
    log, out = write_campaign(tmp_path, 1, seconds=2.0), tmp_path / "out"
    with_table = Products(figures=False, exports=("parquet",))
    batch(log, out, work=worker.work_through, products=with_table)
    assert (out / "runs" / "test_1" / "spectra.parquet").exists()
    (out / "runs" / "test_1" / "note.txt").write_text("mine", encoding="utf-8")
    batch(log, out, work=worker.work_through, products=Products(figures=False))
    assert not (out / "runs" / "test_1" / "spectra.parquet").exists()
    assert (out / "runs" / "test_1" / "note.txt").exists()


@pytest.mark.slow
@pytest.mark.long
def test_no_result_is_filed_under_other_bytes_however_recordings_are_exchanged(tmp_path):
    tally = exchanges(tmp_path, 6, real_share=0.3)  # `make chaos` plays 200 rounds
    assert tally.changes > 20
    assert tally.looked_at > 20
    assert tally.refused > 3
    assert not tally.wrong


def test_the_exchanges_find_a_work_that_trusts_what_it_was_told(tmp_path):
    tally = exchanges(tmp_path, 4, real_share=0.0, work=trusting_work)
    assert tally.wrong
