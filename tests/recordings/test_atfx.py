"""ASAM ODS ATFX: values to the last digit, rate, start, units; what is wrong in one line.

The files are made byte by byte after the published schema, in the forms that the examples of
ASAM, IPETRONIK, HEAD acoustics and Simcenter Testlab have; the oracle is what was written.
"""

from datetime import UTC, datetime

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from tests.recordings.recorder_files import atfx, atfx_component, atfx_explicit

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.errors import RecordingError
from shakerproc.recordings import FilePart, open_recording

N = 60
TIME = ("time", "s", "Time", (0.25, 0.002))
VALUES = np.random.default_rng(44).standard_normal((3, N))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "run.atfx"


def refused(path, **options):
    """The one line with which a file is refused."""
    with pytest.raises(RecordingError) as caught:
        open_recording(path, **options)
    line = str(caught.value)
    assert "\n" not in line
    assert line.startswith(path.name)
    return line


def column(content, name="acc"):
    return (name, "g", "acceleration", content)


def stored(first, block, offset, kind="ieeefloat8", n=N):
    component = atfx_component("B", kind, n, first, block, offset)
    return f"<Art>explicit</Art><Werte>{component}</Werte>"


def one(path, *columns, rows=N, files=None):
    text = atfx([("part", rows, [TIME, *columns])], begin="20240506070809250", files=files)
    path.write_text(text, encoding="utf-8")


def test_numbers_that_are_written_out_are_read_to_the_last_digit(path):
    single = VALUES[1].astype(np.float32)
    written = atfx_explicit(single, "A_FLOAT32")
    one(path, column(atfx_explicit(VALUES[0])), ("force", "N", "force", written))
    with open_recording(path) as found:
        assert [(c.name, c.source_unit) for c in found.channels] == [
            ("acc", "g"),
            ("force", "N"),
        ]
        assert (found.sample_rate, found.n_samples) == (500.0, N)
        assert found.start_time == datetime(2024, 5, 6, 7, 8, 9, 500000, tzinfo=UTC)
        assert_array_equal(found.samples()[0], VALUES[0] * STANDARD_GRAVITY)
        assert_array_equal(found.samples()[1], single.astype(np.float64))
        assert found.notes == ()


def test_times_that_are_written_out_give_the_rate(path):
    free = ("t", "s", "Time", [atfx_explicit(np.arange(N) / 1000.0)])
    path.write_text(atfx([("part", N, [free, column(atfx_explicit(VALUES[0]))])]))
    with open_recording(path) as found:
        assert (found.sample_rate, found.n_samples) == (1000.0, N)


def test_blocks_of_value_and_flag_are_read_a_slice_at_a_time(path):
    record = np.zeros((2, N), [("value", "<f8"), ("flag", "<i2")])
    record["value"], record["flag"] = VALUES[:2], 15
    record["flag"][0, 7] = 14
    (path.parent / "run.bda").write_bytes(record.tobytes())
    flags = atfx_component("B", "dt_short", N, 0, 10, 8)
    contents = [f"{stored(0, 10, 0)}<Marken>{flags}</Marken>", stored(10 * N, 10, 0)]
    one(path, *map(column, contents, ["a", "b"]), files={"B": "run.bda"})
    with open_recording(path) as found:
        samples = found.samples() / STANDARD_GRAVITY
        assert_array_equal(np.flatnonzero(np.isnan(samples[0])), [7])
        assert_array_equal(found.samples()[1], VALUES[1] * STANDARD_GRAVITY)
        part = found.source.read([found.rows[1], found.rows[0]], 5, 30)
        assert_array_equal(part, found.samples()[::-1, 5:30])
        assert any("'run.bda'" in note and "SHA-256" in note for note in found.notes)


def test_channels_that_take_turns_are_whole_at_the_end_of_their_file(path):
    (path.parent / "b").write_bytes(VALUES.T.astype(">f4").tobytes())
    contents = [stored(4 * line, 12, 0, "ieeefloat4_beo") for line in range(3)]
    one(path, *map(column, contents, "abc"), files={"B": "b"})
    with open_recording(path) as found:
        single = VALUES.astype(np.float32).astype(np.float64)
        assert (found.n_samples, found.incomplete) == (N, False)
        assert_array_equal(found.samples(), single * STANDARD_GRAVITY)
    content = (path.parent / "b").read_bytes()
    (path.parent / "b").write_bytes(content[:-30])
    with open_recording(path) as found:
        assert (found.n_samples, found.expected_samples) == (N - 3, N)


@pytest.mark.parametrize(
    ("kind", "parameters", "factor"),
    [
        ("raw_linear_external", "0.5 0.25", 1.0),
        ("raw_linear_calibrated_external", "0.5 0.25 4", 4.0),
    ],
)
def test_counts_of_an_external_component_are_scaled(path, kind, parameters, factor):
    counts = np.random.default_rng(1).integers(-32768, 32768, N)
    (path.parent / "run.btf").write_bytes(b"head" + counts.astype(">i2").tobytes())
    about = (
        f"<Fremd><Id>900</Id><Datei>run.btf</Datei><Typ>dt_short_beo</Typ><Laenge>{N}</Laenge>"
        "<Anfang>4</Anfang><Block>2</Block><JeBlock>1</JeBlock><Versatz>0</Versatz></Fremd>"
    )
    content = f"<Art>{kind}</Art><Zahlen>{parameters}</Zahlen><Fremd>900</Fremd>"
    one(path, column(content))
    path.write_text(path.read_text().replace("</instance_data>", about + "</instance_data>"))
    with open_recording(path) as found:
        expected = (0.5 + 0.25 * counts) * factor * STANDARD_GRAVITY
        assert_array_equal(found.samples()[0], expected)


