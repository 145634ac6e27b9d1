"""Without the extra `parquet` all else works, and what needs it says how to install it."""

import sys

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from typer.testing import CliRunner

from shakerproc.campaign.tables import write_tables
from shakerproc.cli import build_app
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import write_parquet, write_tdms

WANTED = "pip install 'shakerproc[parquet]'"
SAMPLES = np.random.default_rng(4).standard_normal((2, 500)) * np.array([[1e-9], [1e7]])


@pytest.fixture
def files(tmp_path, monkeypatch):
    """A folder with a recording in TDMS and Parquet, and no pyarrow from here on."""
    recording = recording_of_arrays(
        "run", [Channel("a", "N", "a", "N"), Channel("b", "N", "b", "N")], SAMPLES, 1000.0
    )
    write_tdms(tmp_path / "run.tdms", recording)
    write_parquet(tmp_path / "run.parquet", recording)
    for name in [name for name in sys.modules if name.partition(".")[0] == "pyarrow"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    return tmp_path


def ended(*words):
    return CliRunner().invoke(build_app(), [str(word) for word in words])


@pytest.mark.parametrize("words", [
    ("inspect", "run.parquet"),
    ("process", "run.parquet"),
    ("convert", "run.parquet", "out.tdms"),
    ("convert", "run.tdms", "out.parquet"),
    ("process", "run.tdms", "--export", "parquet"),
])  # fmt: skip
def test_what_needs_parquet_says_how_to_install_it(files, words, monkeypatch):
    monkeypatch.chdir(files)
    before = set(files.iterdir())
    done = ended(*words)
    assert done.exit_code != 0
    told = f"{done.output} {done.exception}".replace("\n", " ")
    assert "pyarrow" in told
    assert WANTED in told
    assert set(files.iterdir()) == before


def test_csv_holds_every_digit_without_it_too(files):
    done = ended("convert", files / "run.tdms", files / "run.csv")
    assert done.exit_code == 0, done.output
    read = np.loadtxt(files / "run.csv", delimiter=",", skiprows=1)
    assert_array_equal(read[:, 1:].T, SAMPLES)
    assert_array_equal(read[:, 0], np.arange(500) / 1000.0)


def test_a_campaign_has_its_tables_without_it_too(files):
    written = {path.name for path in write_tables([], [], "a", files)}
    assert "peaks.csv" in written
    assert "peaks.parquet" not in written
