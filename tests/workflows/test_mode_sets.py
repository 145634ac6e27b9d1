# ruff: noqa: E501 - one mistake a row
"""Modes of one program written for another, and at the places of sensors."""

import csv
from pathlib import Path

import numpy as np
import pytest
import pyuff
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from shakerproc.cli import build_app
from shakerproc.errors import ArgumentError, ShakerprocError
from shakerproc.model_files.schema import read_structure
from shakerproc.workflows.mode_sets import ModeOptions, convert_modes

BEAM = Path(__file__).parents[1] / "exchange" / "calculix"
SI = ModeOptions("t", "mm", 0.01)
MASS = 1.884
LOG = """\
testlog: 1
title: beam
recordings: .
channels:
  table: {{role: control}}
  tip acc: {{role: response, name: tip, {tip}}}
  mid acc: {{role: response, name: middle, {middle}}}
tests:
  - {{id: 1, recording: a.tdms, excitation: hammer}}
"""
TIP, MIDDLE = (
    "position: [603 mm, 4 mm, 0 mm], direction: z",
    "position: [300 mm, 0 mm, 0 mm], direction: -z",
)


def numbers(path):
    """Return the lines of a result file that hold nodes with three numbers, and their frequencies."""
    lines = path.read_text().splitlines()
    return [line for line in lines if line.startswith((" -1", "  100CL")) and len(line) > 40]


def log_of(folder, tip=TIP, middle=MIDDLE):
    (folder / "log.yaml").write_text(LOG.format(tip=tip, middle=middle))
    return folder / "log.yaml"


def test_a_result_file_has_the_lines_that_calculix_wrote_of_the_same_modes(tmp_path):
    """Those of nodes without a mode and of elements apart."""
    convert_modes(BEAM / "held.frd", tmp_path / "held.frd", ModeOptions("kg", "m"))
    ours, theirs = numbers(tmp_path / "held.frd"), numbers(BEAM / "held.frd")
    left = [line for line in theirs if line not in set(ours)]
    count = len({line[3:13] for line in ours if line.startswith(" -1")})
    assert len(ours) == 6 * (count + 1) + count
    assert len(theirs) - len(left) == len(ours)
    assert [line for line in ours if line.startswith("  100CL")] == [
        line for line in theirs if line.startswith("  100CL")
    ]


def test_pyuff_reads_frequencies_nodes_and_shapes_of_a_cantilever(tmp_path):
    """Shapes of 2 / sqrt(m) at the free end: R. D. Blevins, 1979, table 8-1."""
    convert_modes(BEAM / "held.frd", tmp_path / "held.uff", SI)
    file = pyuff.UFF(str(tmp_path / "held.uff"))
    modes = [one for one in file.read_sets() if one["type"] == 55]
    nodes = next(one for one in file.read_sets() if one["type"] == 2411)
    first = modes[0]
    tip = list(first["node_nums"]).index(141)
    assert first["modal_m"] == 1.0
    assert first["modal_damp_vis"] == 0.01
    assert first["freq"] == pytest.approx(23.5489, rel=1e-5)  # held.dat
    assert abs(first["r3"][tip]) == pytest.approx(2.0 / np.sqrt(MASS), rel=0.02)
    assert nodes["x"][list(nodes["node_nums"]).index(141)] == pytest.approx(0.6)
    assert file.read_sets(1)["length"] == 1.0  # data set 164: metres


def test_a_punch_file_has_the_fields_of_the_format(tmp_path):
    """Nastran Quick Reference, PUNCH: node and G, three fields of 18, the rotations below."""
    convert_modes(BEAM / "held.frd", tmp_path / "held.pch", SI)
    lines = (tmp_path / "held.pch").read_text().splitlines()
    assert {len(line) for line in lines} == {80}
    assert [int(line[72:]) for line in lines] == list(range(1, len(lines) + 1))
    heads = [line for line in lines if line.startswith("$EIGENVALUE")]
    square = float(heads[0][13:28])
    assert np.sqrt(square) / (2.0 * np.pi) == pytest.approx(23.5489, rel=1e-5)
    assert heads[2][28:72].split() == ["MODE", "=", "3"]
    tip = next(line for line in lines if line[:10].strip() == "141")
    assert tip[10:18].strip() == "G"
    assert abs(float(tip[54:72])) == pytest.approx(2.0 / np.sqrt(MASS), rel=0.02)


