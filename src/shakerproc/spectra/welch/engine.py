"""One pass over the samples to the cross spectra of channels, in bounded memory."""

from collections.abc import Iterable, Sequence

import numpy as np

from shakerproc import checks
from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.spectra.welch.blocks import in_order
from shakerproc.spectra.welch.cross import CrossSpectra, Detrend
from shakerproc.spectra.welch.windows import effective_averages, window_samples

GROUP_VALUES = 2**17
"""Samples windowed at once, 1 MiB: small enough for the cache, large enough for few calls."""

COMPILED_AFTER = 2**25
"""Values transformed before compiled loops take over from numpy: 10 minutes of 5 channels.

Numpy takes twice as long, but the compiler half a second to load. What was loaded before does
not count: the same samples give the same bits in every process.
"""


def cross_spectra(
    blocks: Iterable[FloatArray] | FloatArray,
    sample_rate: float,
    *,
    segment: int = 1024,
    overlap: int | None = None,
    window: str | FloatArray = "hamming",
    n_fft: int | None = None,
    detrend: Detrend = "none",
    inputs: Sequence[int] | None = None,
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
    inputs : sequence of int, optional
        Rows of the channels whose spectra with every other are wanted, from 0; by default all,
        which takes memory and time that grow with the square of the number of channels.

    Returns
    -------
    CrossSpectra
        Densities of every channel, and of each input with every channel, with the effective
        number of averages.

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
    sums = _Sums(weights, segment - shared, length, detrend, inputs)
    for block in in_order(blocks):
        sums.add(block)
    matrix, density = sums.finish()
    scale = sample_rate * sums.n_segments * float(weights @ weights)
    for accumulated in (matrix, density):  # in place: of all pairs of many channels it is large
        np.divide(accumulated, scale, out=accumulated)
        accumulated[..., 1 : (length + 1) // 2] *= 2.0
    return CrossSpectra(
        frequency=np.array(np.fft.rfftfreq(length, 1.0 / sample_rate), dtype=np.float64),
        matrix=matrix,
        inputs=sums.inputs,
        density=density,
        sample_rate=sample_rate,
        n_samples=sums.n_samples,
        segment=segment,
        overlap=shared,
        n_fft=length,
        window_name=name,
        window=weights,
        detrend=detrend,
        n_segments=sums.n_segments,
        lit_segments=sums.lit_segments(),
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
    """Sums over segments, taken in groups whose limits do not depend on the blocks.

    Inside, the inputs stand first: `order` has the row of each channel in the blocks.
    """

    def __init__(
        self,
        window: FloatArray,
        step: int,
        n_fft: int,
        detrend: Detrend,
        inputs: Sequence[int] | None,
    ) -> None:
        if detrend not in {"none", "mean", "segment mean"}:
            raise ValueError(f"detrend must be none, mean or segment mean, not {detrend!r}")
        self.window, self.step, self.n_fft, self.detrend = window, step, n_fft, detrend
        self.wanted = inputs
        self.inputs: tuple[int, ...] = ()
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
        if self.order != sorted(self.order):
            block = block[self.order]
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
        self.n_channels = n_channels
        every = range(n_channels)
        self.inputs = tuple(every if self.wanted is None else sorted(set(self.wanted)))
        if not set(self.inputs) <= set(every):
            raise ValueError(f"inputs must be rows 0 to {n_channels - 1}, not {self.inputs}")
        self.order = [*self.inputs, *(i for i in every if i not in set(self.inputs))]
        self.group = max(1, GROUP_VALUES // (n_channels * self.n_fft))
        self.span = (self.group - 1) * self.step + self.window.size
        self.tail = np.zeros((n_channels, self.span))
        self.segments = np.zeros((self.group, n_channels, self.n_fft))
        shape = (n_channels, n_frequencies)
        self.products = np.zeros((len(self.inputs), *shape), dtype=np.complex128)
        self.powers = np.zeros(shape)
        self.transformed = np.zeros((self.group, *shape), dtype=np.complex128)
        self.conjugates = np.zeros_like(self.transformed)
        self.pairs = np.zeros_like(self.transformed)
        self.spectra = np.zeros(shape, dtype=np.complex128)
        self.fourth = np.zeros((n_channels, n_frequencies))
        self.offset = np.zeros(n_channels)
        self.totals = np.zeros(n_channels)

    def _hold(self, block: FloatArray) -> int:
        """Fill the tail from a block; return the number of samples taken."""
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
        if self.detrend == "mean":
            self._add_means(samples, first, count * self.step)
        if self.n_segments * self.n_channels * self.n_fft < COMPILED_AFTER:
            self._fill_segments(samples, first, count)
            spectra = self._transform(count)
            with np.errstate(invalid="ignore"):  # samples that are no numbers: refused later
                self._multiply(spectra)
        else:
            self._fill_segments_compiled(samples, first, count)
            spectra = self._transform(count)
            self._multiply_compiled(spectra)
        if self.detrend == "mean":
            self.spectra += spectra.sum(axis=0)
        self.n_segments += count

    def _transform(self, count: int) -> ComplexArray:
        """Return the spectra of the windowed segments, (count, n_channels, n_frequencies)."""
        return np.fft.rfft(self.segments[:count], out=self.transformed[:count])

    def _fill_segments(self, samples: FloatArray, first: int, count: int) -> None:
        """Put windowed segments where they are transformed."""
        length = self.window.size
        span = samples[:, first : first + (count - 1) * self.step + length]
        if self.detrend == "mean":
            span = span - self.offset[:, np.newaxis]
        overlapping = np.lib.stride_tricks.sliding_window_view(span, length, axis=1)
        pieces = overlapping[:, :: self.step].swapaxes(0, 1)
        target = self.segments[:count, :, :length]
        if self.detrend == "segment mean":
            np.subtract(pieces, pieces.mean(axis=-1, keepdims=True), out=target)
            pieces = target
        np.multiply(pieces, self.window, out=target)

    def _fill_segments_compiled(self, samples: FloatArray, first: int, count: int) -> None:
        """Fill the windowed segments in compiled code, where no mean is taken away."""
        if self.detrend == "segment mean":
            self._fill_segments(samples, first, count)
            return
        from shakerproc.spectra.kernels import window_segments  # loads the compiler: late

        segments = self.segments[:count]
        window_segments(samples, first, self.step, self.window, self.offset, segments)

    def _multiply(self, spectra: ComplexArray) -> None:
        """Add the products of inputs with later channels, and the powers of all channels."""
        count = len(spectra)
        conjugates = np.conjugate(spectra, out=self.conjugates[:count])
        for i in range(self.n_channels):
            stop = self.n_channels if i < len(self.inputs) else i + 1
            pairs = self.pairs[:count, i:stop]
            np.multiply(conjugates[:, i : i + 1], spectra[:, i:stop], out=pairs)
            if i < len(self.inputs):
                self.products[i, i:] += np.add.reduce(pairs, axis=0)
            power = pairs[:, 0].real
            self.powers[i] += np.add.reduce(power, axis=0)
            self.fourth[i] += np.einsum("sf,sf->f", power, power)

    def _multiply_compiled(self, spectra: ComplexArray) -> None:
        """Add products and powers of the spectra in compiled code."""
        from shakerproc.spectra.kernels import add_products  # loads the compiler: late

        real, imaginary = np.zeros((2, *self.products.shape))
        powers = np.zeros(self.powers.shape)
        add_products(spectra.view(np.float64), real, imaginary, powers, self.fourth)
        self.powers += powers
        self.products.real += real
        self.products.imag += imaginary

    def _add_means(self, samples: FloatArray, first: int, count: int) -> None:
        """Add to the sums of the samples, less the mean of the first segment."""
        if not self.n_segments:
            self.offset = samples[:, first : first + self.window.size].mean(axis=1)
        part = samples[:, first : first + count]
        self.totals += np.sum(part - self.offset[:, np.newaxis], axis=1)

    def finish(self) -> tuple[ComplexArray, FloatArray]:
        """Return the sums of conj(X_i) X_j and |X_j|², the last, smaller group included.

        The first are (n_inputs, n_channels, n_frequencies), Hermitian among the inputs to the
        last bit.

        Raises
        ------
        SpectrumError
            If there is no segment, or a sample is not a number.
        """
        if self.held < self.window.size and not self.n_segments:
            raise SpectrumError(
                f"{self.n_samples} samples are fewer than one segment of {self.window.size}. "
                "Take a longer crop, or a shorter segment (processing: {welch: {segment: "
                f"{max(8, 1 << max(self.n_samples // 4, 1).bit_length() - 1)}}}}} in the log, "
                "or --segment)"
            )
        count = max(0, (self.held - self.window.size) // self.step + 1)
        if count:
            self._add_group(self.tail, 0, count)
        powers = self.powers.copy()
        if self.detrend == "mean":
            rest = count * self.step
            self._add_means(self.tail, rest, self.held - rest)
            self._remove_means(powers)
        place = np.argsort(self.order)
        powers = powers[place]
        broken = np.flatnonzero(~np.isfinite(powers).all(axis=-1))
        if broken.size:
            raise SpectrumError(
                f"channel {broken[0] + 1} of {self.n_channels} holds samples that are not "
                "numbers: crop them away or leave the channel out"
            )
        self._mirror()
        matrix = self.products if np.all(np.diff(place) > 0) else self.products[:, place]
        rows = list(self.inputs)
        matrix[range(len(rows)), rows] = powers[rows]
        return matrix, powers

    def lit_segments(self) -> FloatArray:
        """Return (sum of powers)² over the sum of their squares, for each channel and bin."""
        lit = np.zeros(self.powers.shape)
        np.divide(self.powers**2, self.fourth, out=lit, where=self.fourth > 0.0)
        return lit[np.argsort(self.order)]

    def _mirror(self) -> None:
        """Fill in the sums of pairs of inputs j > i from those of i < j."""
        for i in range(1, len(self.inputs)):
            self.products[i, :i] = self.products[:i, i].conj()

    def _remove_means(self, powers: FloatArray) -> None:
        """Take the means of all samples out of the sums, in the frequency domain."""
        means = self.totals / self.n_samples
        shape = np.fft.rfft(self.window, self.n_fft)
        constant = means[:, np.newaxis] * shape
        corrected = self.spectra - 0.5 * self.n_segments * constant
        powers -= 2.0 * (constant.conj() * corrected).real
        for i in range(len(self.inputs)):
            self.products[i] -= constant[i].conj() * corrected + corrected[i].conj() * constant
