"""Elements one behind the other, that carry one force."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter, check_parameters
from shakerproc.models.effects.coulomb_friction import CoulombFriction
from shakerproc.models.effects.gap import Gap
from shakerproc.models.identification import (
    Contained,
    Identification,
    JointScales,
    Values,
    clearance,
    friction,
    grid,
    number,
    spread,
    sticking_stiffness,
)
from shakerproc.models.laws import Law, Row

_NEVER: Final = 1e30
"""A clearance [m] or a slip force [N] that nothing reaches."""


@final
@dataclass(frozen=True, slots=True)
class Series(AbstractEffect):
    r"""Springs, gaps, stops and dampers in series with one slider at most.

    .. math:: F_1 = F_2 = \dots = F, \qquad z_1 + z_2 + \dots = z

    Compliances and plays add up; the slider holds the force to its own. A gap with a slider is
    play before friction, a spring with one a Jenkins element, a spring with a damper a Maxwell
    element. Between places that move apart for good, the slider creeps after them.

    Attributes
    ----------
    elements : tuple of AbstractEffect
        Springs, gaps, offset gaps, stops, dampers with their damping, and one coulomb_friction
        at most. One of them at least has a stiffness.

    References
    ----------
    .. [1] W. D. Iwan, "A distributed-element model for hysteresis and its steady-state dynamic
       response", Journal of Applied Mechanics 33, 893-900, 1966.
    """

    kind: ClassVar[str] = "series"
    formula: ClassVar[str] = "one force F through all elements, whose displacements add up"
    signature: ClassVar[str] = (
        "Play before a slider: a loop that is flat at the middle and at the ends, open between."
    )
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "elements": Parameter(
            "", "elements", "what stands in series", sign="any", holds="effects"
        )
    })

    elements: tuple[AbstractEffect, ...]

    def __post_init__(self) -> None:
        check_parameters(self, self.parameters)
        self.rows()

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import series_along  # loads the compiler: late

        chain = _chain(self.elements)
        values = np.array(chain.values())
        return series_along(displacement, velocity, 1.0 / sample_rate, values)

    def rows(self) -> tuple[Row, ...]:
        return _chain(self.elements).rows()

    @classmethod
    def estimated(cls) -> Mapping[str, Parameter]:
        return {**Gap.parameters, **CoulombFriction.parameters}

    @classmethod
    def of_numbers(cls, numbers: Values) -> "Series":
        """Return play before a slider, the one series that is looked for."""
        gap = Gap(number(numbers, "stiffness"), number(numbers, "clearance"))
        return cls((gap, CoulombFriction(number(numbers, "sliding_force"))))

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "stiffness": sticking_stiffness(at),
                "clearance": clearance(at),
                "sliding_force": friction(at),
            },
            starts=grid(
                stiffness=(2.0 * at.steepness, 20.0 * at.steepness),
                clearance=spread(0.03, 0.6, 5, at.displacement),
                sliding_force=(0.15 * at.force, 0.7 * at.force),
            ),
            contains=(
                Contained("jenkins", lambda values: _around_jenkins(values, at)),
                Contained("gap", lambda values: _around_gap(values, at)),
            ),
            scaled=("stiffness", "sliding_force"),
        )


def _around_jenkins(values: Values, at: JointScales) -> tuple[Values, ...]:
    """Return the element with hardly any play, and with more."""
    return grid(
        stiffness=(number(values, "stiffness"),),
        clearance=tuple(share * at.displacement for share in (3e-4, 0.02, 0.1, 0.3)),
        sliding_force=(number(values, "slip_force"),),
    )


def _around_gap(values: Values, at: JointScales) -> tuple[Values, ...]:
    """Return the gap with a slider that never slips, and with some that do."""
    return grid(
        stiffness=(number(values, "stiffness"),),
        clearance=(number(values, "clearance"),),
        sliding_force=tuple(share * at.force for share in (100.0, 0.7, 0.3, 0.1)),
    )


@final
@dataclass(frozen=True, slots=True)
class _Chain:
    """Elements in series, added up; a slip force or a mobility of damping of none is None."""

    stiffness: float
    plays: tuple[float, float]
    slip_force: float | None
    mobility: float | None

    def values(self) -> tuple[float, ...]:
        """Return the numbers of `Law.SERIES`."""
        slip = _NEVER if self.slip_force is None else self.slip_force
        return (self.stiffness, *self.plays, slip, self.mobility or 0.0)

    def rows(self) -> tuple[Row, ...]:
        """Return the rows of the shortest equivalent series."""
        if self.mobility is not None or (self.slip_force is not None and any(self.plays)):
            return (Row(Law.SERIES, self.values()),)
        if self.slip_force is not None:
            return (Row(Law.JENKINS, (self.stiffness, self.slip_force)),)
        if not any(self.plays):
            return (Row(Law.LINEAR, (self.stiffness, 0.0)),)
        return tuple(
            Row(Law.STOP, (self.stiffness, side * play, side))
            for side, play in zip((1.0, -1.0), self.plays, strict=True)
            if play < _NEVER
        )


def _chain(elements: tuple[AbstractEffect, ...]) -> _Chain:
    """Return elements in series, added up.

    Raises
    ------
    ValueError
        If one of them cannot stand in series, or they cannot be added up.
    """
    if len(elements) < 2:
        raise ValueError("elements must be two at least, such as a gap and a coulomb_friction")
    compliance, mobility = 0.0, 0.0
    sliders: list[float] = []
    plays = [0.0, 0.0]
    for element in elements:
        part = _part(element)
        compliance += part.compliance
        mobility += part.mobility
        plays = [min(a + b, _NEVER) for a, b in zip(plays, part.plays, strict=True)]
        sliders += part.sliders
    if len(sliders) > 1:
        raise ValueError("elements may hold one coulomb_friction: the weaker one slides")
    if compliance == 0.0:
        raise ValueError("elements need a stiffness: add a spring or a gap")
    if min(plays) >= _NEVER:
        raise ValueError("elements carry no force to either side: two stops face apart")
    slip = sliders[0] if sliders else None
    return _Chain(1.0 / compliance, (plays[0], plays[1]), slip, mobility or None)


@final
@dataclass(frozen=True, slots=True)
class _SeriesPart:
    """Compliance [m/N], plays [m], mobility [m/(N s)] and sliders [N] of one element."""

    compliance: float = 0.0
    plays: tuple[float, float] = (0.0, 0.0)
    mobility: float = 0.0
    sliders: tuple[float, ...] = ()


def _part(element: AbstractEffect) -> _SeriesPart:
    """Return the compliance, plays, mobility and sliders of an element, by its laws.

    Raises
    ------
    ValueError
        If it is none that can stand in series.
    """
    rows = element.rows()
    laws, first = {row.law for row in rows}, rows[0].values
    if laws == {Law.STOP}:
        walls = {row.values[2]: abs(row.values[1]) for row in rows}
        plays = (walls.get(1.0, _NEVER), walls.get(-1.0, _NEVER))
        return _SeriesPart(compliance=1.0 / first[0], plays=plays)
    if laws == {Law.LINEAR} and first[0] > 0.0 and first[1] == 0.0:
        return _SeriesPart(compliance=1.0 / first[0])
    if laws == {Law.LINEAR} and first[0] == 0.0 and first[1] > 0.0:
        return _SeriesPart(mobility=1.0 / first[1])
    if laws == {Law.FRICTION} and math.isclose(first[0], first[1], rel_tol=0.0):
        return _SeriesPart(sliders=(first[0],))
    raise ValueError(
        f"{element.kind} cannot stand in series; there may be springs, gaps, offset gaps, "
        f"stops, dampers and one coulomb_friction"
    )
