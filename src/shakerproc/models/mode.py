"""A mode of the specimen beyond those of its masses and joints."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import final

import numpy as np

from shakerproc import checks


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
