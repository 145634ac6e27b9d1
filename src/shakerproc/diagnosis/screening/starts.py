"""The screening: every effect's force along the measured motion, tried as the missing one."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import JointMotion, Test
from shakerproc.diagnosis.screening.equations import Equations, equations_of
from shakerproc.diagnosis.screening.laws import Law, laws_of, one_of_each_shape
from shakerproc.diagnosis.screening.motion import Motions, motions_of
from shakerproc.diagnosis.screening.regression import Gains, Regression
from shakerproc.diagnosis.screening.stretches import stretches_of
from shakerproc.diagnosis.screening.transfer import Joint, linear_model
from shakerproc.models import Model
from shakerproc.models.identification import Identification, Values
from shakerproc.models.laws import Law as Formula

_BATCH: Final = 16
"""Laws whose columns are held in memory at once: 50 MB for a chain of three masses [-]."""


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
    """

    kind: str
    between: Joint
    values: Values
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    explained: float
    predicted: float
    t: float

    @property
    def words(self) -> tuple[str, ...]:
        """What tells a variant of the effect, such as its side."""
        return tuple(value for value in self.values.values() if isinstance(value, str))


@final
@dataclass(frozen=True, slots=True, eq=False)
class Screening:
    """What all regressions of a campaign share."""

    model: Model
    joints: tuple[Joint, ...]
    motions: Motions
    equations: Equations
    regression: Regression

    def starts(self, laws: Sequence[Law]) -> list[Start]:
        """Return a start for each law that may be physical, its force scaled."""
        found = []
        for own in _alike(laws):
            motion = self.motions.across(own[0].between, absolute=own[0].effect.absolute)
            for i in range(0, len(own), _BATCH):
                found += self._batch(own[i : i + _BATCH], motion)
        return found

    def _batch(self, laws: Sequence[Law], motion: Sequence[JointMotion]) -> list[Start]:
        """Return the starts of laws that see the same motion."""
        forces = along(laws, motion, self.equations)
        kept = [i for i in range(len(laws)) if all(np.all(np.isfinite(f[i])) for f in forces)]
        if not kept:
            return []
        between, only = laws[0].between, laws[0].effect.absolute
        direction = self.equations.linear.direction(between, second_only=only)
        columns = self.equations.columns([force[kept] for force in forces], direction)
        signs = np.array([1.0 if laws[i].one_sign else 0.0 for i in kept])
        gains = self.regression.gains(columns, signs)
        return [self._start(laws[i], gains, place) for place, i in enumerate(kept)]

    def _start(self, law: Law, gains: Gains, i: int) -> Start:
        amplitude = float(gains.amplitude[i])
        stiffness, damping = self.changes(gains.common[i])
        return Start(
            kind=law.kind,
            between=law.between,
            values=law.scaled(amplitude) if amplitude != 0.0 else law.values,
            stiffness=stiffness,
            damping=damping,
            explained=float(gains.explained[i]),
            predicted=float(gains.predicted[i]),
            t=float(gains.t[i]),
        )

    def changes(self, common: FloatArray) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the relative changes of the joints that amplitudes of common columns mean."""
        n = len(self.joints)
        own = np.array([linear_parts(self.model, joint) for joint in self.joints]).T
        changed = np.array([common[:n], common[n : 2 * n]])
        relative = np.divide(changed, own, out=np.zeros_like(own), where=own > 0.0)
        return tuple(map(float, relative[0])), tuple(map(float, relative[1]))


def _alike(laws: Sequence[Law]) -> list[list[Law]]:
    """Return laws by the motion that they see."""
    found: dict[tuple[Joint, bool], list[Law]] = {}
    for law in laws:
        found.setdefault((law.between, law.effect.absolute), []).append(law)
    return list(found.values())


def along(
    laws: Sequence[Law], motion: Sequence[JointMotion], equations: Equations
) -> list[FloatArray]:
    """Return the forces of laws along every stretch, (n_laws, n) arrays [N]."""
    return [
        np.array([
            law.force(motion[s.test], s, equations.tests[s.test].sample_rate) for law in laws
        ])
        for s in equations.stretches
    ]


def linear_parts(model: Model, joint: Joint) -> tuple[float, float]:
    """Return the stiffness [N/m] and damping [N s/m] of what is linear in a joint."""
    rows = [e.effect.rows() for e in model.elements if set(e.between) == set(joint)]
    linear = [row.values for own in rows for row in own if row.law is Formula.LINEAR]
    return sum(v[0] for v in linear), sum(v[1] for v in linear)


def screening_of(model: Model, tests: Sequence[Test], joints: Sequence[Joint]) -> Screening:
    """Return what all regressions around a linear model share."""
    motions = motions_of(model, tests)
    stretches = stretches_of(tests, _sizes(motions, joints))
    equations = equations_of(linear_model(model), tests, stretches)
    common = np.concatenate([*_linear_columns(equations, motions, joints), equations.nuisances])
    first = Regression(equations.residual, common[: 2 * len(joints)], np.zeros(2 * len(joints)))
    prior = np.zeros(len(common))
    prior[2 * len(joints) :] = max(1.0, first.cost / equations.n_numbers)
    regression = Regression(equations.residual, common, prior)
    return Screening(model, tuple(joints), motions, equations, regression)


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


def screen(
    model: Model,
    tests: Sequence[Test],
    joints: Sequence[Joint],
    identifications: Mapping[Joint, Mapping[str, Identification]],
) -> tuple[Start, ...]:
    """Return starts of every effect in every joint, best first."""
    screening = screening_of(model, tests, joints)
    laws = [
        law
        for joint in joints
        for law in one_of_each_shape(laws_of(model, joint, identifications[joint]))
    ]
    starts = screening.starts(laws)
    return tuple(sorted(starts, key=lambda start: -start.predicted))
