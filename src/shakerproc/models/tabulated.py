"""Tabulated laws: bicubic splines of a force over displacement and velocity.

Along each axis the spline is a natural one, so that it has two continuous derivatives
everywhere and goes on straight beyond its ends. Where a law jumps or bends, its axis is cut:
each region has a spline of its own, and simulation finds the instants of crossing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.laws import Law, Row

NEAREST: Final = (1e-8, 1e-6)

FARTHEST: Final = (1e-1, 1e2)
"""Displacements [m] and velocities [m/s] between which a law is sampled."""

LINE_RATIO: Final = 1.04
"""From one sample to the next along a line: a cubic spline misses z^1.5 by 1e-8 [-]."""

PLANE_RATIO: Final = 1.25
"""The same over a plane, of 28,000 samples: by 1e-5 [-]."""

_ALIKE: Final = 1e-12
"""Differences of force that count as rounding, as a share of the largest [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class TableAxis:
    """One axis of a table.

    Attributes
    ----------
    parts : tuple of (n,) arrays
        The values at which the law is given, region by region [m] or [m/s].
    surfaces : tuple of float
        Where the regions meet.
    """

    parts: tuple[FloatArray, ...]
    surfaces: tuple[float, ...] = ()

    @property
    def knots(self) -> FloatArray:
        """All values at which the law is given."""
        return np.concatenate(self.parts)

    @property
    def origins(self) -> FloatArray:
        """Where the polynomial of each cell is 0; a region has a cell beyond either end."""
        return np.concatenate([np.concatenate((part[:1], part)) for part in self.parts])

    @property
    def firsts(self) -> tuple[int, ...]:
        """First cell of each region."""
        sizes = [part.size + 1 for part in self.parts[:-1]]
        return tuple(int(first) for first in np.cumsum([0, *sizes]))

    def cells(self, at: FloatArray) -> NDArray[np.intp]:
        """Return the number of the cell that each value lies in.

        `at` is in the unit of the axis.
        """
        return np.searchsorted(self.origins[1:], at, side="right")

    def spline(self, values: FloatArray) -> FloatArray:
        """Return the coefficients of every cell, (n_cells, 4, ...) array, lowest first.

        Parameters
        ----------
        values : (n_knots, ...) array
            What is interpolated [any unit].
        """
        pieces, start = [], 0
        for part in self.parts:
            pieces.append(_natural_spline(part, values[start : start + part.size]))
            start += part.size
        return np.concatenate(pieces)


@final
@dataclass(frozen=True, slots=True, eq=False)
class SplineTable:
    """A force law by a polynomial in each cell.

    Attributes
    ----------
    displacement, velocity : TableAxis
        Its axes, of which one at most has surfaces.
    coefficients : (n_displacement_cells, n_velocity_cells, 4, 4) array
        By powers of displacement and velocity from the origin of the cell.
    """

    displacement: TableAxis
    velocity: TableAxis
    coefficients: FloatArray

    def value(
        self, displacement: FloatArray, velocity: FloatArray, by: tuple[int, int] = (0, 0)
    ) -> FloatArray:
        """Return the force, or a derivative, at these places [N], [N/m] or [N s/m].

        Parameters
        ----------
        by : (int, int)
            How often it is derived by displacement, and by velocity; once at most.
        """
        z, v = np.broadcast_arrays(displacement, velocity)
        i, j = self.displacement.cells(z), self.velocity.cells(v)
        in_cell = self.coefficients[i, j]
        along = _powers(z - self.displacement.origins[i], by[0])
        across = _powers(v - self.velocity.origins[j], by[1])
        total: FloatArray = np.einsum("...pq,...p,...q->...", in_cell, along, across)
        return total

    def row(self) -> Row:
        """Return it as a line of the kernels' table (see `simulation.kernels.polynomials`)."""
        axis = 1 if self.velocity.surfaces else 0
        cut = (self.displacement, self.velocity)[axis]
        n_z, n_v = self.coefficients.shape[:2]
        values = (float(n_z), float(n_v), float(len(cut.surfaces)), float(axis))
        numbers = (
            self.displacement.origins,
            self.velocity.origins,
            np.array(cut.surfaces, float),
            np.array(cut.firsts, float),
            self.coefficients.ravel(),
        )
        return Row(Law.TABLE, values, np.concatenate(numbers))


def spline_table(
    displacement: TableAxis, velocity: TableAxis, force: FloatArray
) -> SplineTable:
    """Return the table through these forces.

    Parameters
    ----------
    displacement, velocity : TableAxis
        Where the law is given.
    force : (n_displacements, n_velocities) array
        The force there [N].

    Raises
    ------
    ValueError
        If both axes have surfaces.
    """
    if displacement.surfaces and velocity.surfaces:
        raise ValueError("a table is cut along displacement or along velocity, not along both")
    along = displacement.spline(force)  # (cells, 4, n_velocities)
    across = velocity.spline(np.moveaxis(along, 2, 0))  # (cells, 4, cells, 4)
    coefficients = np.ascontiguousarray(across.transpose(2, 0, 3, 1))
    return SplineTable(displacement, velocity, coefficients)


def axis(values: Sequence[float]) -> TableAxis:
    """Return an axis without surfaces. `values` are in any unit."""
    return TableAxis((np.array(values, float),))


def _natural_spline(knots: FloatArray, values: FloatArray) -> FloatArray:
    """Return the coefficients of a natural spline, and of the straight lines beyond it."""
    n = knots.size
    pieces = np.zeros((n + 1, 4, *values.shape[1:]))
    pieces[0, 0], pieces[1:, 0] = values[0], values
    if n == 1:
        return pieces
    bend = _second_derivatives(knots, values)
    step = np.diff(knots).reshape(-1, *[1] * (values.ndim - 1))
    slope = np.diff(values, axis=0) / step
    pieces[1:n, 1] = slope - step * (2.0 * bend[:-1] + bend[1:]) / 6.0
    pieces[1:n, 2] = 0.5 * bend[:-1]
    pieces[1:n, 3] = np.diff(bend, axis=0) / (6.0 * step)
    pieces[0, 1] = pieces[1, 1]
    pieces[n, 1] = slope[-1] + step[-1] * (bend[-2] + 2.0 * bend[-1]) / 6.0
    return pieces


def _second_derivatives(knots: FloatArray, values: FloatArray) -> FloatArray:
    """Return the second derivatives of a natural spline at its knots."""
    bend = np.zeros_like(values)
    n = knots.size
    if n < 3:
        return bend
    from scipy.linalg import solve_banded  # a quarter of a second, which few models need

    step = np.diff(knots)
    slope = np.diff(values, axis=0) / step.reshape(-1, *[1] * (values.ndim - 1))
    system = np.zeros((3, n - 2))
    system[0, 1:] = system[2, :-1] = step[1:-1]
    system[1] = 2.0 * (step[:-1] + step[1:])
    right = 6.0 * np.diff(slope, axis=0)
    solved = solve_banded((1, 1), system, right.reshape(n - 2, -1))
    bend[1:-1] = solved.reshape(right.shape)
    return bend


def _powers(x: FloatArray, derived: int) -> FloatArray:
    """Return 1, x, x^2, x^3, or their derivatives, along a last axis."""
    one, none = np.ones_like(x), np.zeros_like(x)
    if derived == 0:
        return np.stack((one, x, x**2, x**3), axis=-1)
    return np.stack((none, one, 2.0 * x, 3.0 * x**2), axis=-1)


class AbstractSampledEffect(AbstractMemorylessEffect):
    """An effect of the user's own, of which only the force need be stated.

    A class that derives from it is a frozen dataclass with `kind`, `parameters`, `formula`,
    `signature` and `force_at`; with `switches` where its force jumps or bends sharply, in
    displacement or in velocity; and with `identification` where it is to be looked for.
    Friction, which holds a joint at rest, cannot be sampled: write it in `rows` of
    `AbstractMemorylessEffect`, with `Law.FRICTION`.
    """

    __slots__ = ()

    sampled: ClassVar[bool] = True

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        tables = tables_of(self)
        by_displacement = sum(t.value(displacement, velocity, (1, 0)) for t in tables)
        by_velocity = sum(t.value(displacement, velocity, (0, 1)) for t in tables)
        return np.asarray(by_displacement), np.asarray(by_velocity)

    def rows(self) -> tuple[Row, ...]:
        return tuple(table.row() for table in tables_of(self))


@lru_cache(maxsize=32)
def tables_of(effect: AbstractMemorylessEffect) -> tuple[SplineTable, ...]:
    """Return the tables that add up to an effect.

    Raises
    ------
    ValueError
        If it jumps at rest of velocity, or a law of both variables has surfaces in both.
    """
    cuts = tuple(
        sorted({s.at for s in effect.switches() if s.variable == variable})
        for variable in ("displacement", "velocity")
    )
    _check_rest(effect, cuts[1])
    with_z, with_v, together = _depends(effect)
    if together:
        z, v = (_axis(i, cuts[i], PLANE_RATIO) for i in range(2))
        return (spline_table(z, v, _force(effect, z, v)),)
    tables = []
    origin, still = TableAxis((np.zeros(1),)), np.zeros((1, 1))
    rest = _force(effect, origin, origin)
    if with_z or not with_v:
        line = _axis(0, cuts[0], LINE_RATIO)
        tables.append(spline_table(line, origin, _force(effect, line, origin)))
    if with_v:
        line = _axis(1, cuts[1], LINE_RATIO)
        less = rest if tables else still
        tables.append(spline_table(origin, line, _force(effect, origin, line) - less))
    return tuple(tables)


def _check_rest(effect: AbstractMemorylessEffect, cuts: Sequence[float]) -> None:
    if 0.0 not in cuts:
        return
    z = np.array([-1e-4, 0.0, 1e-4])
    up, down = (effect.force_at(z, np.full(3, v)) for v in (1e-12, -1e-12))
    if np.any(np.abs(up - down) > 1e-6 * np.max(np.abs(up) + np.abs(down))):
        raise ValueError(
            "the force jumps where velocity changes sign, so that the joint sticks there: give "
            "rows() with Law.FRICTION, as coulomb_friction does"
        )


def _depends(effect: AbstractMemorylessEffect) -> tuple[bool, bool, bool]:
    """Return whether displacement and velocity matter, and whether more than their sum."""
    z = np.concatenate(([0.0], *(sign * np.geomspace(1e-6, 1e-2, 17) for sign in (1.0, -1.0))))
    v = np.concatenate(([0.0], *(sign * np.geomspace(1e-4, 3.0, 17) for sign in (1.0, -1.0))))
    with np.errstate(all="ignore"):
        force = effect.force_at(*np.meshgrid(z, v, indexing="ij"))
    small = _ALIKE * np.max(np.abs(force))
    with_z = bool(np.any(np.abs(force - force[:1]) > small))
    with_v = bool(np.any(np.abs(force - force[:, :1]) > small))
    residual = force - force[:1] - force[:, :1] + force[0, 0]
    return with_z, with_v, bool(np.any(np.abs(residual) > small))


def _axis(i: int, cuts: Sequence[float], ratio: float) -> TableAxis:
    """Return where a law is sampled, cut at its surfaces, finely to both sides of each."""
    steps = np.log(FARTHEST[i] / NEAREST[i]) / np.log(ratio)
    up = np.geomspace(NEAREST[i], FARTHEST[i], int(np.ceil(steps)) + 1)
    around = np.concatenate((-up[::-1], [0.0], up))
    values = np.unique(np.concatenate([around, *(cut + around for cut in cuts)]))
    centres = np.array([0.0, *cuts])
    near = np.min(np.abs(values[:, None] - centres), axis=1)
    keep = np.ones(values.size, bool)
    last = values[0]
    for k in range(1, values.size):  # where two sets of samples overlap, one is enough
        keep[k] = values[k] - last > 0.4 * (ratio - 1.0) * near[k] or near[k] == 0.0
        last = values[k] if keep[k] else last
    values = values[keep]
    edges = [-np.inf, *cuts, np.inf]
    parts = []
    for low, high in pairwise(edges):
        inside = values[(values > low) & (values < high)]
        ends = [np.nextafter(low, np.inf)] if np.isfinite(low) else []
        far = [np.nextafter(high, -np.inf)] if np.isfinite(high) else []
        parts.append(np.concatenate((ends, inside, far)))
    return TableAxis(tuple(parts), tuple(cuts))


def _force(effect: AbstractMemorylessEffect, z: TableAxis, v: TableAxis) -> FloatArray:
    """Return the force at all samples; beyond where it is finite, that of the last there."""
    with np.errstate(all="ignore"):
        force = np.array(effect.force_at(*np.meshgrid(z.knots, v.knots, indexing="ij")), float)
    return np.where(np.isfinite(force), force, np.nan_to_num(force, posinf=1e12, neginf=-1e12))
