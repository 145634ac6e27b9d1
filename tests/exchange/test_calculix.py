# ruff: noqa: E501 - one mistake a row
"""Modes that CalculiX 2.20 wrote of a steel beam, held to closed forms of Euler and Bernoulli.

R. D. Blevins, "Formulas for Natural Frequency and Mode Shape", 1979, table 8-1: a uniform beam
of mass m has the shapes 2 / sqrt(m) at a free end, and the participation 0.7830 sqrt(m) of its
first mode when it is held at one.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import ShakerprocError
from shakerproc.model_files import read_model

HERE = Path(__file__).parent / "calculix"
MASS, LENGTH, HEIGHT, STIFF, DENSE = 1.884, 0.6, 0.01, 2.1e11, 7850.0
WAVES = np.sqrt(STIFF * HEIGHT**2 / (12.0 * DENSE)) / (2.0 * np.pi * LENGTH**2)
STRUCTURE = """\
structure: 1
modes_from: {name}
nodes: {{middle: 69 z, tip: 141 z}}
damping_ratio: 0.01
mass_unit: t
mass: 1.884 kg
"""
CORNERS = STRUCTURE.replace("nodes: {{", "nodes: {{left: 1 z, right: 4 z, end: 142 z, ")
MODEL = """\
model: 1
structures: {beam: beam.yaml}
elements: [{kind: spring, between: [base, tip], stiffness: 1e5 N/m}, {kind: spring, between: [base, middle], stiffness: 1 N/m}]
excitation: {base: acceleration}
"""


def read(folder, name, structure=STRUCTURE, beside=()):
    """Return the structure of a file of CalculiX that lies beside the model."""
    for one in (name, *beside):
        if not (folder / one).exists():
            shutil.copy(HERE / one, folder / one)
    (folder / "beam.yaml").write_text(structure.format(name=name))
    held = "{kind: spring, between: [base, left], stiffness: 1 N/m}, " * ("left" in structure)
    (folder / "model.yaml").write_text(MODEL.replace("elements: [", f"elements: [{held}"))
    return read_model(folder / "model.yaml").structures["beam"]


@pytest.mark.parametrize(("name", "beside"), [("held.frd", ["held.dat"]), ("held.dat", [])])
def test_a_held_beam_has_frequencies_shapes_and_participations_of_a_beam(
    tmp_path, name, beside
):
    structure = read(tmp_path, name, beside=beside)
    first = structure.modes[0]
    assert first.frequency == pytest.approx(1.87510407**2 * WAVES, rel=0.02)
    assert_allclose(
        np.abs(first.shape), 2.0 / np.sqrt(MASS) * np.array([0.3395, 1.0]), rtol=0.02
    )
    assert abs(structure.participations[0]) == pytest.approx(0.7830 * np.sqrt(MASS), rel=0.01)
    # 0 - tip against base, in the sign that both have
    assert np.sign(structure.participations[0]) == np.sign(first.shape[1])


def test_rigid_body_modes_of_a_free_beam_move_its_mass_and_need_no_hold_across(tmp_path):
    """Six of them, each a mixture: as many as points across the beam tell are those of a model,
    held by springs across it."""
    structure = read(tmp_path, "free.frd", CORNERS)
    moving = [m for m in structure.modes if m.frequency]
    assert len(structure.modes) - len(moving) == 3
    assert moving[0].frequency == pytest.approx(4.73004074**2 * WAVES, rel=0.02)
    assert abs(moving[0].shape[-1]) == pytest.approx(2.0 / np.sqrt(MASS), rel=0.02)
    assert np.sum(structure.participations**2) == pytest.approx(MASS, rel=1e-4)
    assert_allclose(structure.shapes @ structure.participations, 1.0, rtol=1e-4)


def test_points_on_a_line_leave_a_turn_about_it_free_and_the_mass_is_still_checked(tmp_path):
    """A bar free to turn about the line y = 0 at half its height and to move along y, m e to that
    line: what goes with the base at once is m - (m e)^2 / J."""
    structure = read(tmp_path, "free.frd")
    assert len([m for m in structure.modes if not m.frequency]) == 2
    about_edge = MASS * (0.04**2 / 3.0 + HEIGHT**2 / 12.0)
    moved = MASS - (MASS * 0.02) ** 2 / about_edge
    assert np.sum(structure.participations**2) == pytest.approx(moved, rel=1e-3)


def test_printed_participations_are_those_of_the_rigid_body_modes(tmp_path):
    """Both say how the base acts: by integrals of CalculiX, and by the shapes."""
    from_shapes = read(tmp_path, "free.frd", CORNERS).participations
    printed = read(tmp_path, "free.frd", CORNERS, beside=["free.dat"]).participations
    assert_allclose(printed, from_shapes, atol=1e-3)


def test_positions_are_those_of_the_nodes_in_the_unit_that_is_stated(tmp_path):
    assert read(tmp_path, "held.frd", beside=["held.dat"]).position_of("tip") is None
    stated = read(tmp_path, "held.frd", f"{STRUCTURE}length_unit: mm\n", beside=["held.dat"])
    assert_allclose(stated.position_of("tip"), (0.6, 0.0, 0.0), rtol=1e-12)


def cut(name, new, at):
    """Write the first part of a file, cut off after some text."""

    def write(folder):
        text = (HERE / name).read_text()
        (folder / new).write_text(text[: text.index(at) + len(at)])

    return write  # fmt: skip


def changed(name, new, old, by):
    def write(folder):
        text = (HERE / name).read_text()
        assert old in text
        (folder / new).write_text(text.replace(old, by))

    return write  # fmt: skip


def copied(name, new):
    return lambda folder: shutil.copy(HERE / name, folder / new)


def both(*writers):
    return lambda folder: [write(folder) for write in writers]


MM = f"{STRUCTURE}length_unit: mm\n"
REFUSED = [
    (cut("held.frd", "a.frd", " -1        69-4.5"), "a.frd", STRUCTURE, r"a\.frd:211: not 5 nodes with three numbers each before the end of the block: the file is cut off"),
    (cut("held.frd", "a.frd", "    1PSTEP                         2"), "a.frd", STRUCTURE, r"a\.frd:222: the file is cut off: it does not end with 9999"),
    (changed("held.frd", "a.frd", "4.62470E+01", "4.62x70E+01"), "a.frd", STRUCTURE, r"a\.frd:211: not 5 nodes"),
    (changed("held.frd", "a.frd", "MODAL", "     "), "a.frd", STRUCTURE, r"a\.frd: no displacements of modes; ask for them with U below \*NODE FILE"),
    (changed("held.frd", "a.frd", " -4  DISP ", " -4  DISPI"), "a.frd", STRUCTURE, r"a\.frd:211: complex modes"),
    (both(copied("held.frd", "a.frd"), copied("free.dat", "a.dat")), "a.frd", STRUCTURE, r"a\.dat: its modes are not those of a\.frd beside it"),
    (cut("held.dat", "a.dat", "N U M B E R     4"), "a.dat", STRUCTURE, r"a\.dat: 6 modes, and 4 lists of displacements.*cut off"),
    (lambda folder: (folder / "a.dat").write_text("1 2 3\n"), "a.dat", STRUCTURE, r"a\.dat: no eigenvalues; it is printed by CalculiX"),
    (copied("held.frd", "a.frd"), "a.frd", STRUCTURE.replace("141 z", "999 z"), r'nodes: a\.frd has no place "999/z"; it has 1/x'),
    (copied("held.frd", "a.frd"), "a.frd", STRUCTURE, r"no rigid-body mode \(0 Hz\) and no participation"),
    (copied("held.frd", "a.frd"), "a.frd", STRUCTURE.replace("damping_ratio: 0.01\n", ""), r"holds no damping; state damping_ratio"),
    (copied("free.frd", "a.frd"), "a.frd", STRUCTURE.replace("mass_unit: t\n", ""), r"the modes move 0\.001884 kg .* mass says 1\.884 kg.*state mass_unit: t"),
    (copied("free.frd", "a.frd"), "a.frd", MM.replace("mm", "furlong"), r'beam\.yaml:7:14: length_unit: .*furlong'),
]  # fmt: skip


@pytest.mark.parametrize(("write", "name", "structure", "message"), REFUSED)
def test_what_is_wrong_is_said_in_one_line(tmp_path, write, name, structure, message):
    write(tmp_path)
    with pytest.raises(ShakerprocError, match=message) as caught:
        read(tmp_path, name, structure)
    assert "\n" not in str(caught.value)
