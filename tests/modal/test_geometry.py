"""Nodes, lines and surfaces: read, refused, drawn, written; the oracle is pyuff or by hand."""

import csv
import re

import numpy as np
import pytest
import pyuff
from numpy.testing import assert_allclose, assert_array_equal
from tests.in_process import run
from tests.modal.function_files import (
    DAMPING,
    FREQUENCIES,
    LINES,
    SHAPES,
    accelerance,
    nodes,
    record,
    write,
)

import shakerproc
from shakerproc.errors import DocumentError, LogError, RecordingError
from shakerproc.modal.geometry import geometry_of
from shakerproc.recordings.response_functions import read_functions
from shakerproc.report.modal.figures import moving_shape
from shakerproc.testlog import read_testlog

pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning")  # pyuff leaves files open

ALL = [0, 1, 2, 3]
CORNERS = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.4, 0.3, 0.0], [0.0, 0.3, 0.0], [0.2, 0.1, -0.1]]
LOG = """\
testlog: 1
geometry:
  nodes: {1: [0 mm, 0 mm, 0 mm], 2: [0.4 m, 0 m, 0 m], 3: [400 mm, 300 mm, 0 mm]}
  lines: [[1, 2, 3]]
  surfaces: [[1, 2, 3]]
channels:
  a: {role: response, node: 2, direction: -z}
tests: []
"""


def plate(path, *more):
    """Functions of four corners of a plate, a fifth node below it, two lines, one surface."""
    quad = {
        "element_nums": 1, "fe_descriptor": 94, "phys_table": 1, "mat_table": 1, "color": 1,
        "num_nodes": 4, "nodes_nums": [1, 2, 3, 4],
    }  # fmt: skip
    values = accelerance(ALL, [0])
    sets = [
        pyuff.prepare_164(units_code=5, length=1000.0, force=1.0, temp=1.0, temp_offset=0.0),
        nodes(CORNERS, 1000.0),
        pyuff.prepare_82(trace_num=1, n_nodes=7, nodes=np.array([1, 2, 0, 3, 4, 0, 5, 1])),
        {"type": 2412, 94: [quad]},
        *(record(values[r, 0], r, 0) for r in ALL),
        *more,
    ]
    write(path, sets)
    return path


def refused(path):
    with pytest.raises((DocumentError, LogError)) as caught:
        read_testlog(path)
    line = str(caught.value)
    assert "\n" not in line
    return line


def test_a_universal_file_holds_lines_and_surfaces_with_its_functions(tmp_path):
    found = read_functions(plate(tmp_path / "plate.uff"))
    wireframe = found.wireframe
    assert_allclose(list(wireframe.nodes.values()), CORNERS)
    assert wireframe.lines == ((1, 2), (3, 4), (5, 1))
    assert wireframe.surfaces == ((1, 2, 3, 4),)
    assert set(wireframe.edges) == {(1, 2), (2, 3), (3, 4), (1, 4), (1, 5)}
    assert_allclose(found.positions, CORNERS[:4])


def test_directions_are_those_of_the_coordinate_system_of_a_node(tmp_path):
    """Node 2 measures in a system whose z is the global x: points by hand, as of Testlab."""
    path = plate(tmp_path / "turned.uff")
    system = (
        "    -1\n    18\n         7         0         0         8         1\nSYS7\n"
        "  4.00000e+02  0.00000e+00  0.00000e+00  4.00000e+02  1.00000e+00  0.00000e+00\n"
        "  5.00000e+02  0.00000e+00  0.00000e+00\n    -1\n"
    )
    text = path.read_text()
    line = re.search(r"^ {9}2 .*4\.00000E\+02.*$", text, re.MULTILINE)[0]
    path.write_text(system + text.replace(line, line[:20] + f"{7:10d}" + line[30:]))
    found = read_functions(path)
    assert_allclose(found.directions[1], [1.0, 0.0, 0.0], atol=1e-12)
    assert_allclose(found.directions[0], [0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("lines: [[1, 2, 3]]", "lines: [[1, 9]]", "4:11: geometry.lines.1: node 9 has"),
        ("surfaces: [[1, 2, 3]]", "surfaces: [[1, 2, 2]]", "expected 3 nodes or more, got 1"),
        ("node: 2", "node: 9", "channels.a.node: node 9 has no coordinates; those that have"),
        ("node: 2", "node: 2, position: [0 m, 0 m, 0 m]", "expected node or position"),
        ("1: [0 mm, 0 mm, 0 mm]", "1: [0 mm, 0 mm]", "geometry.nodes.1: expected 3 values"),
        ("1: [0 mm, 0 mm, 0 mm]", "1: [0, 0, 0]", "expected"),
    ],
)  # fmt: skip
def test_a_geometry_that_does_not_fit_is_one_line_at_its_place(tmp_path, old, new, message):
    path = tmp_path / "log.yaml"
    path.write_text(LOG.replace(old, new))
    assert message in refused(path)


