"""Modes of a test beside those of a model: pairs, MAC, and what has no partner."""

import csv
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from tests.in_process import completed

from shakerproc.comparison.document import mode_tables, modes_document
from shakerproc.comparison.modes import NaturalModes, beside_model, natural_modes, paired
from shakerproc.modal import mac
from shakerproc.models import EFFECTS, Element, Excitation, Model
from shakerproc.models.structure import Structure, StructureMode
from shakerproc.report.evidence.functions import mode_sections

MASSES, SPRINGS = np.array([0.5, 0.8, 0.3]), np.array([2e5, 3e5, 1e5])


def chain():
    """Three masses one behind the other on the base."""
    names = ["base", "a", "b", "c"]
    elements = [
        Element(law, (first, second))
        for first, second, k in zip(names, names[1:], SPRINGS, strict=False)
        for law in (EFFECTS["spring"](stiffness=k), EFFECTS["damper"](damping=2e-5 * k))
    ]
    masses = dict(zip("abc", MASSES, strict=True))
    return Model("chain", masses, tuple(elements), Excitation("base acceleration"))


def test_natural_modes_are_those_of_mass_and_stiffness():
    """Damping in proportion to stiffness: the closed form is omega_0, and beta omega_0 / 2."""
    k1, k2, k3 = SPRINGS
    stiffness = np.array([[k1 + k2, -k2, 0.0], [-k2, k2 + k3, -k3], [0.0, -k3, k3]])
    squares, shapes = eigh(stiffness, np.diag(MASSES))
    found = natural_modes(chain(), ["a", "b", "c"])
    assert_allclose(found.frequency, np.sqrt(squares) / (2.0 * np.pi), rtol=1e-9)
    assert_allclose(found.damping, 2e-5 * np.sqrt(squares) / 2.0, rtol=1e-9)
    assert_allclose(np.diag(mac(found.shapes, shapes.T)), 1.0, rtol=1e-9)


def sets(measured, model, shapes, other):
    """Modes of a test and of a model with given frequencies [Hz] and shapes."""
    ones = np.full(len(measured), 0.01)
    test = SimpleNamespace(frequency=np.array(measured), damping=ones)
    theirs = NaturalModes(np.array(model), np.full(len(model), 0.01), np.array(other, complex))
    return test, theirs, mac(np.array(shapes, complex), theirs.shapes)


UP, TURN, BEND = [1.0, 1.0, 1.0], [-1.0, 0.0, 1.0], [1.0, -2.0, 1.0]


def test_modes_are_paired_by_shape_where_their_frequencies_cross():
    found = paired(*sets([50.0, 55.0], [51.0, 54.0], [UP, TURN], [TURN, UP]), 3, (10.0, 100.0))
    assert [(pair.measured_hz, pair.model_hz) for pair in found] == [(50.0, 54.0), (55.0, 51.0)]
    assert_allclose([pair.mac for pair in found], 1.0)


def test_modes_of_two_sensors_are_paired_by_frequency_alone():
    found = paired(*sets([50.0, 55.0], [51.0, 54.0], [UP, TURN], [TURN, UP]), 2, (10.0, 100.0))
    assert [(pair.measured_hz, pair.model_hz) for pair in found] == [(50.0, 51.0), (55.0, 54.0)]


def test_a_mode_without_partner_is_told_on_both_sides():
    found = paired(
        *sets([50.0, 80.0], [52.0, 90.0, 300.0], [UP, TURN], [UP, BEND, TURN]), 3, (10.0, 100.0)
    )
    told = [(pair.measured_hz, pair.model_hz) for pair in found]
    assert told == [(50.0, 52.0), (80.0, None), (None, 90.0)]  # 300 Hz lies outside of the band
    assert found[0].difference == pytest.approx(0.04)


@pytest.mark.slow
@pytest.mark.long
def test_compare_prints_the_modes_of_a_simulated_test_and_writes_them(tmp_path, monkeypatch):
    """The truth is the model with the first spring a third softer: all modes are lower."""
    monkeypatch.chdir(tmp_path)
    text = """\
model: 1
masses: {a: 0.5 kg, b: 0.8 kg, c: 0.3 kg}
elements:
  - {kind: spring, between: [base, a], stiffness: K N/m}
  - {kind: damper, between: [base, a], damping: 4 N s/m}
  - {kind: spring, between: [a, b], stiffness: 3e5 N/m}
  - {kind: damper, between: [a, b], damping: 6 N s/m}
  - {kind: spring, between: [b, c], stiffness: 1e5 N/m}
  - {kind: damper, between: [b, c], damping: 2 N s/m}
excitation: {base: acceleration}
sensors: {a: {at: a}, b: {at: b}, c: {at: c}}
"""
    Path("truth.yaml").write_text(text.replace("K N", "1.4e5 N"))
    Path("model.yaml").write_text(text.replace("K N", "2e5 N"))
    Path("log.yaml").write_text("""\
testlog: 1
channels:
  control: {role: control}
  a: {role: response}
  b: {role: response}
  c: {role: response}
tests:
  - {id: 1, recording: one.tdms, excitation: random, level: 0.001 g^2/Hz,
     from: 10 Hz, to: 250 Hz}
""")
    completed("simulate", "truth.yaml", "log.yaml", "--sample-rate-hz", "1000", "--no-growth")
    said = completed("compare", "model.yaml", "log.yaml", "--no-figures")
    model = natural_modes(chain(), ["a", "b", "c"])
    rows = list(csv.DictReader(Path("model_compare/modes.csv").read_text().splitlines()))
    assert len(rows) == 3
    assert "Modes of test 1 and of the linear part of the model" in said.stdout
    for row, frequency in zip(rows, model.frequency, strict=True):
        measured, difference = float(row["measured_hz"]), float(row["difference_percent"])
        assert float(row["model_hz"]) == pytest.approx(frequency, rel=1e-4)
        assert difference == pytest.approx(100.0 * (frequency / measured - 1.0), abs=0.05)
        assert difference > 0.0
        assert float(row["mac"]) > 0.8


