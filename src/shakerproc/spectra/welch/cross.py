"""The cross spectra of a recording, their densities, and their degrees of freedom."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray

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
