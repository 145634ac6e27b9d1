"""Windows: sums of cosines, symmetric as in MATLAB or periodic as for an FFT."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from shakerproc.data import FloatArray

COSINE_TERMS: Final[Mapping[str, tuple[float, ...]]] = MappingProxyType({
    "rectangular": (1.0,),
    "hann": (0.5, 0.5),
    "hamming": (0.54, 0.46),
    "blackman": (0.42, 0.5, 0.08),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
    "flat top": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
})
"""Weights of cos(0), -cos(1 t), +cos(2 t), ... of each window."""

PERIODIC: Final = "periodic "
"""In front of a name: the window repeats after its length, not one sample earlier."""


def window_samples(name: str, length: int) -> FloatArray:
    r"""Return the samples of a window.

    .. math:: w_n = \sum_m (-1)^m a_m \cos(2 \pi m n / (L - 1))

    with :math:`L` for :math:`L - 1` where the name begins with ``periodic``.

    Parameters
    ----------
    name : str
        A key of `COSINE_TERMS`, symmetric as in MATLAB; with ``periodic`` in front, periodic
        as scipy makes it by name.
    length : int
        Number of samples :math:`L`.

    Returns
    -------
    (length,) array
        Weights [-].

    Raises
    ------
    ValueError
        If there is no such window, or it has fewer than 2 samples.
    """
    terms = COSINE_TERMS.get(name.removeprefix(PERIODIC))
    if terms is None:
        raise ValueError(
            f"window must be one of {', '.join(COSINE_TERMS)} "
            f"('{PERIODIC}' may stand in front), not {name!r}"
        )
    if length < 2:
        raise ValueError(f"a window needs at least 2 samples, not {length}")
    period = length if name.startswith(PERIODIC) else length - 1
    angle = 2.0 * np.pi * np.arange(length) / period
    signed = ((-1) ** m * weight * np.cos(m * angle) for m, weight in enumerate(terms))
    return np.array(np.sum(list(signed), axis=0))


def effective_averages(window: FloatArray, step: int, n_segments: int) -> float:
    r"""Return how many independent segments have the same variance of a PSD.

    .. math:: K_e = K \Big/ \Big(1 + 2 \sum_m \frac{K - m}{K} \rho_m^2\Big), \quad
              \rho_m = \frac{\sum_n w_n w_{n + m D}}{\sum_n w_n^2}

    Parameters
    ----------
    window : (length,) array
        Weights [-].
    step : int
        Samples :math:`D` from the start of a segment to the start of the next.
    n_segments : int
        Number of overlapping segments :math:`K`.

    Returns
    -------
    float
        Effective number of averages; the PSD has twice as many degrees of freedom.

    References
    ----------
    .. [1] P. D. Welch, "The use of fast Fourier transform for the estimation of power
       spectra", IEEE Trans. Audio Electroacoustics 15, 1967, eq. 7.
    """
    power = float(window @ window)
    shifts = range(1, min(n_segments, -(-window.size // step)))
    correlation = [float(window[: -m * step] @ window[m * step :]) / power for m in shifts]
    share = [(n_segments - m) / n_segments for m in shifts]
    return n_segments / (
        1.0 + 2.0 * sum(s * r * r for s, r in zip(share, correlation, strict=True))
    )
