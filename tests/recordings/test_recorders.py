"""Files of recorders: values to the last digit, rate, start, units; what is wrong in one line.

The oracle is what was written, by the format's own library where it can write.
"""

import builtins
import os
from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from tests.recordings.recorder_files import rpc3_bytes, write_famos, write_ide, write_mdf

from shakerproc import late
from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import READERS, FilePart, open_recording
from shakerproc.recordings.raw import Frames

RATE = 5000.0
START = datetime(2024, 5, 6, 7, 8, 9, 250000, tzinfo=UTC)


def noise(n_channels=2, n=3001):
    return np.random.default_rng(44).standard_normal((n_channels, n))


def refused(path, **options):
    """The one line with which a file is refused."""
    with pytest.raises(RecordingError) as caught:
        open_recording(path, **options)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(path.name)
    return line


@pytest.mark.parametrize("ending", sorted(READERS.known))
def test_an_empty_file_of_any_format_is_told_as_one(tmp_path, ending):
    (tmp_path / f"run{ending}").touch()
    assert "the file is empty (0 bytes)" in refused(tmp_path / f"run{ending}")


@pytest.fixture
def mf4(tmp_path):
    pytest.importorskip("asammdf", reason="needs the extra recorders")
    return tmp_path / "run.mf4"


@pytest.mark.parametrize(("version", "compression"), [("3.30", 0), ("4.10", 0), ("4.10", 2)])
def test_mdf_is_what_asammdf_wrote(mf4, version, compression):
    path = mf4 if version > "4" else mf4.with_suffix(".mdf")
    times, values = np.arange(3001) / RATE, noise()
    single = values[1].astype(np.float32)
    channels = [("control 1", "g", times, values[0]), ("ch3", "m/s^2", times, single)]
    write_mdf(path, [channels], START, version=version, compression=compression)
    with open_recording(path) as found:
        assert [c.name for c in found.channels] == ["control 1", "ch3"]
        assert [c.source_unit for c in found.channels] == ["g", "m/s^2"]
        assert (found.sample_rate, found.n_samples) == (RATE, 3001)
        assert found.start_time == START
        samples = found.samples()
        assert_array_equal(samples[0], values[0] * STANDARD_GRAVITY)
        assert_array_equal(samples[1], single.astype(np.float64))
        part = found.source.read([found.rows[1], found.rows[0]], 1500, 1600)
        assert_array_equal(part, samples[::-1, 1500:1600])


def test_groups_of_mdf_with_one_rate_are_one_and_others_are_chosen(mf4):
    fast, slow, values = np.arange(3001) / RATE, np.arange(300) / 100.0, noise(3)
    groups = [
        [("a", "g", fast, values[0])],
        [("temperature", "degC", slow, values[2, :300])],
        [("b", "g", fast, values[1])],
    ]
    write_mdf(mf4, groups, START)
    assert "2 groups hold data" in refused(mf4)
    with open_recording(mf4, part=FilePart("raster 2")) as found:
        assert [c.name for c in found.channels] == ["temperature"]
        assert found.sample_rate == 100.0
    with pytest.raises(RecordingError, match="no group 'none'"):
        open_recording(mf4, part=FilePart("none"))


def test_text_in_mdf_is_told_and_left_out(mf4):
    from asammdf import MDF, Signal

    times = np.arange(300) / RATE
    words = np.array([b"on"] * 300)
    with MDF() as file:
        file.append([
            Signal(noise()[0, :300], times, name="a", unit="g"),
            Signal(words, times, name="state", encoding="utf-8"),
        ])
        file.save(mf4)
    with open_recording(mf4) as found:
        assert [c.name for c in found.channels] == ["a"]
        assert [(c.name, c.why) for c in found.unused] == [
            ("state", "it holds text or arrays, not numbers")
        ]


def test_samples_that_mdf_says_are_not_valid_are_no_numbers(mf4):
    from asammdf import MDF, Signal

    times = np.arange(300) / RATE
    invalid = np.zeros(300, dtype=bool)
    invalid[17] = True
    with MDF() as file:
        file.append(Signal(noise()[0, :300], times, name="a", invalidation_bits=invalid))
        file.save(mf4)
    with open_recording(mf4) as found:
        assert_array_equal(np.isnan(found.samples()[0]), invalid)


