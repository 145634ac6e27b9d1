r"""Scatter of a response function or density that Welch's method has smeared.

Over a steady random run the spectra are averages of the input's fine periodogram
:math:`I(\nu)`, which scatters about the density of the input. H1 becomes

.. math:: \hat H(f) = \frac{\int K(f - \nu) H(\nu) I(\nu) d\nu}{\int K(f - \nu) I(\nu) d\nu}

with the spectral window :math:`K = A^2`, so that its error is a sum of independent parts

.. math:: \sum_j \int A(f - \nu) A(f - \nu - j f_D) [H(\nu + j f_D) - \bar H(f)] a_j(\nu) d\nu

over the harmonics of the rate :math:`f_D` at which segments follow each other: of two bins,
their real and their imaginary parts, all covariances follow. Noise that the input knows
nothing of adds its own.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.peaks.mode_fit import Kind, ModesFit
from shakerproc.spectra.welch.cross import CrossSpectra

OVER: Final = 16
"""Points of the window's spectrum in the width of a segment's bin."""

LOBE: Final = 3.5
"""Half the width of a window's main lobe, and a little more [bins of a segment]."""

FAR: Final = 16.0
"""How far the side lobes of a window are followed from a narrow mode [bins of a segment]."""

NARROW: Final = 2.0
"""Half-power width from which leakage through side lobes is nothing [bins of a segment]."""

FINE: Final = 3
"""Nodes of the integrals in the width of a segment's bin."""

POINTS: Final = 41
"""Nodes on a mode that is narrower than they are apart."""

LEAST_NOISE: Final = 1e-3
"""Noise that is assumed at least, as a share of what the coherence misses [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Chance:
    """Errors of the values in some bins, and the bias of their mean by smearing.

    Attributes
    ----------
    covariance : (n_values, n_values) array
        Of the errors, real above imaginary parts [value²].
    bias : (n_bins,) array
        Mean of the error [value].
    n_bins : int
        How many bins.
    """

    covariance: FloatArray
    bias: ComplexArray | FloatArray
    n_bins: int

    @property
    def errors(self) -> FloatArray:
        """Standard error of each value; of complex values that of their parts."""
        power = np.diag(self.covariance).reshape(-1, self.n_bins).mean(axis=0)
        return np.array(np.sqrt(power))


@final
class Smearing:
    """How one setting of Welch's method smears: window, overlap, length of the run."""

    def __init__(self, spectra: CrossSpectra) -> None:
        window, rate = spectra.window, spectra.sample_rate
        spectrum = scipy.fft.rfft(window, OVER * window.size)
        turn = np.pi * np.arange(spectrum.size) / (OVER * window.size) * (window.size - 1)
        power = float(window @ window) * rate
        self.amplitude = (spectrum * np.exp(1j * turn)).real / np.sqrt(power)
        self.step = rate / (OVER * window.size)
        self.segment = rate / spectra.segment
        self.hop = rate / (spectra.segment - spectra.overlap)
        self.bin_width = spectra.bin_width
        self.rate = rate
        self.averages = spectra.effective_averages
        near = int(np.ceil(LOBE * self.segment / self.hop))
        self.pairs = range(near + 1)
        nodes = np.arange(-6.0, 6.0, 1.0 / (2 * FINE)) * self.segment
        weights = [self(nodes) * self(nodes - j * self.hop) for j in self.pairs]
        share = self.segment / (2 * FINE)
        self.norm = share * sum(
            (1.0 if j == 0 else 2.0) * float(w @ w)
            for j, w in zip(self.pairs, weights, strict=True)
        )

    def __call__(self, distance: FloatArray) -> FloatArray:
        """Return the amplitude of the window's spectrum so far from its middle [Hz^-1/2]."""
        place = np.abs(distance) / self.step
        interpolated = np.interp(
            place, np.arange(self.amplitude.size), self.amplitude, right=0.0
        )
        return np.asarray(interpolated, dtype=np.float64)

    def noise_correlation(self, n_bins: int) -> FloatArray:
        """Return how errors by noise are correlated over so many bins, (n_bins,)."""
        nodes = np.arange(-6.0, 6.0, 1.0 / (2 * FINE)) * self.segment
        shifts = np.arange(min(n_bins, round(12.0 * self.segment / self.bin_width)))
        moved = nodes - self.bin_width * shifts[:, np.newaxis]
        result = np.zeros(n_bins)
        for j in self.pairs:
            here = self(nodes) * self(nodes - j * self.hop) * (1.0 if j == 0 else 2.0)
            result[: shifts.size] += (self(moved) * self(moved - j * self.hop)) @ here
        return np.asarray(result / result[0], dtype=np.float64)

    def harmonics(self, fit: ModesFit, span: float) -> range:
        """Return the harmonics of the segments' rate that matter to a fit over a span [Hz]."""
        far = LOBE * self.segment
        if 2.0 * float(np.min(fit.frequency * fit.ratio)) < NARROW * self.segment:
            far = max(far, min(span, FAR * self.segment))
        return range(int(np.ceil(far / self.hop)) + 1)


