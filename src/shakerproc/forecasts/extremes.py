"""The largest value of a motion in a duration longer than what was simulated of it."""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray

BLOCKS: Final = 32
"""Parts of the samples whose largest values tell the law of the largest of all [-]."""

EULER: Final = 0.5772156649015329
"""Mean of the standard Gumbel law [-]."""


def largest_in(samples: FloatArray, longer: float = 1.0, chance: float = 0.5) -> float:
    r"""Return the largest size in a duration, drawn where it is longer than the samples.

    .. math:: x_T^2 = u + \beta \left(\ln \frac{T}{B} - \ln(-\ln p)\right), \qquad
        \beta = \frac{\sqrt 6}{\pi} s_B, \quad u = m_B - \gamma \beta

    with mean :math:`m_B` and standard deviation :math:`s_B` of the squares of the largest sizes
    in blocks of length :math:`B`: those of narrow-band Gaussian response follow Gumbel's law
    with one scale whatever the length, twice the variance [2]_. Never below the largest of the
    samples themselves.

    Parameters
    ----------
    samples : (n,) array
        A motion [any unit].
    longer : float
        The duration over that of the samples, 1 where they are all of it [-].
    chance : float
        Quantile :math:`p` of the largest value in the rest, drawn evenly from 0 to 1 [-].

    References
    ----------
    .. [1] E. J. Gumbel, "Statistics of Extremes", Columbia, 1958, ch. 5.
    .. [2] A. G. Davenport, "Note on the distribution of the largest value of a random function
       with application to gust loading", Proc. ICE 28, 187-196, 1964.
    """
    size = np.abs(samples - np.mean(samples))
    own = float(np.max(size))
    if longer <= 1.0 + 1e-9 or size.size < 2 * BLOCKS:
        return own
    n = size.size // BLOCKS
    largest = size[: n * BLOCKS].reshape(BLOCKS, n).max(axis=1) ** 2
    scale = float(np.sqrt(6.0) / np.pi * np.std(largest, ddof=1))
    place = float(np.mean(largest)) - EULER * scale
    rest = BLOCKS * (longer - 1.0)
    square = place + scale * float(np.log(rest) - np.log(-np.log(chance or 1e-12)))
    return max(own, float(np.sqrt(max(square, 0.0))))