def test_a_table_has_a_row_for_each_mode_and_a_column_for_each_point(tmp_path):
    options = ModeOptions("t", "mm", 0.01, at=["tip=141 z", "middle=69/z"])
    found = convert_modes(BEAM / "held.frd", tmp_path / "held.csv", options)
    with (tmp_path / "held.csv").open() as file:
        first = next(csv.DictReader(file))
    assert abs(float(first["tip"])) == pytest.approx(2.0 / np.sqrt(MASS), rel=0.02)
    assert float(first["middle"]) / float(first["tip"]) == pytest.approx(0.3395, rel=0.02)
    assert abs(float(first["participation"])) == pytest.approx(0.7830 * np.sqrt(MASS), rel=0.01)
    assert found.notes == ("the format does not hold positions",)


CHAINS = [
    [".uff"],
    [".csv"],
    [".uff", ".csv"],
    [".unv", ".frd"],
    [".frd", ".pch", ".uff"],
    [".pch", ".yaml", ".uff"],
]


@pytest.mark.parametrize("endings", CHAINS, ids="-".join)
def test_modes_are_the_same_through_other_formats(tmp_path, endings):
    """To the six digits that universal and result files have."""
    points = ["foot/z=1 z", "middle/y=69 y", "tip/z=141 z", "tip/y=141 y"]
    numbered = [
        f"{p}={n}"
        for p, n in zip(
            ["foot/z", "middle/y", "tip/z", "tip/y"],
            ["1/z", "69/y", "141/z", "141/y"],
            strict=True,
        )
    ]
    before = tmp_path / "before.yaml"
    convert_modes(BEAM / "held.frd", before, ModeOptions("t", "mm", 0.01, "z", points))
    here = BEAM / "held.frd"
    for i, ending in enumerate(endings):
        there = tmp_path / f"{i}{ending}"
        units = ("t", "mm") if here.parent == BEAM else ("kg", "m")
        asked = here.suffix in {".frd", ".pch"}
        convert_modes(here, there, ModeOptions(*(units if asked else (None, None)), 0.01))
        here = there
    asked = here.suffix in {".frd", ".pch"}
    options = ModeOptions(*(("kg", "m") if asked else (None, None)), 0.01, "z", numbered)
    convert_modes(here, tmp_path / "after.yaml", options)
    one, other = read_structure(before), read_structure(tmp_path / "after.yaml")
    assert one.points == other.points
    assert_allclose(other.shapes, one.shapes, rtol=1e-5, atol=1e-5)
    assert_allclose(
        [m.frequency for m in other.modes], [m.frequency for m in one.modes], rtol=1e-5
    )
    assert [m.damping_ratio for m in other.modes] == [0.01] * len(one.modes)


def test_sensors_are_at_the_nearest_nodes_and_the_distance_is_told(tmp_path):
    options = ModeOptions("t", "mm", 0.01, sensors=log_of(tmp_path))
    found = convert_modes(BEAM / "held.frd", tmp_path / "held.yaml", options)
    assert "tip: 141/z, 5 mm from its position" in found.notes  # 3, 4, 5
    assert (
        "middle: 69/z, 0 mm from its position, against its direction: declare sensor_polarity"
        in found.notes
    )
    structure = read_structure(tmp_path / "held.yaml")
    assert structure.points == ("tip", "middle")
    assert structure.modes[0].shape[1] / structure.modes[0].shape[0] == pytest.approx(
        0.3395, rel=0.02
    )
    assert abs(structure.participations[0]) == pytest.approx(0.7830 * np.sqrt(MASS), rel=0.01)
    assert "# tip: 141/z, 5 mm from its position" in (tmp_path / "held.yaml").read_text()


