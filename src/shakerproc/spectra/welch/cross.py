"""The cross spectra of a recording, their degrees of freedom, and the levels of a density."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.numerals import numeral

Detrend: TypeAlias = Literal["none", "mean", "segment mean"]


@final
@dataclass(frozen=True, slots=True, eq=False)
class CrossSpectra:
    """One-sided cross-spectral densities of inputs with every channel.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Middle of each bin, from 0 to half the sample rate [Hz].
    matrix : (n_inputs, n_channels, n_frequencies) complex array
        Mean of conj(X_i) X_j over the segments [unit_i unit_j/Hz].
    inputs : tuple of int
        Rows of the channels that are the rows of `matrix`, rising; all where every pair is
        kept.
    density : (n_channels, n_frequencies) array
        Mean of |X_j|² over the segments [unit²/Hz].
    sample_rate : float
        Samples per second [Hz].
    n_samples : int
        Samples of the crop, those after the last whole segment included.
    segment, overlap, n_fft : int
        Samples of a segment, samples it shares with the next, and length of the FFT.
    window_name : str
        Name of the window, or ``given``.
    window : (segment,) array
        Weights [-].
    detrend : str
        ``none``, ``mean`` (of the whole crop, once) or ``segment mean``.
    n_segments : int
        Segments averaged.
    effective_averages : float
        Independent segments that would give the same variance.
    lit_segments : (n_channels, n_frequencies) array
        How many segments of equal power would vary as these do: all for a steady tone, half
        of them for random vibration, few for a sweep that passes quickly.
    decay_rate : float, optional
        Where every segment holds a whole free decay, as after a blow: by how much its window
        makes all motion decay faster [1/s]; None where segments are cut from steady motion.
    """

    frequency: FloatArray
    matrix: ComplexArray
    inputs: tuple[int, ...]
    density: FloatArray
    sample_rate: float
    n_samples: int
    segment: int
    overlap: int
    n_fft: int
    window_name: str
    window: FloatArray
    detrend: Detrend
    n_segments: int
    effective_averages: float
    lit_segments: FloatArray
    decay_rate: float | None = None

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return len(self.density)

    def between(self, inputs: Sequence[int], outputs: Sequence[int]) -> ComplexArray:
        """Return the cross spectra of some inputs with some channels.

        Parameters
        ----------
        inputs, outputs : sequence of int
            Rows of channels, from 0.

        Returns
        -------
        (n_inputs, n_outputs, n_frequencies) complex array
            Mean of conj(X_i) X_j [unit_i unit_j/Hz].

        Raises
        ------
        ValueError
            If the spectra of an input are not kept.
        """
        missing = sorted(set(inputs) - set(self.inputs))
        if missing:
            raise ValueError(
                f"row {missing[0]} is no input of these spectra, {self.inputs or 'none'} are: "
                "give the channel the role control or force, or name it in response_functions"
            )
        rows = [self.inputs.index(i) for i in inputs]
        return np.asarray(self.matrix[np.ix_(rows, list(outputs))])

    def of(self, channels: Sequence[int]) -> "CrossSpectra":
        """Return the spectra of every pair of some channels, in their order."""
        rows = list(channels)
        return replace(
            self,
            matrix=self.between(rows, rows),
            inputs=tuple(range(len(rows))),
            density=self.density[rows],
            lit_segments=self.lit_segments[rows],
        )

    @property
    def bin_width(self) -> float:
        """Distance of the frequencies [Hz]."""
        return self.sample_rate / self.n_fft

    @property
    def resolution(self) -> float:
        """Width of a white band that passes as much power as the window [Hz]."""
        return (
            self.sample_rate
            * float(self.window @ self.window)
            / float(np.sum(self.window)) ** 2
        )

    def added_damping(self, frequency: float) -> float:
        """Return the damping ratio that the window adds to a decay of that frequency [-]."""
        return (self.decay_rate or 0.0) / (2.0 * np.pi * frequency)

    @property
    def degrees_of_freedom(self) -> float:
        """Degrees of freedom of each PSD value, twice the effective averages."""
        return 2.0 * self.effective_averages


def psd(spectra: CrossSpectra) -> FloatArray:
    """Return the power spectral density of every channel.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.

    Returns
    -------
    (n_channels, n_frequencies) array
        One-sided densities [unit²/Hz].
    """
    return spectra.density.copy()


IMBALANCE: Final = 0.1
"""Relative difference of the control motions that deserves a warning [-] (trap 19)."""

AUDIBLE: Final = 0.01
"""Share of the mean control density below which a bin is not judged [-]."""


def shares_in_band(spectra: CrossSpectra, band: tuple[float, float] | None) -> FloatArray:
    """Return how much of each bin lies in a band.

    A bin reaches half a bin width to both sides of its frequency, at 0 and at half the sample
    rate to one side only.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything.

    Returns
    -------
    (n_frequencies,) array
        Shares, 0 to 1 [-].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    if band is None:
        return np.ones(spectra.frequency.size)
    if not band[0] < band[1]:
        raise ValueError(f"the band must rise, not run from {band[0]:g} to {band[1]:g} Hz")
    half = spectra.bin_width / 2.0
    low = np.maximum(spectra.frequency - half, 0.0)
    high = np.minimum(spectra.frequency + half, spectra.sample_rate / 2.0)
    inside = np.minimum(high, band[1]) - np.maximum(low, band[0])
    return np.array(np.maximum(inside, 0.0) / (high - low))


