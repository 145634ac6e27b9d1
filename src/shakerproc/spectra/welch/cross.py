"""The full matrix of cross spectra of a recording, and what it is worth statistically."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray

Detrend: TypeAlias = Literal["none", "mean", "segment mean"]


@final
@dataclass(frozen=True, slots=True, eq=False)
class CrossSpectra:
    """One-sided cross-spectral densities of every pair of channels.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Middle of each bin, from 0 to half the sample rate [Hz].
    matrix : (n_channels, n_channels, n_frequencies) complex array
        Mean of conj(X_i) X_j over the segments [unit_i unit_j/Hz].
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
        return int(self.matrix.shape[0])

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
        """Return what the window adds to the damping ratio of a decay of that frequency [-]."""
        return (self.decay_rate or 0.0) / (2.0 * np.pi * frequency)

    @property
    def degrees_of_freedom(self) -> float:
        """Degrees of freedom of each PSD value, twice the effective averages."""
        return 2.0 * self.effective_averages
