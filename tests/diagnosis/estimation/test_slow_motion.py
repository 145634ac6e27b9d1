"""A drive that nothing pulls back: windows where no period fits, and what drives it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.signal import lsim

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import TestArrays, prepared
from shakerproc.diagnosis.data.motion import slope
from shakerproc.diagnosis.estimation.form import forms_of
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.models import Element, Excitation, Model, Sensor
from shakerproc.models.effects import Damper

MASS, DAMPING, RATE = 90.0, 200.0, 200.0
OFFSET = -3.0  # constant by which the recorded force is too large [N]


@pytest.fixture(scope="module")
def campaign():
    """Return a carriage that goes to and fro each 6 s, moved by a force that is not pure."""
    time = np.arange(round(24.0 * RATE)) / RATE
    force = 60.0 * np.sin(2.0 * np.pi * time / 6.0) + 15.0 * np.sin(2.0 * np.pi * 1.3 * time)
    _, moved, _ = lsim(([1.0], [MASS, DAMPING, 0.0]), force + OFFSET, time)
    noise = 1e-6 * np.random.default_rng(1).standard_normal(time.size)
    model = Model(
        title="carriage",
        masses={"carriage": MASS},
        elements=(Element(Damper(1.2 * DAMPING), ("base", "carriage")),),
        excitation=Excitation("force", on="carriage"),
        sensors={"position": Sensor("carriage", "displacement")},
    )
    own = TestArrays("1", RATE, force[None], moved[None] + noise, band=(0.1, 5.0))
    return campaign_of(model, prepared([own]))


def test_a_motion_of_four_periods_is_cut_into_windows_to_fit_to_and_to_judge_by(campaign):
    form = forms_of(campaign.data)[0]
    assert len(form.held_out) >= 8
    assert len(form.fitted) >= 12
    assert form.horizon < 1.0


def test_what_is_held_out_shows_all_phases_of_a_motion_that_repeats(campaign):
    kept = np.flatnonzero(campaign.data.kept[0]) / RATE
    phases = np.histogram(kept % 6.0, bins=6, range=(0.0, 6.0))[0]
    assert phases.min() > 0


def test_a_constant_of_the_force_is_estimated_with_the_damping(campaign):
    data = campaign.data
    none = hypothesis_of(data.model)
    windows = forms_of(data)[1].fitted
    found = fit(data, none, np.zeros(none.size), windows, rounds=10)
    element = none.model_at(found.x).elements[0]
    assert_allclose(element.effect.damping, DAMPING, rtol=0.01)
    assert_allclose(found.of_tests[0] * data.input_sizes, OFFSET, rtol=0.03)


def test_a_joint_without_a_spring_carries_what_drives_it(campaign):
    known = campaign.known["base", "carriage"]["coulomb_friction"]
    tried = [start["sliding_force"] for start in known.starts]
    assert min(tried) < 20.0 < max(tried)


def test_the_slope_of_a_ramp_that_does_not_return_is_constant_up_to_its_ends():
    time = np.arange(400) / RATE
    inside = slice(40, -40)
    assert_allclose(slope(3.0 * time, RATE)[inside], 3.0, rtol=0.03)
