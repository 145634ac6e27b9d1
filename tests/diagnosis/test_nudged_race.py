"""The race over the nudging rate: hidden laws of a simulated truth, and none."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis import chains
from tests.diagnosis.one_mass import JOINT, arrays_of, one_mass

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.nudged import race
from shakerproc.diagnosis.nudged.ladder import pieces
from shakerproc.models import EFFECTS
from shakerproc.models.effects import Gap

HIDDEN = {
    "gap": {"stiffness": 2e5, "clearance": 1e-4},
    "cubic_stiffness": {"coefficient": 1e12},
    "coulomb_friction": {"sliding_force": 1.5},
    "jenkins": {"stiffness": 4e4, "slip_force": 3.0},
}


def raced(effect):
    tests = prepared(arrays_of(one_mass(effect=effect), levels=(2.0, 6.0), seconds=2.0))
    campaign = campaign_of(one_mass(), tests)
    laws = {kind: campaign.known[JOINT][kind] for kind in HIDDEN}
    none = hypothesis_of(campaign.data.model)
    return race.raced(
        campaign.data, none, np.zeros(none.size), {JOINT: laws}, lambda _text: None
    )


@pytest.mark.parametrize(
    "kind",
    [
        "gap",
        *(
            pytest.param(k, marks=[pytest.mark.slow, pytest.mark.long])
            for k in HIDDEN
            if k != "gap"
        ),
    ],
)
def test_a_hidden_law_leads_and_has_its_numbers(kind):
    best, *_ = raced(EFFECTS[kind](**HIDDEN[kind])).fits
    assert best.hypothesis.kinds == (kind,)
    (one,) = best.hypothesis.added
    found = one.parameters(best.hypothesis.parts(best.x)[1])
    assert found == pytest.approx(HIDDEN[kind], rel=0.03)


def test_long_laws_are_tried_in_the_joint_that_short_ones_tell():
    model, joint = chains.chain(2), ("m1", "m2")
    tests = chains.campaign(chains.with_effect(model, Gap(2e5, 1e-4), joint))
    known = chains.identifications(model, tests, ("gap", "cubic_stiffness", "offset_gap"))
    data, none = campaign_of(model, tests).data, hypothesis_of(model)
    result = race.raced(data, none, np.zeros(none.size), known, lambda _text: None)
    tried = {one.hypothesis.added[-1].between: set() for one in result.left}
    for one in result.left:
        tried[one.hypothesis.added[-1].between] |= set(one.hypothesis.kinds)
    assert tried == {joint: set(known[joint]), ("base", "m1"): {"gap", "cubic_stiffness"}}
    assert result.fits[0].hypothesis.added[-1].between == joint
    assert [name for name in result.failed if "base and m1" in name]


def test_where_nothing_is_missing_no_law_takes_more_than_a_tenth_of_the_noise_away():
    result = raced(None)
    assert all(one.chi_square > 0.9 * result.base.chi_square for one in result.fits)


def test_pieces_are_chosen_where_a_sweep_meets_the_resonance():
    data = campaign_of(one_mass(), prepared(arrays_of(one_mass(), seconds=8.0))).data
    test = data.tests[0]
    loud = np.zeros(test.n_samples)
    loud[9000:11000] = np.sin(0.3 * np.arange(2000))
    swept = replace(test, responses=1e-3 * test.responses + loud)
    own = replace(data, tests=(swept, *data.tests[1:]))
    chosen = pieces(own, 300.0, 0.1, held_out=False)
    ends = chosen.table[chosen.table[:, 0] == 0]
    assert np.all((ends[:, 1] + ends[:, 2] > 9000) & (ends[:, 1] < 11000))
