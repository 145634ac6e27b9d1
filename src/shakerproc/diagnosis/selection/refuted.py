"""Noise that a hypothesis beats on what was held out, and so is less."""

from collections.abc import Mapping
from typing import TypeAlias

from shakerproc.compare.floor import input_is_refuted, is_refuted
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import moved_tests, scored_tests

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
    data, fit, held_out = found.data, found.best.fit, found.form.held_out
    scored = scored_tests(data, fit, held_out) or {}
    moved = {test.arrays.name: apart for test, _, apart in moved_tests(data, fit, held_out)}
    more = dict(refuted)
    for i, test in scored.items():
        noise, name = data.tests[i].noise_density, data.tests[i].arrays.name
        responses, inputs = refuted.get(name, ((), ()))
        if is_refuted(test, noise):
            more[name] = (_with(responses, noise.source), inputs)
        elif name in moved and input_is_refuted(test, noise, moved[name]):
            more[name] = (responses, _with(inputs, noise.input_source))
    return more


def _with(sources: tuple[str, ...], more: str) -> tuple[str, ...]:
    return sources if more in sources else (*sources, more)