def test_a_node_wants_a_geometry(tmp_path):
    path = tmp_path / "log.yaml"
    path.write_text(re.sub(r"geometry:.*?channels", "channels", LOG, flags=re.DOTALL))
    assert "expected geometry: beside channels:" in refused(path)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("node,x [mm],y [mm],z [mm]\n1,0,0,0\n2,5,,0\n", "nodes.csv:3: node 2 has no y"),
        ("node,x [mm],y [in],z [mm]\n1,0,0,0\n", "one unit for x, y and z"),
        ("node,x,y,z\n1,0,0,0\n", "nodes.csv:1: expected one unit"),
        ("node,x [mm],y [mm]\n1,0,0\n", "expected a header"),
        ("node,x [mm],y [mm],z [mm]\n1,0,0,0\n1,1,0,0\n", "node 1 stands twice"),
        ("node,x [mm],y [mm],z [mm]\n1,0,zero,0\n", "nodes.csv:2: node 1"),
        ("node,x [V],y [V],z [V]\n1,0,0,0\n", "nodes.csv:2: node 1"),
        ("", "got an empty file"),
    ],
)
def test_a_table_of_nodes_that_is_none_is_one_line(tmp_path, table, message):
    (tmp_path / "nodes.csv").write_text(table)
    path = tmp_path / "log.yaml"
    path.write_text(re.sub(r"nodes: \{.*\}", "nodes: nodes.csv", LOG))
    assert message in refused(path)


def test_nodes_of_a_table_and_of_a_universal_file_are_positions_of_channels(tmp_path):
    path = tmp_path / "log.yaml"
    (tmp_path / "nodes.csv").write_text("node;x [mm];y [mm];z [mm]\n1;0;0;0\n2;400,5;0;3\n")
    path.write_text("testlog: 1\ngeometry: nodes.csv\n" + LOG[LOG.index("channels") :].replace(
        "tests: []", "tests: [{id: 1, recording: a.csv}]"))  # fmt: skip
    (test,) = read_testlog(path).tests
    assert_allclose(test.channels[0].position, [0.4005, 0.0, 0.003])
    plate(tmp_path / "plate.uff")
    path.write_text(path.read_text().replace("nodes.csv", "plate.uff"))
    (test,) = read_testlog(path).tests
    assert_allclose(test.channels[0].position, CORNERS[1])
    assert test.geometry.surfaces == ((1, 2, 3, 4),)


def test_a_universal_file_that_contradicts_itself_is_one_line(tmp_path):
    path, log = tmp_path / "plate.uff", tmp_path / "log.yaml"
    log.write_text("testlog: 1\ngeometry: plate.uff\ntests: []\n")
    extra = pyuff.prepare_82(trace_num=2, n_nodes=2, nodes=np.array([1, 77]))
    plate(path, extra)
    assert "line 1-77: node 77 has no coordinates; those that have are 1 to 5" in refused(log)
    notes = read_functions(path).notes  # what was measured counts, the line is told
    assert any("node 77 has no coordinates" in note for note in notes)
    plate(path, pyuff.prepare_164(
        units_code=1, length=1.0, force=1.0, temp=1.0, temp_offset=0.0))  # fmt: skip
    assert "1000 and 1 units of length in a metre" in refused(log)
    with pytest.raises(RecordingError, match="data sets 164 differ"):
        read_functions(path)
    write(path, [record(accelerance([0], [0])[0, 0], 0, 0)])
    assert "no nodes in it" in refused(log)
    path.write_text("    -1\n  2411\n         1         0         0         1\n    -1\n")
    assert "node 1 of data set 2411 has no" in refused(log)
    log.write_text("testlog: 1\ngeometry: plate.stl\ntests: []\n")
    assert "expected a file .uff, .unv or .csv" in refused(log)
    log.write_text("testlog: 1\ngeometry: none.uff\ntests: []\n")
    assert "no such file" in refused(log)


