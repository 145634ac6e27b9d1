"""A force without a name: the missing force of a joint over displacement and velocity.

The force of effect `table` is linear in its numbers, and what a model that is held to the
measured motion leaves is nearly linear in that force: least squares find the whole surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import Joint, joints_of, scales_of
from shakerproc.diagnosis.nudged.ladder import pieces
from shakerproc.diagnosis.nudged.smoothing import Smoothed, smoothed
from shakerproc.errors import DiagnosisError, ModelError
from shakerproc.models import Element
from shakerproc.models.effects.table import Table
from shakerproc.models.tabulated import TableAxis, axis

_FINE: Final = (0.0, 0.003, 0.02, 0.08, 0.2, 0.35, 0.5, 0.65, 0.8, 0.92, 0.98, 0.997, 1.0)
"""Shares of the samples below the numbers of a table along one axis alone [-]."""

_COARSE: Final = (0.0, 0.01, 0.07, 0.25, 0.5, 0.75, 0.93, 0.99, 1.0)
"""The same along each axis of a table along both [-]."""

_ALONE: Final = (0.5,)

_SHAPES: Final = ((_FINE, _ALONE), (_ALONE, _FINE), (_COARSE, _COARSE))
"""Tables that are tried: of displacement, of velocity, and of both."""

_ROUNDS: Final = 5
"""Times that the force is solved for, each from the motion with what was found before [-]."""

_NEAREST: Final = 0.02
"""Least distance of the numbers along an axis, as a share of its length [-]."""

_SHARE: Final = 0.3
"""Share of the tests that it is fitted to: a table has three times the numbers of a law [-]."""

_UNIT: Final = 0.01
"""Force by which slopes are taken, over the largest that the joint carries [-]."""

_WITHIN: Final = 1.96
"""Standard deviations to either side that hold 95 % of a normal distribution [-]."""

_Axes = tuple[TableAxis, TableAxis]


@final
@dataclass(frozen=True, slots=True, eq=False)
class FreeLaw:
    """Missing force of a joint, as a table.

    Attributes
    ----------
    between : (str, str)
        The joint.
    hypothesis : Hypothesis
        The model with it.
    x : (n_x,) array
        The model's own numbers beside it [-].
    effect : Table
        The missing force with its band, 0 at rest.
    left : float
        Sum of squares that it leaves of blocks that took no part, over what the model alone
        leaves [-].
    """

    between: Joint
    hypothesis: Hypothesis
    x: FloatArray
    effect: Table
    left: float


def free_laws(data: DataSet) -> list[FreeLaw]:
    """Return the missing force of each joint as if it alone lacked one, the best first.

    Without those that push away at their ends, so that no body would stay there. `data` are the
    tests.
    """
    none = hypothesis_of(data.model)
    windows = pieces(data, 2.0 * np.pi * data.frequency, _SHARE, held_out=False)
    on = fit(data, none, np.zeros(none.size), windows, rounds=0)
    if on is None:
        return []
    held = _Held(on)
    found = [
        held.table(joint, axes)
        for joint in joints_of(data.model)
        for axes in _axes(data, joint)
    ]
    best: dict[Joint, FreeLaw] = {}
    for law in sorted((law for law in found if law is not None), key=lambda law: law.left):
        best.setdefault(law.between, law)
    return list(best.values())


@final
class _Held:
    """A model held to the measured motion, and how its residual follows its numbers."""

    def __init__(self, on: Fit) -> None:
        self._on = on
        own = Linearisation(on.data, on.hypothesis, on.windows)
        at = own.point(on.x, on.channels)
        state = own.residual(at)
        if state is None:
            raise DiagnosisError(
                f"{on.data.model.title}: its motion runs away where it is held."
            )
        slopes = own.linearise(at, state).slopes
        self._size = min(rows.shape[1] for rows in state[0])
        self._alone = self._blocks(state[0])
        self._common = np.array([
            -self._blocks([rows[..., k] for rows in slopes]) for k in range(own.spread.size)
        ])
        self._prior = own.spread**-2.0

    def _blocks(self, stacks: Sequence[FloatArray]) -> FloatArray:
        """Return (n_blocks, n_rows) rows of equal blocks."""
        parts = [
            rows[:, : rows.shape[1] // self._size * self._size].reshape(-1, self._size)
            for rows in stacks
        ]
        return np.concatenate(parts)

    def table(self, joint: Joint, axes: _Axes) -> FreeLaw | None:
        """Return the table of these axes; None where no body would stay."""
        data, sizes = self._on.data, [one.knots.size for one in axes]
        unit = _UNIT * scales_of(data.model, data.tests, joint, data.across(joint)).force
        units = unit * np.eye(sizes[0] * sizes[1])
        found = [self._residual(_with(self._on, joint, axes, one), self._on.x) for one in units]
        columns = np.array([(self._alone - one) / unit for one in found if one is not None])
        if len(columns) < len(units):
            return None
        kept = self._beside(joint, axes)
        rows, best, left = self._alone, None, float(np.mean(self._alone**2))
        for _ in range(_ROUNDS):
            prior = max(1.0, left) * self._prior[kept]
            one = smoothed(
                rows, columns, self._common[kept], prior=prior, penalty=_roughness(axes)
            )
            left = one.left / rows.size
            law = self._law(joint, axes, one, kept)
            there = None if law is None else self._residual(law.hypothesis, law.x)
            if law is None or there is None or (best is not None and law.left >= best.left):
                break
            best = law
            told = np.tensordot(one.amplitudes, columns, 1)
            rows = there + told + np.tensordot(one.common, self._common[kept], 1)
        return best

    def _residual(self, hypothesis: Hypothesis | None, x: FloatArray) -> FloatArray | None:
        """Return the residual of a hypothesis; None where it runs away."""
        if hypothesis is None:
            return None
        own = Linearisation(self._on.data, hypothesis, self._on.windows)
        try:
            state = own.residual(own.point(x, self._on.channels))
        except ModelError:
            return None
        return None if state is None or state[1].failed.any() else self._blocks(state[0])

    def _beside(self, joint: Joint, axes: _Axes) -> list[int]:
        """Return the numbers that a table leaves free: not those that it holds itself."""
        names = ("stiffness", "damping")
        holds = {name for name, one in zip(names, axes, strict=True) if one.knots.size > 1}
        model, own = self._on.data.model, self._on.hypothesis.own
        held = {
            i for i, n in enumerate(own)
            if n.element is not None and n.name in holds
            and set(model.elements[n.element].between) == set(joint)
        }  # fmt: skip
        return [i for i in range(self._prior.size) if i not in held]

    def _law(
        self, joint: Joint, axes: _Axes, found: Smoothed, kept: Sequence[int]
    ) -> FreeLaw | None:
        effect, x = _table(axes, found), self._on.x.copy()
        for i, change in zip(kept, found.common, strict=True):
            if i < x.size:
                x[i] += change
        hypothesis = _with(self._on, joint, axes, np.ravel(effect.force), effect)
        if hypothesis is None:
            return None
        alone = float(np.sum(self._alone**2))
        return FreeLaw(
            joint, hypothesis, x, effect, float(found.left_out.sum()) / max(alone, 1e-300)
        )


def _with(
    on: Fit, joint: Joint, axes: _Axes, force: FloatArray, effect: Table | None = None
) -> Hypothesis | None:
    """Return the hypothesis with a table of these forces [N]; None where no model has it."""
    table = effect or Table(
        displacement=_numbers(axes[0].knots),
        velocity=_numbers(axes[1].knots),
        force=tuple(map(_numbers, force.reshape(axes[0].knots.size, -1))),
    )
    model = on.hypothesis.model
    try:
        more = replace(model, elements=(*model.elements, Element(table, joint)))
    except ModelError:
        return None
    return replace(on.hypothesis, model=more)


def _axes(data: DataSet, joint: Joint) -> list[_Axes]:
    """Return the axes of every table that is tried."""
    motions = data.across(joint)
    displacement, velocity = (
        np.concatenate([
            getattr(motion, name)[a:b]
            for motion, runs in zip(motions, data.stretches(held_out=False), strict=True)
            for a, b in runs
        ])
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
