"""Noise that a hypothesis beats on what was held out, and so is less."""

from collections.abc import Mapping

from shakerproc.comparison import floor
from shakerproc.comparison.noise import NOT_REFUTED, Refuted
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import scored_tests


def with_more_refuted(found: Found, refuted: Mapping[str, Refuted]) -> dict[str, Refuted]:
    """Return the sources of noise that are refuted, those of a search besides.

    Parameters
    ----------
    found : Found
        What a search found with the noise that was left; the best of its hypotheses judges.
    refuted : mapping of str to Refuted
        What was refuted before, by the name of the test.
    """
    scored = scored_tests(found.data, found.best.fit, found.form.held_out) or {}
    floors = found.floors_under(found.best)
    more = dict(refuted)
    for i, test in scored.items():
        own = found.data.tests[i]
        before = refuted.get(own.name, NOT_REFUTED)
        after = floor.with_more_refuted(test, own.noise_density, floors.get(i), before)
        if after.names:
            more[own.name] = after
    return more