@lru_cache(maxsize=2)
def smearing_of(spectra: CrossSpectra) -> Smearing:
    """Return how some spectra were averaged; the same for every peak of a run."""
    return Smearing(spectra)


def steady_chance(
    smearing: Smearing,
    kind: Kind,
    frequency: FloatArray,
    fit: ModesFit,
    missing: FloatArray | None,
) -> Chance:
    """Return the errors of values that follow some modes, for a steady random run.

    Parameters
    ----------
    smearing : Smearing
        How the values were averaged.
    kind : str
        ``response`` or ``density``.
    frequency : (n_bins,) array
        Of the bins [Hz].
    fit : ModesFit
        The modes.
    missing : (n_bins,) array, optional
        What the coherence says that the input does not explain, over the density of the
        input [-]; of a density none.

    Returns
    -------
    Chance
        Covariance and bias.
    """
    harmonics = smearing.harmonics(fit, float(frequency[-1] - frequency[0]))
    nodes = _nodes(smearing, frequency, fit, harmonics)
    share = np.gradient(nodes)
    distances = frequency[:, np.newaxis] - nodes
    amplitude = smearing(distances)
    here = modelled(kind, nodes, frequency, fit, smearing.rate)
    if kind == "density":
        return _of_density(smearing, frequency, fit, (nodes, share, amplitude, here), harmonics)
    kernel = amplitude**2 * share
    mean = (kernel @ here) / kernel.sum(axis=1)
    off = here - mean[:, np.newaxis]
    leaked = np.sum(kernel * np.abs(off) ** 2, axis=1)
    parts: list[ComplexArray] = [amplitude**2 * np.sqrt(share) * off]
    bias = np.sum(kernel * amplitude**2 * off, axis=1)
    for j in harmonics[1:]:
        shifted = nodes + j * smearing.hop
        there = modelled(kind, shifted, frequency, fit, smearing.rate) - mean[:, np.newaxis]
        weight = amplitude * smearing(distances - j * smearing.hop) * np.sqrt(share)
        bias = bias + np.sum(weight**2 * (off + there), axis=1)
        parts += [
            weight * (off + there) / np.sqrt(2.0),
            1j * weight * (there - off) / np.sqrt(2.0),
        ]
    worth = smearing.norm * smearing.averages
    factor = np.concatenate(parts, axis=1)
    factor = np.concatenate([factor.real, factor.imag])
    noise = _noise(missing, leaked) / (2.0 * smearing.averages)
    pattern = scipy.linalg.toeplitz(smearing.noise_correlation(frequency.size))
    covariance: FloatArray = factor @ factor.T / worth + np.kron(np.eye(2), noise * pattern)
    return Chance(covariance, -bias / worth, frequency.size)


def plain_chance(smearing: Smearing, errors: FloatArray, *, is_complex: bool) -> Chance:
    """Return errors that only the window correlates, from the coherence of a sweep.

    `errors` are in the unit of the values.
    """
    pattern = scipy.linalg.toeplitz(smearing.noise_correlation(errors.size))
    covariance = pattern * errors * errors[:, np.newaxis]
    parts = np.eye(2) if is_complex else np.eye(1)
    every = np.asarray(np.kron(parts, covariance), dtype=np.float64)
    return Chance(every, np.zeros(errors.size), errors.size)


