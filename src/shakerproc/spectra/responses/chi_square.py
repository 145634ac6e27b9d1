"""Quantiles of chi-square: scipy.special has them, but loads for a quarter of a second."""

from math import exp, lgamma, log
from statistics import NormalDist
from typing import Final

import numpy as np

MOST_STEPS: Final = 200
"""Of Newton's method, which needs less than ten where the freedom is above 1."""


def chi_square_quantile(probability: float, freedom: float) -> float:
    r"""Return the value that chi-square stays below with a probability.

    Newton's method for the logarithm of the distribution against the logarithm of the value,
    which is concave: it converges from anywhere. The distribution is the series

    .. math:: P(a, x) = \frac{x^a e^{-x}}{\Gamma(a + 1)}
              \sum_{n \ge 0} \frac{x^n}{(a + 1) \cdots (a + n)}, \quad a = \nu / 2

    Parameters
    ----------
    probability : float
        Between 0 and 1 [-].
    freedom : float
        Degrees of freedom :math:`\nu`, above 0 [-].

    Returns
    -------
    float
        The quantile :math:`2 x` [-].

    References
    ----------
    .. [1] NIST Digital Library of Mathematical Functions, 8.7.1, https://dlmf.nist.gov/8.7.
    """
    shape = 0.5 * freedom
    cube = 1.0 - 1.0 / (9.0 * shape) + NormalDist().inv_cdf(probability) / (9.0 * shape) ** 0.5
    place = log(shape) + 3.0 * log(max(cube, 0.1))
    for _ in range(MOST_STEPS):
        value = exp(place)
        more = 10.0 * max(shape, value) ** 0.5 + max(value - shape, 0.0)
        series = 1.0 + float(np.cumprod(value / (shape + np.arange(1.0, 60.0 + more))).sum())
        below = shape * place - value - lgamma(shape + 1.0) + log(series)
        step = (log(probability) - below) * series / shape
        place += step
        if abs(step) < 1e-15 * max(abs(place), 1.0):
            break
    return 2.0 * exp(place)
