"""Spectra of inputs and responses at the lines of a band, to be fitted."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray

NEIGHBOURS: Final = 20
"""Lines to either side that a line's input is compared with."""

SILENT: Final = 1e-5
"""Share of the largest power below which the input does not reach [-]."""

EMPTY: Final = 1e-2
"""Share of the power of the strongest neighbour below which a line has no input [-]."""

MOST_LINES: Final = 12_000
"""Lines that the likelihood is computed on at once."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Spectra at the lines of a band; outputs are a linear system's answer to the inputs.

    Attributes
    ----------
    frequency : (n_lines,) array
        Rising, above 0 [Hz].
    inputs : (n_inputs, n_lines) complex array
        Discrete Fourier transforms of the inputs over the root of the number of samples; ones
        where `outputs` are response functions.
    outputs : (n_outputs, n_lines) complex array
        Discrete Fourier transforms of the responses, likewise, or response functions.
    interval : float
        Sample interval [s].
    transient : bool
        Whether the outputs hold the free decay of what was before and the end of the record.
    weight : (n_lines,) array, optional
        Of each line in the fit: small where the noise of all outputs is large [-].
    record : (n_lines,) array of int, optional
        Number of the record that a line is of, from 0; all of one where it is not given.
    """

    frequency: FloatArray
    inputs: ComplexArray
    outputs: ComplexArray
    interval: float
    transient: bool = True
    weight: FloatArray | None = None
    record: NDArray[np.intp] | None = None

    @property
    def records(self) -> NDArray[np.bool_]:
        """Which lines are of each record, (n_records, n_lines)."""
        if self.record is None:
            return np.ones((1, self.frequency.size), dtype=bool)
        return np.asarray(self.record == np.arange(int(self.record.max()) + 1)[:, np.newaxis])

    @property
    def n_transients(self) -> int:
        """Number of transients: one of each record, none of response functions."""
        return len(self.records) if self.transient else 0

    @property
    def weights(self) -> FloatArray:
        """Weight of each line, 1 where none are given [-]."""
        return np.ones(self.frequency.size) if self.weight is None else self.weight


def lines_of_samples(
    inputs: FloatArray, outputs: FloatArray, sample_rate: float, band: tuple[float, float]
) -> Lines:
    """Return the spectra of a whole record in a band, without a window.

    The leakage of a record without window is a free decay of the same modes, which the fit
    takes up exactly: no resolution and no damping is lost to a window or to short segments.

    Parameters
    ----------
    inputs : (n_inputs, n_samples) array
        Forces or base motions [unit of the channel].
    outputs : (n_outputs, n_samples) array
        Responses [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    band : (float, float)
        Limits [Hz].

    Returns
    -------
    Lines
        With a transient.

    Raises
    ------
    ValueError
        If the band holds fewer than 8 lines.

    References
    ----------
    .. [1] R. Pintelon and J. Schoukens, "System Identification: A Frequency Domain Approach",
       2nd ed., Wiley, 2012, ch. 6.
    """
    n = inputs.shape[1]
    frequency = scipy.fft.rfftfreq(n, 1.0 / sample_rate)
    kept = (frequency >= band[0]) & (frequency <= band[1]) & (frequency > 0.0)
    if kept.sum() < 8:
        raise ValueError(
            f"the band from {band[0]:g} to {band[1]:g} Hz holds {kept.sum()} lines"
        )
    driven = scipy.fft.rfft(inputs)
    kept[kept] = excited_lines(driven[:, kept])
    even = 1.0 / np.sqrt(n)  # the noise of records of any length is the same
    return Lines(
        frequency[kept],
        even * driven[:, kept],
        even * scipy.fft.rfft(outputs)[:, kept],
        1.0 / sample_rate,
    )


def joined(parts: Sequence[Lines]) -> Lines:
    """Return the lines of several records of one structure as one, by frequency.

    Parameters
    ----------
    parts : sequence of Lines
        Spectra of records with the same inputs and outputs, 0 where an input does not act.

    Returns
    -------
    Lines
        Each record with a transient of its own.
    """
    if len(parts) == 1:
        return parts[0]
    record = np.repeat(np.arange(len(parts)), [part.frequency.size for part in parts])
    frequency = np.concatenate([part.frequency for part in parts])
    order = np.argsort(frequency, kind="stable")
    return Lines(
        frequency[order],
        np.concatenate([part.inputs for part in parts], axis=1)[:, order],
        np.concatenate([part.outputs for part in parts], axis=1)[:, order],
        parts[0].interval,
        record=record[order],
    )


def lines_subset(lines: Lines, kept: slice | NDArray[np.bool_]) -> Lines:
    """Return some of the lines."""
    return replace(
        lines,
        frequency=lines.frequency[kept],
        inputs=lines.inputs[:, kept],
        outputs=lines.outputs[:, kept],
        weight=None if lines.weight is None else lines.weight[kept],
        record=None if lines.record is None else lines.record[kept],
    )


def thinned(lines: Lines, most: int = MOST_LINES) -> Lines:
    """Return every n-th line where there are more than `most`, which the likelihood takes."""
    every = -(-lines.frequency.size // most)
    if every == 1:
        return lines
    kept = np.zeros(lines.frequency.size, dtype=bool)
    for record in lines.records:
        kept[np.flatnonzero(record)[::every]] = True
    return lines_subset(lines, kept)


def thinning_note(lines: Lines, thin: Lines) -> str:
    """Return a sentence on how many lines are left."""
    return (
        f"refined on {thin.frequency.size} of {lines.frequency.size} lines of the record "
        "(evenly spread); a narrower band uses more of them"
    )


def excited_lines(inputs: ComplexArray) -> NDArray[np.bool_]:
    """Return which lines have an input: a periodic one leaves those between its lines empty.

    Parameters
    ----------
    inputs : (n_inputs, n_lines) complex array
        Spectra of the inputs [unit of the channel s].

    Returns
    -------
    (n_lines,) array of bool
        Those that the input reaches; of a periodic input only its own.
    """
    power = np.sum(np.abs(inputs) ** 2, axis=0)
    around = scipy.ndimage.maximum_filter1d(power, 2 * NEIGHBOURS + 1, mode="nearest")
    driven = around > SILENT * power.max()
    lit = driven & (power > EMPTY * around)
    return np.asarray(lit if lit.sum() < driven.sum() // 2 else driven)


def lines_of_functions(frequency: FloatArray, functions: ComplexArray) -> Lines:
    """Return response functions as lines to fit.

    Parameters
    ----------
    frequency : (n_lines,) array
        Lines of the band [Hz].
    functions : (n_responses, n_inputs, n_lines) complex array
        Response functions [response unit/input unit].

    Returns
    -------
    Lines
        Without a transient; outputs run over responses, then inputs.
    """
    flat = functions.reshape(-1, functions.shape[-1])
    ones = np.ones((1, frequency.size), dtype=np.complex128)
    return Lines(frequency, ones, flat, 0.5 / float(frequency[-1]), transient=False)