def modelled(
    kind: Kind, nodes: FloatArray, frequency: FloatArray, fit: ModesFit, sample_rate: float
) -> ComplexArray:
    """Return the sum of modes and background at any frequencies before smearing.

    `nodes` and `frequency` are in [Hz], `sample_rate` too.
    """
    n = fit.frequency.size
    result = np.zeros(nodes.shape, dtype=np.complex128)
    turns = 2j * np.pi * nodes / sample_rate
    for k in range(n):
        f, z = float(fit.frequency[k]), float(fit.ratio[k])
        pole = 2.0 * np.pi * f * complex(-z, np.sqrt(1.0 - z * z)) / sample_rate
        direct = 1.0 / (1.0 - np.exp(pole - turns)) - 0.5
        mirrored = (1.0 / (1.0 - np.exp(pole + turns)) - 0.5).conj()
        both, difference = fit.weights[2 * k : 2 * k + 2]
        result += both * (direct + mirrored) + 1j * difference * (direct - mirrored)
    middle, half = (frequency[0] + frequency[-1]) / 2.0, (frequency[-1] - frequency[0]) / 2.0
    place, rest = (nodes - middle) / half, fit.weights[2 * n :]
    if kind == "density":
        return np.asarray(result.real + rest[0] + rest[1] * place, dtype=np.complex128)
    result += complex(rest[0], rest[1]) + complex(rest[2], rest[3]) * place
    return result


def _of_density(
    smearing: Smearing,
    frequency: FloatArray,
    fit: ModesFit,
    grid: tuple[FloatArray, FloatArray, FloatArray, ComplexArray],
    harmonics: range,
) -> Chance:
    """Return the errors of a density, of which its own periodogram scatters."""
    nodes, share, amplitude, here = grid
    least = LEAST_NOISE * float(np.abs(here.real).max())  # poor fits are negative all over
    density = np.sqrt(np.maximum(here.real, least))
    parts = [amplitude**2 * np.sqrt(share) * density**2]
    distances = frequency[:, np.newaxis] - nodes
    for j in harmonics[1:]:
        shifted = modelled("density", nodes + j * smearing.hop, frequency, fit, smearing.rate)
        there = np.sqrt(np.maximum(shifted.real, least))
        weight = amplitude * smearing(distances - j * smearing.hop) * np.sqrt(share)
        parts.append(np.sqrt(2.0) * weight * density * there)
    factor = np.concatenate(parts, axis=1)
    worth = smearing.norm * smearing.averages
    return Chance(factor @ factor.T / worth, np.zeros(frequency.size), frequency.size)


def _nodes(
    smearing: Smearing, frequency: FloatArray, fit: ModesFit, harmonics: range
) -> FloatArray:
    """Return where the integrals are taken: evenly, and closely on modes that are narrow."""
    step = smearing.segment / FINE
    low = frequency[0] - 4.0 * smearing.segment
    high = frequency[-1] + 4.0 * smearing.segment
    parts = [np.arange(low, high, step)]
    places = np.tan(np.linspace(-1.0, 1.0, POINTS) * 0.49 * np.pi)
    for f, z in zip(fit.frequency, fit.ratio, strict=True):
        if 2.0 * f * z < 3.0 * step:
            parts += [f - j * smearing.hop + f * z * places for j in harmonics]
    nodes = np.unique(np.concatenate(parts))
    return np.asarray(nodes[(nodes >= low) & (nodes <= high)], dtype=np.float64)


def _noise(missing: FloatArray | None, leaked: FloatArray) -> float:
    """Return the noise in the missing coherence beside leakage, one level for all bins."""
    if missing is None:
        return 0.0
    least = LEAST_NOISE * float(missing.mean())
    first = max(float(np.mean(missing - leaked)), least)
    trust = (leaked + first) ** -2.0
    return max(float(np.sum(trust * (missing - leaked)) / np.sum(trust)), least)
