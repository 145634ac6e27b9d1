"""Pictures of the effects: what they show is what closed forms say, and all can be drawn."""

import json

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.in_process import run

from shakerproc.models import EFFECTS, FAULTS
from shakerproc.models.effects import EXAMPLES
from shakerproc.report.figures import style
from shakerproc.report.models.effects import FREQUENCY, cycle_of, picture

OMEGA = 2.0 * np.pi * FREQUENCY
A = 1.2e-4


def half_open(ratio):
    """Describing function of a stop without play on one side of +-1, of a sine of 1 / ratio."""
    return 1.0 - 2.0 / np.pi * (np.arcsin(ratio) + ratio * np.sqrt(1.0 - ratio**2))


@pytest.mark.parametrize(
    ("kind", "stiffness", "damping"),
    [
        ("spring", 1.2e5, 0.0),
        ("damper", 0.0, 1.5),
        ("gap", 1.2e5 * half_open(5e-5 / A), 0.0),
        ("stop", 0.6e5 * half_open(5e-5 / A), 0.0),
        ("cubic_stiffness", 0.75 * 1e13 * A**2, 0.0),
        ("quadratic_stiffness", 0.0, 0.0),
        ("coulomb_friction", 0.0, 4.0 * 2.0 / (np.pi * OMEGA * A)),
        ("quadratic_damping", 0.0, 30.0 * 8.0 * OMEGA * A / (3.0 * np.pi)),
    ],
)
def test_equivalents_are_the_describing_functions(kind, stiffness, damping):
    found = cycle_of(EXAMPLES[kind], A)
    size = np.max(np.abs(found.force)) / A
    assert_allclose(found.stiffness, stiffness, rtol=2e-3, atol=1e-6 * size)
    assert_allclose(found.damping, damping, rtol=2e-3, atol=1e-6 * size / OMEGA)


@pytest.mark.parametrize(
    ("kind", "loss"),
    [
        ("jenkins", 4.0 * 4.0 * (A - 4.0 / 1.2e5)),  # of a parallelogram
        ("iwan", None),
        ("bouc_wen", None),
        ("lugre_friction", None),
    ],
)
def test_loops_enclose_the_work_that_is_lost(kind, loss):
    found = cycle_of(EXAMPLES[kind], A)
    work = np.mean(found.force * found.velocity) / FREQUENCY
    assert work > 0.0
    if loss is not None:
        assert_allclose(work, loss, rtol=2e-3)


@pytest.mark.parametrize("kind", [*EFFECTS, *FAULTS])
def test_every_kind_has_a_picture_that_shows_something(kind):
    with style.look():
        figure = picture(kind)
    drawn = [line for axis in figure.axes for line in axis.get_lines()]
    assert len(figure.axes) >= 2
    assert all(axis.get_xlabel() for axis in figure.axes[:2])
    assert all("[" in axis.get_ylabel() for axis in figure.axes)
    assert all(np.all(np.isfinite(line.get_ydata())) for line in drawn)
    changes = any(np.ptp(line.get_ydata()) > 0.0 for line in drawn)
    assert changes or kind == "constant_force"


@pytest.mark.parametrize("kind", [*EFFECTS, *FAULTS])
def test_every_kind_says_what_betrays_it_and_effects_where_they_come_from(kind, tmp_path):
    assert run("effects", kind, "--json", tmp_path / "one.json") == 0
    one = json.loads((tmp_path / "one.json").read_text())["effects"][kind]
    assert one["signature"].endswith(".")
    assert one["formula"]
    assert "math" not in json.dumps(one)
    assert kind in FAULTS or one["references"]
    for parameter in one["parameters"].values():
        assert parameter["unit"] or parameter["choices"] or parameter["holds"] == "effects"


def test_one_effect_is_told_and_drawn(tmp_path, capsys):
    assert run("effects", "gap", "-o", tmp_path / "gap.png") == 0
    told = capsys.readouterr().out
    for word in ("F = k (|z| - a) sign z", "N/m", "clearance", "signature:", "Hauglid"):
        assert word in told
    assert (tmp_path / "gap.png").read_bytes()[:4] == b"\x89PNG"


def test_all_are_listed_and_an_unknown_one_is_not(capsys):
    assert run("effects") == 0
    told = capsys.readouterr().out
    assert all(kind in told for kind in (*EFFECTS, *FAULTS))
    assert run("effects", "gapp") == 2
    assert "did you mean gap?" in " ".join(capsys.readouterr().err.split())
