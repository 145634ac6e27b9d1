# ruff: noqa: E501 - one mistake a row
"""Modes of a structure from a table, from UFF data set 55 and from a Nastran punch file."""

import numpy as np
import pytest
import pyuff
from numpy.testing import assert_allclose

from shakerproc.errors import ShakerprocError
from shakerproc.model_files import read_model

SHAPES = np.array([[0.5, 0.5, 0.5], [-0.8, 0.0, 0.8], [1.0, -0.6, 1.0]])  # a row for each mode
FREQUENCIES = np.array([0.0, 0.0, 120.0])
MODEL = """\
model: 1
structures: {{beam: {file}}}
elements:
  - {{kind: spring, between: [base, left], stiffness: 2e5 N/m}}
  - {{kind: spring, between: [base, right], stiffness: 2e5 N/m}}
excitation: {{base: acceleration}}
"""
NODES = "nodes: {left: 11 z, middle: 12 z, right: 13 z}\n"


def model_of(folder, name, structure=None, driven="{base: acceleration}"):
    """Read a model of the structure that a file holds, or that a structure file describes."""
    if structure is not None:
        (folder / "beam.yaml").write_text(f"structure: 1\nmodes_from: {name}\n{structure}")
        name = "beam.yaml"
    text = MODEL.format(file=name).replace("{base: acceleration}", driven)
    (folder / "model.yaml").write_text(text)
    return read_model(folder / "model.yaml").structures["beam"]


def table(folder, **changed):
    rows = {
        "frequency_hz": FREQUENCIES, "damping_ratio": [0.0, 0.0, 0.01],
        "left": SHAPES[:, 0], "middle": SHAPES[:, 1], "right": SHAPES[:, 2], **changed,
    }  # fmt: skip
    lines = [
        ",".join(rows),
        *(",".join(map(str, row)) for row in zip(*rows.values(), strict=True)),
    ]
    (folder / "modes.csv").write_text("\n".join(lines) + "\n")


def uff(folder, modal_mass=1.0, without=(), count=3, **changed):
    """The first modes, written by pyuff, with shapes for another modal mass than 1."""
    file = pyuff.UFF(str(folder / "modes.unv"))
    zero = np.zeros(3)
    some = list(zip(FREQUENCIES, SHAPES, strict=True))[:count]
    for i, (frequency, shape) in enumerate(some, 1):
        content = {
            "type": 55, "id1": "x", "id2": "x", "id3": "x", "id4": "x", "id5": "x",
            "model_type": 1, "analysis_type": 2, "data_ch": 3, "spec_data_type": 8,
            "data_type": 2, "n_data_per_node": 6, "load_case": 1, "mode_n": i,
            "freq": frequency + 1e-5, "modal_m": modal_mass, "modal_damp_vis": 0.01,
            "modal_damp_his": 0.0, "node_nums": [11, 12, 13], "r1": zero, "r2": zero,
            "r3": shape * np.sqrt(modal_mass), "r4": zero, "r5": zero, "r6": zero, **changed,
        }  # fmt: skip
        file.write_sets({k: v for k, v in content.items() if k not in without}, "add")


def punch(folder):
    """Written out by the format: fields of 18 characters after a heading for each mode."""
    lines = []
    for i, (frequency, shape) in enumerate(zip(FREQUENCIES, SHAPES, strict=True), 1):
        eigenvalue = (2.0 * np.pi * frequency) ** 2 + 1e-7
        lines += [
            "$TITLE   = BEAM",
            "$EIGENVECTOR",
            "$REAL OUTPUT",
            "$SUBCASE ID =           1",
        ]
        lines += [f"$EIGENVALUE = {eigenvalue:14.7E}  MODE = {i:5d}"]
        for node, value in zip((11, 12, 13), shape, strict=True):
            lines.append(f"{node:10d}       G{0.0:18.6E}{0.0:18.6E}{value:18.6E}")
            lines.append(f"-CONT-            {0.0:18.6E}{0.0:18.6E}{0.0:18.6E}")
    (folder / "modes.pch").write_text("".join(f"{line:<72}\n" for line in lines))


def assert_is_the_beam(structure, rtol=1e-12):
    assert structure.points == ("left", "middle", "right")
    assert_allclose(structure.shapes.T, SHAPES, rtol=rtol, atol=1e-12)
    assert_allclose([m.frequency for m in structure.modes], FREQUENCIES, rtol=1e-6, atol=0.0)
    assert_allclose(structure.participations, [2.0, 0.0, 0.0], atol=1e-6)


def test_a_table_has_a_row_for_each_mode(tmp_path):
    table(tmp_path)
    structure = model_of(tmp_path, "modes.csv")
    assert_is_the_beam(structure)
    assert [m.damping_ratio for m in structure.modes] == [0.0, 0.0, 0.01]


def test_a_universal_file_has_nodes_that_a_structure_file_names(tmp_path):
    uff(tmp_path, modal_mass=2.5)
    structure = model_of(tmp_path, "modes.unv", NODES)
    assert_is_the_beam(structure, rtol=1e-5)
    assert structure.modes[2].damping_ratio == 0.01


def test_a_punch_file_takes_damping_and_unit_of_mass_from_the_structure_file(tmp_path):
    punch(tmp_path)
    structure = model_of(tmp_path, "modes.pch", f"{NODES}damping_ratio: 0.02\n")
    assert_is_the_beam(structure, rtol=1e-6)
    assert structure.modes[2].damping_ratio == 0.02
    tonnes = model_of(tmp_path, "modes.pch", f"{NODES}damping_ratio: 0.02\nmass_unit: t\n")
    assert_allclose(tonnes.shapes.T, SHAPES / np.sqrt(1000.0), rtol=1e-6)


