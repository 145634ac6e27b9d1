"""One effect looked at more closely: its coordinates, and the motion that it completes."""

from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import JointMotion
from shakerproc.diagnosis.screening.completing import Lacking, completed
from shakerproc.diagnosis.screening.laws import Law, with_values
from shakerproc.diagnosis.screening.motion import Motions
from shakerproc.diagnosis.screening.regression import Gains
from shakerproc.diagnosis.screening.shared import Screening
from shakerproc.diagnosis.screening.stretches import Stretch

_ROUNDS: Final = 6
"""Most rounds of completing the motion and moving the coordinates [-]."""

_TRIED: Final = 2
"""Rounds after which an effect is given up that leaves far more than another [-]."""

_WORTH: Final = 0.2
"""Share of what is left that a round must explain for another one to follow [-]."""

_STEP: Final = 0.03
"""Change of a coordinate for its derivative, in the transform it is estimated in [-]."""

_SMALLEST: Final = 0.1
"""Share of a completion below which it is not tried again [-]."""

_SHIFT: Final = 0.01
"""Displacement for the slope of a force, as a share of the largest [-]."""

_LONGEST: Final = 0.5
"""Largest change of a coordinate in a round [-]."""


def refined(screening: Screening, law: Law, hopeless: float = np.inf) -> tuple[Screening, Law]:
    """Return an effect with better coordinates, and the screening around its motion.

    Parameters
    ----------
    screening : Screening
        The screening around the motion that nothing completes.
    law : Law
        The effect.
    hopeless : float
        Sum of squares above which it is given up after two rounds [-].
    """
    first, share = screening.motions, 1.0
    left = float(screening.regression.cost)
    for turn in range(_ROUNDS):
        if turn >= _TRIED and left > hopeless:
            break
        tried = completed_by(screening, law, first, share)
        moved, now = _moved(tried, law)
        if now < left:
            enough = now > (1.0 - _WORTH) * left
            screening, law, left = tried, moved, now
            if enough:
                break
        elif share > _SMALLEST:
            share *= 0.4
        else:
            break
    return screening, law


def completed_by(screening: Screening, law: Law, first: Motions, share: float) -> Screening:
    """Return the screening around the motion that a share [-] of an effect completes."""
    equations = screening.equations
    gains = screening.gains([law])
    rate = equations.tests[0].sample_rate
    lacking = [
        _lacking(screening, law, gains, _longer(stretch)) for stretch in equations.stretches
    ]
    motions = completed(equations.linear, screening.motions, first, lacking, rate, share=share)
    return screening.with_motions(motions)


def _longer(stretch: Stretch) -> Stretch:
    """Return a stretch with a block before it, where there is one."""
    if stretch.start < stretch.block:
        return stretch
    return replace(stretch, start=stretch.start - stretch.block, n_blocks=stretch.n_blocks + 1)


def _lacking(screening: Screening, law: Law, gains: Gains, stretch: Stretch) -> Lacking:
    """Return the force on the masses along a stretch that is not in the model."""
    linear, part = screening.equations.linear, slice(stretch.start, stretch.stop)
    absolute = law.effect.absolute
    direction = linear.direction(law.between, second_only=absolute)
    motion = screening.motions.across(law.between, absolute=absolute)[stretch.test]
    amplitude = float(gains.amplitude[0])
    test = screening.equations.tests[stretch.test]
    own = law.force(motion, stretch, test)
    total = -amplitude * np.outer(direction, own)
    for joint, k, c in zip(screening.joints, *screening.changes(gains.common[0]), strict=True):
        across = screening.motions.across(joint)[stretch.test]
        force = k * across.displacement[part] + c * across.velocity[part]
        total -= np.outer(linear.direction(joint), force)
    shift = _SHIFT * float(np.max(np.abs(motion.displacement[part])))
    if absolute or shift == 0.0:
        return Lacking(stretch, total, direction, 0.0)
    shifted = JointMotion(motion.displacement + shift, motion.velocity)
    rise = stretch.folded(law.force(shifted, stretch, test) - own).mean(axis=-1) / shift
    return Lacking(stretch, total, direction, max(0.0, amplitude * float(np.max(rise))))


def completed_with(screening: Screening, law: Law) -> Screening:
    """Return the screening around the motion that an effect completes, its numbers fixed."""
    first, most = screening.motions, float(screening.gains([law]).explained[0])
    for _ in range(_ROUNDS):
        tried = completed_by(screening, law, first, 1.0)
        explained = float(tried.gains([law]).explained[0])
        if explained <= most:
            break
        screening, most = tried, explained
    return screening


def slopes_of(screening: Screening, law: Law) -> tuple[FloatArray, FloatArray]:
    """Return the column of a law, and its derivatives by the coordinates that shape it.

    They are (1, n_blocks, n_rows) and (n_coordinates, n_blocks, n_rows) arrays, zeros where
    the model cannot have the law with a coordinate changed.
    """
    at = _shaping(law)
    nearby = [_at(screening, law, at + _STEP * row) for row in np.eye(at.size)]
    kept = [i for i, one in enumerate(nearby) if one is not None]
    columns = screening.columns([law, *(one for one in nearby if one is not None)])
    slopes = np.zeros((at.size, *columns.shape[1:]))
    slopes[kept] = (columns[1:] - columns[0]) / _STEP
    return columns[:1], slopes


def _moved(screening: Screening, law: Law) -> tuple[Law, float]:
    """Return the law moved by one Gauss-Newton step if that explains more, and what is left."""
    at = _shaping(law)
    column, slopes = slopes_of(screening, law)
    told = np.any(slopes != 0.0, axis=(1, 2))
    found = screening.regression.together(np.concatenate([column, slopes[told]]))
    step = np.zeros(at.size)
    if found[0] != 0.0:
        step[told] = np.clip(found[1:] / found[0], -_LONGEST, _LONGEST)
    tried = [_at(screening, law, at + share * step) for share in (1.0, 0.4)]
    laws = [law, *(one for one in tried if one is not None)]
    left = 1.0 - screening.gains(laws).explained
    best = int(np.argmin(left))
    return laws[best], float(left[best]) * screening.regression.cost


def _names(law: Law) -> list[str]:
    """Return the coordinates that shape a law: all but one that only scales its force."""
    return [n for n in law.identification.free if n not in law.identification.scaled[:1]]


def _shaping(law: Law) -> FloatArray:
    """Return the columns in the transform they are estimated in."""
    free = law.identification.free
    return np.array([free[name].to_fitted(float(law.values[name])) for name in _names(law)])


def _at(screening: Screening, law: Law, at: FloatArray) -> Law | None:
    """Return the law with other coordinates, or None where it cannot have them."""
    free = law.identification.free
    changed = {
        name: free[name].from_fitted(float(x)) for name, x in zip(_names(law), at, strict=True)
    }
    return with_values(screening.model, law, {**law.values, **changed})
