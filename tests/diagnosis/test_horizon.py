"""What is carried over to longer horizons, and how it is scored there."""

import numpy as np
from tests.diagnosis.one_mass import added, data_of, one_mass

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.estimation.form import carried, usable_forms
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.horizon import along, scored_at
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of
from shakerproc.diagnosis.nudged.ladder import ladder_of
from shakerproc.models import EFFECTS

CUBIC = {"coefficient": 3e11}


def test_what_falls_far_behind_is_fitted_no_further_and_scored_as_the_rest():
    data = data_of(one_mass(effect=EFFECTS["cubic_stiffness"](**CUBIC)))
    campaign = campaign_of(data.model, data.tests)
    forms = usable_forms(campaign.data)[:2]
    hypothesis, x = added(data, "cubic_stiffness", **CUBIC)
    shortest = ladder_of(data)[0].windows
    best = carried(data, fit(data, hypothesis, x, shortest, rounds=5), forms)
    none = hypothesis_of(data.model)
    linear = fit(data, none, np.zeros(none.size), shortest, rounds=5)
    (first,) = scored_at(campaign, [best], forms[-1])
    (beside,) = along(campaign, [linear], forms, beside=best)
    (alone,) = along(campaign, [linear], forms)
    assert first.fitted.shape == beside.fitted.shape == alone.fitted.shape
    assert first.mean < alone.mean
    at_first = carried(data, linear, forms[:1])
    np.testing.assert_array_equal(beside.fit.x, at_first.x)
    assert np.any(alone.fit.x != at_first.x)
