"""Noise that a hypothesis beats on what was held out, and so is less."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

from shakerproc.comparison import floor
from shakerproc.comparison.noise import AGREES, NOT_REFUTED, Refuted
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest, with_noise_of
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import floors_of, scored_tests

NEXT: Final = "the next estimate was taken, if there is one"
"""What is said where another estimate may follow."""


def with_more_refuted(
    found: Found,
    refuted: Mapping[str, Refuted],
    estimated: Callable[[Mapping[str, Refuted]], Sequence[PreparedTest]],
) -> dict[str, Refuted]:
    """Return the sources of noise that are refuted, those of a search besides.

    Parameters
    ----------
    found : Found
        What a search found with the noise that was left; the best of its hypotheses judges.
    refuted : mapping of str to Refuted
        What was refuted before, by the name of the test.
    estimated : callable
        Returns the tests with the noise that is left, which is refuted in its turn until one
        estimate is not.
    """
    data, best, windows = found.data, found.best.fit, found.form.held_out
    scored = scored_tests(data, best, windows) or {}
    floors = found.floors_under(found.best)
    known = dict(refuted)
    while True:
        more = dict(known)
        for i, test in scored.items():
            own = data.tests[i]
            draws: FloatArray | None = floors.get(i)
            before = known.get(own.name, NOT_REFUTED)
            after = floor.with_more_refuted(test, own.noise_density, draws, before)
            if after.names:
                more[own.name] = after
        if more == known:
            return known
        known = more
        data = replace(data, tests=with_noise_of(data.tests, estimated(known)))
        floors = floors_of(data, best, windows)


def refuted_notes(refuted: Mapping[str, Refuted]) -> list[str]:
    """Return which estimates of the noise were too large, of responses and inputs, by test."""
    return [
        f"{test}: there is less noise of {of} than {' and '.join(sources)} said, for a model "
        f"leaves less of what was held out; {taken}."
        for test, own in refuted.items()
        for of, sources, taken in (
            ("the responses", own.responses, NEXT),
            ("the input", own.inputs, NEXT if own.share == 1.0 else _in_its_place(own.share)),
        )
        if sources
    ]


def _in_its_place(share: float) -> str:
    """Return what stands for the noise of the input where no estimate of it is left."""
    told = "no other estimate is left, so that it is taken as what the model leaves"
    return told if share == 0.0 or share >= AGREES else f"{told}, and no probability is told"
