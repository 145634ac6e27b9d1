"""The 90 % band of a quantity, and the probability that it exceeds a limit."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray

BAND: Final = 0.9
"""Probability that the truth lies within a band [-]."""

REPEATS: Final = 200
"""Draws of the model error for each simulated test: probabilities to a tenth of a per mille
[-]."""

_PER_DB: Final = np.log(10.0) / 20.0


@final
@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """A quantity with all that leaves it open.

    Attributes
    ----------
    drawn : (n_draws,) array
        Simulated values, without model error [unit of the quantity].
    all : (n_draws * REPEATS,) array
        The same with model error [unit of the quantity].
    """

    drawn: FloatArray
    all: FloatArray

    @property
    def value(self) -> float:
        """The median."""
        return float(np.median(self.drawn))

    @property
    def band(self) -> tuple[float, float]:
        """The 90 % band."""
        low, high = np.quantile(self.all, [0.5 * (1.0 - BAND), 0.5 * (1.0 + BAND)])
        return float(low), float(high)

    def holds(self, value: float) -> bool:
        """Return whether the 90 % band holds a value [unit of the quantity]."""
        low, high = self.band
        return low <= value <= high

    def quantile(self, probability: float) -> float:
        """Return what the quantity does not exceed with a probability [its unit]."""
        return float(np.quantile(self.all, probability))

    def exceeds(self, limit: float) -> float:
        """Return the probability that the quantity exceeds a limit [-]."""
        return float(np.mean(self.all > limit))


def spread_of(drawn: FloatArray, error_db: float, freedom: float) -> Spread:
    r"""Return a quantity with its model error.

    .. math:: x = x_i \, 10^{(\sigma t_\nu + h z) / 20}

    with the simulated values :math:`x_i`, Student's :math:`t_\nu`, a standard normal :math:`z`
    and the width :math:`h = s\,n^{-1/3}` of the kernel that makes a law of :math:`n` values
    with the standard deviation :math:`s` [1]_.

    Parameters
    ----------
    drawn : (n_draws,) array
        Simulated values, above 0 [unit of the quantity].
    error_db : float
        Scale :math:`\sigma` of the model error [dB].
    freedom : float
        Degrees of freedom :math:`\nu` [-].

    References
    ----------
    .. [1] A. Azzalini, "A note on the estimation of a distribution function and quantiles by a
       kernel method", Biometrika 68, 326-328, 1981.
    """
    generator = np.random.default_rng(0)
    logs = np.log(np.maximum(drawn, np.finfo(float).tiny))
    kernel = float(np.std(logs)) * drawn.size ** (-1.0 / 3.0)
    size = (drawn.size, REPEATS)
    law = generator.standard_t(freedom, size) if error_db else np.zeros(size)
    moved = _PER_DB * error_db * law
    moved = np.clip(moved, -50.0, 50.0) + kernel * generator.standard_normal(size)
    return Spread(drawn, np.exp(logs[:, None] + moved).ravel())
