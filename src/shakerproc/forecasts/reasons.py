"""Why a forecast departs from linear scaling: what the joints do at either level."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts.motion import JointMotion, Motion
from shakerproc.models import AbstractMemorylessEffect, Element, Model
from shakerproc.models.laws import Law
from shakerproc.models.parallel_elements import resolved
from shakerproc.numerals import numeral

CHANGED: Final = 0.02
"""Change of a joint's stiffness or damping that is told [-]: a resonance moves by half of it,
1 %."""


@final
@dataclass(frozen=True, slots=True)
class JointLaw:
    r"""Linear law nearest to that of a joint over one motion, by least squares.

    .. math:: F \approx k z + c \dot z

    Attributes
    ----------
    stiffness, damping : float
        :math:`k` [N/m] and :math:`c` [N s/m].
    """

    stiffness: float
    damping: float


def law_of(joint: JointMotion) -> JointLaw:
    """Return the linear law nearest to that of a joint over its motion."""
    columns = np.stack([joint.displacement, joint.velocity])
    gram = columns @ columns.T
    scale = np.sqrt(np.maximum(np.diag(gram), np.finfo(float).tiny))
    found = np.linalg.lstsq(gram / np.outer(scale, scale), columns @ joint.force / scale)[0]
    stiffness, damping = found / scale
    return JointLaw(float(stiffness), float(damping))


def reasons(model: Model, before: Motion, after: Motion) -> list[str]:
    """Return what joints do otherwise than at the highest level that was run, a clause each.

    Parameters
    ----------
    model : Model
        The model.
    before, after : Motion
        At the highest level that was run, and at the one that is forecast.
    """
    found = []
    for pair, there in after.joints.items():
        here = before.joints[pair]
        own = [one for one in resolved(model) if set(one.between) == set(pair)]
        told = _of_laws(own, pair, here, there)
        was, now = law_of(here), law_of(there)
        moved = []
        for name, one, other in (
            ("stiffness", was.stiffness, now.stiffness), ("damping", was.damping, now.damping)
        ):  # fmt: skip
            if abs(other - one) > CHANGED * abs(one):
                moved.append(f"{name} {(other - one) / abs(one):+.0%}")
        if told or moved:
            clauses = [*told, *([f"effective {' and '.join(moved)}"] if moved else [])]
            found.append(f"joint {'-'.join(pair)}: {', '.join(clauses)}")
    return found


def _of_laws(
    elements: Sequence[Element], pair: tuple[str, str], here: JointMotion, there: JointMotion
) -> list[str]:
    """Return what the laws of a joint do otherwise, by the kinds of them."""
    found = []
    for element in elements:
        effect, turn = element.effect, 1.0 if element.between == pair else -1.0
        name = effect.kind.replace("_", " ")
        laws = {row.law for row in effect.rows()}
        if isinstance(effect, AbstractMemorylessEffect) and Law.FRICTION not in laws:
            walls = [s.at for s in effect.switches() if s.variable == "displacement" and s.at]
            was, now = (_beyond(walls, turn * one.displacement) for one in (here, there))
            if walls and now > 0.0 and now - was > CHANGED * now:
                closed = "closes" if was == 0.0 else f"is in contact {numeral(100 * was, 2)} % "
                rest = (
                    ""
                    if was == 0.0
                    else f"of the time there and {numeral(100 * now, 2)} % here"
                )
                found.append(f"the {name} {closed}{rest}")
        elif Law.FRICTION in laws or not isinstance(effect, AbstractMemorylessEffect):
            found.append(f"the {name} slips further")
    return found


def _beyond(walls: Sequence[float], displacement: FloatArray) -> float:
    """Return the share of time beyond the nearest walls [-]."""
    above = min([wall for wall in walls if wall > 0.0], default=np.inf)
    below = max([wall for wall in walls if wall < 0.0], default=-np.inf)
    return float(np.mean((displacement > above) | (displacement < below)))
