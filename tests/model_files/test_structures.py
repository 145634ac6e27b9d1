# ruff: noqa: E501 - one mistake a row
"""Structures in model files and in files of their own: what is read, written and refused."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import DocumentError, ModelError
from shakerproc.model_files import NewNumbers, add_element, read_model, write_model
from shakerproc.models import EFFECTS, Element
from shakerproc.models.coordinates import coordinates_of
from shakerproc.models.validation import check_sampled

BODY = """\
structure: 1
title: free beam
points: [left, middle, right]
modes:
  - {frequency: 0 Hz, damping_ratio: 0, shape: [0.5, 0.5, 0.5]}     # of 4 kg
  - {frequency: 0 Hz, damping_ratio: 0, shape: [-0.8, 0, 0.8]}
  - {frequency: 120 Hz, damping_ratio: 0.01, shape: [1, -0.6, 1]}
"""
MODEL = """\
model: 1
title: beam on two feet
structures:
  beam: beam.yaml
elements:
  - {kind: spring, between: [base, left], stiffness: 2e5 N/m}
  - {kind: spring, between: [base, right], stiffness: 2e5 N/m}
excitation: {base: acceleration}
sensors:
  a: {at: middle}
"""
FIXED = """\
structure: 1
points: [left, middle, right]
modes:
  - {frequency: 30 Hz, damping_ratio: 0.01, shape: [0.1, 0.5, 1], participation: 1.5 sqrt(kg)}
"""


def written(folder, model=MODEL, body=BODY):
    (folder / "beam.yaml").write_text(body)
    path = folder / "model.yaml"
    path.write_text(model)
    return path


def test_a_structure_of_another_file_has_points_that_are_places(tmp_path):
    model = read_model(written(tmp_path))
    assert model.places == ("base", "left", "middle", "right")
    structure = model.structures["beam"]
    assert structure.points == ("left", "middle", "right")
    assert_allclose(structure.shapes[:, 2], [1.0, -0.6, 1.0])
    assert_allclose(structure.participations, [2.0, 0.0, 0.0], atol=1e-12)  # sqrt(4 kg)


def test_shapes_for_a_unit_mass_of_a_tonne_are_converted(tmp_path):
    in_tonnes = BODY.replace("title: free beam", "mass_unit: t\nmass: 4 t")
    model = read_model(written(tmp_path, body=in_tonnes))
    assert_allclose(np.sum(model.structures["beam"].participations ** 2), 4000.0)


def test_participations_are_written_with_the_root_of_a_mass(tmp_path):
    grams = FIXED.replace("1.5 sqrt(kg)", "47.434164902525695 sqrt(g)")
    found = [read_model(written(tmp_path, body=one)) for one in (FIXED, grams)]
    for model in found:
        assert_allclose(model.structures["beam"].participations, [1.5])


def test_only_points_in_the_direction_of_the_base_move_with_it(tmp_path):
    """Free in x and z: a base that moves along z leaves the points in x where they are."""
    body = """\
structure: 1
points: [left/x, left/z, right/x, right/z]
direction: z
modes:
  - {frequency: 0 Hz, damping_ratio: 0, shape: [0.5, 0, 0.5, 0]}
  - {frequency: 0 Hz, damping_ratio: 0, shape: [0, 0.5, 0, 0.5]}
