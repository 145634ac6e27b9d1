"""HDF5 and netCDF-4, as h5py, the netCDF conventions and Rattlesnake write them.

Oracle: the numbers that are written here by h5py.
"""

from datetime import UTC, datetime

import h5py
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, Sampling, open_recording

RATE = 2000.0
VALUES = np.random.default_rng(45).standard_normal((3, 400))


def rattlesnake(path, streams, values=VALUES):
    """A file as the streaming process of Rattlesnake lays it out."""
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = np.int64(RATE)
        file.attrs["hardware"] = 0
        for number in range(streams):
            name = f"time_data_{number}" if number else "time_data"
            file.create_dataset(
                name, data=values * (number + 1), chunks=(1, 128), maxshape=(3, None)
            )
        file["environment_active_channels"] = np.ones((3, 1), "i1")
        table = file.create_group("channels")
        table["control"] = np.zeros(3, "i1")
        text = h5py.string_dtype()
        for key, column in (
            ("node_number", ["1", "2", "2"]), ("node_direction", ["Z+", "X+", "Y+"]),
            ("unit", ["N", "g", "g"]), ("comment", ["", "", ""]),
        ):  # fmt: skip
            table.create_dataset(key, data=column, dtype=text)
        file.create_group("modal")["frf_window"] = np.hanning(64)


@pytest.fixture
def save(tmp_path):
    def save(fill, name="run.h5"):
        with h5py.File(tmp_path / name, "w") as file:
            fill(file)
        return tmp_path / name

    return save


def described(recording):
    return [(channel.name, channel.unit) for channel in recording.channels]


def test_data_sets_beside_each_other_are_channels_and_attributes_say_the_rest(save):
    def fill(file):
        file.attrs["Sampling Rate"] = RATE
        file.attrs["start_time"] = "2026-11-27T10:00:00.5+01:00"
        for name, row in zip("abc", VALUES, strict=True):
            file[name] = row
            file[name].attrs["units"] = "g"
        file["b"].attrs["long"] = "x"

    with open_recording(save(fill)) as recording:
        assert recording.sample_rate == RATE
        assert recording.start_time == datetime(2026, 11, 27, 9, 0, 0, 500_000, tzinfo=UTC)
        assert described(recording) == [(name, "m/s^2") for name in "abc"]
        assert_allclose(recording.samples(), VALUES * STANDARD_GRAVITY, rtol=1e-15)
        assert_allclose(recording.samples(90, 110), VALUES[:, 90:110] * STANDARD_GRAVITY)


@pytest.mark.parametrize("upright", [True, False])
@pytest.mark.parametrize("packed", [None, "gzip"])
def test_the_columns_of_an_array_have_names_and_units_of_their_own(save, upright, packed):
    def fill(file):
        values = VALUES.T if upright else VALUES
        data = file.create_dataset("acc", data=values, chunks=True, compression=packed)
        data.attrs.update({
            "units": ["N", "g", "V"],
            "names": ["load", "tip", "ai"],
            "dt": 5e-4,
        })

    with open_recording(save(fill)) as recording:
        assert recording.sample_rate == RATE
        assert described(recording) == [("load", "N"), ("tip", "m/s^2"), ("ai", "V")]
        factors = np.array([[1.0], [STANDARD_GRAVITY], [1.0]])
        assert_allclose(recording.samples(3, 77), VALUES[:, 3:77] * factors, rtol=1e-15)


def test_netcdf_says_scale_fill_and_since_when_its_times_count(save):
    counts = np.round(VALUES[0] * 1000.0).astype("i2")
    counts[5] = -32768

    def fill(file):
        file["time"] = np.arange(400) / RATE * 1e3
        file["time"].attrs["units"] = "milliseconds since 2026-01-01 00:00:00"
        file["acc"] = counts
        about = {"units": "m s-2", "scale_factor": 0.001, "add_offset": 0.25}
        file["acc"].attrs.update({**about, "_FillValue": np.int16(-32768)})
        file["axis"] = np.zeros(400, "f4")
        file["axis"].attrs["NAME"] = "This is a netCDF dimension but not a netCDF variable. 400"

    with open_recording(save(fill, "run.nc")) as recording:
        assert recording.sample_rate == RATE
        assert recording.start_time == datetime(2026, 1, 1, tzinfo=UTC)
        assert [channel.name for channel in recording.channels] == ["acc"]
        wanted = np.where(counts == -32768, np.nan, counts * 0.001 + 0.25)
        assert_array_equal(recording.samples()[0], wanted)