def test_a_place_of_the_name_of_a_sensor_counts_before_the_nearest_node(tmp_path):
    """And sensors along several axes are points with their directions."""
    convert_modes(
        BEAM / "held.frd",
        tmp_path / "a.yaml",
        ModeOptions("t", "mm", 0.01, at=["tip/z=69 z", "middle/x=141 x"]),
    )
    log = log_of(tmp_path, middle="at: middle, direction: x")
    found = convert_modes(tmp_path / "a.yaml", tmp_path / "b.yaml", ModeOptions(sensors=log))
    assert found.notes[:2] == ("tip/z: tip/z", "middle/x: middle/x")
    one, other = read_structure(tmp_path / "a.yaml"), read_structure(tmp_path / "b.yaml")
    assert_allclose(other.shapes, one.shapes, rtol=1e-12)


def test_a_node_beyond_the_mesh_is_told_as_far(tmp_path):
    log = log_of(tmp_path, tip="position: [6.0 m, 0 m, 0 m], direction: z")
    found = convert_modes(
        BEAM / "held.frd", tmp_path / "held.yaml", ModeOptions("t", "mm", 0.01, sensors=log)
    )
    assert any(
        one.startswith("tip: 141/z, 5.4e+03 mm from its position, farther than")
        for one in found.notes
    )


def test_modes_of_a_test_are_real_ones_scaled_by_modal_a(tmp_path):
    """In closed form: the residue of a mass-normalised mode is phi phi / (2 i omega_d)."""
    pole, phi = (
        2.0 * np.pi * 40.0 * (-0.02 + 1j * np.sqrt(1.0 - 0.02**2)),
        np.array([0.4, -0.8]),
    )
    zero = np.zeros(2, complex)
    pyuff.UFF(str(tmp_path / "test_1.uff")).write_sets({
        "type": 55, **{f"id{i}": "x" for i in range(1, 6)}, "model_type": 1, "analysis_type": 3,
        "data_ch": 2, "spec_data_type": 8, "data_type": 5, "n_data_per_node": 3, "load_case": 1,
        "mode_n": 1, "eig": pole, "modal_a": 2j * pole.imag / 0.8**2, "modal_b": 1j,
        "node_nums": [1, 2], "r1": zero, "r2": zero, "r3": phi / 0.8 + 0j,
    }, "add")  # fmt: skip
    found = convert_modes(tmp_path / "test_1.uff", tmp_path / "modes.csv", ModeOptions())
    with (tmp_path / "modes.csv").open() as file:
        row = next(csv.DictReader(file))
    assert [
        float(row[c]) for c in ("frequency_hz", "damping_ratio", "1/z", "2/z")
    ] == pytest.approx([40.0, 0.02, *phi], rel=1e-4)
    assert "test_1.uff states no units: kg and m are taken where no option says" in found.notes


def test_a_universal_file_in_mm_and_newton_is_one_of_tonnes(tmp_path):
    """Unit of mass: N s^2 / mm, 1000 kg; shapes are smaller by the root of it."""
    zero, file = np.zeros(1), pyuff.UFF(str(tmp_path / "mm.unv"))
    file.write_sets({
        "type": 164, "units_code": 5, "units_description": "mm (newton)", "temp_mode": 2,
        "length": 1000.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15,
    })  # fmt: skip
    file.write_sets({
        "type": 55, **{f"id{i}": "x" for i in range(1, 6)}, "model_type": 1, "analysis_type": 2,
        "data_ch": 2, "spec_data_type": 8, "data_type": 2, "n_data_per_node": 3, "load_case": 1,
        "mode_n": 1, "freq": 40.0, "modal_m": 1.0, "modal_damp_vis": 0.02, "modal_damp_his": 0.0,
        "node_nums": [1], "r1": zero, "r2": zero, "r3": np.array([31.6228]),
    }, "add")  # fmt: skip
    convert_modes(tmp_path / "mm.unv", tmp_path / "si.yaml", ModeOptions())
    assert read_structure(tmp_path / "si.yaml").shapes.max() == pytest.approx(1.0, rel=1e-5)


