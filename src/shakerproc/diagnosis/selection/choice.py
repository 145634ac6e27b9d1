"""Which hypothesis stands: it predicts better than none, and explains most of what is left."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.errors import PARTED, beyond_noise, error_of
from shakerproc.diagnosis.selection.scores import (
    Score,
    best_of,
    gain,
    is_better,
    is_silent,
    simplest_alike,
)

SHARE: Final = 0.5
"""Share of the error beyond the noise, without an effect, that the model with it may leave: an
effect that leaves more does not explain most of what is missing [-]. Of the power that the
model as it is leaves, each number of the effects may leave as much: a law of many numbers comes
near any."""

TENTH: Final = 0.1
"""Share of the error without it that a law takes away at least, to be named where more than
noise is left [-]."""

NEGLIGIBLE: Final = 0.01
"""Error up to which a response is explained: what sensors are calibrated to [-]."""


def standing_of(found: Found) -> list[Score]:
    """Return the hypotheses that stand, the simplest first; none where none will do.

    Those that explain most: each predicts better than the model without any effect, each of
    its effects explains most of what is missing without it, and each of its numbers halves the
    power that the model as it is leaves. Where none does and more than noise is left, those
    that surely take a tenth of the error away.
    """
    better = _better(found)
    named = [
        s
        for s in better
        if _explains_most(found, s) and _holds_on(found, s, _predicting(found, s))
    ]
    if not named and not found.rigid and leaves_more(found, bare(found)):
        named = [
            s for s in better if _lowers(found, s) and _holds_on(found, s, _fewer(found, s))
        ]
    return simplest_alike(named) if named else []


def leaves_more(found: Found, score: Score) -> bool:
    """Return whether more is left than is known to be noise, by what sensors can tell."""
    return found.left_by(score) > NEGLIGIBLE and not found.is_explained_by(score)


def wants_more(found: Found) -> bool:
    """Return whether no effect stands, and the model without any leaves more than noise."""
    return not standing_of(found) and leaves_more(found, bare(found))


def needs_none(found: Found) -> bool:
    """Return whether no effect stands, and the model leaves no more than sensors can tell.

    Of what was held out, and of what it was fitted to.
    """
    stands = bare(found)
    if leaves_more(found, stands) or standing_of(found):
        return False
    fitted = error_of(found.data, stands.fit, found.form.scored_fitted)
    return fitted <= NEGLIGIBLE or stands.fit.follows_most


def further(found: Found, chosen: Score) -> Score | None:
    """Return the best hypothesis that adds to a chosen one an effect that helps a little.

    The chosen one may be the model without any effect. In whole tests, too, it predicts no
    worse than that.
    """
    more = [
        s
        for s in _better(found)
        if chosen in _without_one(found, s)
        and _holds_on(found, s, [chosen])
        and is_better(s, chosen)
        and found.left_by(s) < found.left_by(chosen)
    ]
    return best_of(more) if more else None


def is_outside(found: Found) -> bool:
    """Return whether a force without a name surely predicts better than all effects do.

    By a tenth of what any of them leaves, and where that is more than noise. Of a joint that
    held nothing is known, and nothing was tried.
    """
    free = found.free
    if found.rigid or free is None or not leaves_more(found, found.best):
        return False
    return is_better(free, found.best) and all(
        _takes_a_tenth(found, free, score) for score in (found.linear, *found.effects)
    )


def is_at_fault(found: Found, chosen: Score) -> bool:
    """Return whether what is corrected of the measurement explains most of what a model leaves.

    Of the tests as recorded the same numbers would leave twice as much at least.
    """
    if found.as_recorded is found.data:
        return False
    recorded = error_of(found.as_recorded, chosen.fit, found.form.held_out)
    return found.left_by(chosen) <= SHARE * recorded


def without_any(found: Found, score: Score) -> Score:
    """Return the model without an effect that a hypothesis is compared with.

    With its own numbers fitted; as it is in its file where they are not its own any more then,
    though those of the hypothesis are: damping a hundred times the model's is no model.
    """
    if found.linear.fit.is_far and not score.fit.is_far:
        return found.as_it_is or found.linear
    return found.linear


def bare(found: Found) -> Score:
    """Return the model that stands where no effect does: fitted, or as it is in its file.

    As it is where the fitted numbers leave more of what was held out, and more than noise.
    """
    fitted, as_it_is = found.linear, found.as_it_is
    if as_it_is is None or found.rigid or found.is_explained_by(fitted):
        return fitted
    return as_it_is if found.left_by(as_it_is) < found.left_by(fitted) else fitted


def _better(found: Found) -> list[Score]:
    """Return the hypotheses that predict better than any model without an effect.

    Those are the model with its own numbers fitted and, where it does not run away, as it is.
    """
    as_it_is = found.as_it_is or found.linear
    return [
        s
        for s in found.effects
        if is_better(s, without_any(found, s))
        and is_better(s, as_it_is)
        and gain(s, found.linear).mean > 0.0
    ]


def _explains_most(found: Found, score: Score) -> bool:
    """Return whether a hypothesis leaves much less than any does with fewer effects.

    One that leaves no more than noise of most blocks is no law that comes near by its many
    numbers, however far motions part in a few: half of the error is enough.
    """
    numbers = score.fit.hypothesis.size - found.linear.fit.hypothesis.size
    share = SHARE if score.is_mostly_noise else SHARE ** (0.5 * numbers)
    told = share * _beyond_noise(found, found.as_it_is or found.linear)
    near = _beyond_noise(found, score) <= told
    return near and all(_halves(found, score, one) for one in _simpler(found, score))


def _lowers(found: Found, score: Score) -> bool:
    """Return whether a hypothesis surely predicts better than any of fewer effects, by a tenth.

    The model without any as fitted, and as it is in its file, are among those: what a stiffness
    that is not the model's own takes away already needs no effect.
    """
    fewer = _fewer(found, score)
    return all(is_better(score, o) and _takes_a_tenth(found, score, o) for o in fewer)


def _fewer(found: Found, score: Score) -> list[Score]:
    """Return those of fewer effects, the model as it is and as fitted among them."""
    return [found.as_it_is or found.linear, found.linear, *_with_fewer(found, score)]


def _takes_a_tenth(found: Found, score: Score, other: Score) -> bool:
    """Return whether a hypothesis takes a tenth of the error of another one away."""
    return found.left_by(score) <= (1.0 - TENTH) * found.left_by(other)


def _halves(found: Found, score: Score, other: Score) -> bool:
    """Return whether a hypothesis leaves half of what another one does, beyond the noise.

    Of what was held out, if the other leaves more than noise of that: else nothing that it
    lacks may have been exercised there, and of what both were fitted to.
    """
    if is_silent(other):
        own, others = (float(np.mean(np.expm1(one.fitted))) - 1.0 for one in (score, other))
        return max(own, 0.0) <= SHARE**2 * others
    return _beyond_noise(found, score) <= SHARE * _beyond_noise(found, other)


def _holds_on(found: Found, score: Score, fewer: Sequence[Score]) -> bool:
    """Return whether none that has fewer effects predicts whole tests better.

    In windows that begin anew, with a memory that is fitted to each, an effect may gain what it
    loses in a test that runs freely: there its memory is a force that each window chooses.
    """
    if not fewer or found.form.horizon is None:
        return True
    own, others = found.free_run(score), map(found.free_run, fewer)
    return not any(one is not None and (own is None or is_better(one, own)) for one in others)


def _simpler(found: Found, score: Score) -> list[Score]:
    """Return the hypotheses with fewer effects, the model without any among them."""
    return [without_any(found, score), *_with_fewer(found, score)]


def _with_fewer(found: Found, score: Score) -> list[Score]:
    """Return the hypotheses with fewer effects, but one at least, of no more numbers."""
    own = score.fit.hypothesis
    others = [(s, s.fit.hypothesis) for s in found.effects]
    return [s for s, one in others if len(one.names) < len(own.names) and one.size <= own.size]


def _predicting(found: Found, score: Score) -> list[Score]:
    """Return the error that a hypothesis has to reach in whole tests.

    Those with fewer effects; the model without any where it predicts nearly all of the motion,
    which then does not part from its neighbours with a small effect either.
    """
    fewer, alone = _with_fewer(found, score), bare(found)
    return [alone, *fewer] if found.left_by(alone) <= PARTED else fewer


def _without_one(found: Found, score: Score) -> list[Score]:
    """Return the hypotheses with all but one of the effects, as far as they were scored.

    Beside a single effect that is the model that stands where none does.
    """
    names = score.fit.hypothesis.names
    if len(names) == 1:
        return [bare(found)]
    others = [(s, s.fit.hypothesis.names) for s in found.effects]
    return [s for s, own in others if len(own) == len(names) - 1 and own < names]


def _beyond_noise(found: Found, score: Score) -> float:
    """Return the error of a hypothesis beyond the noise floor, where that is known [-]."""
    return beyond_noise(found.left_by(score), found.floor)
