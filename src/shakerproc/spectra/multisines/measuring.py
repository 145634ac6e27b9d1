"""Best linear approximation, noise and distortion of every line of a multisine."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.multisines.lines import Grid


@final
@dataclass(frozen=True, slots=True, eq=False)
class LineSpectra:
    r"""What one response does at every line of a multisine.

    Amplitudes are those of sines, zero to peak, root mean squares over the realisations;
    deviations are those of the mean over the periods of one realisation. What a line holds
    without being excited is corrected by :math:`\hat G U`: an input that is not quite clean
    counts as input.

    Attributes
    ----------
    grid : Grid
        The lines.
    input : (n_lines,) array
        Amplitude of the input; between excited lines that of its neighbours.
    function : (n_lines,) array
        Best linear approximation of response over input; between excited lines that of its
        neighbours.
    level : (n_lines,) array
        Amplitude of the response; where nothing is excited, of its distortion and noise.
    noise : (n_lines,) array
        Deviation of the response that does not repeat; NaN of one period.
    scatter : (n_lines,) array
        Deviation of the response over realisations at excited lines, as the deviation of the
        function times the input: all distortion that depends on the phases, and noise; NaN
        elsewhere and of one realisation.
    realisations, periods : int
        What they are averages of.
    """

    grid: Grid
    input: FloatArray
    function: ComplexArray
    level: FloatArray
    noise: FloatArray
    scatter: FloatArray
    realisations: int
    periods: int

    @property
    def noise_share(self) -> float | None:
        """Noise over the response, root mean squares over the band [-]; None if not known."""
        if self.periods == 1:
            return None
        whole = np.mean(self.level[self.grid.excited] ** 2)
        return float(np.sqrt(np.mean(self.noise**2) / whole))


def line_spectra(driving: ComplexArray, response: ComplexArray, grid: Grid) -> LineSpectra:
    r"""Return what a response does at every line.

    .. math:: \hat G = \frac{1}{M} \sum_m \frac{\bar Y_m}{\bar U_m}, \qquad
              \hat\sigma^2_n = \frac{1}{M P (P - 1)} \sum_{m,p}
              |Y_{mp} - \hat G_m U_{mp} - \text{mean}_p|^2

    Parameters
    ----------
    driving, response : (n_realisations, n_periods, n_lines) array
        Complex amplitudes of the lines of `grid` in every period, in any unit.
    grid : Grid
        The lines.

    References
    ----------
    .. [1] R. Pintelon and J. Schoukens, "System Identification: A Frequency Domain Approach",
       2nd ed., Wiley, 2012, ch. 4.3 (fast and robust method).
    """
    n_realisations, n_periods, _ = response.shape
    excited = np.flatnonzero(grid.excited)
    u, y = driving.mean(axis=1), response.mean(axis=1)
    each = y[:, excited] / u[:, excited]
    size = np.sqrt(np.mean(np.abs(u[:, excited]) ** 2, axis=0))
    positions = np.arange(grid.number.size)
    functions = np.array([_between(positions, excited, one) for one in each])
    amplitude = np.interp(positions, excited, size)
    rest = response - functions[:, np.newaxis] * driving
    left = np.where(grid.excited, y, rest.mean(axis=1))
    missing = np.full(grid.number.size, np.nan)
    noise, scatter = missing, missing.copy()
    if n_periods > 1:
        power = np.var(rest, axis=1, ddof=1).mean(axis=0) / n_periods
        noise = np.sqrt(power)
    if n_realisations > 1:
        scatter[excited] = size * np.std(each, axis=0, ddof=1)
    return LineSpectra(
        grid,
        amplitude,
        functions.mean(axis=0),
        np.sqrt(np.mean(np.abs(left) ** 2, axis=0)),
        noise,
        scatter,
        n_realisations,
        n_periods,
    )


def _between(
    positions: NDArray[np.int_],
    known: NDArray[np.int_],
    values: ComplexArray,
) -> ComplexArray:
    """Return complex values at all positions, straight between those that are known."""
    real = np.interp(positions, known, values.real)
    result: ComplexArray = real + 1j * np.interp(positions, known, values.imag)
    return result