REFUSED = [
    ("held.frd", ".yaml", {}, r"mass_unit: .*held\.frd does not say for which unit of mass"),
    ("held.frd", ".yaml", {"mass_unit": "t"}, r"length_unit: .*does not say in which unit its nodes are"),
    ("held.frd", ".yaml", {"mass_unit": "mm", "length_unit": "mm"}, r"mass_unit: expected"),
    ("held.frd", ".yaml", {"mass_unit": "t", "length_unit": "mm"}, r"damping_ratio: .*held\.frd holds no damping"),
    ("held.frd", ".uff", {"mass_unit": "t", "length_unit": "mm", "at": ["tip"]}, r"at: expected NAME=PLACE, got 'tip'"),
    ("held.frd", ".uff", {"mass_unit": "t", "length_unit": "mm", "at": ["tip=7 z"]}, r'at: held\.frd has no place "7/z"; it has 1/x'),
    ("held.frd", ".uff", {"mass_unit": "t", "length_unit": "mm", "direction": "w"}, r"direction: expected x, y or z, got 'w'"),
    ("held.inp", ".uff", {}, r"held\.inp: no reader of modes for \.inp; modes are in files \.yaml"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "ending", "given", "message"), REFUSED)
def test_what_is_wrong_is_said_in_one_line_and_nothing_is_written(
    tmp_path, name, ending, given, message
):
    out = tmp_path / f"out{ending}"
    with pytest.raises(ShakerprocError, match=message) as caught:
        convert_modes(BEAM / name, out, ModeOptions(**given))
    assert "\n" not in str(caught.value)
    assert not out.exists()


SENSORS = [
    ("direction: z", MIDDLE, r"held\.frd has no place tip/z, and the log no position of it"),
    ("position: [1 m, 0 m, 0 m]", MIDDLE, r"direction: the log does not say along which axis tip measures"),
    ("direction: [1, 1, 0]", MIDDLE, r"tip measures along 0\.707 0\.707 0; a point is seen along x, y or z"),
]  # fmt: skip


@pytest.mark.parametrize(("tip", "middle", "message"), SENSORS)
def test_a_sensor_without_place_is_said_in_one_line(tmp_path, tip, middle, message):
    options = ModeOptions("t", "mm", 0.01, sensors=log_of(tmp_path, tip, middle))
    with pytest.raises(ArgumentError, match=message) as caught:
        convert_modes(BEAM / "held.frd", tmp_path / "out.yaml", options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.4, 0.7, 0.95])
def test_modes_of_a_file_that_is_cut_off_are_refused(tmp_path, share):
    whole, part = tmp_path / "whole.uff", tmp_path / "part.uff"
    convert_modes(BEAM / "held.frd", whole, SI)
    content = whole.read_bytes()
    part.write_bytes(content[: int(share * len(content))])
    with pytest.raises(
        ShakerprocError, match=r"part\.uff:\d+: the file is cut off in this data"
    ):
        convert_modes(part, tmp_path / "part.csv", ModeOptions())
    assert not (tmp_path / "part.csv").exists()


def run(*arguments):
    return CliRunner().invoke(build_app(), [str(a) for a in arguments])


def test_the_command_tells_modes_from_recordings_by_both_files(tmp_path):
    (tmp_path / "run.csv").write_text("Time [s],a [g]\n0,1\n0.1,2\n0.2,1\n0.3,0\n")
    assert (
        "1 channels, 4 samples"
        in run("convert", tmp_path / "run.csv", tmp_path / "run.uff").stderr
    )
    units = ("--mass-unit", "t", "--length-unit", "mm", "--damping-ratio", "0.01")
    done = run("convert", BEAM / "held.frd", tmp_path / "held.csv", *units)
    assert done.exit_code == 0
    assert done.stdout == ""
    assert "held.csv: 6 modes at" in done.stderr
    assert "6 modes at" in run("convert", tmp_path / "held.csv", tmp_path / "held.uff").stderr
    back = run("convert", tmp_path / "run.uff", tmp_path / "again.csv")
    assert "1 channels, 4 samples" in back.stderr


def test_options_of_recordings_and_of_modes_do_not_mix(tmp_path):
    (tmp_path / "run.csv").write_text("Time [s],a [g]\n0,1\n0.1,2\n0.2,1\n0.3,0\n")
    done = run("convert", tmp_path / "run.csv", tmp_path / "run.uff", "--mass-unit", "t")
    assert done.exit_code == 2
    assert "--mass-unit: does not belong to a recording" in done.stderr
    done = run("convert", BEAM / "held.frd", tmp_path / "held.yaml", "--group", "x")
    assert done.exit_code == 2
    assert "--group: does not belong to modes" in done.stderr
