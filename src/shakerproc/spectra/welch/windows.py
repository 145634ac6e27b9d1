"""Windows: sums of cosines, symmetric as in MATLAB or periodic as for an FFT."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray

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


class AbstractCorrelation(ABC):
    """Correlation of a window with itself, 1 at no shift, over the shifts from 0."""

    @abstractmethod
    def transform(self, exponent: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        r"""Return its transform, the first sample halved, and the slope along the exponent.

        .. math:: R(s) = \sum_{\tau \ge 0} r(\tau) e^{s \tau} - 1/2

        Parameters
        ----------
        exponent : (n,) array
            Exponents :math:`s` per sample, with a negative real part [rad].
        """


@final
class CosineCorrelation(AbstractCorrelation):
    r"""That of a sum of cosines, in closed form.

    .. math:: r(\tau) = \sum_k (\alpha_k + \beta_k (L - \tau)) e^{i k a \tau}
    """

    def __init__(self, name: str, length: int) -> None:
        terms = COSINE_TERMS[name.removeprefix(PERIODIC)]
        period = length if name.startswith(PERIODIC) else length - 1
        most = len(terms) - 1
        order = np.arange(-most, most + 1)
        weight = np.array([(-1) ** k * terms[k] * (0.5 if k else 1.0) for k in np.abs(order)])
        step = 2.0 * np.pi / period
        alpha, beta = np.zeros((2, order.size), dtype=np.complex128)
        for m, one in zip(order, weight, strict=True):
            for k, other in zip(order, weight, strict=True):
                if m + k == 0:
                    beta[k + most] += one * other
                    continue
                share = one * other / (1.0 - np.exp(1j * step * (m + k)))
                alpha[k + most] += share
                alpha[most - m] -= share * np.exp(1j * step * (m + k) * length)
        power = complex(np.sum(alpha + beta * length)).real
        self.alpha = (alpha + beta * length) / power
        self.beta = beta / power
        self.exponents = 1j * step * order
        self.length = length

    def transform(self, exponent: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        n = self.length
        every = exponent + self.exponents[:, np.newaxis]
        with np.errstate(under="ignore"):
            ratio, end = np.exp(every), np.exp(n * every)
            left = 1.0 / -np.expm1(every)
            plain = (1.0 - end) * left
            first = (ratio * plain - n * end) * left
            second = (ratio * (plain + 2.0 * first) - n * n * end) * left
        spectrum = self.alpha @ plain - self.beta @ first - 0.5
        return spectrum, self.alpha @ first - self.beta @ second


@final
class SampledCorrelation(AbstractCorrelation):
    """That of any weights, summed sample by sample."""

    def __init__(self, window: FloatArray) -> None:
        spectrum = np.fft.rfft(window, 2 * window.size)
        correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: window.size]
        self.correlation = correlation / correlation[0]

    def transform(self, exponent: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        shifts = np.arange(self.correlation.size)
        both = np.stack([self.correlation, self.correlation * shifts], axis=1)
        sums = np.empty((exponent.size, 2), dtype=np.complex128)
        with np.errstate(under="ignore"):
            for k, one in enumerate(exponent):
                sums[k] = np.exp(one * shifts) @ both
        return sums[:, 0] - 0.5, sums[:, 1]


@final
class DecayCorrelation(AbstractCorrelation):
    """Correlation of blocks that hold whole decays under their exponential window.

    Nothing is cut off, so that there is no correlation of a window; as a window multiplies
    input and response alike, a mode decays faster by its rate, which is taken into account
    here as a correlation that decays.
    """

    def __init__(self, decay: float) -> None:
        self.decay = decay  # of the window, per sample

    def transform(self, exponent: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        every = np.asarray(exponent - self.decay, dtype=np.complex128)
        left = np.asarray(-1.0 / np.expm1(every), dtype=np.complex128)
        return left - 0.5, left * left * np.exp(every)


def correlation_of(name: str, window: FloatArray) -> AbstractCorrelation:
    """Return the correlation of a window with itself, in closed form where it has one.

    Parameters
    ----------
    name : str
        A name as in `window_samples`, or another one for weights of one's own.
    window : (length,) array
        Its weights [-].
    """
    if name.removeprefix(PERIODIC) in COSINE_TERMS:
        return CosineCorrelation(name, window.size)
    return SampledCorrelation(window)


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
