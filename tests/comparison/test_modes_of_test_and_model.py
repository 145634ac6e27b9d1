"""Modes of a test beside those of a model: pairs, MAC, and what has no partner."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from tests.in_process import completed

from shakerproc.comparison.modes import NaturalModes, natural_modes, paired
from shakerproc.modal import mac
from shakerproc.models import EFFECTS, Element, Excitation, Model

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
    rows = Path("model_compare/modes.csv").read_text().splitlines()
    assert len(rows) == 4
    assert "Modes of test 1 and of the linear part of the model" in said.stdout
    for row, frequency in zip(rows[1:], model.frequency, strict=True):
        measured, modelled, difference, *_, alike = map(float, row.split(","))
        assert modelled == pytest.approx(frequency, rel=1e-4)
        assert difference == pytest.approx(100.0 * (frequency / measured - 1.0), abs=0.05)
        assert difference > 0.0
        assert alike > 0.8
