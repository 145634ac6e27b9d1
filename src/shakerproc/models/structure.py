"""Elastic bodies by their modes: structures, and one further mode of the specimen."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from types import MappingProxyType
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.geometry import Place

MASS_TOLERANCE: Final = 0.01
"""Departure of the mass that modes move from that of the structure: shapes come with four
digits or more, and units are wrong by a thousand [-]."""

ABOVE: Final = 5.0
"""Frequency of the mode that stands for those that are left out, over the highest that is not:
there its flexibility is off by 1 / 25 [-]."""

AXES: Final[Mapping[str, Place]] = MappingProxyType({
    f"{sign}{axis}": (
        factor * (axis == "x"), factor * (axis == "y"), factor * (axis == "z"),
    )
    for sign, factor in (("", 1.0), ("-", -1.0))
    for axis in "xyz"
})  # fmt: skip
"""Unit vectors of the directions that names of points end in [-]."""

_MOVED: Final = 1e-3
"""Departure of the base motion from what rigid-body modes span at the points: shapes come with
four digits or more [-]."""


@final
@dataclass(frozen=True, slots=True)
class Mode:
    r"""One more linear mode, such as the first bending mode of a rigid mass of the model.

    A mass :math:`\mu` moves by :math:`q` against the base, held by a spring and a damper at the
    places in which the mode takes part:

    .. math:: \mu (\ddot q + \ddot y) + c (\dot q - \textstyle\sum \phi_i \dot x_i)
        + k (q - \textstyle\sum \phi_i x_i) = 0, \qquad
        k = \mu (2 \pi f)^2, \quad c = 2 \zeta \mu \, 2 \pi f

    and :math:`\phi_i` times the force of both acts on mass :math:`i`. What is weighed stays the
    same: :math:`\mu \phi_i^2` of mass :math:`i` moves with the mode, so that with one place of
    participation 1 a part of the mass there hangs on a spring.

    Attributes
    ----------
    frequency : float
        Natural frequency while the masses of the model are held, :math:`f` [Hz].
    damping_ratio : float
        :math:`\zeta` [-].
    mass : float
        Effective mass, :math:`\mu` [kg].
    participation : mapping of str to float
        :math:`\phi_i` of the masses of the model in which it takes part [-].

    References
    ----------
    .. [1] R. R. Craig and A. J. Kurdila, "Fundamentals of Structural Dynamics", 2nd ed., Wiley,
       2006, ch. 17: fixed-interface modes.
    """

    frequency: float
    damping_ratio: float
    mass: float
    participation: Mapping[str, float]

    def __post_init__(self) -> None:
        checks.positive("frequency", self.frequency, "Hz")
        checks.not_negative("damping_ratio", self.damping_ratio, "1")
        checks.positive("mass", self.mass, "kg")
        object.__setattr__(self, "participation", MappingProxyType(dict(self.participation)))
        for name, share in self.participation.items():
            checks.finite(f"participation of {name}", share, "1")
        if not any(self.participation.values()):
            raise ValueError("a mode needs a mass in which it takes part, such as {coupon: 1}")

    def __reduce__(self) -> tuple[type["Mode"], tuple[object, ...]]:
        """Let a mode travel to another process (a mapping proxy cannot)."""
        return Mode, (
            self.frequency, self.damping_ratio, self.mass, dict(self.participation)
        )  # fmt: skip

    @property
    def stiffness(self) -> float:
        """Stiffness of its spring [N/m]."""
        return float(self.mass * (2.0 * np.pi * self.frequency) ** 2)

    @property
    def damping(self) -> float:
        """Damping of its damper [N s/m]."""
        return float(2.0 * self.damping_ratio * self.mass * 2.0 * np.pi * self.frequency)


@final
@dataclass(frozen=True, slots=True)
class StructureMode:
    r"""One mode of a structure, its shape mass-normalised.

    .. math:: \ddot q + 2 \zeta \, 2 \pi f \dot q + (2 \pi f)^2 q
        = \textstyle\sum_p \phi_p F_p - \gamma \ddot y

    Attributes
    ----------
    frequency : float
        Natural frequency; 0 for a rigid-body mode, :math:`f` [Hz].
    damping_ratio : float
        :math:`\zeta` [-].
    shape : tuple of float
        Displacement of each point, :math:`\phi_p` [1/sqrt(kg)].
    participation : float, optional
        :math:`\gamma` of a base acceleration, where the modes are those of a fixed base
        [sqrt(kg)].
    """

    frequency: float
    damping_ratio: float
    shape: tuple[float, ...]
    participation: float | None = None

    def __post_init__(self) -> None:
        checks.not_negative("frequency", self.frequency, "Hz")
        checks.not_negative("damping_ratio", self.damping_ratio, "1")
        object.__setattr__(self, "shape", tuple(map(float, self.shape)))
        for value in self.shape:
            checks.finite("shape", value, "1/sqrt(kg)")
        if self.participation is not None:
            checks.finite("participation", self.participation, "sqrt(kg)")

    @property
    def rigid(self) -> bool:
        """Whether it is a rigid-body mode."""
        return self.frequency == 0.0


@final
@dataclass(frozen=True)
class Structure:
    """An elastic body that moves in its modes, seen at some points.

    Attributes
    ----------
    points : tuple of str
        Names of its points, each with the direction in which it is seen, such as ``foot 1/x``,
        where there are several.
    modes : tuple of StructureMode
        Its modes; free-free with the rigid-body modes, or of a fixed base with participations.
    direction : str, optional
        Direction in which the base moves, ``x`` of ``foot 1/x``; without it all points are seen
        in that direction.
    residual : mapping of str to float
        Flexibility at points of the modes that are left out [m/N].
    positions : mapping of str to (x, y, z)
        Where points are, by their names with or without direction, for drawings [m].

    Raises
    ------
    ValueError
        If a shape has another number of values than there are points, a mode moves none of
        them, or nothing says how a base acceleration acts.
    """

    points: tuple[str, ...]
    modes: tuple[StructureMode, ...]
    direction: str | None = None
    residual: Mapping[str, float] = field(default_factory=dict)
    positions: Mapping[str, Place] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", tuple(self.points))
        for name in ("residual", "positions"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        object.__setattr__(self, "modes", tuple(self.modes))
        if not self.points:
            raise ValueError("a structure needs points, such as points: [foot 1, tip]")
        if not self.modes:
            raise ValueError("a structure needs modes")
        for i, mode in enumerate(self.modes, 1):
            if len(mode.shape) != len(self.points):
                raise ValueError(
                    f"mode {i}: the shape has {len(mode.shape)} values for "
                    f"{len(self.points)} points"
                )
            if not any(mode.shape):
                raise ValueError(f"mode {i} moves none of the points; leave it out")
        for point, flexibility in self.residual.items():
            checks.positive(f"residual of {point}", flexibility, "m/N")
            if point not in self.points:
                raise ValueError(f"residual: no point {point!r}")
        if self.residual and not any(mode.frequency for mode in self.modes):
            raise ValueError("a residual flexibility needs an elastic mode below it")

    def __reduce__(self) -> tuple[type["Structure"], tuple[object, ...]]:
        """Let a structure travel to another process (a mapping proxy cannot)."""
        maps = dict(self.residual), dict(self.positions)
        return Structure, (self.points, self.modes, self.direction, *maps)

    def position_of(self, point: str) -> Place | None:
        """Return where a point is [m]; None where that is not said."""
        return self.positions.get(point, self.positions.get(point.rpartition("/")[0]))

    def direction_of(self, point: str) -> Place | None:
        """Return along which axis a point is seen [-]; None where that is not said."""
        axis = point.rpartition("/")[2] if "/" in point else self.direction
        return AXES.get(axis or "")

    @cached_property
    def with_residuals(self) -> tuple[StructureMode, ...]:
        r"""The modes, and one for each residual flexibility, far above them.

        .. math:: \phi_p = \omega \sqrt{R_p}, \qquad
            \phi_p^2 / \omega^2 = R_p \quad\text{at rest}
        """
        if not self.residual:
            return self.modes
        highest = max(self.modes, key=lambda mode: mode.frequency)
        frequency = ABOVE * highest.frequency
        return self.modes + tuple(
            StructureMode(
                frequency,
                highest.damping_ratio,
                tuple(
                    2.0 * np.pi * frequency * np.sqrt(self.residual[point])
                    if other == point
                    else 0.0
                    for other in self.points
                ),
                0.0 if self.of_fixed_base else None,
            )
            for point in self.residual
        )

    @cached_property
    def shapes(self) -> FloatArray:
        """Mass-normalised shapes of the attached bodies, (n_points, n) array [1/sqrt(kg)]."""
        return np.array([mode.shape for mode in self.with_residuals], float).T

    @cached_property
    def sizes(self) -> FloatArray:
        """Coordinates of the attached bodies by modal displacements, (n,) array [1/sqrt(kg)].

        So many times the largest displacement of a point as there are modes: a length, as the
        coordinates of masses are, and no point moves further than the largest of them.
        """
        values: FloatArray = np.max(np.abs(self.shapes), axis=0) * len(self.with_residuals)
        return values

    @property
    def of_fixed_base(self) -> bool:
        """Whether the modes are those of a fixed base."""
        return not any(mode.rigid for mode in self.modes)

    @property
    def moved_by_base(self) -> FloatArray:
        """Displacement of the points where all moves with the base, (n_points,) array [-]."""
        if self.direction is None:
            return np.ones(len(self.points))
        return np.array([float(p.endswith(f"/{self.direction}")) for p in self.points])

    @property
    def moved_mass(self) -> float:
        r"""Mass that the modes move with the base, :math:`\sum_r \gamma_r^2` [kg].

        Raises
        ------
        ValueError
            As `participations` does.
        """
        return float(np.sum(self.participations**2))

    @cached_property
    def participations(self) -> FloatArray:
        r"""Participation of the attached bodies in a base acceleration, (n,) array [sqrt(kg)].

        As stated; else, of rigid-body modes, that in which all points move as the base does.

        .. math:: \textstyle\sum_r \phi_{pr} \gamma_r = 1

        Raises
        ------
        ValueError
            If no participation is stated, and the rigid-body modes do not move as the base.
        """
        stated = [mode.participation for mode in self.with_residuals]
        if any(value is not None for value in stated):
            return np.array([value or 0.0 for value in stated])
        rigid = np.array([mode.rigid for mode in self.with_residuals])
        if not rigid.any():
            raise ValueError(
                "no rigid-body mode (0 Hz) and no participation, so that nothing says how a "
                "base acceleration acts. State participation of each mode, in sqrt(kg)"
            )
        values = base_participations(self.shapes, rigid, self.moved_by_base)
        if values is None:
            raise ValueError(
                f"no sum of the rigid-body modes (0 Hz) moves all points as the base does: "
                f"more than {_MOVED:.2g} of it is left. Check their shapes, or state "
                "participation"
            )
        return values


def base_participations(
    shapes: FloatArray, rigid: NDArray[np.bool_], moved: FloatArray
) -> FloatArray | None:
    r"""Return the participations of modes in the motion of the base, in which points move.

    .. math:: \textstyle\sum_r \phi_{pr} \gamma_r = m_p

    Parameters
    ----------
    shapes : (n_points, n_modes) array
        Mass-normalised [1/sqrt(kg)].
    rigid : (n_modes,) array of bool
        Which modes are those of a rigid body.
    moved : (n_points,) array
        Displacement of each point where all moves with the base, :math:`m_p` [-].

    Returns
    -------
    (n_modes,) array, optional
        :math:`\gamma`, 0 of elastic modes; None where rigid-body modes do not move so
        [sqrt(kg)].
    """
    values = np.zeros(rigid.size)
    values[rigid] = np.linalg.lstsq(shapes[:, rigid], moved, rcond=None)[0]
    residual = np.max(np.abs(shapes @ values - moved))
    return values if residual <= _MOVED else None


def check_mass(participations: FloatArray, mass: float, *, fixed: bool) -> None:
    r"""Pass modes that move the mass of a structure with the base.

    All of it by rigid-body modes, at most all by those of a fixed base:

    .. math:: \textstyle\sum_r \gamma_r^2 = m

    Parameters
    ----------
    participations : (n_modes,) array
        :math:`\gamma` [sqrt(kg)].
    mass : float
        [kg].
    fixed : bool
        Whether the modes are those of a fixed base.

    Raises
    ------
    ValueError
        If they do not: units of the shapes, or the mass for which they are normalised.
    """
    moved = float(np.sum(participations**2))
    enough = fixed or moved > (1.0 - MASS_TOLERANCE) * mass
    if not enough or moved > (1.0 + MASS_TOLERANCE) * mass:
        advice = " The factor of 1000 is that of tonnes: state mass_unit: t."
        factor = mass / moved
        near = any(abs(factor / f - 1.0) < 0.1 for f in (1e-3, 1e3))
        raise ValueError(
            f"the modes move {moved:.4g} kg with the base, and mass says {mass:.4g} kg."
            + (advice if near else " Check how the shapes are normalised")
        )


def check_modes(
    frequencies: FloatArray, damping_ratios: FloatArray, shapes: FloatArray
) -> None:
    """Pass modes that swing, each once, whose shapes may be for a unit modal mass.

    Shapes whose largest values are all 1 are normalised to that. A point that one mode alone
    moves stands for the mode itself, and does not count.

    Parameters
    ----------
    frequencies : (n_modes,) array
        0 of rigid-body modes [Hz].
    damping_ratios : (n_modes,) array
        [-].
    shapes : (n_points, n_modes) array
        As they are written, for a unit mass.

    Raises
    ------
    ValueError
        If a damping ratio is 1 or more, a mode repeats another, or shapes are not for a unit
        modal mass.
    """
    elastic = np.flatnonzero(frequencies > 0.0)
    for i in elastic[damping_ratios[elastic] >= 1.0]:
        raise ValueError(
            f"mode {i + 1}: with a damping ratio of {damping_ratios[i]:g} it does not swing. "
            "0.5 % of critical damping is 0.005"
        )
    for i, j in combinations(range(frequencies.size * (len(shapes) > 1)), 2):
        one, other = shapes[:, i], shapes[:, j]
        if frequencies[i] == frequencies[j] and (
            np.array_equal(one, other) or np.array_equal(one, -other)
        ):
            raise ValueError(f"mode {j + 1} repeats mode {i + 1}; leave it out")
    shared = np.count_nonzero(shapes, axis=1) > 1
    largest = np.max(np.abs(shapes[np.ix_(shared, elastic)]), axis=0, initial=0.0)
    if elastic.size > 1 and np.all(np.abs(largest - 1.0) < _MOVED):
        raise ValueError(
            "the largest value of every shape is 1: shapes are normalised to that, and not to "
            "a modal mass of 1. Export them mass-normalised"
        )


def seen_rigid_modes(shapes: FloatArray, rigid: NDArray[np.bool_]) -> FloatArray:
    r"""Return how rigid-body modes are mixed, so that as few as can be move the points.

    All have 0 Hz, so that any turn of them is a set of rigid-body modes as good: that by the
    right singular vectors of their shapes leaves those that move no point, such as the motion
    in a plane where points are seen across it. Those need nothing that holds them.

    Parameters
    ----------
    shapes : (n_points, n_modes) array
        [1/sqrt(kg)].
    rigid : (n_modes,) array of bool
        Which modes are those of a rigid body.

    Returns
    -------
    (n_modes, n_modes) array
        By which shapes and participations are multiplied [-]; columns of what moves no point
        are 0, and that of elastic modes is the identity.
    """
    turn = np.eye(rigid.size)
    if not rigid.any():
        return turn
    _, sizes, mixed = np.linalg.svd(shapes[:, rigid], full_matrices=False)
    moving, count = sizes > _MOVED * np.max(sizes), int(np.count_nonzero(rigid))
    if np.count_nonzero(moving) < count:
        block = np.zeros((count, count))
        block[:, : np.count_nonzero(moving)] = mixed[moving].T
        turn[np.ix_(rigid, rigid)] = block
    return turn
