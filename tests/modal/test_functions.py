"""Modes of response functions that another program has written; the oracle is a closed form."""

import contextlib
import json

import h5py
import numpy as np
import pytest
import pyuff
from numpy.testing import assert_allclose, assert_array_equal
from scipy import io as scipy_io
from tests.in_process import run
from tests.modal.function_files import (
    DAMPING,
    FREQUENCIES,
    LINES,
    SHAPES,
    accelerance,
    copied_table,
    nodes,
    record,
    write,
)

import shakerproc
from shakerproc.errors import RecordingError, SpectrumError
from shakerproc.modal import mac
from shakerproc.recordings import matlab
from shakerproc.recordings.response_functions import read_functions

ALL = [0, 1, 2, 3]


def check(modes, shapes=SHAPES):
    assert_allclose(modes.frequency, FREQUENCIES, rtol=1e-4)
    assert_allclose(modes.damping, DAMPING, rtol=0.01)
    assert_array_equal(np.diag(mac(modes.shapes, shapes)) > 0.999, True)


@pytest.mark.parametrize("binary", [0, 1])
def test_modes_of_functions_in_a_universal_file(tmp_path, binary):
    path, values = tmp_path / "plate.uff", accelerance(ALL, [0])
    points = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.2, 0.0, 0.0], [0.3, 0.05, 0.0]]
    records = [record(values[r, 0], r, 0, binary=binary) for r in ALL]
    write(path, [nodes(points), *records])
    found = shakerproc.modes(path).found.tests[0]
    check(found.modes)
    assert found.sensor_names == ["1/z", "2/z", "3/z", "4/z"]
    assert_allclose(found.positions, points)
    assert found.directions[0] == (0.0, 0.0, 1.0)
    assert_allclose(found.unexplained, 0.0, atol=0.01)


def test_a_roving_hammer_tells_the_same_shapes(tmp_path):
    path, values = tmp_path / "hammer.unv", accelerance([1], ALL)
    write(path, [record(values[0, c], 1, c) for c in ALL])
    found = shakerproc.modes(path).found.tests[0]
    check(found.modes)
    assert any("reciprocity" in note for note in found.notes)


def test_spectra_are_made_response_functions(tmp_path):
    """H1 of cross and auto spectra is what they were made from."""
    path, values = tmp_path / "spectra.uff", accelerance(ALL, [0])
    auto = (2.0 + np.sin(LINES / 30.0)).astype(np.complex128)
    sets = [record(auto, 0, 0, kind=2, ordinate_axis_units_lab="N", ordinate_spec_data_type=13)]
    sets += [record(auto * values[r, 0], r, 0, kind=3) for r in ALL]
    write(path, sets)
    found = read_functions(path)
    assert_allclose(found.values, values, rtol=1e-4, atol=1e-5)
    assert (found.response_units[0], found.input_units) == ("m/s^2", ("N",))


def test_units_of_a_file_are_those_it_says_or_those_of_its_system(tmp_path):
    path, values = tmp_path / "units.uff", accelerance(ALL, [0])
    write(path, [record(values[0, 0] / 9.80665, 0, 0, ordinate_axis_units_lab="g")])
    assert_allclose(read_functions(path).values[0, 0], values[0, 0], rtol=1e-5, atol=1e-6)
    millimetres = pyuff.prepare_164(
        units_code=5, length=1000.0, force=1.0, temp=1.0, temp_offset=0.0
    )
    plain = {"ordinate_axis_units_lab": "NONE", "orddenom_axis_units_lab": "NONE"}
    write(path, [
        millimetres, nodes([[0.1, 0.2, 0.3]], 1000.0), record(1e3 * values[0, 0], 0, 0, **plain)
    ])  # fmt: skip
    found = read_functions(path)
    assert_allclose(found.values[0, 0], values[0, 0], rtol=1e-5, atol=1e-6)
    assert_allclose(found.positions, [(0.1, 0.2, 0.3)])
    assert any("do not say their unit" in note for note in found.notes)


def test_coherence_belongs_to_its_function(tmp_path):
    path, values = tmp_path / "coherence.uff", accelerance(ALL, [0])
    coherence = 0.5 + 0.4 * np.cos(LINES / 50.0)
    sets = [record(values[r, 0], r, 0) for r in ALL]
    sets += [record(coherence, r, 0, kind=6) for r in ALL]
    write(path, sets)
    found = read_functions(path)
    assert_allclose(found.coherence[2, 0], coherence, rtol=1e-4)
    write(path, sets[:-1])
    assert read_functions(path).coherence is None


