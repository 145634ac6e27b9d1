r"""Following a curve of solutions around its folds.

The curve is :math:`R(u) = 0` with one unknown more than equations. Each step predicts along the
tangent and its change, and corrects at right angles to the tangent. Lengths are measured in
weights that belong to the place on the curve (a fixed scale would step over the narrow spikes
of superharmonics), and a step that turns the tangent by too much, or whose prediction missed by
too much, is taken again, shorter.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, final

import numpy as np

from shakerproc.data import FloatArray


class ContinuedCurve(Protocol):
    """The equations of a curve."""

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual (n,) and derivative (n, n + 1) at a (n + 1,) point.

        The units are those of the unknowns.
        """

    def weights(self, point: FloatArray) -> FloatArray:
        """Return the weight of each unknown in a length, (n + 1,) array.

        Each is one over the unit of its unknown.
        """


@final
@dataclass(frozen=True, slots=True)
class StepSizes:
    """How a curve is followed.

    Attributes
    ----------
    first : float
        First step, in the local scale [-].
    longest : float
        Longest step [-].
    shortest : float
        A step below which the curve ends [-].
    miss : float
        By how much a prediction may miss without a shorter step [-].
    turn : float
        Largest angle between tangents [rad].
    kink : float
        A step below which the tangent may turn by up to a right angle: where a force has a
        corner, so has the curve [-].
    most : int
        Number of points after which the curve ends.
    tolerance : float
        Size of the last correction [-].
    """

    first: float = 0.02
    longest: float = 0.15
    shortest: float = 1e-7
    miss: float = 0.02
    turn: float = 0.35
    kink: float = 1e-3
    most: int = 4000
    tolerance: float = 1e-9


@final
@dataclass(frozen=True, slots=True, eq=False)
class CurvePlace:
    """A point of the curve with its tangent in the local scale and the step behind it."""

    point: FloatArray
    tangent: FloatArray
    bend: FloatArray
    step: float


