"""A model beside response functions of a file; the oracle is two masses in closed form."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run
from tests.modal.function_files import record, write

from shakerproc.errors import ArgumentError, DiagnosisError
from shakerproc.model_files import read_model
from shakerproc.workflows.comparison import compare_file

LINES = 0.5 * np.arange(1, 401)
MASS, STIFF, DAMP = (2.0, 1.0), (8e4, 3e5), (2.0, 3.0)
MODEL = """\
model: 1
title: two masses
masses: {m1: 2 kg, m2: 1 kg}
elements:
  - {kind: spring, between: [base, m1], stiffness: 8e4 N/m}
  - {kind: spring, between: [m1, m2], stiffness: STIFF N/m}
  - {kind: damper, between: [base, m1], damping: 2 N s/m}
  - {kind: damper, between: [m1, m2], damping: 3 N s/m}
excitation: EXCITATION
sensors:
  top: {at: m2, measures: acceleration}
"""


def impedance(omega):
    """Dynamic stiffness of the two masses, term by term: (a, b, d) of [[a, b], [b, d]]."""
    first, second = (k + 1j * omega * c for k, c in zip(STIFF, DAMP, strict=True))
    return first + second - MASS[0] * omega**2, -second, second - MASS[1] * omega**2


def accelerances():
    """Acceleration of both masses over a force on the first [m/s^2/N]."""
    omega = 2.0 * np.pi * LINES
    a, b, d = impedance(omega)
    return -(omega**2) * np.array([d, -b]) / (a * d - b * b)


def transmissibilities():
    """Acceleration of both masses over that of the base [-]."""
    omega = 2.0 * np.pi * LINES
    a, b, d = impedance(omega)
    support = STIFF[0] + 1j * omega * DAMP[0]
    return support * np.array([d, -b]) / (a * d - b * b)


def model_file(tmp_path, stiffness="3e5", excitation="{force on: m1}"):
    path = tmp_path / "model.yaml"
    path.write_text(MODEL.replace("STIFF", stiffness).replace("EXCITATION", excitation))
    return path


def functions_file(tmp_path, values, **said):
    path = tmp_path / "measured.uff"
    write(path, [record(one, r, 0, lines=LINES, **said) for r, one in enumerate(values)])
    return path


AT = ["1/z=m1", "2/z=top"]


def test_the_true_model_leaves_nothing_of_forced_functions(tmp_path):
    path = functions_file(tmp_path, accelerances())
    model = read_model(model_file(tmp_path))
    found = compare_file(model, path, AT).found
    for one, exact in zip(found.functions, accelerances(), strict=True):
        assert_allclose(one.model, exact, rtol=1e-9)
        assert one.error < 1e-9
        assert one.frac == pytest.approx(1.0, abs=1e-9)
    rng = np.random.default_rng(5)
    noise = 0.005 * (
        rng.standard_normal((2, LINES.size)) + 1j * rng.standard_normal(LINES.size)
    )
    pairs = compare_file(
        model, functions_file(tmp_path, accelerances() + noise), AT
    ).found.modes
    assert [pair.model_hz for pair in pairs.pairs] == pytest.approx(
        [pair.measured_hz for pair in pairs.pairs], rel=1e-4
    )


def test_the_true_model_leaves_nothing_of_base_driven_functions(tmp_path):
    units = {"orddenom_spec_data_type": 12, "orddenom_axis_units_lab": "g",
             "ordinate_axis_units_lab": "g"}  # fmt: skip
    path = functions_file(tmp_path, transmissibilities(), **units)
    model = read_model(model_file(tmp_path, excitation="{base: acceleration}"))
    with pytest.raises(DiagnosisError, match="no input of the file"):
        compare_file(model, path, AT)
    write(path, [
        record(one, r, 4, lines=LINES, **units) for r, one in enumerate(transmissibilities())
    ])  # fmt: skip
    found = compare_file(model, path, [*AT, "5/z=base"]).found
    assert_allclose([one.model for one in found.functions], transmissibilities(), rtol=1e-9)


def test_a_wrong_stiffness_shows_in_error_modes_and_report(tmp_path):
    """The error is computed once more here from the two closed forms; half coherence halves."""
    path, model = functions_file(tmp_path, accelerances()), model_file(tmp_path, "2e5")
    out, document = tmp_path / "out", tmp_path / "found.json"
    options = [f"--at={one}" for one in AT]
    assert run("compare", model, path, "--out", out, "--json", document, *options) == 0
    found = json.loads(document.read_text())
    measured = accelerances()
    omega = 2.0 * np.pi * LINES
    second = 2e5 + 3j * omega
    a = 8e4 + 2j * omega + second - 2.0 * omega**2
    d = second - omega**2
    wrong = -(omega**2) * np.array([d, second]) / (a * d - second**2)
    left = np.linalg.norm(wrong - measured, axis=1) / np.linalg.norm(measured, axis=1)
    assert [one["error_percent"] for one in found["functions"]] == pytest.approx(100 * left)
    assert abs(found["modes"]["pairs"][1]["difference_percent"]) > 5.0
    assert "FRAC" in (out / "report.html").read_text()
    assert len((out / "functions.csv").read_text().splitlines()) == 3


def test_names_that_do_not_fit_are_told_with_those_that_would(tmp_path):
    path, model = functions_file(tmp_path, accelerances()), read_model(model_file(tmp_path))
    with pytest.raises(DiagnosisError, match=r"has 1/z, 2/z; the model has top, m1, m2, base"):
        compare_file(model, path)
    with pytest.raises(ArgumentError, match="NAME=PLACE"):
        compare_file(model, path, ["1/z"])
    found = compare_file(model, path, ["1/z=m1"]).found
    assert any("2/z" in note for note in found.notes)
    assert run("compare", model_file(tmp_path), path, "--fit") == 2