def texts(svg):
    return {text: int(x) for x, text in re.findall(r'<text x="(\d+)"[^>]*>([^<]+)<', svg)}


def test_names_stand_at_their_sensors_in_whatever_order_these_are():
    """Along a line, names from left to right are those of rising positions."""
    geometry = geometry_of([(0.3, 0, 0), (0.0, 0, 0), (0.15, 0, 0)], [(0, 0, 1.0)] * 3)
    shape = np.array([1.0, 0.2, 0.5], complex)
    found = texts(str(moving_shape(geometry, shape, ["tip", "foot", "middle"], "shape")))
    assert sorted(found, key=found.get) == ["foot", "middle", "tip"]


def test_a_triaxial_sensor_moves_its_place_along_the_sum_and_skew_ones_by_least_squares():
    """A motion (1, 2, 3) seen along three axes, and (0, 1, 1) along y and a skew axis."""
    skew = (0.0, np.sqrt(0.5), np.sqrt(0.5))
    seats = [(0.0, 0.0, 0.0)] * 3 + [(1.0, 0.0, 0.0)] * 2 + [(0.0, 1.0, 0.0)] * 2
    along = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0), skew, (0, 0, 1), (0, 0, 1)]
    drawn = geometry_of(seats, along)
    shape = np.array([1, 2, 3, 1, np.sqrt(2.0), 4, 4], complex)
    moved = drawn.moved(shape, 0.0) - drawn.rest
    by_axis = {i: drawn.motion[i, drawn.seats[0]] for i in range(3)}
    assert_allclose(moved[drawn.seats[5]], 4 * by_axis[2], atol=1e-12)  # two alike count once
    assert_allclose(moved[drawn.seats[0]], by_axis[0] + 2 * by_axis[1] + 3 * by_axis[2])
    assert_allclose(moved[drawn.seats[3]], by_axis[1] + by_axis[2], atol=1e-12)
    labels = drawn.labels(["x", "y", "z", "b1", "b2", "c1", "c2"])
    assert labels[drawn.seats[0]] == "x, y, z"