def tables(path, values, *, polar=False, unit="m/s^2/N"):
    """A table of text of functions to place 1."""
    header, columns = ["frequency [Hz]"], [LINES]
    for number, one in enumerate(values):
        name = f"{number + 1}/z to 1/z"
        if polar:
            header += [f"{name} magnitude [{unit}]", f"{name} phase [deg]"]
            columns += [np.abs(one), np.degrees(np.angle(one))]
        else:
            header += [f"{name} real [{unit}]", f"{name} imag"]
            columns += [one.real, one.imag]
    rows = [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([",".join(header), *rows]) + "\n")


@pytest.mark.parametrize("polar", [False, True])
def test_modes_of_a_table(tmp_path, polar):
    path = tmp_path / "table.csv"
    tables(path, accelerance(ALL, [0])[:, 0], polar=polar)
    check(shakerproc.modes(path).found.tests[0].modes)


@pytest.mark.parametrize("ending", [".txt", ".xlsx", ".parquet", ".feather"])
def test_functions_are_read_from_whatever_is_a_table(tmp_path, ending):
    path, values = tmp_path / "table.csv", accelerance(ALL, [0])
    tables(path, values[:, 0])
    other = copied_table(path, ending)
    assert_allclose(read_functions(other).values, values, rtol=1e-12, atol=1e-15)


def test_modes_of_arrays_of_matlab(tmp_path):
    path, values = tmp_path / "frf.mat", accelerance(ALL, [0, 2])
    content = {
        "f": LINES[:, None], "H": np.moveaxis(values, -1, 0), "response_unit": "m/s^2",
        "input_unit": "N", "inputs": np.array(["p1", "p3"], dtype=object),
    }  # fmt: skip
    scipy_io.savemat(path, content)
    found = shakerproc.modes(path).found.tests[0]
    check(found.modes)
    assert found.inputs == ("p1", "p3")


POWER = 2.0 + np.cos(LINES / 40.0)
"""Density of the force [N^2/Hz]."""


@pytest.mark.parametrize(
    ("cross", "auto"),
    [
        ("m/s^2*N/Hz", "auto [N^2/Hz]"),
        ("(m/s^2) N", "PSD [N²]"),
        ("m/s^2·kN/Hz", "auto [N^2/Hz]"),
    ],
)
def test_cross_and_auto_spectra_of_a_table_are_made_response_functions(tmp_path, cross, auto):
    path, values = tmp_path / "spectra.csv", accelerance(ALL, [0])
    tables(path, values[:, 0] * POWER / (1000.0 if "kN" in cross else 1.0), unit=cross)
    header, *rows = path.read_text().splitlines()
    header = header.replace(" real", " cross real").replace(" imag", " cross imag")
    rows = [f"{row},{float(one)!r}" for row, one in zip(rows, POWER, strict=True)]
    path.write_text("\n".join([f"{header},1/z {auto}", *rows]) + "\n")
    found = read_functions(path)
    assert (found.response_units, found.input_units) == (("m/s^2",) * 4, ("N",))
    assert_allclose(found.values, values, rtol=1e-12)


def test_arrays_of_matlab_7_3_are_read_with_their_names(tmp_path):
    """As MATLAB lays them out: axes the other way round, complex numbers as pairs."""
    path, values = tmp_path / "frf.mat", accelerance(ALL, [0])
    stored = np.zeros(values.T.shape[::-1], [("real", "f8"), ("imag", "f8")])
    stored["real"], stored["imag"] = values.real, values.imag
    with h5py.File(path, "w", userblock_size=512) as file:
        file["H"], file["f"] = stored.swapaxes(0, 1), LINES[:, None]
        for name, text in {"response_unit": "m/s^2", "input_unit": "N", "inputs": "p1"}.items():
            file[name] = np.array([[ord(letter)] for letter in text], dtype=np.uint16)
            file[name].attrs["MATLAB_class"] = np.bytes_("char")
    found = read_functions(path)
    assert found.inputs == ("p1",)
    assert_allclose(found.values, values, rtol=1e-12)


def test_variables_of_other_files_and_of_more_than_memory_holds_are_not_taken(
    tmp_path, monkeypatch
):
    path, values = tmp_path / "frf.mat", np.ones((4, 5))
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["H"] = values
    with h5py.File(path, "w", userblock_size=512) as file:
        file["H"], file["f"] = h5py.ExternalLink("other.h5", "/H"), values
    assert list(matlab.hdf5_variables(path, "frf.mat")) == ["f"]
    monkeypatch.setattr(matlab, "LARGEST", 16 * values.size - 1)
    with pytest.raises(
        RecordingError, match=r"variable f holds 20 numbers, .* Save the functi"
    ):
        matlab.hdf5_variables(path, "frf.mat")


