"""Noise that a hypothesis beats on what was held out, and so is less."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from shakerproc.comparison import floor
from shakerproc.comparison.noise import NOT_REFUTED, Refuted
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test, with_noise_of
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import floors_of, scored_tests


def with_more_refuted(
    found: Found,
    refuted: Mapping[str, Refuted],
    estimated: Callable[[Mapping[str, Refuted]], Sequence[Test]],
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