def test_complex_modes_of_a_test_are_scaled_by_their_modal_a(tmp_path):
    """The receptance between two nodes is that of the mass-normalised modes in closed form."""
    frequency, damping, phi = 40.0, 0.02, np.array([0.3, -0.5, 0.8])
    omega = 2.0 * np.pi * frequency
    pole = omega * (-damping + 1j * np.sqrt(1.0 - damping**2))
    psi = phi / 0.8
    lines = 2.0 * np.pi * np.linspace(30.0, 50.0, 41)
    true = phi[0] * phi[1] / (omega**2 - lines**2 + 2j * damping * omega * lines)
    modal_a = 2j * pole.imag / 0.8**2
    fraction = psi[0] * psi[1] / (modal_a * (1j * lines - pole))
    mirrored = psi[0] * psi[1] / (np.conj(modal_a) * (1j * lines - np.conj(pole)))
    assert_allclose(fraction + mirrored, true, rtol=1e-9)  # what modal A means
    zero = np.zeros(3, complex)
    scaled = {"eig": pole, "modal_a": modal_a, "r1": zero, "r2": zero, "r3": psi + 0j}
    uff(tmp_path, without=("r4", "r5", "r6"), count=1, **COMPLEX, **scaled)
    structure = model_of(tmp_path, "modes.unv", NODES, driven="{force on: left}")
    assert_allclose(structure.modes[0].shape, phi, rtol=1e-5)
    assert structure.modes[0].frequency == pytest.approx(frequency, rel=1e-5)
    assert structure.modes[0].damping_ratio == pytest.approx(damping, rel=1e-4)


def test_points_of_a_universal_file_are_where_its_nodes_are(tmp_path):
    uff(tmp_path)
    pyuff.UFF(str(tmp_path / "modes.unv")).write_sets(
        {
            "type": 2411, "grid_global": [[n, 0, 0, 0, 0.1 * n, 0.0, 0.5] for n in (11, 12, 13)],
            "node_nums": [11, 12, 13], "def_cs": [0, 0, 0], "disp_cs": [0, 0, 0],
            "color": [1, 1, 1], "x": [1.1, 1.2, 1.3], "y": [0.0] * 3, "z": [0.5] * 3,
        },
        "add",
    )  # fmt: skip
    structure = model_of(
        tmp_path, "modes.unv", f"{NODES}positions: {{middle: [7 mm, 0 m, 0 m]}}\n"
    )
    assert_allclose(structure.position_of("left"), (1.1, 0.0, 0.5), rtol=1e-6)
    assert structure.position_of("middle") == (0.007, 0.0, 0.0)  # what is written counts


COMPLEX = {"analysis_type": 3, "data_type": 5, "n_data_per_node": 3, "modal_b": 1j}
REFUSED = [
    (table, {"damping_ratio": [0.0, "x", 0.01]}, "modes.csv", None, r"modes\.csv:3: expected a number for 'damping_ratio', got 'x'"),
    (lambda folder: (folder / "modes.csv").write_text("left,right\n1,2\n"), {}, "modes.csv", None, r"modes\.csv: expected a table with a row for each mode"),
    (uff, {}, "modes.unv", "nodes: {left: 14 z, middle: 12 z, right: 13 z}\n", r'beam\.yaml:3:8: nodes: modes\.unv has no place "14/z"; it has 11/x'),
    (uff, COMPLEX | {"eig": -1 + 100j, "modal_a": 0j}, "modes.unv", NODES, r"modes\.unv: mode 1 has no modal A, so that its shape is not scaled\. Measure force and acceleration in one place"),
    (uff, COMPLEX | {"eig": -1 + 100j, "modal_a": 200.0}, "modes.unv", NODES, r"modes\.unv: mode 1 at 15\.92 Hz is real to 50% only"),
    (uff, {"analysis_type": 5, "freq_step_n": 1}, "modes.unv", NODES, r"modes\.unv: no data set 55 with normal or complex modes"),
    (uff, {"modal_mass": 1.0, "modal_m": 0.0}, "modes.unv", NODES, r"modes\.unv: mode 1 is complex or has no modal mass"),
    (uff, {"freq": 40.0, "r3": np.array([0.3, -0.5, 0.8])}, "modes.unv", NODES, r"beam\.yaml:2:13: modes_from: mode 2 repeats mode 1; leave it out"),
    (punch, {}, "modes.pch", NODES, r"beam\.yaml:2:13: modes_from: modes\.pch holds no damping; state damping_ratio"),
    (punch, {}, "modes.step", NODES, r"beam\.yaml:2:13: modes_from: no reader for .*\.csv"),
    (lambda _: None, {}, "modes.pch", NODES, r'beam\.yaml:2:13: modes_from: no file "modes.pch" beside beam\.yaml'),
]  # fmt: skip


@pytest.mark.parametrize(("write", "changed", "name", "structure", "message"), REFUSED)
def test_what_is_wrong_with_modes_is_said_in_one_line(
    tmp_path, write, changed, name, structure, message
):
    write(tmp_path, **changed)
    with pytest.raises(ShakerprocError, match=message) as caught:
        model_of(tmp_path, name, structure)
    assert "\n" not in str(caught.value)
