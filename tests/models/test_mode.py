"""Further linear modes: the same motion as a mass attached, and as the closed form says."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.errors import DocumentError
from shakerproc.model_files import model_text, read_model
from shakerproc.models import EFFECTS, Element, Excitation, Mode, Model, Sensor
from shakerproc.simulation import simulate
from shakerproc.simulation.harmonic_balance.system import system_of_model

ELEMENTS = (
    Element(EFFECTS["spring"](2e5), ("base", "coupon")),
    Element(EFFECTS["damper"](20.0), ("base", "coupon")),
)
PLAIN = Model(
    "one mass", {"coupon": 0.4}, ELEMENTS, Excitation("base acceleration"),
    {"ch3": Sensor("coupon")},
)  # fmt: skip
ATTACHED = Element(EFFECTS["attached_mode"](0.02, 700.0, 0.01), ("base", "coupon"))
MODE = Mode(700.0, 0.01, 0.02, {"coupon": 1.0})


def shaken(model, frequency=0.0):
    rate, n = 8192.0, 8192
    t = np.arange(n) / rate
    drive = (
        np.sin(2 * np.pi * frequency * t) if frequency
        else np.random.default_rng(1).standard_normal(n)
    )  # fmt: skip
    return simulate(model, drive, rate, growth=False).outputs["ch3"]


def test_a_mode_at_one_mass_moves_as_a_mass_attached_there():
    by_element = replace(PLAIN, masses={"coupon": 0.38}, elements=(*ELEMENTS, ATTACHED))
    by_mode = replace(PLAIN, modes=(MODE,))
    assert_allclose(shaken(by_mode), shaken(by_element), rtol=1e-9, atol=1e-9)
    assert np.std(shaken(by_mode) - shaken(PLAIN)) > 0.01 * np.std(shaken(PLAIN))


def test_harmonic_balance_has_the_same_matrices():
    one, other = (
        system_of_model(model, 1.0)
        for model in (
            replace(PLAIN, modes=(MODE,)),
            replace(PLAIN, masses={"coupon": 0.38}, elements=(*ELEMENTS, ATTACHED)),
        )
    )
    for name in ("mass", "damping", "stiffness", "load"):
        assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12)


def test_participation_scales_the_force_as_its_square_scales_the_mass():
    """With a force on the mass, only phi squared times mu counts."""
    forced = replace(PLAIN, excitation=Excitation("force", "coupon"))
    one = replace(forced, modes=(Mode(700.0, 0.01, 0.02, {"coupon": 1.0}),))
    two = replace(forced, modes=(Mode(700.0, 0.01, 0.02 / 4.0, {"coupon": 2.0}),))
    assert_allclose(shaken(one), shaken(two), rtol=1e-9, atol=1e-9)


def test_a_model_file_holds_its_modes(tmp_path):
    model = replace(PLAIN, modes=(MODE, Mode(1200.0, 0.0, 1e-3, {"coupon": -0.5})))
    path = tmp_path / "model.yaml"
    path.write_text(model_text(model), encoding="utf-8")
    assert read_model(path).modes == model.modes


def test_a_mode_heavier_than_its_mass_is_refused():
    with pytest.raises(ValueError, match="less that of the modes"):
        replace(PLAIN, modes=(Mode(700.0, 0.01, 0.5, {"coupon": 1.0}),))


@pytest.mark.parametrize(
    ("participation", "said"),
    [("{coupon: 0}", "takes part"), ("{base: 1}", "expected a mass"), ("{x: 1}", "x")],
)
def test_a_mode_that_moves_nothing_is_refused(tmp_path, participation, said):
    text = model_text(replace(PLAIN, modes=(MODE,)))
    path = tmp_path / "model.yaml"
    path.write_text(text.replace("{coupon: 1}", participation), encoding="utf-8")
    with pytest.raises(DocumentError, match=said):
        read_model(path)
