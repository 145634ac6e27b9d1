"""CSV, LVM, MATLAB, NumPy, UFF and Parquet: what is found in them, and what is refused."""

import re

import numpy as np
import pyarrow
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from pyarrow import feather
from pyarrow import parquet as arrow_parquet
from scipy import io as scipy_io

from shakerproc.data import STANDARD_GRAVITY, Channel, ChannelUse, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import (
    Sampling,
    health,
    matlab,
    open_recording,
    parquet,
    text_format,
    times,
    write_parquet,
    write_uff,
)
from shakerproc.recordings.raw import Frames


@pytest.fixture
def write(tmp_path):
    def write(content, name="run.csv"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def refused(path, match, **options):
    with pytest.raises(RecordingError, match=match) as caught, open_recording(path, **options):
        pass
    assert str(caught.value).isprintable()


ROWS = [(0.0, 1.5, -2.0), (0.01, 2.5, -3.0), (0.02, 3.5, -4.0)]


def table(delimiter, decimal, head):
    lines = [delimiter.join(str(v).replace(".", decimal) for v in row) for row in ROWS]
    return "\n".join([*head, *lines, ""])


@pytest.mark.parametrize(
    ("delimiter", "decimal"),
    [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", ".")],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_delimiter_decimal_sign_and_encoding_are_found(write, delimiter, decimal, encoding):
    head = delimiter.join(["time[s]", "a[g]", "kraft_n"])
    path = write(table(delimiter, decimal, [head]).encode(encoding))
    with open_recording(path) as recording:
        assert recording.sample_rate == 100.0
        assert [(c.name, c.unit) for c in recording.channels] == [
            ("a", "m/s^2"),
            ("kraft", "N"),
        ]
        assert_allclose(
            recording.samples()[0],
            [1.5 * STANDARD_GRAVITY, *[2.5 * STANDARD_GRAVITY, 3.5 * STANDARD_GRAVITY]],
        )
        assert_array_equal(recording.samples()[1], [-2.0, -3.0, -4.0])


@pytest.mark.parametrize(
    "head",
    [
        ["Time (s),a (g),b (N)"],
        ["timestamp,a,b", "seconds,g,N"],
        ["Time,a,b", "[s],[g],[N]"],
        ["Time,a,b", "(s),(g),(N)"],
        ["Device,x,y", "Rate: 100", "", "t,a [g],b [N]"],
        ["sep=,", "Recorder 5", "# comment", "t_s,a_g,b_n"],
        ['"Time [s]","a [g]","b [N]"'],
        ['t,"a [g]",\'=b [N]'],
    ],
)
def test_headers_and_units_are_found(write, head):
    with open_recording(write(table(",", ".", head))) as recording:
        assert [c.unit for c in recording.channels] == ["m/s^2", "N"]
        assert [c.name.strip("=") for c in recording.channels] == ["a", "b"]
        assert recording.sample_rate == 100.0


@pytest.mark.parametrize("decimal", [".", ","])
def test_numbers_are_read_to_the_last_digit(write, decimal):
    """Oracle: Python's own reading of the same text."""
    rng = np.random.default_rng(5)
    values = rng.standard_normal(2000) * 10.0 ** rng.integers(-9, 9, 2000)
    written = [repr(value) for value in values.tolist()]
    rows = [f"{i / 1000:.3f};{text}".replace(".", decimal) for i, text in enumerate(written)]
    path = write("\n".join(["time[s];a[m/s^2]", *rows, ""]))
    with open_recording(path) as recording:
        assert_array_equal(recording.samples()[0], [float(text) for text in written])


def test_a_column_answers_to_its_whole_header_too(write):
    path = write(table(",", ".", ["t,ch3_g,b [N]"]))
    for key in ("ch3", "ch3_g"):
        with open_recording(path, uses=[ChannelUse(key, "response", name="x")]) as recording:
            assert recording.channels[0].name == "x"


@pytest.mark.parametrize(
    ("of_names", "of_rows"), [("", ";"), (";", ""), (";", ";"), (";;", ";")]
)
def test_a_delimiter_at_the_end_of_names_or_rows_loses_no_name(write, of_names, of_rows):
    rows = "".join(f"{i / 100:.2f};{i}.5{of_rows}\n" for i in range(20))
    with open_recording(write(f"time [s];a [N]{of_names}\n{rows}")) as recording:
        assert [(c.name, c.unit) for c in recording.channels] == [("a", "N")]
        assert recording.sample_rate == 100.0


def test_between_blanks_a_unit_belongs_to_the_name_before_it(write):
    rows = "".join(f"{i / 100:.2f} {i}.5 7.25\n" for i in range(20))
    with open_recording(write(f"time [s] a (N) b [m/s^2]\n{rows}")) as recording:
        assert [(c.name, c.unit) for c in recording.channels] == [("a", "N"), ("b", "m/s^2")]
        assert recording.sample_rate == 100.0


def test_names_that_do_not_fit_the_columns_are_refused(write):
    rows = "".join(f"{i},{i / 100:.2f},{i}.5\n" for i in range(20))
    refused(write(f"time [s],a [N]\n{rows}"), "line 1 names 2 columns .* have 3. Give each")
    rows = "".join(f"{i / 100:.2f},{i}.5\n".replace(".", ",") for i in range(20))
    refused(write(f"time [s],a [N]\n{rows}"), "names 2 columns .* have 4. Numbers with decimal")


def test_without_headers_or_time_the_log_must_say_it(write):
    path = write(table(",", ".", []))
    refused(path, "no sample rate for channel 'column 1'")
    with open_recording(path, sample_rate=10.0) as recording:
        assert len(recording.channels) == 3


def test_two_rates_side_by_side_are_brought_to_one_or_one_is_left_out(write):
    fast, slow = np.arange(2000) / 1000.0, np.arange(200) / 100.0
    lines = [f"{t:.3f},{np.sin(40.0 * t):.9f}" for t in fast]
    lines = [
        f"{line},{slow[i]:.2f},{np.cos(20.0 * slow[i]):.9f}" if i < 200 else f"{line},,"
        for i, line in enumerate(lines)
    ]
    path = write("\n".join(["Time [s],acc [g],Time [s],load [N]", *lines, ""]))
    refused(path, "'acc' has 1000 samples per second, 'load' 100.*resample")
    with open_recording(path, uses=[ChannelUse("load", "force")]) as recording:
        assert recording.sample_rate == 100.0
        assert_allclose(recording.samples()[0], np.cos(20.0 * slow), atol=1e-9)
    with open_recording(path, sample_rate=Sampling(resample=100.0)) as recording:
        acc, load = recording.samples()
        at = min(
            (np.arange(n, n + load.size) / 100.0 for n in range(200 - load.size + 1)),
            key=lambda times: np.abs(np.cos(20.0 * times) - load).max(),
        )
        assert_allclose(load, np.cos(20.0 * at), atol=1e-3)
        assert_allclose(acc, STANDARD_GRAVITY * np.sin(40.0 * at), atol=0.02)


def test_a_torn_last_row_is_left_out_and_marked(write):
    whole = table(",", ".", ["t [s],a [g],b [N]"])
    with open_recording(write(whole[: whole.rindex(",")])) as recording:
        assert (recording.n_samples, recording.expected_samples) == (2, 3)
        assert "not whole" in recording.notes[0]


def test_a_last_number_that_may_be_cut_is_left_out_or_noted(write):
    rows = "".join(f"{i / 100:.2f},{i}.2500\n" for i in range(20))
    whole = "t [s],a [N]\n" + rows
    for lost, n, expected in ((0, 20, None), (1, 20, None), (2, 19, 20), (4, 19, 20)):
        with open_recording(write(whole[: len(whole) - lost])) as recording:
            assert (recording.n_samples, recording.expected_samples) == (n, expected)
            assert_array_equal(recording.samples()[0], np.arange(n) + 0.25)
            assert any("may be cut" in note for note in recording.notes) == (lost == 1)


def test_a_time_column_with_a_gap_is_refused(write):
    lines = ["t [s],a [g]", *(f"{t},1.0" for t in (0, 0.1, 0.2, 0.3, 0.9, 1.0, 1.1))]
    refused(write("\n".join(lines)), "time column 't' does not advance evenly")
    lines = ["t [s],a [g]", *(f"{t},1.0" for t in (0.3, 0.2, 0.1))]
    refused(write("\n".join(lines)), "does not advance")


def test_a_lost_second_is_said_beside_the_usual_step(write):
    times = np.arange(400) / 100.0
    times[150:] += 1.0
    rows = "\n".join(f"{t:.2f},1" for t in times)
    refused(write(f"t [s],a [g]\n{rows}\n"), r"149 to 150 it takes 1.01 s, most often 0.01 s")


@pytest.mark.parametrize("rate", [5688.888888888889, 1000.0, 30.0])
@pytest.mark.parametrize("digits", [4, 6, 9])
def test_a_rounded_time_column_gives_the_rate(write, rate, digits):
    n = int(20 * rate)
    times = np.round(np.arange(n) / rate, digits)
    if digits < np.log10(4 * rate):
        pytest.skip("rounded beyond the sample interval")
    path = write("t [s],a [g]\n" + "\n".join(f"{t:.{digits}f},1" for t in times))
    with open_recording(path) as recording:
        assert recording.sample_rate == pytest.approx(rate, rel=2 * 10**-digits / 20)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "empty"),
        (b"hello world\nthis is no table\n", "no table of numbers"),
        (b"\x1b[31m\xff\xfe\x00", "no table of numbers"),
        (b"t [s],a [g]\n0,1\n1,2\n" + b"2,3\n" * 30_000 + b"oops,4\n", "line 30004: 'oops'"),
        (
            b"t [s],a [g]\n0,1\n1,2\n" + b"2,3\n" * 30_000 + b"2,3,4,5\n",
            "line 30004: it has 4 cells",
        ),
    ],
)
def test_text_that_is_no_table_is_refused(write, content, match):
    refused(write(content), match)


