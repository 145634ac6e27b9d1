"""The curves that are followed: response against frequency, and the way to a first solution."""

from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.harmonic_balance.balance import HarmonicBalance


@final
@dataclass(frozen=True, eq=False)
class ForcedCurve:
    """Forced motion against frequency; the last unknown is the base rate [rad/s].

    Attributes
    ----------
    balance : HarmonicBalance
        The equations.
    """

    balance: HarmonicBalance

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual and derivative, both over the size of the load.

        `point` holds coefficients [m] and a rate [rad/s].
        """
        found = self.balance.residual(point[:-1], point[-1])
        scale = np.linalg.norm(self.balance.load)
        derivative = np.column_stack([found.jacobian, found.by_omega])
        return found.force / scale, derivative / scale

    def weights(self, point: FloatArray) -> FloatArray:
        """Return one over the size of the velocity, and one over the rate.

        `point` holds coefficients [m] and a rate [rad/s].
        """
        return motion_weights(self.balance, point, np.array([1.0 / point[-1]]))


@final
@dataclass(frozen=True, eq=False)
class WayFromLinear:
    """From a linear system to the one wanted; the last unknown goes from 0 to 1.

    Attributes
    ----------
    balance : HarmonicBalance
        The equations.
    omega : float
        Base rate [rad/s].
    """

    balance: HarmonicBalance
    omega: float

    def evaluate(self, point: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residual and derivative, both over the size of the load.

        `point` holds coefficients [m] and a share [-].
        """
        balance, share = self.balance, point[-1]
        found = balance.residual(point[:-1], self.omega)
        reference = balance.reference_matrix(self.omega)
        linear = reference @ point[:-1] - balance.load
        jacobian = share * found.jacobian + (1.0 - share) * reference
        scale = np.linalg.norm(balance.load)
        derivative = np.column_stack([jacobian, found.force - linear])
        return (share * found.force + (1.0 - share) * linear) / scale, derivative / scale

    def weights(self, point: FloatArray) -> FloatArray:
        """Return one over the size of the velocity, and 1 for the share.

        `point` holds coefficients [m] and a share [-].
        """
        return motion_weights(self.balance, point, np.array([1.0]))


def motion_weights(
    balance: HarmonicBalance, point: FloatArray, others: FloatArray
) -> FloatArray:
    """Return weights in which the velocity amplitude is 1, followed by those of the others.

    `point` holds coefficients [m] and what follows them, `others` one over the unit of that.
    """
    numbers = np.maximum(balance.numbers, 1.0)
    size = np.linalg.norm(numbers * point[: numbers.size])
    return np.concatenate([numbers / max(float(size), 1e-300), others])