@final
@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Curve that was followed.

    Attributes
    ----------
    points : (n, n_unknowns + 1) array
        Points of the curve in order.
    tangents : (n, n_unknowns + 1) array
        Direction of the curve at each, in the units of the unknowns.
    ended : str
        Why it ends: what the caller said, ``too short a step`` or ``too many points``.
    """

    points: FloatArray
    tangents: FloatArray
    ended: str


def follow(
    curve: ContinuedCurve,
    start: FloatArray,
    towards: FloatArray,
    stop: Callable[[FloatArray, FloatArray], str],
    steps: StepSizes,
) -> Trace:
    """Return the curve from a solution on.

    Parameters
    ----------
    curve : ContinuedCurve
        The equations.
    start : (n + 1,) array
        A solution [units of the unknowns].
    towards : (n + 1,) array
        Direction to set out in, in the units of the unknowns.
    stop : function
        Previous and new point to why the curve ends at the new one; empty to go on
        [units of the unknowns].
    steps : StepSizes
        How to follow it.
    """
    place = _set_out(curve, start, towards)
    places, length = [place], steps.first
    ended = "too many points"
    while len(places) < steps.most:
        following = _advance(curve, place, length, steps)
        if following is None:
            length *= 0.4
            if length < steps.shortest:
                ended = "too short a step"
                break
            continue
        missed = float(np.linalg.norm(following.bend))
        # the prediction is a parabola: what it misses grows with the cube of the step
        growth = 2.0 if missed == 0.0 else (steps.miss / missed) ** (1.0 / 3.0)
        length = min(steps.longest, following.step * min(2.0, max(0.3, 0.9 * growth)))
        previous, place = place, _with_bend(curve, place, following)
        places.append(place)
        said = stop(previous.point, place.point)
        if said:
            ended = said
            break
    points = np.array([place.point for place in places])
    tangents = np.array([place.tangent / curve.weights(place.point) for place in places])
    return Trace(points, tangents, ended)


def refine(
    curve: ContinuedCurve, before: FloatArray, after: FloatArray, unknown: int
) -> FloatArray | None:
    """Return the fold between two points: where the tangent has no share of an unknown.

    The point is sought along the chord by the rule of false position (Illinois).

    Points are in the units of the unknowns.
    """
    weights = curve.weights(before)
    chord = (after - before) * weights
    length = float(np.linalg.norm(chord))

    def at(share: float) -> tuple[FloatArray, float] | None:
        guess = before + share * (after - before)
        corrected = correct(curve, guess, chord / length, weights, 1e-10)
        return None if corrected is None else (corrected[0], float(corrected[1][unknown]))

    low, high, point = 0.0, 1.0, None
    ends = at(low), at(high)
    if ends[0] is None or ends[1] is None or ends[0][1] * ends[1][1] > 0.0:
        return None
    below, above = ends[0][1], ends[1][1]
    for _ in range(30):
        share = (low * above - high * below) / (above - below)
        corrected = at(share)
        if corrected is None:
            return None
        point, slope = corrected
        if abs(slope) < 1e-9 or abs(high - low) < 1e-12:
            break
        if slope * above < 0.0:
            low, below = high, above
        else:
            below *= 0.5
        high, above = share, slope
    return point


def correct(
    curve: ContinuedCurve,
    guess: FloatArray,
    tangent: FloatArray,
    weights: FloatArray,
    tolerance: float,
) -> tuple[FloatArray, FloatArray] | None:
    """Return the solution at right angles to a tangent from a guess, and the tangent there.

    Parameters
    ----------
    curve : ContinuedCurve
        The equations.
    guess : (n + 1,) array
        Where to begin [units of the unknowns].
    tangent : (n + 1,) array
        Direction in the local scale, of length 1 [-].
    weights : (n + 1,) array
        The local scale [one over these units].
    tolerance : float
        Size of the last correction [-].

    Returns
    -------
    two (n + 1,) arrays or None
        Point, and tangent in the local scale; None where there is no solution nearby.
    """
    point = guess
    size = guess.size
    right = np.zeros((size, 2))
    right[-1, 1] = 1.0
    bordered = np.empty((size, size))
    bordered[-1] = tangent
    last = np.nan
    for _ in range(10):
        residual, derivative = curve.evaluate(point)
        np.divide(derivative, weights, out=bordered[:-1])
        right[:-1, 0] = -residual
        right[-1, 0] = -tangent @ ((point - guess) * weights)
        try:
            both = np.linalg.solve(bordered, right)
        except np.linalg.LinAlgError:
            return None
        correction = float(np.sqrt(both[:, 0] @ both[:, 0]))
        if not correction < 1.0 or correction > 4.0 * last:
            return None
        point = point + both[:, 0] / weights
        if correction < tolerance or correction * (correction / last) < 0.01 * tolerance:
            return point, both[:, 1] / np.sqrt(both[:, 1] @ both[:, 1])
        last = correction
    return None


def _set_out(curve: ContinuedCurve, start: FloatArray, towards: FloatArray) -> CurvePlace:
    weights = curve.weights(start)
    _, derivative = curve.evaluate(start)
    _, _, right = np.linalg.svd(derivative / weights)
    tangent = right[-1] * np.sign(right[-1] @ (towards * weights) or 1.0)
    return CurvePlace(start, tangent, np.zeros_like(tangent), 0.0)


def _advance(
    curve: ContinuedCurve, place: CurvePlace, length: float, steps: StepSizes
) -> CurvePlace | None:
    """Return the next place, with the miss of its prediction in the room of its bend."""
    weights = curve.weights(place.point)
    ahead = length * place.tangent + 0.5 * length**2 * place.bend
    guess = place.point + ahead / weights
    corrected = correct(curve, guess, place.tangent, weights, steps.tolerance)
    if corrected is None:
        return None
    point, tangent = corrected
    missed = (point - guess) * weights
    limit = steps.turn if length > steps.kink else 0.5 * np.pi
    if tangent @ place.tangent < np.cos(limit):
        return None
    if float(np.linalg.norm(missed)) > 5.0 * steps.miss:
        return None
    return CurvePlace(point, tangent, missed, length)


def _with_bend(
    curve: ContinuedCurve, previous: CurvePlace, following: CurvePlace
) -> CurvePlace:
    """Return a place with its tangent in its own scale and the change of the tangent."""
    scale = curve.weights(following.point) / curve.weights(previous.point)
    tangent = following.tangent * scale
    before = previous.tangent * scale
    bend = (tangent - before) / (following.step * float(np.linalg.norm(tangent)) ** 2)
    tangent = tangent / np.linalg.norm(tangent)
    bend -= tangent * (tangent @ bend)
    return replace(following, tangent=tangent, bend=bend)
