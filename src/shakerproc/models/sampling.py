"""Effects that state their force in numpy alone: simulated by a table of it.

A law of displacement alone, of velocity alone, or a sum of the two is sampled along lines, any
other over a plane, from rest outwards in equal ratios to both sides, and to both sides of
every surface of `switches`. It then goes where every tabulated law goes (`tabulated`).
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import ClassVar, Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractMemorylessEffect, Switch
from shakerproc.models.laws import Row
from shakerproc.models.tabulated import SplineTable, TableAxis, spline_table

NEAREST: Final = (1e-8, 1e-6)
FARTHEST: Final = (1e-1, 1e2)
"""Displacements [m] and velocities [m/s] between which a law is sampled."""

LINE_RATIO: Final = 1.04
"""From one sample to the next along a line: a cubic spline misses z^1.5 by 1e-8 [-]."""

PLANE_RATIO: Final = 1.25
"""The same over a plane, of 28,000 samples: by 1e-5 [-]."""

_ALIKE: Final = 1e-12
"""Differences of force that count as rounding, as a share of the largest [-]."""


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

    def switches(self) -> tuple[Switch, ...]:
        return ()

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
    left = force - force[:1] - force[:, :1] + force[0, 0]
    return with_z, with_v, bool(np.any(np.abs(left) > small))


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
