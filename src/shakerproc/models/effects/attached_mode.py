"""A mode of the structure that the model had left out."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.models.effects.base import AbstractEffect, Parameter
from shakerproc.models.identification import (
    Free,
    Identification,
    JointScales,
    grid,
    positive,
    spread,
)
from shakerproc.models.laws import Law, Row


@final
@dataclass(frozen=True, slots=True)
class AttachedMode(AbstractEffect):
    r"""One more mass, on a spring and a damper of its own, on the second place of ``between``.

    .. math:: F = k_t (x - x_t) + c_t (\dot x - \dot x_t), \qquad
        k_t = m_t (2 \pi f_t)^2, \qquad c_t = 2 \zeta_t m_t 2 \pi f_t

    It is joined to one place only: ``between: [coupon]``, or ``[base, coupon]``, of which the
    first is not used. Its force depends on the absolute motion of the place, so the motion
    given to `force_along` is that, and not a relative one.

    Attributes
    ----------
    mass : float
        Attached mass, :math:`m_t` [kg].
    frequency : float
        Its natural frequency while its place is held, :math:`f_t` [Hz].
    damping_ratio : float
        Its damping ratio, :math:`\zeta_t` [-].

    References
    ----------
    .. [1] J. P. Den Hartog, "Mechanical Vibrations", 4th ed., McGraw-Hill, 1956, ch. 3.
    """

    kind: ClassVar[str] = "attached_mode"
    formula: ClassVar[str] = (
        "F = kt (x - xt) + ct (x' - xt'), kt = mt (2π ft)², ct = 2 ζt mt 2π ft"
    )
    signature: ClassVar[str] = (
        "Two peaks with a notch between them, the same at every level: linear."
    )
    absolute: ClassVar[bool] = True
    parameters: ClassVar[Mapping[str, Parameter]] = MappingProxyType({
        "mass": Parameter("kg", "mt", "attached mass", linear=True),
        "frequency": Parameter("Hz", "ft", "natural frequency on a held place"),
        "damping_ratio": Parameter("1", "ζt", "damping ratio", sign="not negative"),
    })

    mass: float
    frequency: float
    damping_ratio: float

    def force_along(
        self, displacement: FloatArray, velocity: FloatArray, sample_rate: float
    ) -> FloatArray:
        from shakerproc.models.kernels import attached_along  # loads the compiler: late

        omega = 2.0 * np.pi * self.frequency
        advance = _advance(omega, self.damping_ratio, 1.0 / sample_rate)
        return attached_along(
            displacement, velocity, np.array((self.stiffness, self.damping)), advance
        )

    @classmethod
    def identification(cls, at: JointScales) -> Identification:
        return Identification(
            free={
                "mass": positive(0.06 * at.mass, 1e-3, 1e2),
                "frequency": positive(at.frequency, 0.1, 30.0),
                "damping_ratio": Free(1e-4, 0.5, "logarithm", 0.015),
            },
            starts=grid(
                mass=(0.02 * at.mass, 0.1 * at.mass),
                frequency=spread(0.4, 3.0, 12, at.frequency),
                damping_ratio=(0.015,),
            ),
            scaled=("mass",),
        )

    def rows(self) -> tuple[Row, ...]:
        return (Row(Law.ATTACHED, (self.mass, self.stiffness, self.damping)),)

    @property
    def stiffness(self) -> float:
        """Stiffness of its spring [N/m]."""
        return float(self.mass * (2.0 * np.pi * self.frequency) ** 2)

    @property
    def damping(self) -> float:
        """Damping of its damper [N s/m]."""
        return float(2.0 * self.damping_ratio * self.mass * 2.0 * np.pi * self.frequency)

    def apparent_mass(self, frequency: FloatArray) -> ComplexArray:
        """Return force over absolute acceleration of its place, (n_frequencies,) array [kg]."""
        s = 2j * np.pi * frequency
        joint = self.stiffness + self.damping * s
        return self.mass * joint / (self.mass * s**2 + joint)


def _advance(omega: float, damping_ratio: float, step: float) -> FloatArray:
    """Return the (2, 6) matrix of one sample, the motion of the place linear in between."""
    from scipy.linalg import expm  # a quarter of a second, which few models need

    system = np.zeros((6, 6))
    system[0, 1] = 1.0
    system[1, :4] = (-(omega**2), -2.0 * damping_ratio * omega, omega**2, 0.0)
    system[1, 3] = 2.0 * damping_ratio * omega
    system[2, 4] = system[3, 5] = 1.0 / step
    over = expm(system * step)[:2]
    known = np.zeros((2, 6))
    known[:, :2] = over[:, :2]
    known[:, 2:4] = over[:, 2:4] - over[:, 4:]
    known[:, 4:] = over[:, 4:]
    return known
