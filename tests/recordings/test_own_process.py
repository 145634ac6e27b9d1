"""A file that another process reads: what it does to itself it does to nobody else."""

import os

import numpy as np
import pytest
from tests.recordings.shared_data import FOLDER

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording, own_process, write_parquet
from shakerproc.recordings.own_process import opened_apart, result_apart

ABORTS = FOLDER.parent / "cases" / "33-parquet-abort" / "x.parquet"

READER = """
import ctypes, os
import numpy as np
from shakerproc.data import SampleSource
from shakerproc.errors import RecordingError
from shakerproc.recordings.raw import RawChannel, RawFile, RawGroup, TimeAxis, TimesInFile

class Source(SampleSource):
    def read(self, rows, start, stop):
        print("on the terminal of a library")
        if stop > 50:
            {does}
        return np.array([np.arange(start, stop) + 100.0 * row for row in rows])

    def close(self):
        pass

def read(path, run):
    if path.name == "bad.x":
        raise ValueError("no such block")
    source = Source()
    axes = (TimeAxis("a column", times=TimesInFile(source, 2, 60), unit="s"),)
    made = [RawChannel(name, row, 60, 60, "g", axes=axes) for row, name in enumerate("ab")]
    return RawFile((RawGroup("", tuple(made)),), source, (str(os.getpid()),))
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where the readers are: one place for all, so that processes go on.

    Those that other tests have left do not know it.
    """
    own_process._idle.cache_clear()
    return tmp_path_factory.mktemp("readers")


@pytest.fixture
def opened(folder, monkeypatch):
    """A function that opens a file whose reader does something behind its fiftieth sample."""
    monkeypatch.syspath_prepend(folder)

    def open_file(does="pass", name="file.x"):
        module = f"reader_{abs(hash(does))}"
        (folder / f"{module}.py").write_text(READER.format(does=does))
        (folder / name).touch()
        return opened_apart(folder / name, "run", f"{module}:read", "json")

    return open_file


@pytest.fixture
def without_fork(folder, monkeypatch):
    """No fork, here and in every process that is started."""
    hides = folder / "sitecustomize.py"
    hides.write_text("import os\nif hasattr(os, 'fork'):\n    del os.fork\n")
    monkeypatch.delattr(os, "fork", raising=False)
    own_process._idle.cache_clear()
    yield
    own_process._idle.cache_clear()
    hides.unlink()


def test_samples_and_times_are_those_of_the_reader(opened):
    raw = opened()
    a, b = raw.groups[0].channels
    assert (a.name, b.unit, a.axes[0].times.size) == ("a", "g", 60)
    assert a.axes is b.axes
    assert raw.source.read([1, 0], 3, 60).tolist() == [
        list(np.arange(103.0, 160.0)), list(np.arange(3.0, 60.0)),
    ]  # fmt: skip
    assert a.axes[0].times[57:99].tolist() == [257.0, 258.0, 259.0]
    assert a.axes[0].times[9:3].size == 0
    raw.source.close()
    with pytest.raises(RecordingError, match="run: the recording is closed"):
        raw.source.read([0], 0, 1)


def test_each_file_has_a_process_of_its_own(opened):
    one, other = opened(), opened()
    other.source.close()
    third = opened()
    processes = {raw.notes[0] for raw in (one, other, third)}
    assert len(processes | {str(os.getpid())}) == 4
    assert one.source.read([0], 0, 2).tolist() == [[0.0, 1.0]]
    for raw in (one, third):
        raw.source.close()


@pytest.mark.parametrize(
    ("does", "told"),
    [
        ("os.abort()", r"gives up \(SIGABRT\): it is damaged"),
        ("ctypes.string_at(8)", r"gives up \(SIGSEGV\): it is damaged"),
        ("os._exit(7)", r"gives up \(status 7\): it is damaged"),
        ("os._exit(0)", r"gives up \(it has ended\): it is damaged"),
        ("raise KeyError('block')", "reading the file failed: KeyError: \"'block'\""),
        ("raise RecordingError('run: is cut.')", "^run: is cut"),
        ("raise MemoryError", "run: reading the file failed: MemoryError"),
    ],
)
def test_what_a_slice_does_to_the_process_is_one_line(opened, does, told):
    raw, whole = opened(does), opened()
    assert raw.source.read([0], 0, 50).size == 50
    with pytest.raises(RecordingError, match=told):
        raw.source.read([0], 40, 60)
    assert whole.source.read([0], 50, 60).tolist() == [list(np.arange(50.0, 60.0))]
    raw.source.close()
    whole.source.close()


def test_what_the_reader_raises_is_one_line(opened):
    with pytest.raises(
        RecordingError, match=r"run: reading the file failed: ValueError: 'no such"
    ):
        opened(name="bad.x")
    assert opened().source.read([0], 0, 1).tolist() == [[0.0]]


def test_a_slice_that_never_comes_is_given_up(opened, monkeypatch):
    raw = opened("__import__('time').sleep(60)")
    monkeypatch.setattr(own_process, "LONGEST_S", 0.3)
    with pytest.raises(RecordingError, match=r"gives up \(no answer for 0\.3 s\)"):
        raw.source.read([0], 40, 60)


@pytest.mark.usefixtures("without_fork")
def test_without_a_fork_it_is_the_same(opened):
    one, other = opened("os.abort()"), opened()
    assert one.notes != other.notes
    with pytest.raises(RecordingError, match=r"gives up \(SIGABRT\)"):
        one.source.read([0], 40, 60)
    assert other.source.read([1], 57, 59).tolist() == [[157.0, 158.0]]
    other.source.close()
    third = opened()
    assert third.notes != other.notes
    third.source.close()


def test_the_result_of_a_function_comes_from_another_process(folder, monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(folder)
    (folder / "asked.py").write_text(
        "import os\ndef of(path, run):\n    return [run, path.read_text(), os.getpid()]\n"
    )
    (tmp_path / "file.x").write_text("its text")
    run, text, process = result_apart(tmp_path / "file.x", "run", "asked:of", "json")
    assert (run, text) == ("run", "its text")
    assert process != os.getpid()


@pytest.mark.shared
@pytest.mark.skipif(not ABORTS.exists(), reason="the shared cases are not there")
def test_a_parquet_file_that_aborts_its_library_is_refused():
    with pytest.raises(RecordingError, match=r"x\.parquet: the library .* \(SIGABRT\)"):
        open_recording(ABORTS)


def test_a_sound_parquet_file_is_read_apart(tmp_path):
    rows = np.random.default_rng(1).standard_normal((2, 300))
    channels = [Channel(name, "N", name, "N") for name in "ab"]
    write_parquet(tmp_path / "a.parquet", recording_of_arrays("a", channels, rows, 100.0))
    with open_recording(tmp_path / "a.parquet") as found:
        assert np.array_equal(found.samples(), rows)