@pytest.mark.parametrize("part", [0.0, 0.01, 0.3, 0.999])
def test_a_cut_mdf_is_one_line_and_nothing_is_left_on_the_terminal(mf4, part, capfd):
    write_mdf(mf4, [[("a", "g", np.arange(3001) / RATE, noise()[0])]])
    content = mf4.read_bytes()
    mf4.write_bytes(content[: int(part * len(content))])
    refused(mf4)
    assert capfd.readouterr() == ("", "")


def test_mdf_with_times_that_jump_asks_for_a_remedy(mf4):
    times = np.arange(3001) / RATE
    times[2000:] += 0.01
    write_mdf(mf4, [[("a", "g", times, noise()[0])]])
    assert "resample" in refused(mf4)


def test_dat_is_mdf_famos_or_a_table_by_its_first_bytes(mf4, tmp_path):
    pytest.importorskip("imctermite", reason="needs the extra recorders")
    path, values = tmp_path / "run.dat", noise()
    write_mdf(mf4, [[("a", "g", np.arange(3001) / RATE, values[0])]], version="3.30")
    path.write_bytes(mf4.with_suffix(".mdf").read_bytes())
    with open_recording(path) as found:
        assert_array_equal(found.samples()[0], values[0] * STANDARD_GRAVITY)
    write_famos(path, [("a", "g", values[0])], 1.0 / RATE, (6, 5, 2024, 7, 8, 9.25))
    with open_recording(path) as found:
        assert_array_equal(found.samples()[0], values[0] * STANDARD_GRAVITY)
    path.write_text("time [s],a [g]\n" + "".join(f"{i / 100},{i % 7}\n" for i in range(50)))
    with open_recording(path) as found:
        assert found.sample_rate == 100.0


def test_famos_is_what_was_written(tmp_path):
    pytest.importorskip("imctermite", reason="needs the extra recorders")
    path, values = tmp_path / "run.raw", noise()
    channels = [("control 1", "g", values[0]), ("ch3", "m/s^2", values[1])]
    write_famos(path, channels, 1.0 / RATE, (6, 5, 2024, 7, 8, 9.25))
    with open_recording(path) as found:
        assert [c.source_unit for c in found.channels] == ["g", "m/s^2"]
        assert (found.sample_rate, found.start_time) == (RATE, START)
        assert_array_equal(found.samples()[1], values[1])
        part = found.source.read([found.rows[1]], 1500, 1600)
        assert_array_equal(part[0], values[1, 1500:1600])


@pytest.mark.parametrize("left", [3, 300, 15_000, -9])
def test_a_cut_famos_file_is_one_line(tmp_path, left, capfd):
    pytest.importorskip("imctermite", reason="needs the extra recorders")
    path = tmp_path / "run.raw"
    write_famos(path, [("a", "g", noise()[0])], 1.0 / RATE, (6, 5, 2024, 7, 8, 9.25))
    path.write_bytes(path.read_bytes()[:left])
    refused(path)
    assert capfd.readouterr() == ("", "")


@pytest.fixture
def ide(tmp_path):
    pytest.importorskip("idelib", reason="needs the extra recorders")
    return tmp_path / "run.ide"


def test_ide_is_what_was_written(ide):
    values = noise(3, 4100).astype(np.float32)
    names = ("X", "Y", "Z")
    write_ide(ide, [(8, "Accelerometer", "g", names, RATE, values)], 1714979289)
    with open_recording(ide) as found:
        assert [c.name for c in found.channels] == list(names)
        assert (found.sample_rate, found.n_samples) == (RATE, 4100)
        assert found.start_time == START.replace(microsecond=0)
        assert_array_equal(found.samples(), values.astype(np.float64) * STANDARD_GRAVITY)
        part = found.source.read([found.rows[2]], 990, 2010)
        assert_array_equal(part, found.samples()[2:, 990:2010])


