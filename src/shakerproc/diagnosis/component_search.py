"""The search in component tests: the motion is imposed, the force is compared."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.diagnosis import component_tests
from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.estimation.linear import as_given
from shakerproc.diagnosis.estimation.one_more import OneMore
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.horizon import along
from shakerproc.diagnosis.left_behind import with_all
from shakerproc.diagnosis.own_fit import as_it_is
from shakerproc.diagnosis.search import ruled_out
from shakerproc.diagnosis.selection.scores import ranked
from shakerproc.errors import DiagnosisError
from shakerproc.models import Model


def search_component_tests(
    model: Model, tests: Sequence[Test], say: Callable[[str], None]
) -> Found:
    """Return which single effect explains the force over an imposed motion, and how well.

    Raises
    ------
    DiagnosisError
        If the force cannot be simulated.
    """
    campaign = campaign_of(model, tests)
    form = component_tests.form_of(campaign.data)
    if not len(form.held_out):
        raise DiagnosisError(
            f"{model.title}: nothing can be held out, since the drive of each test repeats "
            "itself. Add a test with another amplitude or frequency, marked hold_out: true."
        )
    campaign = replace(campaign, stages=component_tests.stages_of(form))
    data = campaign.data
    say("the model's own numbers")
    linear = component_tests.linear_fit(data, form)
    if linear is None:
        raise DiagnosisError(f"{model.title}: its force cannot be simulated in these tests.")
    say("screening")
    starts = component_tests.starts_of(campaign, campaign.known)
    own = np.zeros(len(linear.hypothesis.own))
    one_more = OneMore(data, linear, campaign.known, campaign.stages, linear=own, say=say)
    singles = one_more.found(starts)
    bare = along(campaign, [linear], [form])
    if not bare:
        raise DiagnosisError(
            f"{model.title}: its force cannot be simulated in what is held out."
        )
    found = Found(
        data=data,
        linear_model=as_given(model, tests),
        form=form,
        before=as_it_is(model, linear),
        linear=bare[0],
        effects=tuple(ranked(along(campaign, singles, [form]))),
        free=None,
        ruled_out=ruled_out(starts, singles),
        failed=one_more.failed,
    )
    return with_all(found, campaign, [form], lambda: one_more.every(starts), say, known={})
