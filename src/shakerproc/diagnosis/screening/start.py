"""Where a fit of one effect in one joint may start."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.diagnosis.hypotheses.joints import Known, has_limit
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models.identification import Values


@final
@dataclass(frozen=True, slots=True)
class Start:
    """Where a fit of one effect in one joint may start.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str)
        The joint.
    values : mapping
        Coordinates, fixed words and numbers.
    stiffness, damping : tuple of float
        Relative changes of stiffness and damping of every joint that go with it; 0 where the
        joint has none [-].
    explained : float
        Share of what the linear model leaves that it explains, in units of the noise [-].
    predicted : float
        The same for blocks of samples that took no part in the regression [-].
    t : float
        Mean over standard error of its gains in such blocks [-].
    left : float
        Mean square of what is left, in units of the noise: 1 where all is explained [-].
    kept : bool
        Whether it is worth a fit.
    told : bool
        Whether a regression on the measured motion, which has no mean, sees it at all.
    """

    kind: str
    between: Joint
    values: Values
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    explained: float
    predicted: float
    t: float
    left: float
    kept: bool = True
    told: bool = True

    @property
    def words(self) -> tuple[str, ...]:
        """Words for a variant of the effect, such as its side."""
        return tuple(value for value in self.values.values() if isinstance(value, str))


def widening(starts: Sequence[Start], known: Known) -> Iterator[tuple[Start, ...]]:
    """Yield the starts that are fitted before all others, fewer first.

    Those of likely effects; with these, those of all effects that contain no simpler one.
    Where such a one explains the tests, those that contain it, most of them slow as they have
    a memory, need not be tried.

    Parameters
    ----------
    starts, known
        As for `likely`.
    """
    near = likely(starts, known)
    chosen = {(start.kind, start.between) for start in near}
    simple = tuple(
        start
        for start in starts
        if (start.kind, start.between) in chosen
        or not known[start.between][start.kind].contains
    )
    if len(near) < len(simple):
        yield near
    if len(simple) < len(starts):
        yield simple


def likely(starts: Sequence[Start], known: Known) -> tuple[Start, ...]:
    """Return the starts of effects that explain at least half as much as the best.

    In logarithms of what is left: less than the geometric mean of what the best leaves and what
    is left without any. Besides, those that contain one another with them, and those of which
    a regression tells nothing, such as a constant force. The true effect of all 22 single
    effects of tuning seed 40 was among them, not always that of a joint that sticks.

    Parameters
    ----------
    starts : sequence of Start
        Of every effect in every joint.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    """
    left = _least_left(starts)
    if not left:
        return ()
    least, first = min(left.values()), starts[0]
    nothing = first.left / max(1.0 - first.explained, 1e-12)
    bound = np.sqrt(least * nothing)
    near = {name for name, own in left.items() if own <= bound}
    near |= {(start.kind, start.between) for start in starts if not start.told}
    return with_limits(starts, near, known)


def in_likely_joints(starts: Sequence[Start], known: Known) -> tuple[Start, ...]:
    """Return the starts of as many effects as one joint may have, those that leave least.

    In a structure of many joints most laws in most joints explain nothing of what is missing.
    Besides, those that contain one another with them, and in the likeliest joint those of which
    a regression tells nothing.

    Parameters
    ----------
    starts, known
        As for `likely`.
    """
    left = _least_left(starts)
    order = sorted(left, key=lambda name: left[name])
    most = max((len(own) for own in known.values()), default=0)
    near = set(order[:most])
    untold = {(start.kind, start.between) for start in starts if not start.told}
    near |= {name for name in untold if name[1] in {between for _, between in order[:1]}}
    return with_limits(starts, near, known)


def known_of(starts: Sequence[Start], known: Known) -> Known:
    """Return the laws of each joint that have a start."""
    names = {(start.kind, start.between) for start in starts}
    return {
        joint: {kind: one for kind, one in laws.items() if (kind, joint) in names}
        for joint, laws in known.items()
    }


def _least_left(starts: Sequence[Start]) -> dict[tuple[str, Joint], float]:
    """Return the mean square that is left by the best start of each effect and joint [-]."""
    left: dict[tuple[str, Joint], float] = {}
    for start in starts:
        name = start.kind, start.between
        left[name] = min(start.left, left.get(name, np.inf))
    return left


def with_limits(
    starts: Sequence[Start], chosen: Iterable[tuple[str, Joint]], known: Known
) -> tuple[Start, ...]:
    """Return the starts of chosen effects in joints, and of those that they contain there."""
    names = {(start.kind, start.between) for start in starts}
    near = set(chosen)
    near |= {name for name in names if any(has_limit(known, one, name) for one in near)}
    return tuple(start for start in starts if (start.kind, start.between) in near)
