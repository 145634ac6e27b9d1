"""How well hypotheses predict what they were not fitted to, window by window."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.comparison.noise import EXCESS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.levels import predicted_rows
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.diagnosis.hypotheses.joints import Joint, Known, has_limit

BY_CHANCE: Final = 0.2
"""Standard deviation of the difference in one block of two that predict equally well: a tenth
of the residual, what some hundred samples leave open [-]."""

ALIKE: Final = 2.0
"""Standard errors within which two predictions are equally good: 95 % of a normal law [-]."""

SURE: Final = 3.0
"""Standard errors by which one must predict better than another: by chance 1 in 700 [-]."""

FAR: Final = 6.0
"""Standard errors by which a hypothesis may predict worse than the best on short windows and is
still fitted at the horizon: once in 10^9 by chance [-]."""

MOSTLY_NOISE: Final = float(np.log1p(EXCESS**2))
"""Mean logarithm of 1 + mean square up to which noise alone is left of most blocks [-]."""

LEAST: Final = 0.01
"""Gain below which an effect does not matter: what is left falls by half a per cent [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """Held-out prediction of one hypothesis.

    Attributes
    ----------
    fit : Fit
        The hypothesis and its numbers.
    logs : (n_blocks,) array
        Logarithm of 1 + mean square of the residual over the noise in each block: half of it
        is how many times the residual is larger than the noise, as a logarithm [-].
    """

    fit: Fit
    logs: FloatArray

    @property
    def fitted(self) -> FloatArray:
        """Logarithms of the errors in the fitted part, (n_blocks,) array [-]."""
        return np.log1p(self.fit.rows)

    @property
    def mean(self) -> float:
        """Mean over the blocks [-]."""
        return float(np.mean(self.logs))

    @property
    def is_noise(self) -> bool:
        """Whether no more is left than noise and what it becomes in the model."""
        return _are_noise(self.logs)

    @property
    def is_mostly_noise(self) -> bool:
        """Whether no more is left of most blocks, however far motions diverge in a few.

        Of those that were held out, and of those that it was fitted to.
        """
        return max(self.mean, float(np.mean(self.fitted))) <= MOSTLY_NOISE


def scored(data: DataSet, found: Fit, windows: Windows) -> Score | None:
    """Return the score of a fit on windows that took no part in it.

    Starts of windows are fitted on their first two periods, which do not count.
    """
    settled = with_starts_fitted(data, found, windows)
    rows = predicted_rows(data, settled, windows) if settled is not None else None
    if rows is None:
        return None
    return Score(found, np.log1p(rows))


def as_fitted(data: DataSet, found: Fit) -> Score | None:
    """Return the score of a fit on the windows that it was fitted to, starts included."""
    own = found.rows if found.data is data else None
    rows = predicted_rows(data, found, found.windows) if own is None else own
    return None if rows is None else Score(found, np.log1p(rows))


@final
@dataclass(frozen=True, slots=True)
class Gain:
    """By how much one hypothesis predicts better than another.

    Attributes
    ----------
    mean : float
        Mean difference of the logarithms; above 0 where the first is better [-].
    error : float
        Its standard error, from the blocks that speak against it and from chance: a gain that
        is large in a few blocks and nothing in the rest is no less certain for that [-].
    """

    mean: float
    error: float

    @property
    def t(self) -> float:
        """Mean over standard error [-]."""
        return self.mean / self.error


def gain(better: Score, other: Score) -> Gain:
    """Return by how much the first predicts better than the other what was held out.

    Where both leave no more of that than noise it cannot tell them apart: a joint never slipped
    there, say. Then what they were fitted to does, if one of them leaves more than noise of it,
    or of some of its blocks where the other leaves noise of each.
    """
    held_out, fitted = (better.logs, other.logs), (better.fitted, other.fitted)
    each = [float(np.max(np.expm1(logs))) <= EXCESS**2 for logs in fitted]
    tells = not all(map(_are_noise, fitted)) or each[0] != each[1]
    return gain_of(*(fitted if tells and all(map(_are_noise, held_out)) else held_out))


def is_silent(score: Score) -> bool:
    """Return whether more than noise is left of what was fitted to, but not of the rest."""
    return _are_noise(score.logs) and not _are_noise(score.fitted)


def leaves_something(score: Score) -> bool:
    """Return whether more than noise is left, of what was held out or was fitted to."""
    return not (_are_noise(score.logs) and _are_noise(score.fitted))


def gain_of(better: FloatArray, other: FloatArray) -> Gain:
    """Return by how much less one leaves than another, from their logarithms in each block.

    Both are (n_blocks,) arrays of the same blocks (see `Score.logs`).
    """
    apart = other - better
    mean = float(np.mean(apart))
    against = np.minimum(apart * np.sign(mean), 0.0)
    error = np.sqrt((2.0 * np.mean(against**2) + BY_CHANCE**2) / apart.size)
    return Gain(mean, float(error) if apart.size > 1 else np.inf)


def is_better(score: Score, other: Score) -> bool:
    """Return whether the first predicts better than the other, for sure and by what matters."""
    own = gain(score, other)
    return own.t > SURE and own.mean > LEAST


def best_of(scores: Sequence[Score]) -> Score:
    """Return the hypothesis that predicts best (see `gain`)."""
    best = min(scores, key=lambda score: score.mean)
    for score in scores:
        if gain(score, best).mean > 0.0:
            best = score
    return best


def ranked(scores: Sequence[Score]) -> list[Score]:
    """Return scores, the best first."""
    return sorted(scores, key=lambda score: score.mean)


def best_of_each(scores: Sequence[Score]) -> list[Score]:
    """Return the best score of each hypothesis."""
    best: dict[frozenset[tuple[str, Joint]], Score] = {}
    for score in ranked(scores):
        best.setdefault(score.fit.hypothesis.names, score)
    return list(best.values())


def simplest_alike(scores: Sequence[Score]) -> list[Score]:
    """Return those that predict as well as the best, the one with fewest numbers first.

    Of those, with numbers that are the model's own; else that is no simpler.
    """
    best = best_of(scores)
    alike = [s for s in scores if s is best or gain(best, s).t < ALIKE]
    return sorted(alike, key=lambda s: (s.fit.is_far, s.fit.hypothesis.size, s.mean))


def _are_noise(logs: FloatArray) -> bool:
    return float(np.mean(np.expm1(logs))) <= EXCESS**2


def worth_a_fit(
    scores: Sequence[Score],
    known: Known,
    *,
    beside: Sequence[Score] = (),
    behind: float = SURE,
) -> list[Fit]:
    """Return the fits that may be the best where the windows are longer, by their scores.

    A law that contains another one that it does not outdo is left out: the simpler stands in;
    where it does, the simpler may just not have arrived, and stays: where the richer turns
    out to have more numbers than it can account for, the simpler is asked for.
    The model without any is contained in all; beside it the best effect always stays.

    Parameters
    ----------
    scores : sequence of Score
        With effects and, maybe, without.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    beside : sequence of Score
        What is contained in all others besides, and does not go on.
    behind : float
        Standard errors by which one may be behind the best [-].
    """
    bare = [score for score in scores if not score.fit.hypothesis.added]
    less = [*bare, *beside]
    effects = [score for score in scores if score.fit.hypothesis.added]
    best = min(effects, key=lambda score: score.mean, default=None)
    unmatched = [
        s
        for s in effects
        if all(gain(s, none).mean > LEAST for none in less)
        and not any(
            contains(s.fit, other.fit, known) and _no_better(s, other) for other in effects
        )
    ]
    near = [s for s in unmatched if best is not None and gain(best, s).t < behind]
    near += [
        s
        for s in unmatched
        if s not in near and any(contains(other.fit, s.fit, known) for other in near)
    ]
    if best is not None and not near:
        near = [best]
    return [score.fit for score in (*bare, *near)]


def contains(richer: Fit, simpler: Fit, known: Known) -> bool:
    """Return whether one hypothesis has another as a limit: all effects alike but one.

    That one has the other's, in the same joint, as a limit.
    """
    own = richer.hypothesis.names - simpler.hypothesis.names
    others = simpler.hypothesis.names - richer.hypothesis.names
    if len(own) != 1 or len(others) != 1:
        return False
    return has_limit(known, *own, *others)


def _no_better(richer: Score, simpler: Score) -> bool:
    return richer.mean >= simpler.mean - LEAST
