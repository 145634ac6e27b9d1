"""One pass over the samples to the full matrix of cross spectra, in bounded memory."""

from collections.abc import Iterable

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra import kernels
from shakerproc.spectra.welch.blocks import in_order
from shakerproc.spectra.welch.cross import CrossSpectra, Detrend
from shakerproc.spectra.welch.windows import effective_averages, window_samples

GROUP_VALUES = 2**17
"""Samples windowed at once, 1 MiB: small enough for the cache, large enough for few calls."""


def cross_spectra(
    blocks: Iterable[FloatArray] | FloatArray,
    sample_rate: float,
    *,
    segment: int = 1024,
    overlap: int | None = None,
    window: str | FloatArray = "hamming",
    n_fft: int | None = None,
    detrend: Detrend = "none",
) -> CrossSpectra:
    r"""Return the cross-spectral matrix by Welch's method, in one pass.

    .. math:: S_{ij} = \frac{2}{K f_s \sum w^2} \sum_k \overline{X_i^{(k)}} X_j^{(k)}

    (not doubled at 0 and at half the sample rate).

    Parameters
    ----------
    blocks : iterable of (n_channels, n) arrays, or one (n_channels, n_samples) array
        The samples in order, in blocks of any size; the result does not depend on the sizes
        [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    segment : int
        Samples of a segment.
    overlap : int, optional
        Samples that a segment shares with the next, by default half of it.
    window : str or (segment,) array
        A name (see `window_samples`; ``hamming`` is MATLAB's symmetric one) or the weights [-].
    n_fft : int, optional
        Length of the FFT, by default `segment`; what is longer is filled with zeros.
    detrend : str
        ``none``; ``mean``, which removes the mean of all samples once; or ``segment mean``,
        which also takes away what the segments hold of slow motion.

    Returns
    -------
    CrossSpectra
        Densities of every pair of channels, with the effective number of averages.

    Raises
    ------
    SpectrumError
        If there are fewer samples than one segment, or a sample is not a number.
    ValueError
        If an option does not fit the others.

    References
    ----------
    .. [1] P. D. Welch, "The use of fast Fourier transform for the estimation of power
       spectra", IEEE Trans. Audio Electroacoustics 15, 1967.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    shared = segment // 2 if overlap is None else overlap
    name, weights = _window(window, segment)
    length = segment if n_fft is None else n_fft
    if not 0 <= shared < segment:
        raise ValueError(f"overlap must be 0 to {segment - 1} samples, not {shared}")
    if length < segment:
        raise ValueError(f"n_fft must be at least the segment of {segment}, not {length}")
    sums = _Sums(weights, segment - shared, length, detrend)
    for block in in_order(blocks):
        sums.add(block)
    products = sums.finish()
    lit = sums.lit_segments()
    matrix = products / (sample_rate * sums.n_segments * float(weights @ weights))
    matrix[..., 1 : (length + 1) // 2] *= 2.0
    return CrossSpectra(
        frequency=scipy.fft.rfftfreq(length, 1.0 / sample_rate),
        matrix=matrix,
        sample_rate=sample_rate,
        n_samples=sums.n_samples,
        segment=segment,
        overlap=shared,
        n_fft=length,
        window_name=name,
        window=weights,
        detrend=detrend,
        n_segments=sums.n_segments,
        lit_segments=lit,
        effective_averages=effective_averages(weights, segment - shared, sums.n_segments),
    )


def _window(window: str | FloatArray, segment: int) -> tuple[str, FloatArray]:
    """Return the name and the weights of a window that fits the segment.

    Raises
    ------
    ValueError
        If it does not fit.
    """
    if segment < 2:
        raise ValueError(f"segment must be at least 2 samples, not {segment}")
    name = window if isinstance(window, str) else "given"
    given = window_samples(window, segment) if isinstance(window, str) else window
    weights = np.array(given, dtype=np.float64)
    if weights.shape != (segment,) or not weights.any():
        raise ValueError(f"window must hold {segment} weights, not all 0")
    return name, weights


class _Sums:
    """Sums over segments, taken in groups whose limits do not depend on the blocks."""

    def __init__(self, window: FloatArray, step: int, n_fft: int, detrend: Detrend) -> None:
        if detrend not in {"none", "mean", "segment mean"}:
            raise ValueError(f"detrend must be none, mean or segment mean, not {detrend!r}")
        self.window, self.step, self.n_fft, self.detrend = window, step, n_fft, detrend
        self.n_samples = 0
        self.n_segments = 0
        self.n_channels = 0
        self.held = 0  # samples in the tail, which begins where the next group does

    def add(self, block: FloatArray) -> None:
        """Take in the next samples, a (n_channels, n) array in row order.

        Raises
        ------
        ValueError
            If the number of channels changes.
        """
        if not self.n_channels:
            self._begin(block.shape[0])
        if block.shape[0] != self.n_channels:
            raise ValueError(f"a block has {block.shape[0]} channels, not {self.n_channels}")
        self.n_samples += block.shape[1]
        used = 0
        while self.held and used < block.shape[1]:
            used += self._hold(block[:, used:])
            if self.held == self.span:
                self._add_group(self.tail, 0, self.group)
                self._drop(self.group * self.step)
                if used >= self.held:  # what the tail holds stands in this block too
                    used -= self.held
                    self.held = 0
        while self.held == 0 and used + self.span <= block.shape[1]:
            self._add_group(block, used, self.group)
            used += self.group * self.step
        self._hold(block[:, used:])

    def _begin(self, n_channels: int) -> None:
        n_frequencies = self.n_fft // 2 + 1
        n_pairs = n_channels * (n_channels + 1) // 2
        self.n_channels = n_channels
        self.group = max(1, GROUP_VALUES // (n_channels * self.n_fft))
        self.span = (self.group - 1) * self.step + self.window.size
        self.tail = np.zeros((n_channels, self.span))
        self.segments = np.zeros((self.group, n_channels, self.n_fft))
        self.real = np.zeros((n_pairs, n_frequencies))
        self.imaginary = np.zeros((n_pairs, n_frequencies))
        self.group_real = np.zeros_like(self.real)
        self.group_imaginary = np.zeros_like(self.real)
        self.spectra = np.zeros((n_channels, 2 * n_frequencies))
        self.fourth = np.zeros((n_channels, n_frequencies))
        self.offset = np.zeros(n_channels)
        self.totals = np.zeros(n_channels)

    def _hold(self, block: FloatArray) -> int:
        """Put what fits of a block into the tail; return how many samples that are."""
        count: int = min(block.shape[1], self.span - self.held)
        self.tail[:, self.held : self.held + count] = block[:, :count]
        self.held += count
        return count

    def _drop(self, count: int) -> None:
        """Forget the first samples of the tail."""
        self.held -= count
        self.tail[:, : self.held] = self.tail[:, count : count + self.held].copy()

    def _add_group(self, samples: FloatArray, first: int, count: int) -> None:
        """Add `count` segments, the first of which starts at sample `first`."""
        segments = self.segments[:count]
        if self.detrend == "segment mean":
            kernels.window_centred_segments(samples, first, self.step, self.window, segments)
        else:
            if self.detrend == "mean":
                self._add_means(samples, first, count * self.step)
            kernels.window_segments(
                samples, first, self.step, self.window, self.offset, segments
            )
        spectra = scipy.fft.rfft(segments).view(np.float64)
        if self.detrend == "mean":
            kernels.add_spectra(spectra, self.spectra)
        self.group_real[:] = 0.0
        self.group_imaginary[:] = 0.0
        kernels.add_products(spectra, self.group_real, self.group_imaginary, self.fourth)
        self.real += self.group_real
        self.imaginary += self.group_imaginary
        self.n_segments += count

    def _add_means(self, samples: FloatArray, first: int, count: int) -> None:
        """Add to the sums of the samples, less the mean of the first segment."""
        if not self.n_segments:
            self.offset = samples[:, first : first + self.window.size].mean(axis=1)
        kernels.add_samples(samples, first, count, self.offset, self.totals)

    def finish(self) -> ComplexArray:
        """Return the sums of conj(X_i) X_j, the last, smaller group included.

        Raises
        ------
        SpectrumError
            If there is no segment, or a sample is not a number.
        """
        if self.held < self.window.size and not self.n_segments:
            raise SpectrumError(
                f"{self.n_samples} samples are fewer than one segment of {self.window.size}: "
                "take a longer crop, or a shorter segment (processing: {welch: {segment: "
                f"{max(8, 1 << max(self.n_samples // 4, 1).bit_length() - 1)}}}}} in the log, "
                "or --segment)"
            )
        count = max(0, (self.held - self.window.size) // self.step + 1)
        if count:
            self._add_group(self.tail, 0, count)
        matrix = self._matrix()
        if self.detrend == "mean":
            rest = count * self.step
            kernels.add_samples(self.tail, rest, self.held - rest, self.offset, self.totals)
            self._remove_means(matrix)
        broken = [i for i in range(self.n_channels) if not np.isfinite(matrix[i, i]).all()]
        if broken:
            raise SpectrumError(
                f"channel {broken[0] + 1} of {self.n_channels} holds samples that are not "
                "numbers: crop them away or leave the channel out"
            )
        return matrix

    def lit_segments(self) -> FloatArray:
        """Return (sum of powers)² over the sum of their squares, for each channel and bin."""
        diagonal = [
            pair for pair, (i, j) in enumerate(zip(*self._pairs(), strict=True)) if i == j
        ]
        total = self.real[diagonal] ** 2
        lit = np.zeros(total.shape)
        np.divide(total, self.fourth, out=lit, where=self.fourth > 0.0)
        return lit

    def _pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return row and column of each pair of channels."""
        return np.triu_indices(self.n_channels)

    def _matrix(self) -> ComplexArray:
        """Return the sums as a full, Hermitian matrix."""
        n = self.n_channels
        row, column = self._pairs()
        matrix = np.empty((n, n, self.real.shape[1]), dtype=np.complex128)
        with np.errstate(invalid="ignore"):  # samples that are NaN are refused later
            matrix[row, column] = self.real + 1j * self.imaginary
        matrix[column, row] = matrix[row, column].conj()
        matrix[np.arange(n), np.arange(n)] = matrix[np.arange(n), np.arange(n)].real
        return matrix

    def _remove_means(self, matrix: ComplexArray) -> None:
        """Take the means of all samples out of the sums, in the frequency domain."""
        means = self.totals / self.n_samples
        shape = scipy.fft.rfft(self.window, self.n_fft)
        spectra = self.spectra.view(np.complex128)
        constant = means[:, np.newaxis] * shape
        cross = constant.conj()[:, np.newaxis] * spectra[np.newaxis]
        matrix -= cross + cross.conj().swapaxes(0, 1)
        matrix += self.n_segments * constant.conj()[:, np.newaxis] * constant[np.newaxis]