def rms_in_band(spectra: CrossSpectra, band: tuple[float, float] | None = None) -> FloatArray:
    r"""Return the root mean square of each channel in a band; of accelerations, the Grms.

    .. math:: \sqrt{\sum_k S_k \Delta f}

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything from 0, the mean included.

    Returns
    -------
    (n_channels,) array
        Root mean squares [unit].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    return cumulative_rms(spectra, band)[:, -1]


def cumulative_rms(
    spectra: CrossSpectra, band: tuple[float, float] | None = None
) -> FloatArray:
    """Return the root mean square of each channel from the lower limit up to each frequency.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    band : (float, float), optional
        Lower and upper limit [Hz]; by default everything from 0, the mean included.

    Returns
    -------
    (n_channels, n_frequencies) array
        Root mean squares up to the upper end of each bin [unit].

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    power = psd(spectra) * shares_in_band(spectra, band) * spectra.bin_width
    return np.array(np.sqrt(np.cumsum(power, axis=1)))


@final
@dataclass(frozen=True, slots=True)
class Imbalance:
    """How far control channels, which should move as one, differ.

    Attributes
    ----------
    overall : float
        Rms difference of two controls over the rms of their mean, in the band [-].
    worst : float
        The same at the frequency where it is largest [-].
    worst_frequency : float
        That frequency [Hz].
    warning : str, optional
        A sentence, where the larger of the two exceeds 10 %.
    """

    overall: float
    worst: float
    worst_frequency: float
    warning: str | None


def control_imbalance(
    spectra: CrossSpectra, controls: Sequence[int], band: tuple[float, float]
) -> Imbalance | None:
    r"""Return how far the controls differ within a band.

    .. math:: \sqrt{\frac{2}{n - 1} \sum_i S_{d_i d_i} \Big/ S_{mm}}, \quad d_i = x_i - m

    with the mean control :math:`m`; of two controls it is the rms of their difference.
    The worst frequency is sought in bins where the controls have at least 1 % of their mean
    density, averaged over three bins.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    controls : sequence of int
        Rows of the control channels, from 0.
    band : (float, float)
        Excited band [Hz].

    Returns
    -------
    Imbalance or None
        None where there is but one control, or no power in the band.

    Raises
    ------
    ValueError
        If the band does not rise.
    """
    inputs = list(controls)
    inside = shares_in_band(spectra, band) > 0.5
    if len(inputs) < 2 or not inside.any():
        return None
    matrix = spectra.between(inputs, inputs)[..., inside]
    mean = matrix.mean(axis=(0, 1)).real
    power = np.einsum("iif->f", matrix).real / len(inputs)
    if not power.any() or not mean.any():
        return None
    scatter = 2.0 * len(inputs) / (len(inputs) - 1.0) * np.maximum(power - mean, 0.0)
    overall = float(np.sqrt(scatter.sum() / mean.sum()))
    smooth_apart, smooth_mean = _smooth(scatter), _smooth(mean)
    judged = (smooth_mean > 0.0) & (power >= AUDIBLE * np.mean(power))
    ratio = np.zeros(power.size)
    np.divide(smooth_apart, smooth_mean, out=ratio, where=judged)
    where = int(np.argmax(ratio))
    worst = float(np.sqrt(ratio[where]))
    frequency = float(spectra.frequency[inside][where])
    return Imbalance(overall, worst, frequency, _warning(overall, worst, frequency))


def _smooth(values: FloatArray) -> FloatArray:
    """Return the sums over three neighbours, the ends repeated."""
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.array(padded[:-2] + padded[1:-1] + padded[2:])


def _warning(overall: float, worst: float, frequency: float) -> str | None:
    """Return the warning of controls that differ by more than 10 %."""
    if max(overall, worst) <= IMBALANCE:
        return None
    return (
        f"the controls differ by {overall:.0%} of their mean overall and by {worst:.0%} at "
        f"{numeral(frequency, 4)} Hz: response functions against the mean control are "
        "doubtful there"
    )
