"""UFF 58 as its definition allows: padded lines, stored abscissas, every type of function.

Oracle: the numbers that are written here, and pyuff on the same file.
"""

import re
import struct

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import completed

from shakerproc.data import Channel, recording_of_arrays
from shakerproc.errors import RecordingError
from shakerproc.recordings import open_recording, write_uff

RATE = 2000.0
VALUES = np.random.default_rng(58).standard_normal(61).round(5)
TIMES = np.arange(61) / RATE


def record(values, *, kind=2, even=True, function=1, axis=("Time", "s"), code=17, pad="",
           binary=False, order="<", single=False):  # fmt: skip
    """The bytes of a data set 58."""
    count = len(values)
    axes = [f"{code:10d}{0:5d}{0:5d}{0:5d} {axis[0]:20} {axis[1]:20}"]
    axes += [
        f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {unit:20}" for unit in ("m/s^2", "NONE", "NONE")
    ]
    head = [
        *(f"{text:80}" for text in ("acc", "NONE", "NONE", "NONE", "NONE")),
        f"{function:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{1:10d}{0:4d} {'NONE':10}{0:10d}{0:4d}",
        f"{kind:10d}{count:10d}{even:10d}{0.0:13.5e}{even / RATE:13.5e}{0.0:13.5e}",
        *axes,
    ]  # fmt: skip
    if binary:
        x, y = ("f" if single else "d"), "f" if kind == 2 else "d"
        pairs = zip(TIMES, values, strict=True)
        data = (
            struct.pack(f"{order}{count}{y}", *values) if even
            else b"".join(struct.pack(f"{order}{x}{y}", t, v) for t, v in pairs)
        )  # fmt: skip
        first = (
            f"    58b{1 if order == '<' else 2:6d}{2:6d}{11:12d}{len(data):12d}" + f"{0:6d}" * 2
        )
        text = "\n".join(["    -1", f"{first}{0:12d}{0:12d}", *head]) + "\n"
        return text.encode() + data + b"\n    -1\n"
    width, places = (13, 5) if kind == 2 else (20, 12)
    cells = [f"{value:{width}.{places}e}" for value in values]
    if not even:
        cells = [f"{t:13.5e}{cell}" for t, cell in zip(TIMES, cells, strict=True)]
    line = {(2, True): 6, (4, True): 4, (2, False): 3, (4, False): 2}[kind, even]
    rows = ["".join(cells[at : at + line]) for at in range(0, count, line)]
    zero = f"{0.0:{width}.{places}e}" if even else f"{0.0:13.5e}{0.0:{width}.{places}e}"
    if pad == "zeros":
        rows[-1] += zero * (-count % line)
    if pad == "blanks":
        rows = [f"{row:80}" for row in rows]
    return ("\n".join(["    -1", "    58", *head, *rows, "    -1"]) + "\n").encode()


@pytest.fixture
def write(tmp_path):
    def write(*records):
        path = tmp_path / "run.uff"
        path.write_bytes(b"".join(records))
        return path

    return write


@pytest.mark.parametrize("pad", ["", "zeros", "blanks"])
@pytest.mark.parametrize("even", [True, False])
@pytest.mark.parametrize("kind", [2, 4])
def test_values_and_times_are_what_was_written_however_lines_end(write, kind, even, pad):
    path = write(record(VALUES, kind=kind, even=even, pad=pad))
    with open_recording(path) as recording:
        assert_allclose(recording.samples()[0], VALUES, rtol=1e-12)
        assert_allclose(recording.sample_rate, RATE, rtol=1e-4)
        assert recording.expected_samples is None
        assert any("only fill" in note for note in recording.notes) == (pad == "zeros")


@pytest.mark.parametrize("kind", [2, 4])
def test_values_of_a_stored_abscissa_are_those_of_pyuff(write, kind):
    import pyuff

    path = write(record(VALUES, kind=kind, even=False))
    oracle = pyuff.UFF(str(path)).read_sets(0)
    with open_recording(path) as recording:
        assert_allclose(recording.samples()[0], oracle["data"], rtol=1e-12)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("single", [True, False])
def test_a_binary_stored_abscissa_is_read_in_both_widths(write, order, single):
    path = write(record(VALUES, kind=4, even=False, binary=True, order=order, single=single))
    with open_recording(path) as recording:
        assert_allclose(recording.samples()[0], VALUES, rtol=1e-12)
        assert_allclose(recording.sample_rate, RATE, rtol=1e-4)


@pytest.mark.parametrize(
    ("stated", "told"),
    [
        (f"{1:6d}{1:6d}", "floats of DEC VMS"),
        (f"{1:6d}{3:6d}", "floats of IBM"),
        (f"{0:6d}{2:6d}", "byte order 0"),
        (f"{7:6d}{2:6d}", "byte order 7"),
    ],
)
def test_floats_of_other_computers_are_one_line(write, stated, told):
    content = record(VALUES, kind=4, binary=True)
    assert content[7:26] == f"    58b{1:6d}{2:6d}".encode()
    path = write(content[:14] + stated.encode() + content[26:])
    with pytest.raises(RecordingError, match=told) as caught:
        open_recording(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("last", ["  1.00000E+00", "  0.00000E+00" * 7])
def test_values_that_do_not_only_fill_the_last_line_are_refused(write, last):
    content = record(VALUES).replace(b"\n    -1\n", f"{last}\n    -1\n".encode())
    with pytest.raises(RecordingError, match=r"holds 6[28] values but says 61"):
        open_recording(write(content))


def test_a_general_function_over_time_is_a_channel_and_told(write):
    path = write(record(VALUES, function=0))
    with open_recording(path) as recording:
        assert_allclose(recording.samples()[0], VALUES, rtol=1e-12)
        assert any("no stated type" in note for note in recording.notes)


def test_a_general_function_over_frequency_or_nothing_known_is_no_recording(write):
    for axis, code in ((("Frequency", "Hz"), 18), (("NONE", "NONE"), 0)):
        path = write(record(VALUES, function=0, axis=axis, code=code))
        with pytest.raises(RecordingError, match=r"no stated type \(1\)"):
            open_recording(path)


def test_functions_other_than_time_are_left_out_by_name(write):
    others = [record(VALUES, function=n, axis=("Frequency", "Hz"), code=18) for n in (4, 4, 6)]
    path = write(record(VALUES), *others)
    with open_recording(path) as recording:
        told = " ".join(recording.notes)
        assert "frequency response functions (2), coherences (1)" in told


def test_inspect_tells_spectra_as_what_they_are(write):
    path = write(
        record(VALUES, function=4), record(VALUES, function=9), record(VALUES, function=4)
    )
    done = completed("inspect", str(path))
    assert done.returncode == 0
    assert done.stdout.strip() == (
        "run.uff: no samples over time: frequency response functions (2), "
        "power spectral densities (1)"
    )


@pytest.mark.parametrize("kept", [1, 2])
def test_a_file_of_ours_that_is_cut_between_two_records_says_so(tmp_path, kept):
    path = tmp_path / "cut.uff"
    channels = [Channel(name, "N", name, "N") for name in "abc"]
    write_uff(path, recording_of_arrays("run", channels, np.ones((3, 40)), 100.0))
    content = path.read_bytes()
    begins = [match.start() for match in re.finditer(rb"    -1\n    58", content)]
    path.write_bytes(content[: begins[kept]])
    with open_recording(path) as found:
        assert len(found.channels) == kept
        assert f"The file is not whole: {3 - kept} of 3 records are missing." in found.notes