LVM = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t{decimal}
Date\t2024/05/06
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t4\t4\t
Date\t2024/05/06\t2024/05/06\t
Time\t07:08:09.250000\t07:08:09.250000\t
Y_Unit_Label\tg\tVolts\t
X_Dimension\tTime\tTime\t
X0\t0\t0\t
Delta_X\t0{decimal}002\t{step}\t
***End_of_Header***\t\t\t
X_Value\tcontrol\tdrive\tComment
{rows}"""


def lvm(decimal=".", step="0.002", rows=4):
    lines = [f"{0.002 * i:.3f}\t{i + 0.5}\t-{i}.25\t" for i in range(rows)]
    body = "\n".join(lines).replace(".", decimal) + "\n"
    return LVM.format(decimal=decimal, step=step.replace(".", decimal), rows=body)


@pytest.mark.parametrize("decimal", [".", ","])
def test_lvm(write, decimal):
    with open_recording(write(lvm(decimal), "run.lvm")) as recording:
        assert recording.sample_rate == 500.0
        assert [(c.name, c.unit) for c in recording.channels] == [
            ("control", "m/s^2"),
            ("drive", "V"),
        ]
        assert_array_equal(recording.samples()[1], [-0.25, -1.25, -2.25, -3.25])
        assert recording.start_time.isoformat() == "2024-05-06T07:08:09.250000+00:00"


def test_lvm_that_stops_short_is_marked(write):
    with open_recording(write(lvm(rows=3), "run.lvm")) as recording:
        assert (recording.n_samples, recording.expected_samples) == (3, 4)


def test_lvm_whose_last_number_is_cut_loses_that_row(write):
    with open_recording(write(lvm(rows=3)[:-4], "run.lvm")) as recording:
        assert (recording.n_samples, recording.expected_samples) == (2, 4)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (
            lvm(step="0.004"),
            "contradicts itself: 500 Hz .Delta_X of 'control', time column.*, 250 Hz",
        ),
        (lvm(step="0"), "Delta_X of 'drive' is 0 s"),
        (lvm().replace("LabVIEW", "Labview"), "line 1 does not say"),
        (lvm().replace("***End_of_Header***\t\t\t\n", ""), "the second .* is missing"),
        (lvm().replace("Decimal_Separator\t.", "Decimal_Separator\t;"), "decimal sign ';'"),
        (lvm().replace("-2.25", "oops"), "line 20: 'oops' in column 3 is no number"),
    ],
)
def test_lvm_that_cannot_be_used(write, content, match):
    refused(write(content, "run.lvm"), match)


def mat(path, content):
    scipy_io.savemat(path, content)
    return path


T = np.arange(50) / 200.0
Y = np.sin(T)


@pytest.mark.parametrize(
    "content",
    [
        {"t": T, "acc_g": Y},
        {"time": T[:, None], "acc_g": Y[:, None]},
        {"fs": 200.0, "acc_g": Y},
        {"sample_rate_hz": 200, "acc_g": Y, "spectrum": np.ones(26)},
        {"dt": 0.005, "acc_g": Y},
        {"data": {"fs": 200.0, "acc_g": Y}},
        {
            "samples": Y[:, None],
            "names": np.array(["acc"], object),
            "units": np.array(["g"], object),
            "fs": 200.0,
        },
    ],
)
def test_matlab_variables(tmp_path, content):
    with open_recording(mat(tmp_path / "run.mat", content)) as recording:
        assert recording.sample_rate == 200.0
        (channel,) = recording.channels
        assert channel.name.rpartition(".")[2] == "acc"
        assert channel.unit == "m/s^2"
        assert_allclose(recording.samples()[0], Y * STANDARD_GRAVITY)


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (
            {"t": T, "fs": 100.0, "a": Y},
            "contradicts itself: 200 Hz .time vector 't'., 100 Hz .fs.",
        ),
        ({"fs": -1.0, "a": Y}, "fs gives a rate of -1 Hz"),
        ({"dt": 0.0, "a": Y}, "dt is 0 s"),
        ({"a": Y}, "no sample rate"),
        ({"fs": 1.0, "note": "hello"}, "no time series"),
        ({"z": Y + 1j, "fs": 1.0}, "no time series"),
    ],
)
def test_matlab_variables_that_do_not_say_it(tmp_path, content, match):
    refused(mat(tmp_path / "run.mat", content), match)


def test_what_is_left_out_is_named(tmp_path):
    content = {"t": T, "a": Y, "H": Y + 1j, "psd": np.ones(26)}
    with open_recording(mat(tmp_path / "run.mat", content)) as recording:
        assert "Left out, not of the same length or kind: 'H', 'psd'" in recording.notes[0]


def hdf5(path, *, link=None):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        file["acc"] = np.stack([Y, 2 * Y])  # MATLAB's 50 x 2, transposed in the file
        file["fs"] = np.array([[200.0]])
        for name, words in (("names", ("one", "two")), ("units", ("g", "N"))):
            cell = file.create_dataset(name, (2, 1), dtype=h5py.ref_dtype)
            cell.attrs["MATLAB_class"] = np.bytes_("cell")
            for i, word in enumerate(words):
                text = file.create_dataset(
                    f"#refs#/{name}{i}", data=[[ord(c)] for c in word], dtype="u2"
                )
                text.attrs["MATLAB_class"] = np.bytes_("char")
                cell[i, 0] = text.ref
        if link:
            file["elsewhere"] = link
    with path.open("rb+") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(512))
    return path


def test_matlab_7_3_is_read_lazily(tmp_path):
    with open_recording(hdf5(tmp_path / "run.mat")) as recording:
        assert [(c.name, c.unit) for c in recording.channels] == [
            ("one", "m/s^2"),
            ("two", "N"),
        ]
        assert_allclose(
            recording.samples(10, 20), np.stack([Y * STANDARD_GRAVITY, 2 * Y])[:, 10:20]
        )


def test_matlab_7_3_follows_no_link_out_of_the_file(tmp_path):
    import h5py

    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["secret"] = Y
    for link in (h5py.ExternalLink("secret.h5", "/secret"), h5py.SoftLink("/acc")):
        with open_recording(hdf5(tmp_path / "run.mat", link=link)) as recording:
            assert len(recording.channels) == 2
            assert "'elsewhere'" in recording.notes[0]


@pytest.mark.parametrize("name", ["run.mat", "run.npz", "run.uff", "run.parquet"])
@pytest.mark.parametrize(
    "content", [b"", b"garbage" * 100, b"MATLAB 5.0 MAT-file".ljust(600, b"\1")]
)
def test_garbage_is_refused(write, name, content):
    refused(write(content, name), f"^{name}: ")


def test_numpy_archives(tmp_path):
    np.savez(tmp_path / "run.npz", t=T, acc_g=np.stack([Y, -Y], axis=1), f=np.ones(26))
    with open_recording(tmp_path / "run.npz") as recording:
        assert [c.name for c in recording.channels] == ["acc_g 1", "acc_g 2"]
        assert recording.sample_rate == 200.0


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["<f8", ">f4", "<i2"])
@pytest.mark.parametrize("upright", [True, False])
def test_an_array_of_numpy_is_read_a_slice_at_a_time(tmp_path, order, kind, upright):
    values = (np.random.default_rng(3).standard_normal((200, 3)) * 1000.0).astype(kind)
    path = tmp_path / "run.npy"
    np.save(path, np.asarray(values if upright else values.T, order=order))
    with open_recording(path, sample_rate=1000.0) as recording:
        assert [channel.name for channel in recording.channels] == ["run 1", "run 2", "run 3"]
        assert_array_equal(recording.samples(), values.T)
        assert_array_equal(recording.samples(13, 44), values[13:44].T)
    path.write_bytes(path.read_bytes()[:-1])
    refused(path, r"run.npy: 'run' says it holds .* bytes, but \d+ are there")


def test_fields_of_a_structured_array_are_channels_and_its_times_count(tmp_path):
    rows = np.zeros(300, [("time", "<f8"), ("acc_g", "<f4"), ("tag", "U3")])
    rows["time"], rows["acc_g"] = np.arange(300) / 500.0, np.random.default_rng(4).random(300)
    np.save(tmp_path / "run.npy", rows)
    with open_recording(tmp_path / "run.npy") as recording:
        assert recording.sample_rate == 500.0
        assert_allclose(recording.samples()[0], rows["acc_g"] * STANDARD_GRAVITY, rtol=1e-7)
        assert any("'tag'" in note for note in recording.notes)


@pytest.mark.parametrize("array", [np.zeros(9, complex), np.array([{}]), np.zeros((2, 3, 4))])
def test_an_array_of_no_samples_is_refused(tmp_path, array):
    np.save(tmp_path / "run.npy", array)
    refused(tmp_path / "run.npy", r"run.npy: ")


def test_a_pickle_in_a_numpy_archive_is_never_loaded_but_named(tmp_path):
    trap = np.array([Trap()], dtype=object)
    np.savez(tmp_path / "run.npz", t=T, acc_g=Y, trap=trap)
    with open_recording(tmp_path / "run.npz") as recording:
        assert "'trap'" in recording.notes[0]


def test_opening_a_long_npy_reads_no_more_than_its_head(tmp_path, monkeypatch):
    np.save(tmp_path / "run.npy", np.random.default_rng(1).standard_normal((200_000, 4)))
    read = []
    plain = Frames.__getitem__

    def counted(self, key):
        values = plain(self, key)
        read.append(values.size)
        return values

    monkeypatch.setattr(Frames, "__getitem__", counted)
    with open_recording(tmp_path / "run.npy", sample_rate=1000.0) as recording:
        assert max(read) <= 1 << 16
        assert recording.n_samples == 200_000


def test_a_pickle_of_numpy_is_named_as_one(tmp_path):
    np.save(tmp_path / "run.npy", np.array([Trap()], dtype=object))
    refused(tmp_path / "run.npy", r"run.npy: holds Python objects \(a pickle\)")


class Trap:
    """What must not be made again from its pickle."""

    def __reduce__(self):
        return (pytest.fail, ("the pickle was loaded",))


LONG = np.random.default_rng(4).standard_normal((2, 8000))
TIMES = np.arange(8000) / 1000.0


def saved(path, content):
    if path.suffix == ".npz":
        np.savez(path, **content)
    else:
        scipy_io.savemat(path, content)
    return path


def test_an_encrypted_archive_of_arrays_is_told_as_one(tmp_path):
    path = tmp_path / "run.npz"
    np.savez(path, t=T, acc_g=Y)
    content = bytearray(path.read_bytes())
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):  # flags of both its heads
        for found in re.finditer(mark, bytes(content)):
            content[found.start() + place] |= 1
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=r"run\.npz: is encrypted\. Save it without"):
        open_recording(path)


@pytest.mark.parametrize("ending", [".npz", ".mat"])
@pytest.mark.parametrize("rate", [{"fs": 1000.0}, {"fs": np.array([1000.0])}, {"dt": 0.001}])
def test_vectors_beside_a_rate_are_channels(tmp_path, ending, rate):
    path = saved(tmp_path / f"run{ending}", {**rate, "a_g": LONG[0], "b_g": LONG[1]})
    with open_recording(path) as recording:
        assert [channel.name for channel in recording.channels] == ["a", "b"]
        assert (recording.sample_rate, recording.n_samples) == (1000.0, 8000)


@pytest.mark.parametrize("ending", [".npz", ".mat"])
@pytest.mark.parametrize("upright", [True, False])
def test_the_first_line_of_an_array_is_its_time_where_it_advances_as_one(
    tmp_path, ending, upright
):
    """One channel and its time in each of two arrays, and two channels in a third."""
    times = TIMES.round(3) + 5.0
    stacks = {
        "control": np.stack([times, LONG[0]]),
        "response": np.stack([times, LONG[1]]),
        "more": np.stack([times, LONG[0], LONG[1]]),
    }
    arrays = {name: data.T if upright else data for name, data in stacks.items()}
    path = saved(tmp_path / f"run{ending}", arrays)
    with open_recording(path) as recording:
        assert [channel.name for channel in recording.channels] == [
            "control", "response", "more 1", "more 2"
        ]  # fmt: skip
        assert recording.sample_rate == 1000.0
        assert_array_equal(recording.samples(), [LONG[0], LONG[1], LONG[0], LONG[1]])
        assert recording.notes[0].startswith(
            "The first line of 'control' is taken for its time"
        )
    wrong = {**arrays, "fs": 500.0}
    refused(saved(tmp_path / f"wrong{ending}", wrong), "the file contradicts itself")


@pytest.mark.parametrize("ending", [".npz", ".mat"])
@pytest.mark.parametrize("upright", [True, False])
def test_a_count_in_an_array_is_never_a_channel_nor_a_time(tmp_path, ending, upright):
    data = np.stack([1e3 * TIMES, LONG[0]])
    path = saved(tmp_path / f"run{ending}", {"data": data.T if upright else data})
    refused(path, "'data 1' is no channel: it advances evenly by .* a vector of its own")
    with open_recording(path, sample_rate=1000.0) as recording:
        assert [channel.name for channel in recording.channels] == ["data 2"]
        assert recording.notes[0].startswith("'data 1' is no channel")


@pytest.mark.parametrize(
    ("name", "factor"), [("time_ms", 1e3), ("t_us", 1e6), ("time_min", 1 / 60.0), ("t_s", 1.0)]
)
def test_the_unit_of_a_time_vector_counts(tmp_path, name, factor):
    path = saved(tmp_path / "run.npz", {name: factor * TIMES, "a_g": LONG[0]})
    with open_recording(path) as recording:
        assert recording.sample_rate == pytest.approx(1000.0, rel=1e-9)


@pytest.mark.parametrize(
    ("times", "match"),
    [
        (
            np.delete(np.arange(8001) / 1000.0, 4000),
            "does not advance evenly: from sample 3999",
        ),
        (TIMES[::-1].copy(), "does not advance"),
        (np.where(TIMES == 1.0, np.nan, TIMES), "has gaps"),
    ],
)
def test_a_time_vector_that_is_not_even_is_named_even_beside_a_rate(tmp_path, times, match):
    path = saved(tmp_path / "run.npz", {"t": times, "fs": 1000.0, "a_g": LONG[0]})
    refused(path, f"time vector 't' {match}")


def test_whole_numbers_are_told_because_they_may_be_counts_without_a_scale(tmp_path):
    content = {"fs": 1000.0, "a_g": (1000 * LONG[0]).astype("i2"), "b_g": LONG[1]}
    with open_recording(saved(tmp_path / "run.npz", content)) as recording:
        (note,) = recording.notes
        assert note.startswith("'a_g' holds whole numbers (int16): if they are counts")


def test_arrays_of_another_length_are_named(tmp_path):
    content = {"fs": 1000.0, "a_g": LONG[0], "b_g": LONG[1, :7000], "z": LONG[0] + 1j}
    with open_recording(saved(tmp_path / "run.npz", content)) as recording:
        assert [channel.name for channel in recording.channels] == ["a"]
        assert "Left out, not of the same length or kind: 'z', 'b_g'." in recording.notes


def test_an_array_that_promises_more_than_it_holds_is_refused_before_it_is_made(tmp_path):
    import io
    import zipfile

    array = io.BytesIO()
    np.save(array, LONG[0])
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000000,), }"
    lie = array.getvalue()[:10] + head.ljust(117) + b"\n" + array.getvalue()[128:]
    with zipfile.ZipFile(tmp_path / "run.npz", "w") as archive:
        archive.writestr("a_g.npy", lie)
    refused(tmp_path / "run.npz", "holds 1000000000000000 numbers in 8000000000000000 bytes")


def test_an_hdf5_variable_that_holds_next_to_nothing_of_what_it_says_is_left_out(tmp_path):
    import h5py

    with h5py.File(tmp_path / "run.mat", "w") as file:
        file["fs"] = np.array([[200.0]])
        file.create_dataset("a", (1, 10**12), dtype="f8", chunks=(1, 10**4))
        file["b"] = Y[None]
    with open_recording(tmp_path / "run.mat") as recording:
        assert [channel.name for channel in recording.channels] == ["b"]
        assert "'a'" in recording.notes[0]


def test_an_archive_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    from shakerproc.recordings import numpy_file

    monkeypatch.setattr(numpy_file, "LARGEST", 1000)
    np.savez(tmp_path / "run.npz", t=T, a=np.zeros(500))
    refused(tmp_path / "run.npz", "too many to hold in memory")


def uff(tmp_path, n=60):
    path = tmp_path / "run.uff"
    one = recording_of_arrays(
        "run", [Channel("a", "m/s^2", "a", "g")], np.sin(np.arange(n))[None], RATE
    )
    write_uff(path, one)
    return path


RATE = 51200.0 / 9.0


@pytest.mark.parametrize(
    ("old", "new", "match"),
    [
        (b"        60         1", b"        61         1", "holds 60 values but says 61"),
        (b"        60         1", b"        59         1", "holds 60 values but says 59"),
        (b"  1.75781e-04", b"  0.00000e+00", "the step of record 'a' is 0 s"),
        (b"    1         0    0", b"    9         0    0", "no time record"),
    ],
)
def test_uff_records_that_are_not_what_they_say(tmp_path, old, new, match):
    path = uff(tmp_path)
    content = path.read_bytes()
    assert content.count(old) == 1
    path.write_bytes(content.replace(old, new))
    refused(path, match)


def two_records(tmp_path, form):
    """A universal file of two channels, its text as pyuff writes it, and what it holds."""
    import pyuff

    path = tmp_path / "run.uff"
    values = np.random.default_rng(5).standard_normal((2, 60)).round(6)
    if form == "binary":
        channels = [Channel(name, "m/s^2", name, "g") for name in ("a", "b")]
        write_uff(path, recording_of_arrays("run", channels, values * STANDARD_GRAVITY, 1000.0))
        return path, values
    for name, row in zip(("a", "b"), values, strict=True):
        axes = ("abscissa", "ordinate", "orddenom", "z_axis")
        blank = {
            f"{axis}_{key}": 0
            for axis in axes
            for key in ("spec_data_type", "len_unit_exp", "force_unit_exp", "temp_unit_exp")
        }
        blank |= {
            f"{axis}_{key}": "NONE" for axis in axes for key in ("axis_lab", "axis_units_lab")
        }
        blank |= {"z_axis_axis_lab": "NONE", "z_axis_axis_units_lab": "NONE"}
        record = blank | {
            "type": 58, "binary": 0, "func_type": 1, "rsp_node": 1,
            "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "data": row.astype(float),
            "x": np.arange(60) / 1000.0, "id1": name, "ordinate_axis_units_lab": "g",
            "abscissa_spacing": 1, "abscissa_inc": 0.001, "abscissa_min": 0.0,
            "ord_data_type": 4, "byte_ordering": 1, "fp_format": 2, "n_ascii_lines": 11,
            "n_bytes": 8 * 60, "ver_num": 0, "load_case_id": 0, "rsp_ent_name": "NONE",
            "ref_ent_name": "NONE", "z_axis_value": 0.0,
        }  # fmt: skip
        pyuff.UFF(str(path)).write_sets(record, "add")
    return path, values


@pytest.mark.parametrize("form", ["binary", "text"])
def test_uff_is_what_was_written(tmp_path, form):
    path, values = two_records(tmp_path, form)
    with open_recording(path) as recording:
        assert [c.name for c in recording.channels] == ["a", "b"]
        assert recording.sample_rate == 1000.0
        assert_allclose(recording.samples(), values * STANDARD_GRAVITY, rtol=1e-10)


@pytest.mark.parametrize("form", ["binary", "text"])
def test_uff_that_is_cut_is_refused_or_incomplete_wherever_it_is_cut(tmp_path, form):
    path, values = two_records(tmp_path, form)
    whole = path.read_bytes()
    seen = set()
    for size in range(len(whole) // 2 + 5, len(whole) - 8, 3):
        path.write_bytes(whole[:size])
        try:
            with open_recording(path) as recording:
                assert len(recording.channels) == 2
                assert recording.incomplete
                assert "The file is not whole: it ends inside 'b'" in recording.notes[0]
                found = recording.samples()
                seen.add("incomplete")
        except RecordingError:
            seen.add("refused")
            continue
        n = found.shape[1]
        assert_allclose(found, values[:, :n] * STANDARD_GRAVITY, rtol=1e-10)
    assert seen == {"refused", "incomplete"}


def test_files_that_are_too_long_to_hold_are_refused(tmp_path, write, monkeypatch):
    monkeypatch.setattr(text_format, "LARGEST", 10)
    refused(write(table(",", ".", ["t,a,b"])), "too many to hold in memory")
    path = uff(tmp_path)
    monkeypatch.setattr("shakerproc.recordings.uff.LARGEST", 10)
    refused(path, "too many to hold in memory")
    monkeypatch.setattr(matlab, "LARGEST", 10)
    refused(mat(tmp_path / "run.mat", {"t": T, "a": Y}), "too many to hold in memory")
    write_parquet(tmp_path / "run.parquet", held())
    monkeypatch.setattr(parquet, "LARGEST", 10)
    with pytest.raises(RecordingError, match="50 rows of 2 columns, more than any recording"):
        parquet.read_parquet(tmp_path / "run.parquet", "run.parquet")


@pytest.mark.parametrize("field", [2, 3])
@pytest.mark.parametrize("compression", ["snappy", "none"])
def test_a_page_of_parquet_that_promises_more_than_its_column_is_refused(
    compression, field, tmp_path
):
    """Fields 1, 2 and 3 of a page header are numbers of one, three and three bytes."""
    import pyarrow as pa
    from pyarrow import parquet

    path = tmp_path / "run.parquet"
    values = np.random.default_rng(1).standard_normal(2000)
    table = pa.table({"a [g]": values, "b [g]": values[::-1]})
    parquet.write_table(table, path, compression=compression, use_dictionary=False)
    with open_recording(path, sample_rate=1000.0) as sound:
        assert sound.n_samples == 2000
    content = bytearray(path.read_bytes())
    page = parquet.ParquetFile(path).metadata.row_group(0).column(1).data_page_offset
    at = {2: page + 2, 3: page + 6}[field]
    assert (content[at], content[at + 3] & 0x80) == (0x15, 0)
    content[at + 1 : at + 4] = b"\xfe\xff\x7f"
    path.write_bytes(content)
    with pytest.raises(
        RecordingError, match=r"column 'b \[g\]' says it holds 1048575 bytes, but"
    ):
        open_recording(path, sample_rate=1000.0)


@pytest.mark.parametrize("rate", ["nan", "0", "-1", "inf", "1e400", "fast"])
def test_a_sample_rate_of_parquet_that_is_none_is_named(tmp_path, rate):
    import pyarrow as pa

    table = pa.table({"a [N]": np.ones(50)}, metadata={b"sample_rate_hz": rate.encode()})
    arrow_parquet.write_table(table, tmp_path / "run.parquet")
    refused(tmp_path / "run.parquet", "sample_rate_hz gives a rate of .* Hz, which is none")


def test_parquet_is_the_same_in_every_order_and_says_what_it_does_not_use(tmp_path):
    import pyarrow as pa

    n, rng = 5000, np.random.default_rng(8)
    values = rng.standard_normal((3, n)).round(4)
    cents = pa.array(values[2]).cast(pa.decimal128(12, 4))
    columns = {
        "time [s]": np.arange(n) / 250.0,
        "a [N]": values[0],
        "remark": ["none"] * n,
        "b [N]": values[1].astype(np.float32),
        "c [N]": cents,
        "state": rng.random(n) > 0.5,
    }
    arrow_parquet.write_table(pa.table(columns), tmp_path / "run.parquet", row_group_size=777)
    expected = np.stack([values[0], values[1].astype(np.float32), values[2]])
    with open_recording(tmp_path / "run.parquet") as recording:
        assert (recording.sample_rate, recording.n_samples) == (250.0, n)
        assert "not used: 'remark' (string), 'state' (bool)" in recording.notes[0]
        assert_allclose(recording.samples(), expected, rtol=1e-15)
        for start, stop in [(0, 10), (4990, 5000), (700, 1600), (1, 4999), (300, 301)]:
            assert_allclose(recording.samples(start, stop), expected[:, start:stop])
        assert_allclose(recording.select([2]).samples(776, 779)[0], expected[2, 776:779])


@pytest.mark.parametrize("compression", ["lz4", "uncompressed"])
def test_feather_is_what_pyarrow_reads_and_of_version_1_is_refused(tmp_path, compression):
    path = tmp_path / "run.feather"
    values = np.random.default_rng(5).standard_normal((2, 500))
    columns = {
        "t": np.arange(500) / 100.0,
        "a [g]": values[0],
        "b [N]": values[1],
        "c": ["x"] * 500,
    }
    table = pyarrow.table(columns)
    feather.write_feather(table, path, compression=compression, chunksize=128)
    oracle = feather.read_table(path)
    with open_recording(path) as recording:
        assert recording.sample_rate == 100.0
        assert_array_equal(recording.samples()[1], oracle["b [N]"].to_numpy())
        assert_array_equal(recording.samples(100, 300)[1], values[1, 100:300])
        assert_allclose(recording.samples()[0], values[0] * STANDARD_GRAVITY, rtol=1e-15)
        assert any("'c' (string)" in note for note in recording.notes)
    path.write_bytes(path.read_bytes()[:-40])
    refused(path, r"run.feather: opening the table failed")
    path.write_bytes(b"FEA1" + bytes(60) + b"FEA1")
    refused(path, r"run.feather: Feather of version 1")


def test_a_row_that_parquet_lacks_is_seen_in_its_time_column(tmp_path):
    import pyarrow as pa

    times = np.delete(np.arange(2_000_000) / 5000.0, 1_500_000)
    table = pa.table({"t [s]": times, "a [N]": np.zeros(times.size)})
    arrow_parquet.write_table(table, tmp_path / "run.parquet")
    refused(tmp_path / "run.parquet", "does not advance evenly")
    table = table.replace_schema_metadata({b"sample_rate_hz": b"4000.0"})
    table = table.set_column(0, "t [s]", pa.array(np.arange(times.size) / 5000.0))
    arrow_parquet.write_table(table, tmp_path / "run.parquet")
    refused(tmp_path / "run.parquet", "contradicts itself: 4000 Hz .* 5000 Hz")


def test_a_slow_time_column_of_parquet_gives_its_rate_in_pieces(tmp_path, monkeypatch):
    import pyarrow as pa

    monkeypatch.setattr(times, "JUDGED", 64)
    table = pa.table({"t [s]": 4.0 * np.arange(1000.0), "a [N]": np.zeros(1000)})
    arrow_parquet.write_table(table, tmp_path / "run.parquet")
    with open_recording(tmp_path / "run.parquet") as recording:
        assert recording.sample_rate == 0.25


def test_health_of_a_long_still_recording_is_quick_and_needs_little_memory(tmp_path):
    import resource
    import time

    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({"a [N]": np.zeros(3_000_000)}, metadata={b"sample_rate_hz": b"5000"})
    parquet.write_table(table, tmp_path / "run.parquet")
    del table
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    with open_recording(tmp_path / "run.parquet") as recording:
        assert health(recording)
    assert time.process_time() - start < 3.0  # [s]; a second at most here
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50 * 1024


def held():
    return recording_of_arrays("run", [Channel("a", "N", "a", "N")], np.ones((1, 50)), 10.0)


@pytest.mark.parametrize("compressed", [False, True])
def test_every_kind_of_matlab_variable_is_what_scipy_reads(tmp_path, compressed):
    rng = np.random.default_rng(3)
    kinds = ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"]
    content = {f"a_{kind}": (100 * rng.random((3, 4))).astype(kind) for kind in kinds}
    content |= {
        "whole": np.arange(5.0),  # stored as bytes
        "flag": np.array([[True, False]]),
        "words": np.array(["one", "two"], object),
        "line": "one line",
        "lines": np.array(["abc", "def"]),
        "inner": {"x": np.arange(3.0), "deep": {"unit": "g"}},
        "empty": np.zeros((0, 3)),
        "wave": np.array([[1.0 + 2.0j, 3.0], [4.0j, 5.5 - 6.0j]]),
        "mixed": np.array([1.0, "x"], object),
    }
    path = tmp_path / "run.mat"
    scipy_io.savemat(path, content, do_compression=compressed)
    oracle = scipy_io.loadmat(path)
    found = dict(matlab.read_variables(memoryview(path.read_bytes()), 1 << 20))
    assert set(found) == set(content)
    for name in [f"a_{kind}" for kind in kinds] + ["whole", "flag", "empty", "wave"]:
        assert_array_equal(found[name], oracle[name])
    assert found["words"] == ["one", "two"]
    assert found["line"] == ["one line"]
    assert found["lines"] == ["abc", "def"]
    assert_array_equal(found["inner"]["x"], [[0.0, 1.0, 2.0]])
    assert found["inner"]["deep"] == {"unit": ["g"]}
    assert found["mixed"] == {"{1}": oracle["mixed"][0, 0], "{2}": ["x"]}


def test_a_matlab_file_that_would_fill_the_memory_is_refused(tmp_path):
    path = tmp_path / "run.mat"
    scipy_io.savemat(path, {"a": np.zeros((1000, 1000))}, do_compression=True)
    with pytest.raises(matlab.Mat5Error, match="more than fits into memory"):
        list(matlab.read_variables(memoryview(path.read_bytes()), 1 << 20))


def test_a_matlab_variable_of_absurd_size_is_refused_with_its_size(tmp_path):
    path = tmp_path / "run.mat"
    scipy_io.savemat(path, {"a": np.zeros((0, 7, 5))})
    content, absurd = path.read_bytes(), 2**31 - 1
    old = np.array([0, 7, 5], "<i4").tobytes()
    assert content.count(old) == 1
    path.write_bytes(content.replace(old, np.array([0, absurd, absurd], "<i4").tobytes()))
    refused(path, "a variable of 0 x 2147483647 x 2147483647 numbers")


def test_matlab_version_4_is_read_through_scipy(tmp_path):
    scipy_io.savemat(tmp_path / "run.mat", {"t": T, "acc_g": Y}, format="4")
    with open_recording(tmp_path / "run.mat") as recording:
        assert recording.sample_rate == 200.0
        assert_allclose(recording.samples()[0], Y * STANDARD_GRAVITY)


def test_a_table_of_lines_longer_than_the_first_look_is_read(tmp_path):
    samples = np.random.default_rng(2).standard_normal((12, 5000)).round(6)
    names = ",".join(["time (s)", *(f"sensor {i} (m/s^2)" for i in range(5000))])
    assert len(names) > 2**16
    table = np.column_stack([np.arange(12) / 1000.0, samples])
    np.savetxt(tmp_path / "wide.csv", table, "%.6f", ",", header=names, comments="")
    with open_recording(tmp_path / "wide.csv") as recording:
        assert recording.channels[4999].name == "sensor 4999"
        assert_allclose(recording.samples(), samples.T, atol=1e-6)


def test_a_line_without_end_is_refused(tmp_path):
    (tmp_path / "one.csv").write_text("1.5," * 5_000_000)
    with pytest.raises(RecordingError, match="line 1 does not end within 16777216 bytes"):
        open_recording(tmp_path / "one.csv")


@pytest.mark.parametrize(
    ("delimiter", "decimal", "end"), [(",", ".", "\n"), (";", ",", "\r\n"), (" ", ".", "\n")]
)
def test_a_table_of_more_columns_than_rows_is_read_number_by_number(
    tmp_path, delimiter, decimal, end
):
    """Known numbers to the last digit; one cell is empty where a delimiter shows it."""
    numbers = np.random.default_rng(4).standard_normal((8, 300))
    numbers[:, 0] = np.arange(8) / 64.0
    lines = [[repr(float(x)).replace(".", decimal) for x in row] for row in numbers]
    if delimiter != " ":
        lines[3][7], numbers[3, 7] = "", np.nan
    header = ["time_s", *(f"a{i}_g" for i in range(1, 300))]
    path = tmp_path / "wide.csv"
    path.write_bytes("".join(delimiter.join(row) + end for row in [header, *lines]).encode())
    with open_recording(path) as recording:
        assert recording.sample_rate == 64.0
        read = recording.samples() / 9.80665
    np.testing.assert_allclose(read, numbers[:, 1:].T, rtol=1e-15)


def test_two_infinite_values_of_a_damaged_file_make_no_time_and_no_warning(tmp_path):
    """As `make fuzz` found it: a flipped bit in two exponents that are neighbours."""
    values = np.arange(64.0)
    values[20:22] = np.inf
    path = tmp_path / "damaged.mat"
    scipy_io.savemat(path, {"a": values, "b": np.ones(64), "fs": 64.0})
    with open_recording(path, sample_rate=64.0) as recording:
        assert recording.sample_rate == 64.0