def test_submatrices_of_one_rate_are_one_group_and_others_are_chosen(path):
    slow = ("time", "s", "Time", (0.0, 0.1))
    parts = [
        (name, N, [axis, column(atfx_explicit(values), name)])
        for name, axis, values in zip("abc", [TIME, slow, TIME], VALUES, strict=True)
    ]
    path.write_text(atfx(parts))
    assert "2 groups hold data" in refused(path)
    with open_recording(path, part=FilePart("a")) as found:
        assert [c.name for c in found.channels] == ["a", "c"]
        assert_array_equal(found.samples(), VALUES[[0, 2]] * STANDARD_GRAVITY)


def test_columns_that_are_no_measured_numbers_are_named(path):
    text = "<Art>explicit</Art><Werte><A_UTF8STRING><s>on</s></A_UTF8STRING></Werte>"
    invalid = atfx_explicit(VALUES[0]).replace("<Marke>15", "<Marke>0")
    odd = {
        "text": text, "constant": "<Art>implicit_constant</Art>",
        "empty": "<Art>explicit</Art>", "bits": stored(0, 2, 0, "dt_bit_int"),
        "gone": stored(0, 8, 0).replace(">B<", ">C<"),
        "invalid": invalid, "word": atfx_explicit(VALUES[0]).replace(" ", " x ", 1),
    }  # fmt: skip
    (path.parent / "b").write_bytes(bytes(400))
    columns = [column(content, name) for name, content in odd.items()]
    one(path, column(atfx_explicit(VALUES[0])), *columns, files={"B": "b", "C": "nowhere.bin"})
    with open_recording(path) as found:
        assert [c.name for c in found.channels] == ["acc"]
        why = {one.name: one.why for one in found.unused}
    assert list(why) == list(odd)
    told = ["text", "kind 'implicit_constant'", "0 places", "'dt_bit_int'", "not there",
            "not valid", "'x'"]  # fmt: skip
    for words, line in zip(told, why.values(), strict=True):
        assert words in line


@pytest.mark.parametrize("name", ["", "../b", "/etc/passwd", "C:\\data\\b", "other/b"])
def test_samples_that_do_not_stand_beside_the_file_are_one_line(path, name):
    one(path, column(stored(0, 8, 0)), files={"B": name})
    line = refused(path)
    assert "its values stand in" in line
    assert "not beside the file" in line or "not there" in line


def test_a_spectrum_is_no_recording(path):
    axis = ("frequency", "Hz", "Frequency", (0.0, 0.5))
    path.write_text(atfx([("part", N, [axis, column(atfx_explicit(VALUES[0]))])]))
    assert "spectrum" in refused(path)


def test_without_an_axis_the_log_says_the_rate(path):
    path.write_text(atfx([("part", N, [column(atfx_explicit(VALUES[0]))])]))
    assert "sample rate" in refused(path)
    with open_recording(path, sample_rate=2000.0) as found:
        assert found.sample_rate == 2000.0


@pytest.mark.parametrize(
    ("text", "other", "told"),
    [
        ("<Beginn>2024", "<Beginn>on 2024", "no date"),
        ("<Messung>1</Messung><Spalten>", "<Messung>7</Messung><Spalten>", "'7', which is not"),
        ("<Messung>1</Messung><Spalten>", "<Spalten>", "belongs to no measurement"),
        ("<Einheit><Id>9<", "<Einheit><Id>99<", "aounit '9', which is not in it"),
    ],
)
def test_what_a_file_refers_to_in_vain_is_told(path, text, other, told):
    one(path, column(atfx_explicit(VALUES[0])))
    assert text in path.read_text()
    path.write_text(path.read_text().replace(text, other))
    with open_recording(path) as found:
        assert any(told in note for note in found.notes)


@pytest.mark.parametrize("part", [0.01, 0.5, 0.99])
def test_a_cut_file_is_one_line(path, part):
    one(path, column(atfx_explicit(VALUES[0])))
    content = path.read_bytes()
    path.write_bytes(content[: int(part * len(content))])
    assert "no whole XML" in refused(path)


def test_other_xml_and_entities_without_end_are_one_line(path):
    path.write_text("<svg></svg>")
    assert "no ATFX" in refused(path)
    entities = "".join(f'<!ENTITY a{i + 1} "{f"&a{i};" * 20}">' for i in range(9))
    path.write_text(f'<!DOCTYPE x [<!ENTITY a0 "aaaa">{entities}]><x>&a9;</x>')
    assert "no whole XML" in refused(path)


def test_fewer_values_than_rows_make_it_incomplete(path):
    one(path, column(atfx_explicit(VALUES[0, :50])))
    with open_recording(path) as found:
        assert (found.n_samples, found.expected_samples) == (50, N)