def test_sensors_of_ide_are_groups(ide):
    sensors = [
        (8, "Analog", "g", ("X",), RATE, noise(1).astype(np.float32)),
        (36, "Pressure", "Pa", ("P",), 10.0, noise(1, 60).astype(np.float32)),
    ]
    write_ide(ide, sensors, 1714979289)
    with open_recording(ide, part=FilePart("Pressure")) as found:
        assert (found.sample_rate, found.channels[0].unit) == (10.0, "Pa")
    assert "Analog" in refused(ide)


def test_a_slice_of_ide_is_that_of_the_whole_file_in_its_library(ide):
    """Calibrated by a polynomial of its own and of the temperature, which is slower."""
    from idelib.importer import importFile

    by_temperature = [
        ("CalID", 8), ("BivariateChannelIDRef", 36), ("BivariateSubChannelIDRef", 0),
        ("CalReferenceValue", 0.5), ("BivariateCalReferenceValue", 20.0),
        *(("PolynomialCoef", one) for one in (-0.003, 2.0, 0.1, 0.25)),
    ]  # fmt: skip
    own = [("CalID", 36), ("PolynomialCoef", 0.5), ("PolynomialCoef", 20.0)]
    values = noise(3, 4100).astype(np.float32)
    warming = np.linspace(0.0, 10.0, 60, dtype=np.float32)[None]
    sensors = [
        (8, "A", "g", ("X", "Y", "Z"), RATE, values),
        (36, "T", "degC", ("T",), 30.0, warming),
    ]
    calibrations = [("BivariatePolynomial", by_temperature), ("UnivariatePolynomial", own)]
    write_ide(ide, sensors, 1714979289, block=37, calibrations=calibrations)
    with importFile(str(ide)) as whole:
        expected = whole.channels[8].getSession().arraySlice()[1:] * STANDARD_GRAVITY
    with open_recording(ide, part=FilePart("A")) as found:
        for first, last in [(0, 4100), (0, 1), (36, 38), (1000, 3000), (4099, 4100)]:
            part = found.source.read(found.rows, first, last)
            assert_array_equal(part, expected[:, first:last])
    assert np.abs(expected / STANDARD_GRAVITY - values).max() > 0.1  # calibrated


def test_ide_with_one_sample_in_a_block_has_the_times_of_its_blocks(ide):
    values = noise(1, 300).astype(np.float32)
    write_ide(ide, [(8, "A", "g", ("X",), 50.0, values)], 1714979289, block=1)
    with open_recording(ide) as found:
        assert found.sample_rate == 50.0
        part = found.source.read(found.rows, 7, 11)
        assert_array_equal(part, values[:, 7:11].astype(float) * STANDARD_GRAVITY)


def test_of_an_ide_cut_in_a_block_the_whole_blocks_are_read(ide):
    values = noise(1, 4500).astype(np.float32)
    write_ide(ide, [(8, "A", "g", ("X",), RATE, values)], 1714979289)
    ide.write_bytes(ide.read_bytes()[:-300])
    with open_recording(ide) as found:
        assert (found.n_samples, found.expected_samples) == (4000, 4500)
        assert_array_equal(found.samples(), values[:, :4000].astype(float) * STANDARD_GRAVITY)


@pytest.mark.parametrize("part", [0.0, 0.01, 0.1, 0.2])
def test_a_cut_ide_is_one_line_and_nothing_is_left_on_the_terminal(ide, part, capfd):
    write_ide(ide, [(8, "A", "g", ("X",), RATE, noise(1).astype(np.float32))], 1714979289)
    content = ide.read_bytes()
    ide.write_bytes(content[: int(part * len(content))])
    refused(ide)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", [int, float])
def test_rpc3_is_what_its_python_package_writes(tmp_path, kind):
    rpc3 = pytest.importorskip("rpc3", reason="needs rpc3-file")
    rpc3.rpc3.progressbar = False
    values = noise(2, 5000)
    written = [
        rpc3.Channel(name=name, unit=unit, dt=1.0 / RATE, data=line)
        for name, unit, line in zip(["a", "b"], ["g", "m/s^2"], values, strict=True)
    ]
    path = tmp_path / "run.rsp"
    rpc3.write(str(path), written, datatype=kind, pts_per_group=256)
    channels, _ = rpc3.read(str(path))
    with open_recording(path) as found:
        assert [c.source_unit for c in found.channels] == ["g", "m/s^2"]
        assert (found.sample_rate, found.n_samples) == (RATE, 5000)
        other = np.asarray(channels[1].data, dtype=np.float64)  # rounded to single there
        assert_array_equal(found.samples()[1].astype(np.float32), other.astype(np.float32))
        part = found.source.read([found.rows[1]], 200, 1300)
        assert_array_equal(part[0], found.samples()[1, 200:1300])


