"""A force law that was measured."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType
from typing import ClassVar, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import (
    AbstractMemorylessEffect,
    Parameter,
    check_parameters,
)
from shakerproc.models.laws import Row
from shakerproc.models.tabulated import SplineTable, axis, spline_table
from shakerproc.numerals import numeral

Numbers: TypeAlias = tuple[float, ...]


@final
@dataclass(frozen=True, slots=True)
class Table(AbstractMemorylessEffect):
    r"""A force given at displacements and velocities, such as `diagnose` measures it.

    .. math:: F = S(z, v), \qquad S(z_i, v_j) = F_{ij}

    S is the natural bicubic spline through the numbers; beyond them it goes on straight. With
    one velocity alone the force depends on displacement alone, and the other way round.

    Attributes
    ----------
    displacement : tuple of float
        Displacements :math:`z_i`, rising [m].
    velocity : tuple of float
        Velocities :math:`v_j`, rising [m/s].
    force : tuple of tuple of float
        Force :math:`F_{ij}`, a row for each displacement [N].
    band : tuple of tuple of float, optional
        Half width of the 95 % interval of each force [N]; no part of the law.

    References
    ----------
    .. [1] S. F. Masri and T. K. Caughey, "A nonparametric identification technique for
       nonlinear dynamic problems", Journal of Applied Mechanics 46, 433-447, 1979.
    .. [2] C. de Boor, "A Practical Guide to Splines", Springer, 1978, ch. 4 and 17.
    """

    kind: ClassVar[str] = "table"
    formula: ClassVar[str] = "F = S(z, v), the natural bicubic spline through Fij at zi, vj"
    signature: ClassVar[str] = "Whatever was measured, within the range of the measurement."
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "displacement": Parameter(
            "m", "z", "displacements, rising", sign="any", holds="numbers"
        ),
        "velocity": Parameter("m/s", "v", "velocities, rising", sign="any", holds="numbers"),
        "force": Parameter(
            "N", "F", "force, a row for each displacement", sign="any", holds="rows"
        ),
        "band": Parameter(
            "N", "F", "half width of its interval", sign="any", holds="rows", optional=True
        ),
    })

    displacement: Numbers
    velocity: Numbers
    force: tuple[Numbers, ...]
    band: tuple[Numbers, ...] | None = None

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)
        _check_shape(self)

    def force_at(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        return self._spline().value(displacement, velocity)

    def slopes(
        self, displacement: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        spline = self._spline()
        by_displacement = spline.value(displacement, velocity, (1, 0))
        return by_displacement, spline.value(displacement, velocity, (0, 1))

    def rows(self) -> tuple[Row, ...]:
        return (_row(self.displacement, self.velocity, self.force),)

    def remark(self, displacement: FloatArray, velocity: FloatArray) -> str | None:
        ranges = [
            f"{name} reached {numeral(np.min(motion))} to {numeral(np.max(motion))} {unit}, "
            f"the table {numeral(known[0])} to {numeral(known[-1])}"
            for name, unit, motion, known in (
                ("displacement", "m", displacement, self.displacement),
                ("velocity", "m/s", velocity, self.velocity),
            )
            if len(known) > 1 and (np.min(motion) < known[0] or np.max(motion) > known[-1])
        ]
        return f"{'; '.join(ranges)}: beyond it the force goes on straight" if ranges else None

    def _spline(self) -> SplineTable:
        return _table(self.displacement, self.velocity, self.force)


@lru_cache(maxsize=16)
def _table(displacement: Numbers, velocity: Numbers, force: tuple[Numbers, ...]) -> SplineTable:
    return spline_table(axis(displacement), axis(velocity), np.array(force, float))


@lru_cache(maxsize=16)
def _row(displacement: Numbers, velocity: Numbers, force: tuple[Numbers, ...]) -> Row:
    return _table(displacement, velocity, force).row()


def _check_shape(table: Table) -> None:
    """Pass a table whose axes rise and whose rows are as long as they must be.

    Raises
    ------
    ValueError
        If not.
    """
    for name, values in (("displacement", table.displacement), ("velocity", table.velocity)):
        if any(b <= a for a, b in pairwise(values)):
            raise ValueError(f"{name} must rise from each number to the next")
    wanted = (len(table.displacement), len(table.velocity))
    for name, rows in (("force", table.force), ("band", table.band)):
        if rows is None:
            continue
        if len(rows) != wanted[0] or any(len(row) != wanted[1] for row in rows):
            raise ValueError(
                f"{name} must have {wanted[0]} rows, one for each displacement, of "
                f"{wanted[1]} numbers, one for each velocity"
            )
