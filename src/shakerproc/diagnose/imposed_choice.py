"""Which law explains an imposed motion's force, and the least that any law could leave."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from shakerproc.data import FloatArray
from shakerproc.diagnose.candidates import Values
from shakerproc.diagnose.imposed_fit import Bench, Fitted, fit, refined, score, starts_of
from shakerproc.diagnose.imposed_laws import PLAY_AND_SLIDER, Law, single_laws
from shakerproc.diagnose.imposed_motion import scatter
from shakerproc.diagnose.pipeline import MATTERS

ABOVE = 1.5
"""How far above the floor a law may stay that explains the force: that of DESIGN.md [-]."""
ALIKE = 0.01
"""Share of what is left by which two equals may differ [-]."""
SURE = 2.0
"""Standard errors over the swings by which the better of two must lead [-]."""
SCORED = 6
"""Pairs that are fitted again without the swings that score them."""
KNOTS = (20, 40, 80)
"""Points of the free curve along a swing [-]."""


@dataclass(frozen=True, slots=True)
class Floor:
    """The least that can be left of the force, as shares of its rms.

    Attributes
    ----------
    scatter : float
        Between repeats of a swing; the noise of the sensor where none is repeated [-].
    repeated : bool
        Whether a swing was repeated.
    free : float
        Of a free curve of displacement, velocity and way since the turn, held out [-].
    """

    scatter: float
    repeated: bool
    free: float

    @property
    def reachable(self) -> float:
        """What a law of the motion could be expected to leave [-]."""
        return max(self.scatter, self.free)


def floor_of(at: Bench) -> Floor:
    """Return the floor of these tests."""
    noise = float(np.sqrt(np.mean([loop.noise**2 for loop in at.loops])))
    between = scatter(at.loops)
    return Floor(max(between or 0.0, noise) / at.rms, between is not None, _free(at) / at.rms)


def _free(at: Bench) -> float:
    """Return what a free curve leaves of swings it was not fitted to, rms [N].

    The force is any curve along each way of a swing (over the displacement since the turn),
    with a straight line or any curve of displacement and of velocity besides, linear between
    knots. The best of six is taken.
    """
    since = np.concatenate([
        np.abs(loop.displacement - loop.turns[np.maximum(loop.swing, 0)])[kept]
        for loop, kept in zip(at.loops, at.judged, strict=True)
    ])  # fmt: skip
    forward = np.concatenate([
        (np.diff(loop.turns)[np.maximum(loop.swing, 0)] > 0.0)[kept]
        for loop, kept in zip(at.loops, at.judged, strict=True)
    ])  # fmt: skip
    z, v = at.displacement / at.motion.rms, at.velocity / at.motion.fast
    ends = np.eye(len(at.loops))[at.test]
    left = []
    for knots in KNOTS:
        along = _hats(since, knots)
        one = [
            z[:, None],
            v[:, None],
            ends,
            along * forward[:, None],
            along * ~forward[:, None],
        ]
        for design in (one, [*one, _hats(z, KNOTS[0]), _hats(v, KNOTS[0])]):
            left.append(_held_out(at, np.concatenate(design, axis=1)))
    return min(left)


def _hats(x: FloatArray, knots: int) -> FloatArray:
    """Return columns that are 1 at one knot and 0 at the others, linear between them."""
    at = np.unique(np.quantile(x, np.linspace(0.0, 1.0, knots)))
    return np.stack([np.interp(x, at, row) for row in np.eye(at.size)], axis=1)


def _held_out(at: Bench, design: FloatArray) -> float:
    squares, count = 0.0, 0
    for part, kept in at.folds():
        normal = design[part].T @ design[part]
        normal += 1e-6 * np.trace(normal) / len(normal) * np.eye(len(normal))
        weights = np.linalg.solve(normal, design[part].T @ at.force[part])
        squares += float(np.sum((at.force[kept] - design[kept] @ weights) ** 2))
        count += int(np.sum(kept))
    return float(np.sqrt(squares / max(count, 1)))


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """What was fitted and which of it is to be named.

    Attributes
    ----------
    linear : Fitted
        The model refitted, without any effect beside those it has.
    ordered : tuple of Fitted
        Everything else, the one to be named first.
    same : tuple of Fitted
        Those that do as well with other effects.
    floor : Floor
        What can be left at least.
    """

    linear: Fitted
    ordered: tuple[Fitted, ...]
    same: tuple[Fitted, ...]
    floor: Floor


def squares(fitted: Fitted) -> float:
    """Return the mean square of what is left of swings that took no part [N²]."""
    return float(np.nanmean(fitted.scored**2))


def lead(at: Bench, better: Fitted, other: Fitted) -> tuple[float, float]:
    """Return by how much one leaves less, mean square and its standard error [N²]."""
    scored = np.isfinite(better.scored) & np.isfinite(other.scored)
    gain = other.scored[scored] ** 2 - better.scored[scored] ** 2
    swings = at.swing[scored]
    sums = np.array([np.sum(gain[swings == s]) for s in np.unique(swings)]) / gain.size
    error = float(np.std(sums, ddof=1) * np.sqrt(sums.size)) if sums.size > 1 else np.inf
    return float(np.sum(sums)), error


def choose(at: Bench, base: Law, values: Values, say: Callable[[str], None]) -> Choice:
    """Return what the force of an imposed motion asks for beside the model."""
    linear = fit(at, base, [values])
    say("free curve and repeats")
    floor = floor_of(at)
    say("single effects along the imposed motion")
    singles = [_beside(at, linear, law) for law in single_laws(at.motion)]
    found = [one for one in singles if one is not None]
    if not found:
        return Choice(linear, (), (), floor)
    best = min(found, key=squares)
    first = _simplest(at, found)
    pairs: list[Fitted] = []
    if np.sqrt(squares(best)) > ABOVE * floor.scatter * at.rms:
        say("pairs along the imposed motion")
        rest = sorted((one for one in found if one is not first), key=squares)
        pairs = _pairs(at, (first, *rest[:2]), len(base.parts))
    enough = ABOVE * floor.scatter * at.rms
    if pairs:
        pair = _simplest(at, pairs)
        gain, error = lead(at, pair, first)
        much = gain > MATTERS * squares(linear) or np.sqrt(squares(pair)) < enough
        if gain > max(SURE * error, ALIKE * squares(pair)) and much:
            first = pair
    rest = sorted((one for one in (*found, *pairs) if one is not first), key=squares)
    size = len(first.law.parts)
    same = tuple(
        one for one in rest
        if len(one.law.parts) <= size and _alike(at, first, one)
        and not set(first.law.kinds) <= set(one.law.kinds)
    )  # fmt: skip
    return Choice(linear, (first, *rest), same, floor)


def _beside(at: Bench, known: Fitted, law: Law) -> Fitted | None:
    """Return the fit of a law beside one that is known already."""
    starts = starts_of(at, law.parts[0], at.law(known.law, known.values))
    joined = Law((*known.law.parts, *law.parts))
    return fit(at, joined, [(*known.values, *start) for start in starts]) if starts else None


def _pairs(at: Bench, leading: Sequence[Fitted], n_base: int) -> list[Fitted]:
    """Return fits of the leading single laws beside each other one, the best few scored."""
    out: list[Fitted] = []
    seen = set()
    for one in leading:
        for law in single_laws(at.motion):
            kinds = frozenset((*one.law.kinds[n_base:], *law.kinds))
            if kinds in seen or set(law.kinds) & set(one.law.kinds):
                continue
            seen.add(kinds)
            start = starts_of(at, law.parts[0], at.law(one.law, one.values))[:1]
            joined = Law((*one.law.parts, *law.parts))
            if start:
                out.append(refined(at, joined, (*one.values, *start[0])))
    out.sort(key=lambda one: float(np.sum(one.left[~at.hold_out] ** 2)))
    return [score(at, one) for one in out[:SCORED]]


def _alike(at: Bench, one: Fitted, other: Fitted) -> bool:
    """Return whether another fit is no worse than the swings and 1 % leave open."""
    gain, error = lead(at, one, other)
    return gain <= max(SURE * error, ALIKE * squares(one))


def _simplest(at: Bench, found: Sequence[Fitted]) -> Fitted:
    """Return the fit with the fewest numbers of those as good as the best."""
    best = min(found, key=squares)
    return min(
        (one for one in found if _alike(at, best, one)),
        key=lambda one: (len(one.values), squares(one)),
    )


def sureness(at: Bench, choice: Choice) -> float:
    """Return how sure the first is to lead the next that lacks one of its effects."""
    first = choice.ordered[0]
    rivals = [
        one for one in (choice.linear, *choice.ordered[1:])
        if not set(first.law.kinds) <= set(one.law.kinds)
    ]  # fmt: skip
    scores = []
    for one in rivals:
        gain, error = lead(at, first, one)
        scores.append(gain / max(error, 1e-12 * squares(one), 1e-300))
    return float(min(scipy.stats.norm.cdf(min(scores)), 0.99)) if scores else 0.99


def is_series(fitted: Fitted) -> bool:
    """Return whether play and friction act one behind the other."""
    return PLAY_AND_SLIDER in fitted.law.parts