@pytest.mark.parametrize("order", ["<", ">"])
def test_rpc3_of_either_byte_order_is_counts_times_scale(tmp_path, order):
    counts = np.random.default_rng(1).integers(-32752, 32752, (2, 150))
    path = tmp_path / "run.rpc"
    path.write_bytes(rpc3_bytes(counts, [0.001, 0.0005], 0.001, order=order))
    with open_recording(path) as found:
        expected = counts * np.array([[0.001], [0.0005]]) * STANDARD_GRAVITY
        assert_array_equal(found.samples(), expected)
        assert (found.sample_rate, found.incomplete) == (1000.0, False)
    path.write_bytes(path.read_bytes()[:-300])  # groups have 256 bytes: two are torn
    with open_recording(path) as found:
        assert (found.n_samples, found.expected_samples) == (64, 150)


def as_rpc3(path, values, kind, said, stored):
    """Write values (n_channels, n) as RPC III that says one byte order and holds another."""
    changed = {"FORMAT": said, "DATA_TYPE": kind}
    head = rpc3_bytes(np.zeros((len(values), 256), int), [1.0] * len(values), 0.001,
                      per_group=256, changed=changed)[: 8 * 512]  # fmt: skip
    path.write_bytes(head + values.astype(stored).tobytes())


BOTH = {"BINARY": "<", "BINARY_IEEE_LITTLE_END": "<", "BINARY_IEEE_BIG_END": ">"}
MOVING = np.cumsum(np.random.default_rng(2).standard_normal((3, 256)), axis=1)
STEADY = np.random.default_rng(3).standard_normal((3, 256))


@pytest.mark.parametrize("said", BOTH)
@pytest.mark.parametrize(
    ("kind", "values", "stored"),
    [
        ("SHORT_INTEGER", MOVING * 1000.0, "i2"),
        ("SHORT_INTEGER", MOVING, "i2"),  # a few counts: one byte holds them
        ("SHORT_INTEGER", STEADY * 2000.0, "i2"),
        ("FLOATING_POINT", MOVING, "f4"),
        ("FLOATING_POINT", STEADY * 1e-6, "f4"),
        ("FLOATING_POINT", np.rint(STEADY), "f4"),  # whole numbers, many of them zero
    ],
)
def test_rpc3_of_another_byte_order_than_it_says_is_refused(
    tmp_path, said, kind, values, stored
):
    path = tmp_path / "run.rsp"
    as_rpc3(path, values, kind, said, BOTH[said] + stored)
    with open_recording(path) as found:
        expected = values.astype(stored).astype(float) * STANDARD_GRAVITY
        assert_array_equal(found.samples(), expected)
    as_rpc3(path, values, kind, said, {"<": ">", ">": "<"}[BOTH[said]] + stored)
    line = refused(path)
    assert f"FORMAT says '{said}'" in line
    assert "the order is wrong" in line


def test_rpc3_with_floats_of_vms_is_refused(tmp_path):
    """F floating of a VAX: words of 16 bits the other way round, and four times as large."""
    path = tmp_path / "run.rsp"
    words = (STEADY * 4.0).astype("<f4").view("<u2").reshape(3, -1, 2)[..., ::-1]
    as_rpc3(path, np.ascontiguousarray(words), "FLOATING_POINT", "BINARY", "<u2")
    assert "the order is wrong" in refused(path)


def test_numbers_that_do_not_show_their_byte_order_are_read_as_rpc3_says(tmp_path):
    path = tmp_path / "run.rsp"
    values = np.random.default_rng(4).integers(-32752, 32752, (1, 256))
    as_rpc3(path, values, "SHORT_INTEGER", "BINARY_IEEE_BIG_END", ">i2")
    with open_recording(path) as found:
        assert_array_equal(found.samples(), values * STANDARD_GRAVITY)


