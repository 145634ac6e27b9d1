import json
import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.in_process import run
from tests.small_campaign import write_campaign

from shakerproc import files

plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda children: st.lists(children) | st.dictionaries(st.text(), children),
    max_leaves=15,
)


@given(plain)
def test_json_comes_back_as_it_was(document):
    assert json.loads(files.json_text(document)) == document


def test_lists_of_numbers_stand_on_one_line():
    text = files.json_text({"x": [1.0, -2.5e-9, None], "words": ["[ 1.0,\n 2.0 ]"]})
    assert '"x": [1.0, -2.5e-09, null]' in text
    assert json.loads(text)["words"] == ["[ 1.0,\n 2.0 ]"]


def test_arrays_paths_and_what_is_not_finite_have_json():
    document = {"a": np.arange(3.0), "n": math.nan, "i": np.int64(3), "p": Path("a") / "b"}
    assert json.loads(files.json_text(document)) == {
        "a": [0.0, 1.0, 2.0],
        "n": None,
        "i": 3,
        "p": "a/b",
    }
    with pytest.raises(TypeError, match="no JSON for object"):
        files.json_text(object())


def write_half(path):
    with files.atomic_path(path) as temporary:
        temporary.write_text("half", encoding="utf-8")
        raise OSError(28, "No space left on device")


def test_a_file_that_cannot_be_finished_leaves_the_old_one(tmp_path):
    path = tmp_path / "x.csv"
    files.write_text(path, "old")
    with pytest.raises(OSError, match="No space left"):
        write_half(path)
    assert path.read_text(encoding="utf-8") == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["x.csv"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_a_full_disk_is_an_error_and_no_file(tmp_path, monkeypatch):
    (tmp_path / f"{files.TEMPORARY_PREFIX}aaaa.csv").symlink_to("/dev/full")
    monkeypatch.setattr(files.secrets, "token_hex", lambda _n: "aaaa")
    with pytest.raises(OSError, match="No space left"):
        files.write_text(tmp_path / "x.csv", "content")
    assert not (tmp_path / "x.csv").exists()


def test_a_file_that_another_program_holds_is_tried_again(tmp_path, monkeypatch):
    refused = iter([PermissionError, PermissionError, None])
    replace = Path.replace

    def hold(self, target):
        problem = next(refused)
        if problem:
            raise problem(13, "in use")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", hold)
    monkeypatch.setattr(files, "_REPLACE_PAUSE", 0.0)
    files.write_text(tmp_path / "x.csv", "content")
    assert (tmp_path / "x.csv").read_text(encoding="utf-8") == "content"


def test_leftovers_of_killed_writers_are_removed(tmp_path):
    leftover = tmp_path / "runs" / f"{files.TEMPORARY_PREFIX}abc.csv"
    leftover.parent.mkdir()
    leftover.write_text("half", encoding="utf-8")
    (tmp_path / "runs" / "kept.csv").write_text("whole", encoding="utf-8")
    files.remove_leftovers(tmp_path)
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["kept.csv"]


@given(st.text())
def test_printable_text_obeys_no_terminal(text):
    shown = files.printable(text)
    assert all(c.isprintable() or c in "\xa0 " for c in shown)
    assert "\n" not in shown


def test_the_date_can_be_given(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1500000000")
    assert files.now() == datetime(2017, 7, 14, 2, 40, tzinfo=UTC)


@pytest.mark.parametrize("name", ["errors.csv", "report.html", "peaks.csv", "Figure.PNG"])
@pytest.mark.parametrize("command", ["process", "batch"])
def test_a_file_that_the_program_did_not_write_is_never_written_over(
    tmp_path, capsys, command, name
):
    log = write_campaign(tmp_path, 1)
    mine = tmp_path / "out" / name
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    what = log if command == "batch" else tmp_path / "recordings" / "test_1.tdms"
    assert run(command, what, "--out", mine.parent) == 1
    told = capsys.readouterr().err.splitlines()
    assert [line for line in told if "error" in line] == told
    assert f"holds {name}, which shakerproc did not write" in told[0]
    assert {path.name for path in mine.parent.iterdir()} <= {name, ".shakerproc.lock"}
    assert mine.read_text(encoding="utf-8") == "mine"
