"""A law that no effect of the library need know: missing force over displacement and velocity.

The force of effect `table` is linear in its numbers, so that the same regression which tries
one effect after the other finds a whole surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.screening.laws import StartedLaw
from shakerproc.diagnosis.screening.refining import completed_by
from shakerproc.diagnosis.screening.regression import surely
from shakerproc.diagnosis.screening.shared import Screening, screening_of
from shakerproc.diagnosis.screening.smoothing import Smoothed, smoothed
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models import Model
from shakerproc.models.effects.table import Table
from shakerproc.models.identification import Identification
from shakerproc.models.tabulated import TableAxis, axis

_FINE: Final = (0.0, 0.003, 0.02, 0.08, 0.2, 0.35, 0.5, 0.65, 0.8, 0.92, 0.98, 0.997, 1.0)
"""Shares of the samples below the numbers of a table along one axis alone [-]."""

_COARSE: Final = (0.0, 0.01, 0.07, 0.25, 0.5, 0.75, 0.93, 0.99, 1.0)
"""The same along each axis of a table along both [-]."""

_ALONE: Final = (0.5,)

_SHAPES: Final = ((_FINE, _ALONE), (_ALONE, _FINE), (_COARSE, _COARSE))
"""Tables that are tried: of displacement, of velocity, and of both."""

_ROUNDS: Final = 3
"""Rounds of completing the motion by the force that was found [-]."""

_NEAREST: Final = 0.02
"""Least distance of the numbers along an axis, as a share of its length [-]."""

_WITHIN: Final = 1.96
"""Standard deviations to either side that hold 95 % of a normal distribution [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class FreeLaw:
    """Missing force of a joint, as a table.

    Attributes
    ----------
    between : (str, str)
        The joint.
    effect : Table
        The missing force with its band, 0 at rest.
    stiffness, damping : tuple of float
        As of `Start`; a table holds those of its own joint itself along the axes it has.
    explained, predicted, t, left : float
        As of `Start`.
    """

    between: Joint
    effect: Table
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    explained: float
    predicted: float
    t: float
    left: float


def free_laws(
    model: Model, tests: Sequence[PreparedTest], joints: Sequence[Joint]
) -> tuple[FreeLaw, ...]:
    """Return the missing force of each joint as if it alone lacked one, best first.

    Parameters
    ----------
    model : Model
        The linear model.
    tests : sequence of PreparedTest
        What may be fitted to.
    joints : sequence of (str, str)
        Where a force may be missing.
    """
    screening = screening_of(model, tests, joints)
    found = [free_law(screening, joint) for joint in joints]
    return tuple(sorted(found, key=lambda law: -law.predicted))


def free_law(screening: Screening, joint: Joint) -> FreeLaw:
    """Return the missing force of one joint, by the table that predicts best."""
    found = [_fitted(screening, joint, axes) for axes in _axes(screening, joint)]
    best = max(found, key=lambda law: law.predicted)
    there, first = screening, screening.motions
    for _ in range(_ROUNDS):
        there = completed_by(there, _as_law(joint, best.effect), first, 1.0)
        axes = axis(best.effect.displacement), axis(best.effect.velocity)
        again = _fitted(there, joint, axes)
        if again.left >= best.left:
            break
        best = again
    return best


def _as_law(joint: Joint, effect: Table) -> StartedLaw:
    return StartedLaw(effect.kind, joint, Identification(free={}, starts=()), {}, effect)


def _axes(screening: Screening, joint: Joint) -> list[tuple[TableAxis, TableAxis]]:
    """Return the axes of every table that is tried."""
    motion = screening.motions.across(joint)
    stretches = screening.equations.stretches
    displacement, velocity = (
        np.concatenate([getattr(motion[s.test], name)[s.start : s.stop] for s in stretches])
        for name in ("displacement", "velocity")
    )
    return [
        (axis(_places(displacement, along)), axis(_places(velocity, across)))
        for along, across in _SHAPES
    ]


def _places(samples: FloatArray, shares: Sequence[float]) -> tuple[float, ...]:
    """Return quantiles of samples, none much nearer to another than to the whole range."""
    if len(shares) == 1:
        return (0.0,)
    wanted = np.quantile(samples, shares)
    nearest = _NEAREST * (wanted[-1] - wanted[0]) or 1e-12
    kept = [float(wanted[0])]
    for value in wanted[1:-1]:
        if value - kept[-1] >= nearest and wanted[-1] - value >= nearest:
            kept.append(float(value))
    return (*kept, max(float(wanted[-1]), kept[-1] + nearest))


def _fitted(screening: Screening, joint: Joint, axes: tuple[TableAxis, TableAxis]) -> FreeLaw:
    """Return the table of these axes."""
    equations = screening.equations
    motion = screening.motions.across(joint)
    forces = [
        _unit_forces(axes, motion[s.test].displacement[p], motion[s.test].velocity[p])
        for s in equations.stretches
        for p in (slice(s.start, s.stop),)
    ]
    columns = equations.columns(forces, equations.linear.direction(joint))
    kept = _beside(screening, joint, axes)
    regression = screening.regression
    found = smoothed(
        equations.residual,
        columns,
        regression.common[kept],
        prior=regression.prior[kept],
        penalty=_roughness(axes),
    )
    common = np.zeros(len(regression.common))
    common[kept] = found.common
    stiffness, damping = screening.relative_changes(common)
    before = regression.left_out()
    gained = before - found.left_out
    return FreeLaw(
        between=joint,
        effect=_table(axes, found),
        stiffness=stiffness,
        damping=damping,
        explained=1.0 - found.left / max(regression.cost, 1e-300),
        predicted=float(gained.sum() / max(before.sum(), 1e-300)),
        t=float(surely(gained)),
        left=found.left / equations.n_numbers,
    )


def _beside(screening: Screening, joint: Joint, axes: tuple[TableAxis, TableAxis]) -> list[int]:
    """Return which common columns a table leaves: not those that it holds itself."""
    n = len(screening.joints)
    own = screening.joints.index(joint)
    held = {own + n * i for i, one in enumerate(axes) if one.knots.size > 1}
    return [i for i in range(len(screening.regression.common)) if i not in held]


def _unit_forces(
    axes: tuple[TableAxis, TableAxis], displacement: FloatArray, velocity: FloatArray
) -> FloatArray:
    """Return the force of tables with one number of 1 N and all others 0, (n, n_samples)."""
    along, across = (
        _unit_splines(one, samples)
        for one, samples in zip(axes, (displacement, velocity), strict=True)
    )
    both = along[:, None] * across
    return np.asarray(both.reshape(-1, displacement.size))


def _unit_splines(one: TableAxis, samples: FloatArray) -> FloatArray:
    """Return splines that are 1 at one number of an axis and 0 at the others."""
    cells = one.cells(samples)
    powers = (samples - one.origins[cells])[:, None] ** np.arange(4)
    coefficients = one.spline(np.eye(one.knots.size))[cells]
    return np.asarray(np.einsum("spn,sp->ns", coefficients, powers))


def _roughness(axes: tuple[TableAxis, TableAxis]) -> FloatArray:
    """Return the bending energy of a table, as a quadratic form of its numbers.

    Second and mixed derivatives count alike, over axes of unit length.
    """
    sizes = [one.knots.size for one in axes]
    slopes, bends = zip(*(_derivatives(one.knots) for one in axes), strict=True)
    own = [np.eye(size) for size in sizes]
    parts = [
        np.kron(bends[0], own[1]),
        np.kron(own[0], bends[1]),
        np.sqrt(2.0) * np.kron(slopes[0], slopes[1]),
    ]
    return np.asarray(sum(part.T @ part for part in parts))


def _derivatives(knots: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return matrices of first and second derivatives, times the root of their intervals."""
    if knots.size < 2:
        return np.zeros((0, 1)), np.zeros((0, 1))
    step = np.diff(knots) / (knots[-1] - knots[0])
    first = np.diff(np.eye(knots.size), axis=0) / step[:, None]
    middle = 0.5 * (step[1:] + step[:-1])
    second = np.diff(first, axis=0) / np.sqrt(middle)[:, None]
    return first * np.sqrt(step)[:, None], second


def _table(axes: tuple[TableAxis, TableAxis], found: Smoothed) -> Table:
    """Return numbers as an effect whose force is 0 at rest.

    The mean force is not told by a band that does not hold frequency 0.
    """
    shape = tuple(one.knots.size for one in axes)
    rest = _unit_forces(axes, np.zeros(1), np.zeros(1))[:, 0]
    shift = np.eye(rest.size) - rest  # each number less the force at rest
    force = (shift @ found.amplitudes).reshape(shape)
    variance = np.einsum("ij,jk,ik->i", shift, found.covariance, shift)
    band = _WITHIN * np.sqrt(np.maximum(variance, 0.0)).reshape(shape)
    return Table(
        displacement=_numbers(axes[0].knots),
        velocity=_numbers(axes[1].knots),
        force=tuple(_numbers(row) for row in force),
        band=tuple(_numbers(row) for row in band),
    )


def _numbers(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