def beam_modes(shapes, frequencies, sensors, positions=()):
    """Modes of a test, as the analysis returns them, of sensors at the tips of a comb."""
    where = positions or (None,) * len(sensors)
    found = SimpleNamespace(
        shapes=np.array(shapes, complex), frequency=np.array(frequencies),
        damping=np.full(len(frequencies), 0.01),
    )  # fmt: skip
    return SimpleNamespace(
        modes=found, sensor_names=list(sensors), positions=where,
        directions=(None,) * len(sensors), wireframe=None, band=(20.0, 400.0),
    )  # fmt: skip


X = np.linspace(0.0, 1.0, 7)
PLUCKED = np.sin(np.pi * np.outer([1, 2, 3], X[1:-1]))
"""Modes of a taut string at its five inner points."""


def string(**said):
    points = tuple(f"p{i}/z" for i in range(1, 6))
    modes = [StructureMode(50.0 * n, 0.01, tuple(PLUCKED[n - 1]), 0.0) for n in (1, 2, 3)]
    body = Structure(points, tuple(modes), "z", **said)
    return Model("string", {}, (), Excitation("force", "p2/z"), {}, structures={"s": body})


def test_measured_shapes_are_expanded_to_points_without_a_sensor():
    """The string is 3 % heavier than its model: all frequencies lower, the shapes the same."""
    places = {f"s{i}": f"p{i}/z" for i in (1, 2, 4, 5)}
    rows = [int(place[1]) - 1 for place in places.values()]
    positions = {f"p{i}": (float(x), 0.0, 0.0) for i, x in enumerate(X[1:-1], 1)}
    test = beam_modes(PLUCKED[:, rows], [49.0, 98.0, 147.0], list(places))
    found = beside_model(string(positions=positions), test, places, "1")
    assert found.shapes.points == ("p1/z", "p2/z", "p3/z", "p4/z", "p5/z")
    for n, pair in enumerate(found.pairs):
        test_shape, model_shape = found.shapes.of_pair(pair)
        alike = test_shape.real @ PLUCKED[n] / np.linalg.norm(PLUCKED[n])
        assert abs(alike) == pytest.approx(np.linalg.norm(test_shape), rel=1e-9)
        assert_allclose(model_shape, test_shape, atol=1e-9)
        assert pair.missed < 1e-9
    geometry = found.shapes.geometry
    assert geometry.scaled
    assert_allclose(np.diff(geometry.rest[:, 0]), 0.25)  # evenly along the string
    assert "expanded to 5 points by modes of the model" in found.shapes.sentence
    table = mode_tables(found)["mode_shapes.csv"]
    assert table["point"][2] == "p3/z"
    assert abs(table["test"][2]) == pytest.approx(1.0)
    assert modes_document(found)["pairs"][0]["expansion_left_out"] < 1e-9


def test_a_shape_that_the_model_does_not_have_is_told_as_a_guess():
    """Points that move to and fro by turns: no mode tells one of them from the others."""
    places = {f"s{i}": f"p{i}/z" for i in range(1, 6)}
    test = beam_modes([[1.0, -1.0, 1.0, -1.0, 1.0]], [120.0], list(places))
    found = beside_model(string(), test, places, "1")
    (pair,) = (one for one in found.pairs if one.measured_hz is not None)
    assert pair.left_out > 1.0
    assert "a guess" in found.shapes.sentence
    assert not found.shapes.geometry.scaled


def test_the_page_draws_both_shapes_of_a_pair_moving():
    places = {f"s{i}": f"p{i}/z" for i in (1, 2, 4, 5)}
    rows = [int(place[1]) - 1 for place in places.values()]
    test = beam_modes(PLUCKED[:2, rows], [49.0, 98.0], list(places))
    (section,) = mode_sections(beside_model(string(), test, places, "1"))
    titles = [figure.title for figure in section.figures]
    assert titles == ["Test: 49 Hz", "Model: 50 Hz", "Test: 98 Hz", "Model: 100 Hz",
                      "Model: 150 Hz", "MAC"]  # fmt: skip
    assert all("<animate" in figure.drawing for figure in section.figures[:-1])
    assert mode_sections(None) == []
