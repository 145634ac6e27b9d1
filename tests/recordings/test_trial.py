"""A file that ends the process which opens it: one line, and we live."""

import numpy as np
import pytest
from tests.recordings.shared_data import FOLDER

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording, write_parquet
from shakerproc.recordings.trial import check_survived

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
