"""Data that all regressions around one linear model share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.hypotheses.joints import linear_parts
from shakerproc.diagnosis.screening.equations import (
    Equations,
    columns_of,
    equations_of,
    own_columns,
)
from shakerproc.diagnosis.screening.laws import StartedLaw
from shakerproc.diagnosis.screening.motion import Motions, motions_of
from shakerproc.diagnosis.screening.regression import Gains, Regression
from shakerproc.diagnosis.screening.stretches import stretches_of
from shakerproc.diagnosis.screening.transfer import Joint, linear_model
from shakerproc.models import Model


@final
@dataclass(frozen=True, slots=True, eq=False)
class Screening:
    """A linear model, how its joints move, and what it leaves unexplained.

    Attributes
    ----------
    model : Model
        The model.
    joints : tuple of (str, str)
        Joints whose stiffness and damping are free in every regression.
    motions : Motions
        How the places move.
    equations : Equations
        What turns forces into columns.
    regression : Regression
        The residual beside what is common to all candidates: a spring and a damper in every
        joint, `beside`, and errors of the sensors.
    beside : (n_beside, n_blocks, n_rows) array
        More common columns.
    """

    model: Model
    joints: tuple[Joint, ...]
    motions: Motions
    equations: Equations
    regression: Regression
    beside: FloatArray

    def columns(self, laws: Sequence[StartedLaw]) -> FloatArray:
        """Return the whitened columns of laws of one joint; zeros where a force fails.

        One condition scales all of them, or none does.
        """
        first, effects = laws[0], [law.effect for law in laws]
        shares = self.equations.shares(first.identification.scaled_by)
        return columns_of(self.equations, self.motions, first.between, effects, shares)

    def gains(self, laws: Sequence[StartedLaw]) -> Gains:
        """Return the explained part of the forces of laws of one joint."""
        signs = np.array([1.0 if law.one_sign else 0.0 for law in laws])
        return self.regression.gains(self.columns(laws), signs)

    def with_motions(self, motions: Motions) -> "Screening":
        """Return the screening around another motion."""
        regression = _regression(self.equations, motions, self.joints, self.beside)
        return replace(self, motions=motions, regression=regression)

    def changes(self, common: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return changes of stiffness [N/m] and damping [N s/m] of every joint.

        Parameters
        ----------
        common : (n_common,) array
            Amplitudes of the common columns.
        """
        n = len(self.joints)
        return common[:n], common[n : 2 * n]

    def relative_changes(
        self, common: FloatArray
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return changes as shares of the model's numbers; 0 where a joint has none [-]."""
        own = np.array([linear_parts(self.model, joint) for joint in self.joints]).T
        changes = np.array(self.changes(common))
        relative = np.divide(changes, own, out=np.zeros_like(own), where=own > 0.0)
        return tuple(map(float, relative[0])), tuple(map(float, relative[1]))


def screening_of(
    model: Model, tests: Sequence[PreparedTest], joints: Sequence[Joint]
) -> Screening:
    """Return the shared data of all regressions around a linear model."""
    motions = motions_of(model, tests)
    linear = linear_model(model)
    stretches = stretches_of(tests, _sizes(motions, joints), len(linear.sensors))
    equations = equations_of(linear, tests, stretches)
    beside = own_columns(model, equations, motions)
    regression = _regression(equations, motions, joints, beside)
    return Screening(model, tuple(joints), motions, equations, regression, beside)


def _regression(
    equations: Equations, motions: Motions, joints: Sequence[Joint], beside: FloatArray
) -> Regression:
    """Return the regression on what is common to all candidates.

    Errors of the sensors have their usual size as a prior, in units of what the linear model
    leaves.
    """
    linear = np.concatenate([*_linear_columns(equations, motions, joints), beside])
    first = Regression(equations.residual, linear, np.zeros(len(linear)))
    common = np.concatenate([linear, equations.nuisances])
    prior = np.zeros(len(common))
    prior[len(linear) :] = max(1.0, first.cost / equations.n_numbers)
    return Regression(equations.residual, common, prior)


def _sizes(motions: Motions, joints: Sequence[Joint]) -> list[FloatArray]:
    """Return how much the joints move in each test, in units of the largest motion of each."""
    total: list[FloatArray] = []
    for joint in joints:
        squares = [motion.displacement**2 for motion in motions.across(joint)]
        unit = max(float(np.max(square)) for square in squares) or 1.0
        shares = [square / unit for square in squares]
        total = [a + b for a, b in zip(total, shares, strict=True)] if total else shares
    return [np.sqrt(own) for own in total]


def _linear_columns(
    equations: Equations, motions: Motions, joints: Sequence[Joint]
) -> tuple[FloatArray, FloatArray]:
    """Return the columns of a spring and of a damper in every joint."""
    springs, dampers = [], []
    for joint in joints:
        motion = motions.across(joint)
        forces = [
            np.array([
                motion[s.test].displacement[s.start : s.stop],
                motion[s.test].velocity[s.start : s.stop],
            ])
            for s in equations.stretches
        ]
        spring, damper = equations.columns(forces, equations.linear.direction(joint))
        springs.append(spring)
        dampers.append(damper)
    return np.array(springs), np.array(dampers)