def test_a_group_is_chosen_by_its_name_and_has_its_own_rate(save):
    def fill(file):
        for name, rate in (("fast", RATE), ("slow", 100.0)):
            group = file.create_group(name)
            group.attrs["fs"] = rate
            group["x"] = VALUES[0] * rate

    path = save(fill)
    with pytest.raises(RecordingError, match=r"2 groups hold data: 'fast' .*2000 Hz.*'slow'"):
        open_recording(path)
    with open_recording(path, part=FilePart("slow")) as recording:
        assert recording.sample_rate == 100.0
        assert_array_equal(recording.samples()[0], VALUES[0] * 100.0)


def test_a_group_with_one_data_set_of_values_is_a_channel(save):
    def fill(file):
        for name, row in zip(("x", "y"), VALUES, strict=False):
            group = file.create_group(name)
            group["data"], group["time"] = row, np.arange(400) / RATE
            group.attrs["unit"] = "m/s^2"

    with open_recording(save(fill)) as recording:
        assert recording.sample_rate == RATE
        assert described(recording) == [("x", "m/s^2"), ("y", "m/s^2")]
        assert_array_equal(recording.samples(), VALUES[:2])


def test_a_file_of_rattlesnake_is_known_by_its_channel_table(tmp_path):
    rattlesnake(tmp_path / "one.nc4", 1)
    with open_recording(tmp_path / "one.nc4") as recording:
        assert recording.sample_rate == RATE
        assert described(recording) == [("1Z+", "N"), ("2X+", "m/s^2"), ("2Y+", "m/s^2")]
        factors = np.array([[1.0], [STANDARD_GRAVITY], [STANDARD_GRAVITY]])
        assert_allclose(recording.samples(), VALUES * factors, rtol=1e-15)
    rattlesnake(tmp_path / "two.nc4", 2)
    with open_recording(tmp_path / "two.nc4", part=FilePart("time_data_1")) as recording:
        assert_allclose(recording.samples(), 2.0 * VALUES * factors, rtol=1e-15)


def test_what_the_file_does_not_say_is_asked_for(save):
    def fill(file):
        file["x"] = VALUES[0]
        file.attrs["t0"] = "noon"

    path = save(fill)
    with pytest.raises(RecordingError, match=r"run.h5: .*sample rate"):
        open_recording(path)
    with open_recording(path, sample_rate=Sampling(RATE)) as recording:
        assert any("'t0' is 'noon', no date" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"CDF\x01" + b"\0" * 60, r"is netCDF of version 3, not 4. Convert it: nccopy"),
        (b"\xd0\xcf\x11\xe0" * 200, r"opening the file failed: .*signature"),
        (b"", r"opening the file failed|the file is empty"),
    ],
)
def test_what_is_no_hdf5_is_refused_in_one_line(tmp_path, content, match):
    path = tmp_path / "run.nc"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=rf"run.nc: .*({match})") as caught:
        open_recording(path)
    assert str(caught.value).isprintable()


def test_a_link_out_of_the_file_and_a_spectrum_are_no_channels(save):
    def fill(file):
        file["x"], file["spectrum"] = VALUES[0], VALUES[1, :50]
        file["x"].attrs["sample_rate"] = RATE
        file["away"] = h5py.ExternalLink("other.h5", "/x")
        file["complex"] = VALUES[0] + 1j

    with open_recording(save(fill)) as recording:
        assert [channel.name for channel in recording.channels] == ["x"]
        assert any("'complex', 'spectrum'" in note for note in recording.notes)