def test_a_damaged_file_of_matlab_is_read_or_refused_and_ends_nothing(tmp_path):
    path, rng = tmp_path / "frf.mat", np.random.default_rng(7)
    content = {"f": LINES[:9], "H": accelerance(ALL, [0]).T[:9, 0], "input_unit": "N"}
    scipy_io.savemat(path, content | {"response_unit": "m/s^2"})
    whole, refused = path.read_bytes(), 0
    for at in rng.integers(128, len(whole), 100):
        damaged = bytearray(whole)
        damaged[at] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        with contextlib.suppress(RecordingError):
            read_functions(path)
            refused -= 1
        refused += 1
    assert refused > 10


def test_cross_and_auto_spectra_of_matlab_are_made_response_functions(tmp_path):
    path, values = tmp_path / "spectra.mat", accelerance(ALL, [0, 2])
    both = np.array([POWER, 3.0 * POWER])
    content = {
        "f": LINES, "Gyx": np.moveaxis(values * both, -1, 0), "Gxx": both.T,
        "response_unit": "m/s^2", "input_unit": "N",
    }  # fmt: skip
    scipy_io.savemat(path, content)
    assert_allclose(read_functions(path).values, values, rtol=1e-12)
    scipy_io.savemat(path, content | {"Gxx": POWER})
    with pytest.raises(RecordingError, match="auto spectrum of 1 x 1 channels beside"):
        read_functions(path)


def test_the_command_writes_tables_and_report_without_a_log(tmp_path):
    path, out = tmp_path / "plate.uff", tmp_path / "out"
    values = accelerance(ALL, [0])
    write(path, [record(values[r, 0], r, 0) for r in ALL])
    document_path = tmp_path / "modes.json"
    assert run("modal", path, "--out", out, "--no-figures", "--json", document_path) == 0
    document = json.loads(document_path.read_text())
    modes = document["tests"][0]["modes"]
    assert_allclose([m["frequency_hz"]["value"] for m in modes], FREQUENCIES, rtol=1e-4)
    assert "modal model" in (out / "report.html").read_text()
    assert len((out / "modes.csv").read_text().splitlines()) == 4


def refused(path):
    with pytest.raises((RecordingError, SpectrumError)) as caught:
        shakerproc.modes(path)
    line = str(caught.value)
    assert "\n" not in line
    return line


def test_a_command_that_is_refused_leaves_no_folder(tmp_path):
    table, out = tmp_path / "bad.csv", tmp_path / "out"
    table.write_text("time [s],a [g]\n0,1\n")
    assert run("modal", table, "--out", out) == 1
    assert not out.exists()


def test_what_is_wrong_with_functions_is_one_line(tmp_path):
    path, values = tmp_path / "bad.uff", accelerance(ALL, [0])
    write(path, [record(values[0, 0], 0, 0), record(values[1, 0], 0, 0)])
    assert "record 1 and record 2 are both of 1/z to 1/z" in refused(path)
    other = LINES[:400]
    write(path, [record(values[0, 0], 0, 0), record(values[1, 0, :400], 1, 0, lines=other)])
    assert "has other frequencies" in refused(path)
    write(path, [record(values[0, 0].real.copy(), 0, 0, kind=1)])
    assert "no response functions in it" in refused(path)
    write(path, [record(values[0, 0], 0, 0, ordinate_axis_units_lab="furlong")])
    assert "the unit 'furlong' is unknown" in refused(path)
    write(path, [record(values[r, 0], r, 0) for r in ALL])
    path.write_bytes(path.read_bytes()[:30_000])
    assert "ends inside record" in refused(path)
    table = tmp_path / "bad.csv"
    table.write_text("time [s],a [g]\n0,1\n")
    assert "no column of frequencies" in refused(table)
    tables(table, values[:, 0])
    table.write_text(table.read_text().replace("0.5,", "half,", 1))
    assert "bad.csv: line 3: 'half' in column 1 is no number" in refused(table)
    table.write_text("frequency [Hz],a [g]\n0.5,1\n1.0,1\n")
    assert "bad.csv: no response functions in the columns 'a [g]'" in refused(table)
    tables(table, values[:, 0], unit="")
    assert "the unit is not said" in refused(table)
    matlab = tmp_path / "bad.mat"
    scipy_io.savemat(matlab, {"x": np.arange(3)})
    assert "expected an array frf (or H)" in refused(matlab)
