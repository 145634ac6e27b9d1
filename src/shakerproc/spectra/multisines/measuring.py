"""Best linear approximation, noise and distortion of every line of a multisine."""

from dataclasses import dataclass
from typing import TypeVar, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.multisines.lines import Grid


@final
@dataclass(frozen=True, slots=True, eq=False)
class LineSpectra:
    r"""Response at every line of a multisine.

    Amplitudes are those of sines, zero to peak, root mean squares over the realisations;
    deviations are those of the mean over the periods of one realisation. What a line holds
    without being excited is corrected by :math:`\hat G U`: an input that is not quite clean
    counts as input. Each line is averaged over those realisations in which it is excited, or
    is not: their numbers are `grid.carried` and the rest.

    Attributes
    ----------
    grid : Grid
        The lines.
    input : (n_lines,) array
        Amplitude of the input where it is excited; between excited lines that of its
        neighbours.
    function : (n_lines,) array
        Best linear approximation of response over input; between excited lines that of its
        neighbours.
    level : (n_lines,) array
        Amplitude of the response where it is excited; NaN elsewhere.
    distortion : (n_lines,) array
        Amplitude of distortion and noise where nothing is excited; NaN at a line that every
        realisation excites.
    noise : (n_lines,) array
        Deviation of the response that does not repeat; NaN of one period.
    scatter : (n_lines,) array
        Deviation of the response over realisations at excited lines, as the deviation of the
        function times the input: all distortion that depends on the phases, and noise; NaN
        where fewer than two realisations excite a line.
    periods : int
        Periods of each realisation.
    """

    grid: Grid
    input: FloatArray
    function: ComplexArray
    level: FloatArray
    distortion: FloatArray
    noise: FloatArray
    scatter: FloatArray
    periods: int

    @property
    def realisations(self) -> int:
        """How many there are."""
        return len(self.grid.excited_in)

    @property
    def response_power(self) -> float:
        """Mean square amplitude of the response over all excited lines [unit squared]."""
        some = self.grid.excited
        return float(np.average(self.level[some] ** 2, weights=self.grid.carried[some]))

    @property
    def noise_share(self) -> float | None:
        """Noise over the response, root mean squares over the band [-]; None if not known."""
        if self.periods == 1:
            return None
        return float(np.sqrt(np.mean(self.noise**2) / self.response_power))


def line_spectra(driving: ComplexArray, response: ComplexArray, grid: Grid) -> LineSpectra:
    r"""Return the response at every line.

    .. math:: \hat G = \frac{1}{M} \sum_m \frac{\bar Y_m}{\bar U_m}, \qquad
              \hat\sigma^2_n = \frac{1}{R P (P - 1)} \sum_{m,p}
              |Y_{mp} - \hat G_m U_{mp} - \text{mean}_p|^2

    over those :math:`M` of the :math:`R` realisations that excite the line.

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
    .. [2] J. Schoukens, M. Vaes and R. Pintelon, "Linear System Identification in a Nonlinear
       Setting", IEEE Control Systems Magazine 36(3), 38-69, 2016.
    """
    n_periods = response.shape[1]
    active, some = grid.excited_in, np.flatnonzero(grid.excited)
    u, y = driving.mean(axis=1), response.mean(axis=1)
    each = np.divide(y, u, out=np.zeros_like(y), where=active)
    function = _mean_where(each, active)
    size = np.sqrt(_mean_where(np.abs(u) ** 2, active))
    positions = np.arange(grid.number.size)
    between = _between(positions, some, function[some])
    rest = response - np.where(active, each, between)[:, np.newaxis] * driving
    missing = np.full(grid.number.size, np.nan)
    noise, scatter = missing, missing.copy()
    if n_periods > 1:
        power = np.var(rest, axis=1, ddof=1).mean(axis=0) / n_periods
        noise = np.sqrt(power)
    repeated = grid.carried > 1
    apart = np.abs(each - function) ** 2
    freedom = grid.carried[repeated] - 1
    variance = np.sum(apart * active, axis=0)[repeated] / freedom
    scatter[repeated] = size[repeated] * np.sqrt(variance)
    return LineSpectra(
        grid,
        np.interp(positions, some, size[some]),
        between,
        np.sqrt(_mean_where(np.abs(y) ** 2, active)),
        np.sqrt(_mean_where(np.abs(rest.mean(axis=1)) ** 2, ~active)),
        noise,
        scatter,
        n_periods,
    )


T = TypeVar("T", FloatArray, ComplexArray)


def _mean_where(values: T, chosen: NDArray[np.bool_]) -> T:
    """Return the mean over the chosen realisations of each line; NaN where there is none."""
    count = chosen.sum(axis=0)
    total = np.sum(values, axis=0, where=chosen)
    result: T = np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
    return result


def _between(
    positions: NDArray[np.int_],
    known: NDArray[np.int_],
    values: ComplexArray,
) -> ComplexArray:
    """Return complex values at all positions, straight between those that are known."""
    real = np.interp(positions, known, values.real)
    result: ComplexArray = real + 1j * np.interp(positions, known, values.imag)
    return result
