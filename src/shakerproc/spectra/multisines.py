"""Multisines: response function, noise, even and odd distortion, before any model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, TypeVar, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral

PERIOD_ROUNDING: Final = 0.01
"""By how many samples a period may miss a whole number: it is written in so many digits [-]."""

SHORTEST_PERIOD: Final = 8
"""Samples that a period has at least [-]."""

TRANSIENT_POWER: Final = 2.0
"""Power of the difference of two periods over that of later ones from which on the first of
the two is taken for a transient [-]: noise over a hundred lines rarely varies by as much."""

ROUNDING_POWER: Final = 1e-16
"""Power of a difference over that of the signal below which it is that of numbers [-]."""

UNREPEATED_POWER: Final = 0.1
"""Power of the noise of the input over its own from which on its periods do not repeat [-]."""

REPEATED_CORRELATION: Final = 0.99
"""Correlation from which on two stretches of an input are the same [-]."""

LINE_REACH: Final = 10
"""Lines to each side among which an excited one is looked for [-]: of four odd lines one is
left out at random, so that eight lines hold some."""

LEAST_OF_NEIGHBOURS: Final = 0.2
"""Amplitude of an excited line over the largest near it, at least [-]: a force falls less than
that within a few lines, and what is not excited lies below in a shaker that is fit for this."""

LEAST_OF_ALL: Final = 0.01
"""The same over the largest of all lines [-]."""

STRAY_EVEN_LINES: Final = 0.05
"""Share of even lines among those that seem excited up to which they are disturbances, such as
mains hum, and the multisine is odd [-]."""

LEAST_OVER_NOISE: Final = 5.0
"""Amplitude of an excited line over the deviation of its mean, at least [-]."""

FEWEST_LINES: Final = 4
"""Excited lines of a realisation, at least [-]."""


@final
@dataclass(frozen=True, slots=True)
class PeriodLayout:
    """Where the periods of a multisine lie in a run.

    Attributes
    ----------
    n_period : int
        Samples of a period.
    periods, realisations : int
        Periods of each realisation, and how many of these there are.
    every : int
        Samples from the beginning of a realisation to that of the next.
    left_out : int
        Periods at the beginning of each realisation that are not used.
    """

    n_period: int
    periods: int
    realisations: int
    every: int
    left_out: int = 0

    def without(self, count: int) -> "PeriodLayout":
        """Return the layout without so many periods at the beginning of each realisation."""
        return replace(self, left_out=count)


def layout_of(
    n_samples: int,
    sample_rate: float,
    period: float,
    *,
    periods: int | None = None,
    realisations: int = 1,
    every: float | None = None,
) -> PeriodLayout:
    """Return where the periods of a run lie.

    Parameters
    ----------
    n_samples : int
        Samples of the run, which begins with the first realisation.
    sample_rate : float
        Samples per second [Hz].
    period : float
        After this time the multisine repeats [s].
    periods, realisations : int
        Of each realisation, by default as many as there is time for; and how many.
    every : float, optional
        From the beginning of one realisation to that of the next [s].

    Raises
    ------
    SpectrumError
        If a period is no whole number of samples, or the run is too short.
    """
    n_period = samples_of_period(period, sample_rate)
    if periods is None:
        periods = n_samples // (n_period * realisations)
    step = periods * n_period if every is None else round(every * sample_rate)
    needed = step * (realisations - 1) + max(periods, 1) * n_period
    if needed > n_samples or periods < 1:
        raise SpectrumError(
            f"{realisations} realisations of {max(periods, 1)} periods of {period:.6g} s need "
            f"{needed / sample_rate:.6g} s, and the run has {n_samples / sample_rate:.6g} s. "
            "Correct period, periods or realisations under multisine, or the crop"
        )
    return PeriodLayout(n_period, periods, realisations, step)


def samples_of_period(period: float, sample_rate: float) -> int:
    """Return how many samples a period [s] has at a sample rate [Hz].

    Raises
    ------
    SpectrumError
        If that is no whole number, or below eight.
    """
    exact = period * sample_rate
    n_period = round(exact)
    if abs(exact - n_period) > PERIOD_ROUNDING or n_period < SHORTEST_PERIOD:
        raise SpectrumError(
            f"a period of {period:.9g} s is {exact:.9g} samples at {sample_rate:.9g} Hz, and a "
            f"whole number from {SHORTEST_PERIOD} on is needed. Write "
            f"{max(n_period, SHORTEST_PERIOD) / sample_rate:.9g} s if it was that, else record "
            "with the clock of the generator, or resample"
        )
    return n_period


def cut(samples: FloatArray, layout: PeriodLayout) -> FloatArray:
    """Return the periods of a run, (n_channels, n_realisations, n_periods, n_period) array.

    Parameters
    ----------
    samples : (n_channels, n_samples) array
        The run, in any unit.
    layout : PeriodLayout
        Where its periods lie.
    """
    first = layout.left_out * layout.n_period
    stop = layout.periods * layout.n_period
    each = [
        samples[:, m * layout.every + first : m * layout.every + stop]
        for m in range(layout.realisations)
    ]
    shape = (len(samples), layout.realisations, -1, layout.n_period)
    return np.stack(each, axis=1).reshape(shape)


def transient_periods(lines: ComplexArray) -> int:
    """Return how many periods at the beginning do not repeat; two are always left.

    Parameters
    ----------
    lines : (n_channels, n_realisations, n_periods, n_lines) array
        Spectrum of every period, in any unit.
    """
    if lines.shape[2] < 3:
        return 0
    changes = np.sum(np.abs(np.diff(lines, axis=2)) ** 2, axis=(1, 3))
    power = np.sum(np.abs(lines[:, :, -1]) ** 2, axis=(1, 2))
    usual = np.median(changes[:, changes.shape[1] // 2 :], axis=1)
    limit = TRANSIENT_POWER * usual + ROUNDING_POWER * power
    odd = np.any(changes > limit[:, np.newaxis], axis=0)
    return int(np.argmin(odd)) if not odd.all() else 0


def check_input(samples: FloatArray, layout: PeriodLayout, sample_rate: float) -> None:
    """Pass an input that repeats within a realisation and differs between them.

    Parameters
    ----------
    samples : (n_samples,) array
        The input of the run, in any unit.
    layout : PeriodLayout
        Where its periods lie.
    sample_rate : float
        Samples per second [Hz].

    Raises
    ------
    SpectrumError
        If its periods do not repeat, or two realisations are the same.
    """
    (periods,) = cut(samples[np.newaxis], layout)
    periods = periods - periods.mean()
    power = float(np.mean(periods**2))
    if not power > 0.0:
        raise SpectrumError("the input does not move; correct its role in the log")
    if periods.shape[1] > 1:
        noise = float(np.mean(np.diff(periods, axis=1) ** 2)) / 2.0
        if noise > UNREPEATED_POWER * power:
            raise SpectrumError(
                f"the periods do not repeat: successive ones of the input differ by "
                f"{100.0 * np.sqrt(2.0 * noise / power):.0f} % of its rms; "
                + _repeats(samples[: layout.periods * layout.n_period], sample_rate)
            )
    means = periods.mean(axis=1)
    size = np.sqrt(np.sum(means**2, axis=1))
    for m in range(1, len(means)):
        if means[m] @ means[m - 1] > REPEATED_CORRELATION * size[m] * size[m - 1]:
            raise SpectrumError(
                f"realisations {m} and {m + 1} have the same phases: they are periods of one; "
                "correct periods and realisations under multisine"
            )


def _repeats(samples: FloatArray, sample_rate: float) -> str:
    """Return after which time an input repeats, in words."""
    centred = samples - samples.mean()
    n = centred.size
    spectrum = np.fft.rfft(centred, 2 * n)
    products = np.fft.irfft(np.abs(spectrum) ** 2, 2 * n)[:n]
    energy = np.cumsum(centred**2)
    common = np.sqrt(energy[::-1] * np.maximum(energy[-1] - np.append(0.0, energy[:-1]), 0.0))
    repeats = products[: 2 * n // 3] > (1.0 - UNREPEATED_POWER) * common[: 2 * n // 3]
    different = np.flatnonzero(~repeats)
    again = np.flatnonzero(repeats[different[0] :]) if different.size else np.zeros(0, int)
    if not again.size:
        return "nothing in it repeats: correct the crop, or record the multisine again"
    start = int(different[0] + again[0])
    end = start + int(np.argmin(np.append(repeats[start:], False)))
    lag = start + int(np.argmax(products[start:end]))
    return f"it repeats after {lag / sample_rate:.9g} s: correct period under multisine"


@final
@dataclass(frozen=True, slots=True, eq=False)
class LineGrid:
    """The lines of a multisine, from the first excited one to the last.

    Each realisation may excite lines of its own: a line that carries the input in one then
    shows distortion in another.

    Attributes
    ----------
    number : (n_lines,) array
        Which multiple of one over the period each is.
    frequency : (n_lines,) array
        [Hz].
    excited_in : (n_realisations, n_lines) array
        Whether the input moves there.
    """

    number: NDArray[np.int_]
    frequency: FloatArray
    excited_in: NDArray[np.bool_]

    @property
    def excited(self) -> NDArray[np.bool_]:
        """Lines at which the input moves in one realisation at least."""
        return np.asarray(self.excited_in.any(axis=0))

    @property
    def n_exciting(self) -> NDArray[np.int_]:
        """Number of realisations in which the input moves at a line."""
        return np.asarray(self.excited_in.sum(axis=0))

    @property
    def common(self) -> bool:
        """Whether all realisations excite the same lines."""
        return bool(np.all(self.excited_in == self.excited_in[0]))

    @property
    def even(self) -> NDArray[np.bool_]:
        """Lines that show even distortion alone: even ones, none of them excited."""
        return self._detecting(0)

    @property
    def odd(self) -> NDArray[np.bool_]:
        """Odd lines that are not excited in one realisation at least."""
        return self._detecting(1)

    def _detecting(self, parity: int) -> NDArray[np.bool_]:
        """Return lines of a parity that detect: sums of even lines are even and odd alike."""
        odd_only = bool(np.all(self.number[self.excited] % 2 == 1))
        silent = ~self.excited_in.all(axis=0)
        result: NDArray[np.bool_] = silent & (self.number % 2 == parity) & odd_only
        return result


def grid_of(
    lines: ComplexArray, spacing: float, band: tuple[float, float], first: int = 0
) -> LineGrid:
    """Return which lines an input excites in each realisation.

    A line of which an input is suspected stands out of its neighbours in one realisation; it is
    excited in those in which it reaches a share of its own largest amplitude, so that neither a
    dip of the force nor a line that another realisation leaves out is mistaken.

    Parameters
    ----------
    lines : (n_realisations, n_periods, n_lines) array
        Spectrum of the input in every period, in any unit.
    spacing : float
        Distance of the lines [Hz].
    band : (float, float)
        Where excited ones are looked for [Hz].
    first : int
        Number of the first line.

    Raises
    ------
    SpectrumError
        If a realisation has not four.
    """
    number = first + np.arange(lines.shape[-1])
    inside = (number * spacing >= band[0] * (1.0 - 1e-9)) & (number > 0)
    inside &= number * spacing <= band[1] * (1.0 + 1e-9)
    each = np.abs(lines.mean(axis=1)) * inside
    largest = each.max(axis=0)
    around = scipy.ndimage.maximum_filter1d(largest, 2 * LINE_REACH + 1, mode="constant")
    suspected = inside & (largest > LEAST_OF_NEIGHBOURS * around)
    suspected &= largest > LEAST_OF_ALL * largest.max(initial=0.0)
    excited = suspected & (each > LEAST_OF_NEIGHBOURS * largest)
    if lines.shape[1] > 1:
        power = np.mean(np.var(lines, axis=1, ddof=1), axis=0)
        excited &= each > LEAST_OVER_NOISE * np.sqrt(power / lines.shape[1])
    somewhere = excited.any(axis=0)
    if np.sum(somewhere & (number % 2 == 0)) <= STRAY_EVEN_LINES * np.sum(somewhere):
        excited &= number % 2 == 1
    fewest = int(np.argmin(excited.sum(axis=1)))
    n_excited = int(excited[fewest].sum())
    if n_excited < FEWEST_LINES:
        whose = f" in realisation {fewest + 1}" if len(excited) > 1 else ""
        raise SpectrumError(
            f"only {n_excited} lines of the input are excited{whose} from "
            f"{numeral(band[0], 4)} to {numeral(band[1], 4)} Hz; correct from, to, "
            "period or the role of the input"
        )
    chosen = np.flatnonzero(excited.any(axis=0))
    part = slice(int(chosen[0]), int(chosen[-1]) + 1)
    return LineGrid(number[part], np.asarray(number[part] * spacing, float), excited[:, part])


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
    is not: their numbers are `grid.n_exciting` and the rest.

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
        return float(np.average(self.level[some] ** 2, weights=self.grid.n_exciting[some]))

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
    repeated = grid.n_exciting > 1
    squares = np.abs(each - function) ** 2
    freedom = grid.n_exciting[repeated] - 1
    variance = np.sum(squares * active, axis=0)[repeated] / freedom
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
    silent = spectra.realisations - grid.n_exciting
    shares: dict[Kind, Share] = {}
    kinds: tuple[tuple[Kind, NDArray[np.bool_], FloatArray, NDArray[np.int_]], ...] = (
        ("even", grid.even, spectra.distortion, silent),
        ("odd", grid.odd, spectra.distortion, silent),
        ("all", grid.n_exciting > 1, spectra.scatter, grid.n_exciting - 1),
    )
    for kind, chosen, amplitude, repeats in kinds:
        if chosen.any():
            shares[kind] = _share(spectra, kind, np.flatnonzero(chosen), amplitude**2, repeats)
    return shares


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