"""
    model = MODEL.replace("left]", "left/z]").replace("right]", "right/z]")
    model = model.replace("at: middle", "at: left/z").replace(
        "excitation",
        "  - {kind: spring, between: [base, left/x], stiffness: 1 N/m}\nexcitation",
    )
    found = read_model(written(tmp_path, model, body))
    assert_allclose(found.structures["beam"].participations, [0.0, 2.0], atol=1e-12)


def test_a_model_is_written_with_its_structures_in_it_and_reads_back(tmp_path):
    for body in (BODY, FIXED):
        model = read_model(written(tmp_path, body=body))
        other = tmp_path / "alone" / "model.yaml"
        write_model(model, other)
        assert read_model(other) == model


def test_an_effect_is_added_in_another_folder_and_the_structure_is_still_found(tmp_path):
    path, out = written(tmp_path), tmp_path / "results" / "with-gap.yaml"
    gap = Element(EFFECTS["gap"](stiffness=1e5, clearance=1e-5), ("base", "left"))
    add_element(path, gap, out)
    model = read_model(out)
    assert model.elements[-1] == gap
    assert model.structures == read_model(path).structures


@pytest.mark.parametrize(
    "place", ["structures:\n  beam: beam.yaml", "structures: {beam: beam.yaml}"]
)
def test_a_structure_with_other_numbers_goes_into_the_model_file_its_own_stays(tmp_path, place):
    path = written(tmp_path, MODEL.replace("structures:\n  beam: beam.yaml", place))
    known = read_model(path)
    beam = known.structures["beam"]
    fitted = replace(beam, modes=(*beam.modes[:2], replace(beam.modes[2], frequency=118.75)))
    gap = Element(EFFECTS["gap"](stiffness=1e5, clearance=1e-5), ("base", "left"))
    add_element(
        path, gap, tmp_path / "new.yaml", numbers=NewNumbers(structures={"beam": fitted})
    )
    found = read_model(tmp_path / "new.yaml")
    assert found.structures["beam"] == fitted
    assert found.elements == (*known.elements, gap)
    assert (tmp_path / "beam.yaml").read_text() == BODY


def test_a_residual_flexibility_is_that_at_rest_and_survives_being_written(tmp_path):
    """Static flexibility of a held point: the sum over modes of phi^2 / omega^2, and R."""
    body = FIXED.replace("points:", "residual: {right: 3e-6 m/N}\npoints:")
    plain, model = (read_model(written(tmp_path, body=one)) for one in (FIXED, body))
    yields = []
    for one in (plain, model):
        bare = replace(one, elements=one.elements[:0], sensors={})
        linear = coordinates_of(bare)
        right = linear.at("right")
        yields.append(right @ np.linalg.solve(linear.stiffness, right))
    assert_allclose(yields, 1.0 / (2.0 * np.pi * 30.0) ** 2 + np.array([0.0, 3e-6]), rtol=1e-12)
    other = tmp_path / "alone" / "model.yaml"
    write_model(model, other)
    assert read_model(other) == model


SAME = "".join(
    f"  - {{frequency: 120 Hz, damping_ratio: {ratio}, shape: [{shape}]}}\n"
    for ratio, shape in ((0.01, "1.1, -0.6, 1"), (0.02, "-1.1, 0.6, -1"))
)
LARGEST = "".join(
    f"  - {{frequency: {frequency} Hz, damping_ratio: 0.01, shape: [{shape}]}}\n"
    for frequency, shape in ((120, "1, -0.6, 1"), (330, "-1, 0, 1"))
)
REFUSED = [
    ("model", "beam: beam.yaml", "beam: bean.yaml", r'model\.yaml:4:9: .*no file "bean.yaml" beside'),
    ("model", "beam: beam.yaml", "beam: beam.step", r"model\.yaml:4:9: .*no reader for .*\.yaml"),
    ("model", "[base, left]", "[base, lefd]", r'model\.yaml:6:\d+: .*no place "lefd"; did you mean "left"'),
    ("model", "  beam: beam.yaml", "  beam: beam.yaml\n  twin: beam.yaml", r'model\.yaml:5:9: .*point "left" is the name of a point of beam'),
    ("model", "structures:", "masses: {left: 1 kg}\nstructures:", r'point "left" is the name of a mass already'),
    ("model", "  - {kind: spring, between: [base, right], stiffness: 2e5 N/m}\n", "", r"model\.yaml:5:1: .*no chain of elements leads from beam as a rigid body"),
    ("model", "{base: acceleration}", "{displacement of: left}", r"displacement of: .*expected a mass, got left, a point of a structure"),
    ("beam", "0.5, 0.5, 0.5]", "0.5, 0.5]", r"beam\.yaml:5:\d+: modes\.1\.shape: expected 3 values, one for each point, got 2"),
    ("beam", "[1, -0.6, 1]", "[0, 0, 0]", r"beam\.yaml:7:\d+: modes\.3\.shape: .*moves none of the points"),
    ("beam", "[left, middle, right]", "[left, middle, left]", r'beam\.yaml:3:\d+: points\.3: point "left" stands twice'),
    ("beam", "[left, middle, right]", "[]", r"beam\.yaml:3:9: points: expected points"),
    ("beam", "title: free beam", "mass: 4 t", r"beam\.yaml:2:7: mass: the modes move 4 kg .*mass_unit: t"),
    ("beam", "title: free beam", "mass: 5 kg", r"beam\.yaml:2:7: mass: the modes move 4 kg .*normalised"),
    ("beam", "title: free beam", "mass_unit: N", r"beam\.yaml:2:12: mass_unit: expected"),
    ("beam", "title: free beam", "direction: z", r"beam\.yaml:2:12: direction: no point ends in /z"),
    ("beam", "title: free beam", "residual: {midle: 1e-9 m/N}", r'beam\.yaml:2:12: residual\.midle: no point "midle"'),
    ("beam", "title: free beam", "residual: {middle: 1e-9}", r"beam\.yaml:2:\d+: residual\.middle: expected a number with a unit of m/N"),
    ("beam", "0 Hz", "12 Hz", r"model\.yaml:4:9: structures\.beam: no sum of the rigid-body modes"),
    ("beam", "0 Hz", "-1 Hz", r"beam\.yaml:5:\d+: modes\.1\.frequency: expected at least 0"),
    ("beam", "120 Hz", "120", r"beam\.yaml:7:\d+: modes\.3\.frequency: expected a number with a unit of Hz"),
    ("beam", "shape: [1, ", "participation: 2 kg, shape: [1, ", r"modes\.3\.participation: expected such as 1\.9 sqrt\(kg\)"),
    ("beam", "points:", "pionts:", r'beam\.yaml:3:1: unknown key "pionts"; did you mean "points"'),
    ("beam", "damping_ratio: 0.01", "damping_ratio: 1", r"beam\.yaml:5:3: modes: mode 3: with a damping ratio of 1 it does not swing\. 0\.5 % of critical damping is 0\.005"),
    ("beam", "  - {frequency: 120 Hz, damping_ratio: 0.01, shape: [1, -0.6, 1]}\n", SAME, r"beam\.yaml:5:3: modes: mode 4 repeats mode 3; leave it out"),
    ("beam", "  - {frequency: 120 Hz, damping_ratio: 0.01, shape: [1, -0.6, 1]}\n", LARGEST, r"beam\.yaml:5:3: modes: the largest value of every shape is 1: .*Export them mass-normalised"),
    ("beam", "structure: 1", "model: 1", r"beam\.yaml:1:1: "),
]  # fmt: skip


@pytest.mark.parametrize(("where", "old", "new", "message"), REFUSED)
def test_what_is_wrong_is_said_with_file_line_and_column(tmp_path, where, old, new, message):
    texts = {"model": MODEL, "beam": BODY}
    assert old in texts[where]
    texts[where] = texts[where].replace(old, new, 1)
    path = written(tmp_path, texts["model"], texts["beam"])
    with pytest.raises(DocumentError, match=message) as caught:
        read_model(path)
    assert "\n" not in str(caught.value)


def test_modes_of_a_free_base_without_rigid_body_modes_or_participation_are_refused(tmp_path):
    body = "\n".join(
        line for line in BODY.splitlines() if "0 Hz, damping_ratio: 0," not in line
    )
    with pytest.raises(
        DocumentError, match=r"no rigid-body mode \(0 Hz\) and no participation"
    ):
        read_model(written(tmp_path, body=body))


def test_an_element_at_points_where_no_mode_moves_is_refused(tmp_path):
    body = FIXED.replace("[0.1, 0.5, 1]", "[0, 0.5, 1]")
    with pytest.raises(DocumentError, match="between base and left never moves"):
        read_model(written(tmp_path, body=body))


def test_a_mode_beyond_half_the_sample_rate_is_refused(tmp_path):
    model = read_model(written(tmp_path))
    check_sampled(model, 241.0)
    with pytest.raises(
        ModelError, match="mode 3 of beam at 120 Hz lies beyond half the sample"
    ):
        check_sampled(model, 239.0)


def test_the_own_point_of_a_mode_is_1_and_says_nothing_of_its_normalisation(tmp_path):
    modes = "".join(
        f"  - {{frequency: {frequency} Hz, damping_ratio: 0.01, shape: [{shape}]}}\n"
        for frequency, shape in ((120, "0.9, -0.5, 0.9, 1, 0"), (330, "-0.7, 0, 0.7, 0, 1"))
    )
    body = "structure: 1\npoints: [left, middle, right, first, second]\nmodes:\n" + modes
    model = MODEL.replace("{base: acceleration}", "{force on: middle}")
    shapes = read_model(written(tmp_path, model, body)).structures["beam"].shapes
    assert_allclose(np.max(shapes, axis=0), 1.0)


def test_positions_are_read_written_and_refused_without_their_point(tmp_path):
    positions = "positions: {left: [0 mm, 0 mm, 0 mm], right: [400 mm, 0 mm, 25 mm]}\n"
    model = read_model(written(tmp_path, body=BODY + positions))
    structure = model.structures["beam"]
    assert structure.position_of("right") == (0.4, 0.0, 0.025)
    assert structure.position_of("middle") is None
    write_model(model, tmp_path / "again.yaml")
    assert read_model(tmp_path / "again.yaml").structures["beam"] == structure
    with pytest.raises(DocumentError, match=r'beam\.yaml:8:13: .*positions.*: no point "tip"'):
        read_model(written(tmp_path, body=BODY + "positions: {tip: [0 m, 0 m, 0 m]}\n"))


def test_directions_of_a_point_share_its_position(tmp_path):
    body = BODY.replace("[left, middle, right]", "[foot/x, foot/-z, right/z]") + (
        "direction: z\npositions: {foot: [1 m, 2 m, 3 m]}\n"
    )
    structure = read_model(
        written(tmp_path, MODEL.replace("left", "foot/x").replace("right", "right/z")
                .replace("middle", "foot/-z").replace("{base: acceleration}", "{force on: foot/x}"), body)
    ).structures["beam"]  # fmt: skip
    assert (
        structure.position_of("foot/x") == structure.position_of("foot/-z") == (1.0, 2.0, 3.0)
    )
    assert structure.direction_of("foot/-z") == (0.0, 0.0, -1.0)