def test_modes_go_out_with_geometry_and_functions_as_pyuff_reads_them(tmp_path):
    """A receptance summed from the shapes, poles and modal A of the file is the closed form."""
    path, out = plate(tmp_path / "plate.uff"), tmp_path / "out"
    assert run("modal", path, "--out", out, "--no-figures") == 0
    sets = pyuff.UFF(str(out / "test_plate.uff")).read_sets()
    kinds = [int(one["type"]) for one in sets]
    assert kinds == [151, 164, 2411, 82, 82, 82, 2412, 55, 55, 55, 58, 58, 58, 58]
    geometry = dict(zip(kinds[:7], sets, strict=False))
    assert (geometry[164]["length"], geometry[164]["force"]) == (1.0, 1.0)
    points = np.column_stack([geometry[2411][axis] for axis in "xyz"])
    assert_allclose(points, CORNERS)
    assert_array_equal(sets[3]["nodes"], [1, 2])
    assert_array_equal(geometry[2412][94][0]["nodes_nums"], [1, 2, 3, 4])
    omega, receptance = 2.0 * np.pi * LINES[1:], 0.0
    for number, one in enumerate(sets[7:10]):
        own = 2.0 * np.pi * FREQUENCIES[number]
        assert_allclose(one["eig"].imag, own * np.sqrt(1 - DAMPING[number] ** 2), rtol=1e-4)
        assert_allclose(-one["eig"].real / own, DAMPING[number], rtol=0.01)
        assert_array_equal(one["node_nums"], [1, 2, 3, 4])
        shape, a, pole = one["r3"], one["modal_a"], one["eig"]
        part = np.outer(shape, shape[0]) / a
        receptance = receptance + part @ (1.0 / (1j * omega - pole))[None]
        receptance = receptance + part.conj() @ (1.0 / (1j * omega - np.conj(pole)))[None]
        assert_allclose(np.abs(a) / (2 * own), 1 / np.max(SHAPES[number] ** 2), rtol=0.02)
    exact = accelerance(ALL, [0], noise=0.0)[:, 0, 1:] / -(omega**2)
    assert np.linalg.norm(receptance - exact) < 0.02 * np.linalg.norm(exact)
    measured = read_functions(path)
    for row, one in enumerate(sets[10:]):
        assert (one["func_type"], one["rsp_node"], one["rsp_dir"]) == (4, row + 1, 3)
        assert (one["ref_node"], one["ref_dir"], one["binary"]) == (1, 3, 0)
        inside = np.isin(measured.frequency.round(3), one["x"].round(3))
        assert_allclose(one["data"], measured.values[row, 0, inside], rtol=1e-11)
    again = read_functions(out / "test_plate.uff")
    assert set(again.wireframe.edges) == set(measured.wireframe.edges)
    with (out / "shapes.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 12


def patched(path, old, new):
    """Give the records 58 of a file a type that pyuff does not write."""
    text = path.read_text()
    path.write_text(re.sub(rf"^{old:5d}( {{9}}0 {{4}}0)", rf"{new:5d}\1", text, flags=re.M))


def test_transmissibilities_are_response_functions(tmp_path):
    path, values = tmp_path / "base.uff", accelerance([1, 2], [0])
    base = {"orddenom_spec_data_type": 12, "orddenom_axis_units_lab": "m/s^2"}
    write(path, [record(values[r, 0], r + 1, 0, **base) for r in (0, 1)])
    patched(path, 4, 5)
    found = read_functions(path)
    assert found.input_units == ("m/s^2",)
    assert_allclose(found.values, values, rtol=1e-4, atol=1e-5)


def test_spectra_of_one_record_are_divided_by_that_of_the_force(tmp_path):
    path, values = tmp_path / "spectra.uff", accelerance([1, 2], [0])
    force = 2.0 + np.exp(1j * LINES / 20.0)
    newton = {"ordinate_spec_data_type": 13, "ordinate_axis_units_lab": "N"}
    sets = [record(force, 0, 0, **newton)]
    sets += [record(force * values[r, 0], r + 1, 0) for r in (0, 1)]
    write(path, sets)
    patched(path, 4, 12)
    found = read_functions(path)
    assert_allclose(found.values, values, rtol=2e-4, atol=1e-4)
    assert (found.inputs, found.input_units) == (("1/z",), ("N",))
    assert any("ratios of spectra of one record" in note for note in found.notes)
    write(path, [sets[0], record(force, 3, 0, **newton), *sets[1:]])
    patched(path, 4, 12)
    with pytest.raises(RecordingError, match="no response functions in it: spectrum"):
        read_functions(path)


def test_a_multiple_coherence_counts_for_every_input(tmp_path):
    path, values = tmp_path / "several.uff", accelerance(ALL, [0, 1])
    coherence = 0.5 + 0.4 * np.cos(LINES / 50.0)
    sets = [record(values[r, c], r, c) for r in ALL for c in (0, 1)]
    write(path, sets + [record(coherence, r, -1, kind=6) for r in ALL])
    patched(path, 6, 26)
    found = read_functions(path)
    assert_allclose(found.coherence, np.broadcast_to(coherence, (4, 2, LINES.size)), rtol=1e-4)


def test_the_page_of_a_plate_has_lines_surface_and_note(tmp_path):
    modes = shakerproc.modes(plate(tmp_path / "plate.uff"))
    classes = re.findall(r'<path class="(\w+)"', modes.shape(1).svg)
    assert classes[:4] == ["rest", "face", "c0", "d0"]
    assert any("1 of 5 nodes have no sensor" in n for n in modes.found.tests[0].notes)
    figure = modes.plot("test_plate_shapes")
    assert [len(c.get_segments()) for c in figure.axes[0].collections] == [5, 4, 4]
