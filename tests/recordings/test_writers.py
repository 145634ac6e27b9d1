"""Everything that is written is read back the same, by every reader of its format."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
import pyuff
from nptdms import TdmsFile
from numpy.testing import assert_allclose, assert_array_equal
from scipy import io as scipy_io

from shakerproc.data import STANDARD_GRAVITY, Channel, SampleSource, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import (
    READERS,
    UNKNOWN,
    WRITERS,
    open_recording,
    sha256,
    write_csv,
    write_mat,
    write_tdms,
    write_uff,
)

RATE = 51200.0 / 9.0
START = datetime(2024, 5, 6, 7, 8, 9, 250000, tzinfo=UTC)
CHANNELS = (
    Channel("control 1", "m/s^2", "ai0", "g"),
    Channel("=1+1, \"quoted\"", "m/s^2", "ai1", "m/s^2"),
    Channel("force", "N", "ai2", "kN"),
    Channel("gap", "m", "ai3", "V, 8 V/mm"),
    Channel("temperature", UNKNOWN, "ai4", "Deg C"),
    Channel("plain", "1", "ai5", ""),
)  # fmt: skip


def example(n=200_001):
    samples = np.random.default_rng(1).standard_normal((len(CHANNELS), n))
    recording = recording_of_arrays("run 7", CHANNELS, samples, RATE)
    return replace(recording, start_time=START)


def test_every_writer_has_a_reader():
    assert set(WRITERS) <= set(READERS)


@pytest.mark.parametrize("ending", WRITERS)
def test_a_round_trip_keeps_everything(tmp_path, ending):
    recording = example(70_001)
    path = tmp_path / f"out{ending}"
    WRITERS[ending](path, recording)
    with open_recording(path) as found:
        assert [c.name for c in found.channels] == [c.name for c in CHANNELS]
        units = ["m/s^2", "m/s^2", "N", "m", UNKNOWN]
        assert [c.unit for c in found.channels[:5]] == units
        assert found.channels[0].source_unit == "g"
        assert found.channels[4].source_unit == "Deg C"
        assert found.sample_rate == pytest.approx(RATE, rel=1e-12)
        assert found.n_samples == recording.n_samples
        assert not found.incomplete
        assert_allclose(found.samples(), recording.samples(), rtol=1e-15)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]


@pytest.mark.parametrize("ending", sorted(set(WRITERS) - {".csv"}))
def test_a_file_with_the_ending_of_another_format_is_told_its_own(tmp_path, ending):
    written, path = tmp_path / f"out{ending}", tmp_path / "run.wav"
    WRITERS[ending](written, example(500))
    path.write_bytes(written.read_bytes())
    with pytest.raises(RecordingError, match=r"not of \.wav\. Rename it") as caught:
        open_recording(path)
    told = str(caught.value).partition("of the ending ")[2].partition(",")[0]
    assert READERS.known[told] == READERS.known[ending]
    path.with_suffix(told).write_bytes(written.read_bytes())
    open_recording(path.with_suffix(told)).source.close()


@pytest.mark.parametrize("first", WRITERS)
@pytest.mark.parametrize("second", WRITERS)
def test_any_format_can_follow_any_other(tmp_path, first, second):
    recording = example(500)
    WRITERS[first](tmp_path / f"a{first}", recording)
    with open_recording(tmp_path / f"a{first}") as one:
        WRITERS[second](tmp_path / f"b{second}", one)
    with open_recording(tmp_path / f"b{second}") as two:
        assert_allclose(two.samples(), recording.samples(), rtol=1e-14)
        assert [c.name for c in two.channels] == [c.name for c in CHANNELS]
        assert two.sample_rate == pytest.approx(RATE, rel=1e-12)


def test_tdms_is_what_nptdms_reads(tmp_path):
    recording = example()
    path = tmp_path / "out.tdms"
    write_tdms(path, recording)
    oracle = TdmsFile.read(path)
    names = [group.name for group in oracle.groups()]
    assert names == ["05/06/2024 07:08:09 AM - run 7 - All Data"]
    (whole,) = oracle.groups()
    assert whole["control 1"].properties["unit_string"] == "g"
    assert whole["control 1"].properties["wf_start_time"] == np.datetime64(
        START.replace(tzinfo=None), "us"
    )
    assert_array_equal(whole["control 1"][:], recording.samples()[0] / STANDARD_GRAVITY)
    with open_recording(path) as found:
        assert found.n_samples == 200_001
        assert found.start_time == START
        assert found.sample_rate == pytest.approx(RATE, rel=1e-15)


def test_that_a_recording_is_incomplete_survives_tdms(tmp_path):
    write_tdms(tmp_path / "out.tdms", replace(example(600), expected_samples=1000))
    with open_recording(tmp_path / "out.tdms") as found:
        assert (found.n_samples, found.expected_samples) == (600, 1000)


def test_csv_runs_nothing_in_a_spreadsheet(tmp_path):
    write_csv(tmp_path / "out.csv", example(3))
    text = (tmp_path / "out.csv").read_text()
    assert text.splitlines()[0] == (
        'time [s],control 1 [g],"\'=1+1, ""quoted"" [m/s^2]",force [kN],gap [m],'
        "temperature [Deg C],plain [1]"
    )
    assert len(text.splitlines()) == 4


def test_mat_is_a_matrix_with_names(tmp_path):
    recording = example(100)
    write_mat(tmp_path / "out.mat", recording)
    content = scipy_io.loadmat(tmp_path / "out.mat")
    assert content["samples"].shape == (100, 6)
    assert content["names"][2, 0][0] == "force"
    assert_allclose(content["samples"][:, 2] * 1e3, recording.samples()[2])


def test_mat_that_is_too_long_is_refused(tmp_path, monkeypatch):
    from shakerproc.recordings import writers

    monkeypatch.setattr(writers, "LARGEST", 100)
    with pytest.raises(RecordingError, match=r"more than a \.mat file can hold"):
        write_mat(tmp_path / "out.mat", example(100))
    assert not list(tmp_path.iterdir())


def test_uff_is_what_pyuff_reads(tmp_path):
    recording = example(100)
    write_uff(tmp_path / "out.uff", recording)
    records = pyuff.UFF(str(tmp_path / "out.uff")).read_sets()
    assert [r["id1"] for r in records] == [c.name for c in CHANNELS]
    assert records[0]["ordinate_spec_data_type"] == 12
    assert_array_equal(records[5]["data"], recording.samples()[5])


def test_a_failed_write_leaves_nothing(tmp_path):
    class BrokenError(Exception):
        pass

    recording = example(200_000)

    class BreakingSource(SampleSource):
        def read(self, rows, start, stop):
            if start:
                raise BrokenError
            return recording.source.read(rows, start, stop)

        def close(self):
            pass

    for ending, write in WRITERS.items():
        path = tmp_path / f"out{ending}"
        path.write_bytes(b"old")
        with pytest.raises(BrokenError):
            write(path, replace(recording, source=BreakingSource()))
        assert path.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == len(WRITERS)


def test_sha256_is_that_of_the_standard(tmp_path):
    path = tmp_path / "abc"
    path.write_bytes(b"abc")  # FIPS 180-2, appendix B.1
    assert sha256(path) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    with pytest.raises(RecordingError, match="cannot be read"):
        sha256(tmp_path / "none")
