"""Hypotheses judged again by another estimate of the noise."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from shakerproc.diagnosis.campaign import campaign_of
from shakerproc.diagnosis.data import Test, with_noise_of
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.outcome import at_the_horizon
from shakerproc.diagnosis.search import told
from shakerproc.models import Model


def judged_again(
    model: Model, before: Found, tests: Sequence[Test], say: Callable[[str], None]
) -> Found | None:
    """Return the hypotheses, fitted and judged at the horizon by another noise.

    None where they leave more than noise then: others may be better. Of structures all raced,
    whatever the noise.

    Parameters
    ----------
    model, tests, say
        As for `search`; the tests differ from those before by their noise alone.
    before : Found
        What was found before.
    """
    campaign = campaign_of(before.data.model, with_noise_of(before.data.tests, tests))
    if before.data.points:
        campaign = replace(campaign, data=campaign.data.as_values())
    if before.data.differing:
        campaign = replace(campaign, data=campaign.data.as_differing())
    fits = [score.fit for score in before.effects]
    outcome = at_the_horizon(campaign, before.linear.fit, fits, say)
    found = replace(
        told(model, before.linear_model, outcome, before.failed, ()),
        ruled_out=before.ruled_out,
        corrected=before.corrected,
        rigid=before.rigid,
        signs=before.signs,
        late=before.late,
        hums=before.hums,
        recorded=tuple(tests) if before.recorded else (),
    )
    return found if found.rigid or found.is_enough or model.structures else None
