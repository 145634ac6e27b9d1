"""Laws that contain one that was fitted, begun where it ended."""

import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.one_mass import JOINT, added, data_of, one_mass

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.richer_laws import richer_laws
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.models import EFFECTS

FORCES = {"sliding_force": 0.8, "breakaway_force": 1.1, "stribeck_velocity": 5e-3}


@pytest.fixture(scope="module")
def searched():
    """Return laws and a fit of Coulomb friction to tests with Stribeck friction."""
    data = data_of(one_mass(effect=EFFECTS["stribeck_friction"](**FORCES)), seconds=1.5)
    campaign = campaign_of(data.model, data.tests)
    hypothesis, x = added(data, "coulomb_friction", sliding_force=0.9)
    coulomb = fit(data, hypothesis, x, whole_tests(data, held_out=False), rounds=10)
    return campaign.known, coulomb


def test_the_law_that_contains_it_leaves_less_and_has_the_true_numbers(searched):
    known, coulomb = searched
    richer = richer_laws(
        coulomb.data, known, coulomb, coulomb.windows, rounds=8, say=lambda _: None
    )
    stribeck = next(one for one in richer if one.hypothesis.kinds == ("stribeck_friction",))
    assert stribeck.level < coulomb.level
    effect = stribeck.hypothesis.model_at(stribeck.x).elements[-1].effect
    assert_allclose(effect.sliding_force, FORCES["sliding_force"], rtol=0.05)
    assert_allclose(effect.breakaway_force, FORCES["breakaway_force"], rtol=0.05)
    assert stribeck.hypothesis.added[0].between == JOINT
