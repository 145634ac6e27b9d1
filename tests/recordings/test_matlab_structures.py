"""MATLAB files as Simulink and measuring programs write them, in versions 5 and 7.3.

Written by scipy and h5py; right is what was put in.
"""

import h5py
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import io as scipy_io

from shakerproc.data import STANDARD_GRAVITY, ChannelUse
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording

RATE = 2000.0
T = np.arange(400) / RATE
Y = np.random.default_rng(36).standard_normal((2, 400))


def in_hdf5(path, content):
    """Write nested variables as MATLAB does in 7.3: arrays of structures by reference."""
    with h5py.File(path, "w", userblock_size=512) as file:
        counter = iter(range(10**6))

        def put(group, name, value):
            if isinstance(value, dict):
                inner = group.create_group(name)
                inner.attrs["MATLAB_class"] = np.bytes_("struct")
                for key, item in value.items():
                    put(inner, key, item)
            elif isinstance(value, str):
                codes = np.array([[ord(letter)] for letter in value], dtype=np.uint16)
                group.create_dataset(name, data=codes).attrs["MATLAB_class"] = np.bytes_("char")
            elif isinstance(value, list):
                inner = group.create_group(name)
                inner.attrs["MATLAB_class"] = np.bytes_("struct")
                for key in value[0]:
                    refs = []
                    for item in value:
                        place = f"r{next(counter)}"
                        put(file.require_group("#refs#"), place, item[key])
                        refs.append(file["#refs#"][place].ref)
                    inner.create_dataset(key, data=np.array([refs], dtype=h5py.ref_dtype))
            else:
                data = np.atleast_2d(np.asarray(value, dtype=float)).T
                made = group.create_dataset(name, data=data)
                made.attrs["MATLAB_class"] = np.bytes_("double")

        for name, value in content.items():
            put(file, name, value)
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM"
    with path.open("r+b") as raw:
        raw.write(head)


def in_version_5(path, content):
    def plain(value):
        if isinstance(value, list):
            made = np.empty(len(value), dtype=object)
            made[:] = [plain(item) for item in value]
            names = list(value[0])
            array = np.zeros(len(value), dtype=[(name, object) for name in names])
            for number, item in enumerate(value):
                for name in names:
                    array[number][name] = plain(item[name])
            return array
        if isinstance(value, dict):
            return {key: plain(item) for key, item in value.items()}
        return np.atleast_2d(value).T if isinstance(value, np.ndarray) else value

    scipy_io.savemat(path, {name: plain(value) for name, value in content.items()})


every_version = pytest.mark.parametrize("save", [in_version_5, in_hdf5])


@every_version
def test_a_structure_with_time_of_simulink_gives_its_signals_by_their_labels(tmp_path, save):
    signals = [
        {"values": Y[0], "dimensions": np.array([1.0]), "label": "base"},
        {"values": Y[1], "dimensions": np.array([1.0]), "label": "top"},
    ]
    save(tmp_path / "run.mat", {"ScopeData": {"time": T, "signals": signals}})
    with open_recording(tmp_path / "run.mat") as recording:
        assert [c.name for c in recording.channels] == ["base", "top"]
        assert_allclose(recording.sample_rate, RATE, rtol=1e-12)
        assert_allclose(recording.samples(), Y, rtol=1e-12)


@every_version
def test_a_structure_of_one_signal_with_two_columns_numbers_them(tmp_path, save):
    signals = {"values": Y.T.copy() if save is in_hdf5 else Y, "label": "acc"}
    content = {"simout": {"time": T, "signals": signals}}
    if save is in_hdf5:
        content["simout"]["signals"]["values"] = Y
    save(tmp_path / "run.mat", content)
    with open_recording(tmp_path / "run.mat") as recording:
        assert [c.name for c in recording.channels] == ["acc 1", "acc 2"]
        assert_allclose(recording.samples(), Y, rtol=1e-12)


@every_version
def test_a_timeseries_made_a_structure_keeps_its_unit_and_that_of_its_times(tmp_path, save):
    one = {
        "Name": "table", "Time": 1e3 * T, "Data": Y[0],
        "TimeInfo": {"Units": "milliseconds", "Start": 0.0}, "DataInfo": {"Units": "g"},
    }  # fmt: skip
    save(tmp_path / "run.mat", {"ts": one})
    with open_recording(tmp_path / "run.mat") as recording:
        assert [(c.name, c.unit) for c in recording.channels] == [("table", "m/s^2")]
        assert_allclose(recording.sample_rate, RATE, rtol=1e-9)
        assert_allclose(recording.samples()[0], Y[0] * STANDARD_GRAVITY, rtol=1e-12)


