"""What is fitted: spectra of inputs and responses at the lines of a band."""

from dataclasses import dataclass
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


@final
@dataclass(frozen=True, slots=True, eq=False)
class Lines:
    """Spectra at the lines of a band; outputs are a linear system's answer to the inputs.

    Attributes
    ----------
    frequency : (n_lines,) array
        Rising, above 0 [Hz].
    inputs : (n_inputs, n_lines) complex array
        Discrete Fourier transforms of the inputs; ones where `outputs` are response functions.
    outputs : (n_outputs, n_lines) complex array
        Discrete Fourier transforms of the responses, or response functions.
    interval : float
        Sample interval [s].
    transient : bool
        Whether the outputs hold the free decay of what was before and the end of the record.
    weight : (n_lines,) array, optional
        Of each line in the fit: small where the noise of all outputs is large [-].
    """

    frequency: FloatArray
    inputs: ComplexArray
    outputs: ComplexArray
    interval: float
    transient: bool = True
    weight: FloatArray | None = None

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
    return Lines(
        frequency[kept],
        driven[:, kept],
        scipy.fft.rfft(outputs)[:, kept],
        1.0 / sample_rate,
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
