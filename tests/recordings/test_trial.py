"""A file that ends the process which opens it: one line, and we live."""

import numpy as np
import pytest
from tests.recordings.shared_data import FOLDER

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import apart, open_recording, write_parquet
from shakerproc.recordings.apart import check_survived

ABORTS = FOLDER.parent / "cases" / "33-parquet-abort" / "x.parquet"


@pytest.mark.parametrize(
    ("does", "told"),
    [
        ("import os; os.abort()", r"gives up \(SIGABRT\)"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", r"gives up \(SIGSEGV\)"),
        ("import os; os._exit(3)", r"gives up \(status 3\)"),
        ("raise ValueError(1)", None),
        ("return", None),
    ],
)
def test_what_kills_the_process_of_the_trial_is_one_line(tmp_path, monkeypatch, does, told):
    (tmp_path / "deadly.py").write_text(f"def open_it(path):\n    {does}\n", encoding="utf-8")
    (tmp_path / "file.x").write_bytes(b"1")
    monkeypatch.syspath_prepend(tmp_path)
    if told is None:
        check_survived(tmp_path / "file.x", "run", "deadly:open_it")
        return
    with pytest.raises(RecordingError, match=f"run: the library that reads it {told}"):
        check_survived(tmp_path / "file.x", "run", "deadly:open_it")


def test_a_file_is_not_blamed_for_what_an_earlier_one_did_to_the_process(tmp_path, monkeypatch):
    """The process of the trial goes on with the next file; here it dies of its third."""
    (tmp_path / "frail.py").write_text(
        "import os\npaths = []\ndef open_it(path):\n"
        "    path.with_suffix('.process').write_text(str(os.getpid()))\n"
        "    paths.append(path)\n"
        "    if path.name == 'deadly.x' or len(paths) == 3:\n        os.abort()\n",
        encoding="utf-8",
    )
    monkeypatch.syspath_prepend(tmp_path)
    processes = []
    for name in ("a", "b", "c", "d"):
        (tmp_path / f"{name}.x").write_bytes(b"1")
        check_survived(tmp_path / f"{name}.x", "run", "frail:open_it")
        processes.append((tmp_path / f"{name}.process").read_text())
    first, second = processes[0], processes[2]
    assert processes == [first, first, second, second]
    assert first != second
    (tmp_path / "deadly.x").write_bytes(b"1")
    with pytest.raises(RecordingError, match=r"gives up \(SIGABRT\)"):
        check_survived(tmp_path / "deadly.x", "run", "frail:open_it")


def test_a_trial_without_an_answer_is_given_up(tmp_path, monkeypatch):
    (tmp_path / "slow.py").write_text("import time\ndef open_it(path):\n    time.sleep(60)\n")
    (tmp_path / "file.x").write_bytes(b"1")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(apart, "LONGEST_S", 0.2)
    with pytest.raises(RecordingError, match=r"gives up \(no answer for 0\.2 s\)"):
        check_survived(tmp_path / "file.x", "run", "slow:open_it")


@pytest.mark.shared
@pytest.mark.skipif(not ABORTS.exists(), reason="the shared cases are not there")
def test_a_parquet_file_that_aborts_its_library_is_refused():
    with pytest.raises(RecordingError, match=r"x\.parquet: the library .* \(SIGABRT\)"):
        open_recording(ABORTS)


def test_a_sound_file_is_read_after_its_trial(tmp_path):
    rows = np.random.default_rng(1).standard_normal((2, 300))
    channels = [Channel(name, "N", name, "N") for name in "ab"]
    write_parquet(tmp_path / "a.parquet", recording_of_arrays("a", channels, rows, 100.0))
    with open_recording(tmp_path / "a.parquet") as found:
        assert np.array_equal(found.samples(), rows)
