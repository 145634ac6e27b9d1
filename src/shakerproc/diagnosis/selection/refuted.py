"""Noise that a hypothesis beats on what was held out, and so is less."""

from collections.abc import Mapping
from typing import TypeAlias

from shakerproc.compare.floor import is_beaten, is_refuted
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import scored_tests

Refuted: TypeAlias = Mapping[str, tuple[tuple[str, ...], tuple[str, ...]]]
"""Sources of noise that are no floor, of responses and of inputs, by the name of the test."""


def with_more_refuted(found: Found, refuted: Refuted) -> Refuted:
    """Return the sources of noise that are refuted, those of a search besides.

    Parameters
    ----------
    found : Found
        What a search found with the noise that was left; the best of its hypotheses judges.
    refuted : mapping of str to pair of tuple of str
        What was refuted before.
    """
    scored = scored_tests(found.data, found.best.fit, found.form.held_out) or {}
    floors = found.floors_under(found.best)
    more = dict(refuted)
    for i, test in scored.items():
        noise, name = found.data.tests[i].noise_density, found.data.tests[i].arrays.name
        responses, inputs = refuted.get(name, ((), ()))
        if is_refuted(test, noise):
            more[name] = (_with(responses, noise.source), inputs)
        elif i in floors and is_beaten(test, floors[i]):
            more[name] = (responses, _with(inputs, noise.input_source))
    return more


def _with(sources: tuple[str, ...], more: str) -> tuple[str, ...]:
    return sources if more in sources else (*sources, more)