@every_version
def test_elements_of_a_data_set_that_have_each_their_own_times_are_read(tmp_path, save):
    elements = [
        {"Name": name, "Values": {"Time": T, "Data": row}}
        for name, row in zip(("in", "out"), Y, strict=True)
    ]
    save(tmp_path / "run.mat", {"logsout": elements})
    with open_recording(tmp_path / "run.mat") as recording:
        assert [c.name for c in recording.channels] == ["in", "out"]
        assert_allclose(recording.samples(), Y, rtol=1e-12)


@every_version
@pytest.mark.parametrize("rate", [{}, {"Sample_rate": np.array([RATE])}])
def test_channels_with_times_called_after_them_are_read(tmp_path, save, rate):
    content = {
        "Data1_AI_1": Y[0], "Data1_AI_2": Y[1], "Data1_time_AI_1": T,
        "Data1_time_AI_2": T, **rate,
    }  # fmt: skip
    save(tmp_path / "run.mat", content)
    with open_recording(tmp_path / "run.mat") as recording:
        assert [c.name for c in recording.channels] == ["Data1_AI_1", "Data1_AI_2"]
        assert_allclose(recording.sample_rate, RATE, rtol=1e-9)
        assert_allclose(recording.samples(), Y, rtol=1e-12)


@every_version
def test_scopes_of_two_rates_each_have_their_own(tmp_path, save):
    content = {
        "fast": {"time": T, "signals": {"values": Y[0], "label": "a"}},
        "slow": {"time": 2.0 * T, "signals": {"values": Y[1], "label": "b"}},
    }
    save(tmp_path / "run.mat", content)
    for name, rate in (("a", RATE), ("b", RATE / 2.0)):
        uses = [ChannelUse(name, "response", unit="g")]
        with open_recording(tmp_path / "run.mat", uses=uses) as recording:
            assert_allclose(recording.sample_rate, rate, rtol=1e-9)


def test_a_vector_of_three_axes_is_a_vector(tmp_path):
    scipy_io.savemat(tmp_path / "run.mat", {"ts": {"Time": T[:, None], "Data": Y[:1, None, :]}})
    with open_recording(tmp_path / "run.mat") as recording:
        assert_allclose(recording.samples()[0], Y[0], rtol=1e-12)


def test_an_object_of_matlab_is_named_with_what_to_do(tmp_path):
    path = tmp_path / "run.mat"
    in_hdf5(path, {"ts": np.arange(6.0)})
    with h5py.File(path, "r+") as file:
        file["ts"].attrs["MATLAB_class"] = np.bytes_("timeseries")
        file["ts"].attrs["MATLAB_object_decode"] = np.int32(3)
    with pytest.raises(RecordingError, match=r"object of class timeseries.*as vectors"):
        open_recording(path)


def test_a_damaged_chunk_names_file_and_variable(tmp_path):
    path = tmp_path / "run.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("fs", data=[[RATE]])
        data = file.create_dataset("acc", data=Y[:1].T, chunks=(400, 1), compression="gzip")
        offset, size = data.id.get_chunk_info(0).byte_offset, data.id.get_chunk_info(0).size
    with path.open("r+b") as raw:
        raw.seek(offset + size // 2)
        raw.write(bytes(64))
    with (
        pytest.raises(RecordingError, match=r"run\.mat: reading variable 'acc' failed"),
        open_recording(path) as recording,
    ):
        recording.samples()


def test_numbers_of_no_processor_are_damage(tmp_path):
    """As `make fuzz` found it: a bit of the exponent's bias makes 1000 Hz 256000 Hz."""
    path = tmp_path / "run.mat"
    kind = h5py.h5t.IEEE_F64LE.copy()
    kind.set_ebias(1023 - 8)
    with h5py.File(path, "w", userblock_size=512) as file:
        file["acc"] = Y[:1].T.astype(">f4")
        file["count"] = np.arange(8, dtype=np.uint16)
    with open_recording(path, sample_rate=RATE) as recording:
        assert_allclose(recording.samples()[0], Y[0].astype(np.float32), rtol=1e-6)
    with h5py.File(path, "r+") as file:
        rate = h5py.h5d.create(file.id, b"fs", kind, h5py.h5s.create_simple((1, 1)))
        rate.write(h5py.h5s.ALL, h5py.h5s.ALL, np.array([[RATE / 256.0]]))
    with pytest.raises(RecordingError, match=r"run\.mat: variable 'fs' .* no program writes"):
        open_recording(path)
