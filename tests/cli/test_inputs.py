"""A comparison and a diagnosis are filed under the bytes that they were made from."""

import hashlib
import json
import shutil

import pytest
from tests.comparison.small_campaigns import campaign, drive, written
from tests.in_process import run

from shakerproc.comparison import usable_tests
from shakerproc.diagnosis.progress import Progress
from shakerproc.errors import DiagnosisError
from shakerproc.executors import TaskOutcome
from shakerproc.model_files import read_model
from shakerproc.runs import RunSummary
from shakerproc.testlog import read_testlog
from shakerproc.workflows import diagnosis, evidence
from shakerproc.workflows.arguments import Machines


@pytest.fixture
def files(tmp_path):
    drives = (drive(level=3.0), drive(level=5.0, number=2))
    return written(campaign(drives=drives, seconds=2.0), tmp_path)


def silent(_text):
    pass


def recordings_of(log):
    return [test.recording for test in read_testlog(log).active]


def hash_of(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_compare_files_its_errors_under_what_was_read_not_what_is_there_afterwards(
    files, tmp_path, monkeypatch
):
    log, model = files
    one, other = recordings_of(log)
    wanted = [hash_of(path) for path in (model, log, one, other)]
    look = evidence.sections_of

    def exchange_everything(*given):
        shutil.copy(other, one)
        model.write_text(model.read_text(encoding="utf-8") + "# other\n", encoding="utf-8")
        return look(*given)

    monkeypatch.setattr(evidence, "sections_of", exchange_everything)
    assert run("compare", model, log, "--no-figures", "--out", tmp_path / "out") == 0
    told = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))
    assert [one["sha256"] for one in told["inputs"]] == wanted


def test_a_recording_that_is_read_twice_must_be_the_same(files):
    log, model = files
    known = read_model(model)
    first = usable_tests(read_testlog(log), known).tests
    one, other = recordings_of(log)
    evidence.check_same(first, usable_tests(read_testlog(log), known).tests)
    shutil.copy(other, one)
    with pytest.raises(DiagnosisError, match="the recording changed since it was read before"):
        evidence.check_same(first, usable_tests(read_testlog(log), known).tests)


def test_the_model_of_a_batch_is_held_against_the_recordings_of_the_batch(files):
    log, model = files
    runs = [RunSummary("1", "done", sha256="0" * 64)]
    with pytest.raises(DiagnosisError, match=r"test 1 .*the recording changed since"):
        evidence.held_against(model, read_testlog(log), log, runs, tell=silent, warn=silent)


def test_a_diagnosis_of_other_recordings_elsewhere_is_refused(files, monkeypatch):
    log, model = files
    known = read_model(model)
    usable = usable_tests(read_testlog(log), known)

    class Elsewhere:
        def run(self, _work, tasks):
            value = {"diagnosis": "", "sha256": {"1": "0" * 64}}
            return [TaskOutcome(task.name, value) for task in tasks]

    monkeypatch.setattr(Machines, "executor", lambda _self: Elsewhere())
    with pytest.raises(DiagnosisError, match="the worker read other recordings"):
        diagnosis.judged(
            known,
            read_testlog(log),
            usable,
            Machines(scheduler="x"),
            seed=0,
            progress=Progress(),
        )


def test_batch_and_compare_refuse_a_log_without_tests_in_the_same_words(files, capsys):
    log, model = files
    head, _, _ = log.read_text(encoding="utf-8").partition("tests:")
    log.write_text(head + "tests: []\n", encoding="utf-8")
    told = []
    for words in (("batch", log), ("compare", model, log)):
        assert run(*words, "--out", log.parent / "out") == 1
        told.append(capsys.readouterr().err.splitlines()[-1])
    assert told[0] == told[1]
    assert "testlog.yaml: no test has a recording that may be used. Give a test" in told[0]
    assert not (log.parent / "out").exists()
