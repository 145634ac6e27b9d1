"""Best linear approximation, noise and distortion of a multisine, and where that stands out."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, TypeVar, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.multisines.periods import LineGrid

T = TypeVar("T", FloatArray, ComplexArray)

Kind: TypeAlias = Literal["even", "odd", "all"]
"""Even and odd distortion, of lines that are not excited; all of it, from realisations."""

LINES_OF_BLOCK: Final = 8
"""Neighbouring lines of one kind that are judged together [-]."""

FALSE_DISTORTION: Final = 0.01
"""Probability that noise alone shows as distortion anywhere in a curve [-]."""

LIMIT_DEVIATIONS: Final = 2.0
"""Deviations by which the limit of a share lies above it [-]."""


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
    grid : LineGrid
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

    grid: LineGrid
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


def line_spectra(driving: ComplexArray, response: ComplexArray, grid: LineGrid) -> LineSpectra:
    r"""Return the response at every line.

    .. math:: \hat G = \frac{1}{M} \sum_m \frac{\bar Y_m}{\bar U_m}, \qquad
              \hat\sigma^2_n = \frac{1}{R P (P - 1)} \sum_{m,p}
              |Y_{mp} - \hat G_m U_{mp} - \text{mean}_p|^2

    over those :math:`M` of the :math:`R` realisations that excite the line.

    Parameters
    ----------
    driving, response : (n_realisations, n_periods, n_lines) array
        Complex amplitudes of the lines of `grid` in every period, in any unit.
    grid : LineGrid
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


@final
@dataclass(frozen=True, slots=True)
class Share:
    """Distortion of one kind as a share of the response at excited lines.

    Attributes
    ----------
    kind : Kind
        Which.
    lines : int
        How many lines show it.
    value, limit : float
        Of the root mean squares over the band, the noise taken away; and its upper limit, 95 %,
        as far as noise hides it in these realisations [-]. With one period the noise is in
        both.
    largest, at : float
        Largest share of neighbouring lines [-], and where [Hz]; NaN where none stands out.
    bands : sequence of (float, float)
        Where it stands out of the noise [Hz].
    """

    kind: Kind
    lines: int
    value: float
    limit: float
    largest: float
    at: float
    bands: Sequence[tuple[float, float]]


def shares_of(spectra: LineSpectra) -> dict[Kind, Share]:
    """Return how large each kind of distortion is that the measurement shows.

    Parameters
    ----------
    spectra : LineSpectra
        What the response does at every line.
    """
    grid = spectra.grid
    silent = spectra.realisations - grid.carried
    found: dict[Kind, Share] = {}
    kinds: tuple[tuple[Kind, NDArray[np.bool_], FloatArray, NDArray[np.int_]], ...] = (
        ("even", grid.even, spectra.distortion, silent),
        ("odd", grid.odd, spectra.distortion, silent),
        ("all", grid.carried > 1, spectra.scatter, grid.carried - 1),
    )
    for kind, chosen, amplitude, repeats in kinds:
        if chosen.any():
            found[kind] = _share(spectra, kind, np.flatnonzero(chosen), amplitude**2, repeats)
    return found


def _share(
    spectra: LineSpectra,
    kind: Kind,
    lines: NDArray[np.int_],
    power: FloatArray,
    repeats: NDArray[np.int_],
) -> Share:
    """Return the share of one kind, seen at `lines` with so many `repeats` at each.

    Lines count by their repeats, so that every observation counts once.
    """
    excited = np.flatnonzero(spectra.grid.excited)
    whole, carried = spectra.response_power, spectra.level**2
    known = spectra.periods > 1
    noise = spectra.noise**2 if known else np.zeros(power.size)
    noisy = spectra.realisations * (spectra.periods - 1)
    count = repeats[lines]
    value = max(float(np.average(power[lines] - noise[lines], weights=count)), 0.0)
    seen, quiet = np.maximum(power[lines], noise[lines]), noise[lines]
    spread = np.sum(count * (2.0 * seen - quiet) * quiet)
    spread += np.sum((count * quiet) ** 2) / noisy if known else 0.0
    limit = value + LIMIT_DEVIATIONS * float(np.sqrt(spread)) / float(count.sum())
    blocks = np.array_split(lines, max(1, lines.size // LINES_OF_BLOCK))
    share, place, stands = [], [], []
    for block in blocks:
        near = excited[np.argsort(np.abs(excited - block.mean()))[: block.size]]
        each = repeats[block]
        over = np.average(power[block] - noise[block], weights=each) / np.mean(carried[near])
        share.append(float(np.sqrt(max(over, 0.0))))
        place.append(float(spectra.grid.frequency[block].mean()))
        stands.append(
            known
            and _exceeds_noise(
                power[block], noise[block], (each, noisy), FALSE_DISTORTION / len(blocks)
            )
        )
    top = int(np.argmax(np.where(stands, share, -1.0)))
    any_stands = bool(np.any(stands))
    return Share(
        kind,
        lines.size,
        float(np.sqrt(value / whole)),
        float(np.sqrt(limit / whole)),
        share[top] if any_stands else float("nan"),
        place[top] if any_stands else float("nan"),
        _bands(spectra.grid.frequency, blocks, stands),
    )


def _exceeds_noise(
    power: FloatArray,
    noise: FloatArray,
    repeats: tuple[NDArray[np.int_], int],
    chance: float,
) -> bool:
    """Return whether the power of lines is more than noise makes of it by chance.

    Each line holds as many observations as it has repeats. The noise, of which a line has the
    same number everywhere, is weighted alike: Satterthwaite's degrees of freedom.
    """
    each, noisy = repeats
    above = 2 * int(each.sum())
    below = 2.0 * noisy * float(each.sum()) ** 2 / float(np.sum(each**2))
    limit = 1.0 / scipy.special.fdtri(below, above, chance)  # F's upper quantile
    return bool(np.sum(each * power) > limit * np.sum(each * noise))


def _bands(
    frequency: FloatArray,
    blocks: Sequence[NDArray[np.int_]],
    stands: Sequence[bool],
) -> tuple[tuple[float, float], ...]:
    """Return the bands of neighbouring blocks that stand out [Hz]."""
    bands: list[tuple[float, float]] = []
    before = False
    for block, yes in zip(blocks, stands, strict=True):
        if yes:
            low = bands.pop()[0] if before else float(frequency[block[0]])
            bands.append((low, float(frequency[block[-1]])))
        before = yes
    return tuple(bands)