def test_of_rpc3_in_one_group_no_more_is_read_than_is_asked_for(tmp_path, monkeypatch):
    values, path, read = np.cumsum(noise(2, 100_000), axis=1) * 10.0, tmp_path / "run.rsp", []
    path.write_bytes(rpc3_bytes(np.rint(values), [1.0, 1.0], 0.001, per_group=100_000))
    plain = Frames._numbers

    def counted(self, first, count):
        read.append(count)
        return plain(self, first, count)

    monkeypatch.setattr(Frames, "_numbers", counted)
    with open_recording(path) as found:
        part = found.source.read(found.rows, 40_000, 41_000)
    assert_array_equal(part, np.rint(values[:, 40_000:41_000]) * STANDARD_GRAVITY)
    assert max(read) <= 1024


def test_rpc3_that_shrinks_while_it_is_read_is_one_line(tmp_path):
    path = tmp_path / "run.rsp"
    path.write_bytes(rpc3_bytes(np.zeros((2, 150_000), int), [1.0, 1.0], 0.001))
    found = open_recording(path)
    os.truncate(path, 5000)
    with pytest.raises(RecordingError, match="shorter"):
        found.samples()
    found.source.close()


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"FORMAT": "BINARY_VAX"}, "BINARY_VAX"),
        ({"FORMAT": "ASCII"}, "ASCII"),
        ({"FILE_TYPE": "PSD"}, "holds 'PSD', no time history"),
        ({"DELTA_T": "fast"}, "DELTA_T 'fast'"),
        ({"DELTA_T": "0"}, "DELTA_T"),
        ({"CHANNELS": "-1"}, "CHANNELS"),
        ({"CHANNELS": "70000"}, "ends before its first samples"),
        ({"SAMPLES": "999"}, "999 samples in 192 places"),
        ({"PTS_PER_FRAME": "48"}, "do not fit"),
        ({"NUM_PARAMS": "99999"}, "no fit"),
        ({"PARTITIONS": "2"}, "PARTITIONS is '2'"),
        ({"HALF_FRAMES": "1"}, "HALF_FRAMES is '1'"),
        ({"SCALE.CHAN_1": "inf"}, "SCALE.CHAN_1"),
    ],
)
def test_what_is_wrong_with_rpc3_is_one_line(tmp_path, changed, told):
    path = tmp_path / "run.rsp"
    counts = np.zeros((2, 150), int)
    path.write_bytes(rpc3_bytes(counts, [0.001, 0.0005], 0.001, changed=changed))
    assert told in refused(path)


@pytest.mark.parametrize(
    ("name", "package"),
    [("a.mf4", "asammdf"), ("a.ide", "idelib"), ("a.raw", "imctermite")],
)
def test_a_missing_extra_is_one_line_with_the_command(tmp_path, monkeypatch, name, package):
    monkeypatch.setattr(late, "find_spec", lambda _: None)
    path = tmp_path / name
    path.write_bytes(b"anything")
    line = refused(path)
    assert f"needs {package}: pip install 'shakerproc[recorders]'" in line


def test_readers_of_recorders_load_their_package_only_for_their_files(tmp_path, monkeypatch):
    plain = builtins.__import__

    def watched(name, *more, **options):
        assert name.partition(".")[0] not in {"asammdf", "idelib", "imctermite"}
        return plain(name, *more, **options)

    monkeypatch.setattr(builtins, "__import__", watched)
    path = tmp_path / "a.rsp"
    path.write_bytes(rpc3_bytes(np.zeros((1, 70), int), [1.0], 0.001))
    with open_recording(path) as found:
        assert found.n_samples == 70


@pytest.mark.long
def test_an_mdf_beyond_200_mb_is_read_like_a_small_one(tmp_path):
    """From that size on asammdf takes another way through files that it opened itself."""
    times = np.arange(13_200_000) / 1e4
    write_mdf(tmp_path / "a.mf4", [[("a", "g", times, np.sin(times))]])
    assert (tmp_path / "a.mf4").stat().st_size > 200 << 20
    with open_recording(tmp_path / "a.mf4") as found:
        last = found.source.read(found.rows, times.size - 3, times.size)
    assert_array_equal(last[0], np.sin(times[-3:]) * STANDARD_GRAVITY)
