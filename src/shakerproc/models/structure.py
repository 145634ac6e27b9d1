"""An elastic body of a model, by its modes."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray

MASS_TOLERANCE: Final = 0.01
"""Departure of the mass that modes move from that of the structure: shapes come with four
digits or more, and units are wrong by a thousand [-]."""

_MOVED: Final = 1e-3
"""Departure of the base motion from what rigid-body modes span at the points: shapes come with
four digits or more [-]."""


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
@dataclass(frozen=True, slots=True)
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

    Raises
    ------
    ValueError
        If a shape has another number of values than there are points, a mode moves none of
        them, or nothing says how a base acceleration acts.
    """

    points: tuple[str, ...]
    modes: tuple[StructureMode, ...]
    direction: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", tuple(self.points))
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

    @property
    def shapes(self) -> FloatArray:
        """Mass-normalised shapes, (n_points, n_modes) array [1/sqrt(kg)]."""
        return np.array([mode.shape for mode in self.modes], float).T

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

    def check_mass(self, mass: float) -> None:
        r"""Pass modes that move the mass of the structure with the base [kg].

        All of it by rigid-body modes, at most all by those of a fixed base:

        .. math:: \textstyle\sum_r \gamma_r^2 = m

        Raises
        ------
        ValueError
            If they do not: units of the shapes, or the mass for which they are normalised.
        """
        moved = float(np.sum(self.participations**2))
        enough = self.of_fixed_base or moved > (1.0 - MASS_TOLERANCE) * mass
        if not enough or moved > (1.0 + MASS_TOLERANCE) * mass:
            advice = " The factor of 1000 is that of tonnes: state mass_unit: t."
            factor = mass / moved
            near = any(abs(factor / f - 1.0) < 0.1 for f in (1e-3, 1e3))
            raise ValueError(
                f"the modes move {moved:.4g} kg with the base, and mass says {mass:.4g} kg."
                + (advice if near else " Check how the shapes are normalised")
            )

    @property
    def participations(self) -> FloatArray:
        r"""Participation of each mode in a base acceleration, (n_modes,) array [sqrt(kg)].

        As stated; else, of rigid-body modes, that in which all points move as the base does.

        .. math:: \textstyle\sum_r \phi_{pr} \gamma_r = 1

        Raises
        ------
        ValueError
            If no participation is stated, and the rigid-body modes do not move as the base.
        """
        stated = [mode.participation for mode in self.modes]
        if any(value is not None for value in stated):
            return np.array([value or 0.0 for value in stated])
        rigid = np.array([mode.rigid for mode in self.modes])
        found = np.zeros(rigid.size)
        if not rigid.any():
            raise ValueError(
                "no rigid-body mode (0 Hz) and no participation, so that nothing says how a "
                "base acceleration acts. State participation of each mode, in sqrt(kg)"
            )
        wanted, spanned = self.moved_by_base, self.shapes[:, rigid]
        found[rigid] = np.linalg.lstsq(spanned, wanted, rcond=None)[0]
        left = np.max(np.abs(spanned @ found[rigid] - wanted))
        if left > _MOVED:
            raise ValueError(
                f"no sum of the rigid-body modes (0 Hz) moves all points as the base does: "
                f"{left:.2g} of it is left. Check their shapes, or state participation"
            )
        return found
