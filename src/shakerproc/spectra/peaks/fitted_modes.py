"""The modes that fit the bins around a peak, and the errors that chance makes.

What Welch's method gives is not the response function but its average over the window's
spectrum. In time that is a product, so the fit compares like with like: the decay of a mode
times the correlation of the window with itself, transformed. Frequencies and damping ratios
are searched; what enters linearly (the residues, and a straight background for the modes far
away) is solved for.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.spectra.peaks.chance import Chance, plain_chance, smearing_of, steady_chance
from shakerproc.spectra.peaks.finding import IndexArray, local_maxima, resolved
from shakerproc.spectra.welch.cross import CrossSpectra
from shakerproc.spectra.welch.windows import (
    AbstractCorrelation,
    DecayCorrelation,
    correlation_of,
)

Kind: TypeAlias = Literal["response", "density"]

RATIOS: Final = (1e-5, 0.7)
"""Damping ratios that the search does not pass [-]."""

MOST_STEPS: Final = 60
"""Evaluations after which a search is given up."""


CLOSE: Final = 1e-4
"""Relative step and relative fall of the squares at which a search ends [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class SmearedModes:
    """Responses of modes in certain bins.

    Attributes
    ----------
    kind : str
        ``response`` (complex values) or ``density`` (real ones).
    bins : (n_bins,) array of int
        Which bins.
    correlation : AbstractCorrelation
        Of the window with itself.
    n_fft : int
        Length of the FFT.
    sample_rate : float
        Samples per second [Hz].
    """

    kind: Kind
    bins: NDArray[np.intp]
    correlation: AbstractCorrelation
    n_fft: int
    sample_rate: float

    def mode(self, frequency: float, ratio: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the two columns of a mode and their slopes along ln f and ln zeta.

        `frequency` is in [Hz], `ratio` without unit [-].
        """
        root = float(np.sqrt(1.0 - ratio * ratio))
        omega = 2.0 * np.pi * frequency / self.sample_rate
        pole = omega * complex(-ratio, root)
        turns = 2j * np.pi / self.n_fft * np.concatenate([self.bins, -self.bins])
        spectrum, along = self.correlation.transform(pole - turns)
        direct, mirrored = spectrum[: self.bins.size], spectrum[self.bins.size :].conj()
        slope, mirrored_slope = along[: self.bins.size], along[self.bins.size :].conj()
        turn = omega * ratio * complex(-1.0, -ratio / root)
        return (
            self._columns(direct, mirrored),
            self._columns(pole * slope, pole.conjugate() * mirrored_slope),
            self._columns(turn * slope, turn.conjugate() * mirrored_slope),
        )

    def background(self) -> FloatArray:
        """Return the columns of the modes far away: level and slope."""
        place = np.linspace(-1.0, 1.0, self.bins.size)
        level, nothing = np.ones(self.bins.size), np.zeros(self.bins.size)
        if self.kind == "density":
            return np.column_stack([level, place])
        pairs = ((level, nothing), (nothing, level), (place, nothing), (nothing, place))
        return np.column_stack([np.concatenate(pair) for pair in pairs])

    def _columns(self, direct: ComplexArray, mirrored: ComplexArray) -> FloatArray:
        """Return the columns of a residue and its conjugate, real above imaginary parts."""
        both, apart = direct + mirrored, 1j * (direct - mirrored)
        if self.kind == "density":
            return np.column_stack([both.real, apart.real])
        return np.column_stack([stacked(both), stacked(apart)])


@final
@dataclass(frozen=True, slots=True, eq=False)
class ModesFit:
    """The modes that fit best.

    Attributes
    ----------
    frequency, ratio : (n_modes,) array
        Natural frequencies [Hz] and damping ratios [-].
    weights : (n_values,) array
        Residue of each mode (two numbers), then the background.
    residual : (n_values,) array
        Fit less values, over the errors, real above imaginary parts [-].
    slopes : (n_values, 2 n_modes) array
        Derivative of the residual along the logarithms of frequencies, then of ratios, with
        the linear coefficients following.
    basis : (n_values, n) array
        Orthonormal columns that span all that the fit can follow.
    misfit : float
        Rms of what is not explained over the largest value [-].
    converged : bool
        Whether the search ended at a minimum inside its limits.
    """

    frequency: FloatArray
    ratio: FloatArray
    weights: FloatArray
    residual: FloatArray
    slopes: FloatArray
    basis: FloatArray
    misfit: float
    converged: bool

    @property
    def squares(self) -> float:
        """Sum of the squared residuals [-]."""
        return float(self.residual @ self.residual)


def fit_modes(
    shape: SmearedModes,
    values: ComplexArray | FloatArray,
    errors: FloatArray,
    frequency: FloatArray,
    ratio: FloatArray,
) -> ModesFit:
    """Return the modes that fit values best in the sense of least squares.

    Parameters
    ----------
    shape : SmearedModes
        What modes look like in these bins.
    values : (n_bins,) array
        Response function or density [any unit].
    errors : (n_bins,) array
        Standard error of each value (of a complex value: of each of its parts)
        [unit of the values].
    frequency, ratio : (n_modes,) array
        Where to start [Hz] [-].

    Returns
    -------
    ModesFit
        Best fit, in the order of the start.
    """
    problem = _FitProblem(shape, values, errors)
    n = frequency.size
    width = shape.sample_rate / shape.n_fft
    start = np.log(np.concatenate([frequency, ratio]))
    span = width * shape.bins.size / frequency  # none leaves for another peak
    lower = np.concatenate([start[:n] - span, np.full(n, np.log(RATIOS[0]))])
    upper = np.concatenate([start[:n] + span, np.full(n, np.log(RATIOS[1]))])
    begin = np.clip(start, lower + 1e-9, upper - 1e-9)
    try:
        with np.errstate(invalid="raise", divide="raise"):
            found = scipy.optimize.least_squares(
                problem.residual,
                begin,
                problem.jacobian,
                bounds=(lower, upper),
                x_scale=np.concatenate([ratio, np.ones(n)]),
                max_nfev=MOST_STEPS,
                xtol=CLOSE,
                ftol=CLOSE,
                gtol=None,
            )
    except FloatingPointError:  # no slope at all: a channel that is a multiple of the control
        return problem.solved(begin, converged=False)
    return problem.solved(found.x, converged=found.status > 0 and not found.active_mask.any())


def best_ratio(
    shape: SmearedModes,
    values: ComplexArray | FloatArray,
    errors: FloatArray,
    frequency: float,
    ratios: FloatArray,
) -> float:
    """Return which of some damping ratios fits one mode best [-]; arguments as `fit_modes`."""
    problem = _FitProblem(shape, values, errors)
    residuals = [problem.residual(np.log([frequency, ratio])) for ratio in ratios]
    return float(ratios[int(np.argmin([residual @ residual for residual in residuals]))])


def stacked(values: ComplexArray | FloatArray) -> FloatArray:
    """Return real values as they are, complex ones as real above imaginary parts.

    `values` may be in any unit.
    """
    if np.iscomplexobj(values):
        return np.concatenate([values.real, values.imag])
    return np.array(values, dtype=np.float64)


@final
class _FitProblem:
    """Residuals of the fit for any logarithms of frequencies and damping ratios.

    The linear coefficients are solved for at every point (variable projection).
    """

    def __init__(
        self, shape: SmearedModes, values: ComplexArray | FloatArray, errors: FloatArray
    ) -> None:
        self.shape = shape
        self.errors = errors if shape.kind == "density" else np.concatenate([errors, errors])
        self.target = stacked(values) / self.errors
        self.background = shape.background() / self.errors[:, np.newaxis]
        self.height = float(np.abs(values).max())
        self.point: FloatArray = np.zeros(0)
        self.left: FloatArray = self.target
        self.slopes: FloatArray = self.background

    def residual(self, point: FloatArray) -> FloatArray:
        """Return fit less target, over the errors."""
        self._solve(point)
        return self.left

    def jacobian(self, point: FloatArray) -> FloatArray:
        """Return the derivatives of the residual, (n_values, 2 n_modes)."""
        self._solve(point)
        return self.slopes

    def solved(self, point: FloatArray, *, converged: bool) -> ModesFit:
        """Return all that is known at a point."""
        self._solve(point)
        n = point.size // 2
        along = np.linalg.qr(self.slopes)[0]
        missed = self.left * self.errors
        return ModesFit(
            frequency=np.exp(point[:n]),
            ratio=np.exp(point[n:]),
            weights=self.weights,
            residual=self.left,
            slopes=self.slopes,
            basis=np.column_stack([self.basis, along]),
            misfit=float(np.sqrt(np.sum(missed**2) / self.shape.bins.size)) / self.height,
            converged=converged,
        )

    def _solve(self, point: FloatArray) -> None:
        if np.array_equal(point, self.point):
            return
        n = point.size // 2
        shapes = [
            self.shape.mode(float(f), float(z))
            for f, z in zip(np.exp(point[:n]), np.exp(point[n:]), strict=True)
        ]
        below = self.errors[:, np.newaxis]
        columns = np.column_stack([*(mode / below for mode, _, _ in shapes), self.background])
        self.basis, triangle = np.linalg.qr(columns)
        # of shapes that are alike, as those of two equal modes, any share will do
        self.weights = np.linalg.lstsq(triangle, self.basis.T @ self.target, rcond=None)[0]
        self.left = columns @ self.weights - self.target
        parts = self.weights[: 2 * n].reshape(n, 2)
        slopes = np.column_stack([
            mode[k] @ part / self.errors
            for k in (1, 2)
            for mode, part in zip(shapes, parts, strict=True)
        ])
        self.slopes = slopes - self.basis @ (self.basis.T @ slopes)
        self.point = point.copy()


REACH_BINS: Final = 6
"""Bins to each side of a peak that are fitted at least."""

MOST_BINS: Final = 64
"""Bins to each side of a peak that are fitted at most."""

LEAST_BINS: Final = 7
"""Bins below which six or eight unknowns are too many."""

NEIGHBOUR_BINS: Final = 400
"""Bins to each side of a peak in which its neighbours are looked for."""

MOST_BIAS: Final = 0.3
"""Bias in standard errors that is let stand [-]: it costs a 95 % interval 1 % of its coverage,
P(|z + 0.3| < 1.96) = 0.94."""

MOST_MODES: Final = 6
"""Modes that are fitted together at most."""

FIRST_RATIOS: Final = np.geomspace(2e-4, 0.3, 13)
"""Damping ratios tried before the search [-]."""

UNSTEADY_DEVIATIONS: Final = 3.0
"""Standard deviations by which fewer segments light a bin than random vibration lights."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class PeakData:
    """Data of a fit: values of every frequency and their standard errors."""

    kind: Kind
    values: ComplexArray | FloatArray
    errors: FloatArray
    lit_segments: FloatArray
    missing: FloatArray | None = None


def smoothing_of(power: FloatArray, data: PeakData, place: float) -> int:
    """Return over how many bins to average so that chance makes no peaks of its own.

    `power` may be in any unit, `place` counts bins [-].
    """
    centre = min(max(round(place), 2), power.size - 3)
    near = slice(centre - 2, centre + 3)
    kept = power[near] > 0.0
    if not kept.any():
        return 1
    error = np.median(data.errors[near][kept] / np.abs(data.values[near][kept]))
    error *= 2.0 if data.kind == "response" else 1.0
    return min(1 + 2 * round(8.0 * float(error) ** 2), 201)


def maxima_around(data: PeakData, usable: NDArray[np.bool_], place: float) -> IndexArray:
    """Return the peaks around a place that chance does not make. `place` counts bins [-]."""
    low = max(0, int(place) - NEIGHBOUR_BINS)
    part = slice(low, int(place) + NEIGHBOUR_BINS + 1)
    height = np.where(usable[part], np.abs(data.values[part]), np.nan)
    share = np.full(height.shape, np.nan)
    np.divide(data.errors[part], height, out=share, where=height > 0.0)
    return low + resolved(local_maxima(height), height, share)


def nearest_peak(maxima: IndexArray, power: FloatArray, place: float) -> int:
    """Return the peak nearest to a place, or the tallest bin there if there is none near.

    `power` may be in any unit, `place` counts bins [-].
    """
    near = maxima[np.abs(maxima - place) <= NEIGHBOUR_BINS / 4]
    if near.size:
        return int(near[np.argmin(np.abs(near - place))])
    low = min(max(round(place) - 2, 1), power.size - 2)
    return low + int(np.argmax(power[low : low + 5]))


def bins_around(
    data: PeakData, usable: NDArray[np.bool_], maxima: IndexArray, peak: int, reach: float,
    *, width: float,
) -> tuple[IndexArray, tuple[int, ...]]:  # fmt: skip
    """Return the bins around a peak, those of neighbours that matter included, and these.

    `reach` and the half-power `width` count bins [-].
    """
    others = maxima[maxima != peak]
    others = others[
        (np.abs(others - peak) <= 2.0 * reach) | _bend(data, others, peak, reach, width)
    ]
    beyond = max(reach / 2.0, REACH_BINS / 2.0)
    low = min([peak - reach, *(others - beyond)])
    high = max([peak + reach, *(others + beyond)])
    number = np.arange(usable.size)
    bins = number[(number >= low) & (number <= high) & (np.abs(number - peak) <= 2 * MOST_BINS)]
    broken = bins[~usable[bins]]
    if (broken < peak).any():
        bins = bins[bins > broken[broken < peak].max()]
    if (broken > peak).any():
        bins = bins[bins < broken[broken > peak].min()]
    inside = others[np.isin(others, bins)]
    nearest = inside[np.argsort(np.abs(inside - peak), kind="stable")][: MOST_MODES - 1]
    return bins, tuple(int(k) for k in nearest)


def _bend(
    data: PeakData, others: IndexArray, peak: int, reach: float, width: float
) -> NDArray[np.bool_]:
    r"""Return which neighbours a straight background under a peak misses by more than chance.

    A neighbour of height A and half-width h so many bins d away is
    :math:`A (h/d)^p` under the peak, p = 1 in a response function and 2 in a density. A
    straight line over r bins to each side misses of that, rms,
    :math:`2/\sqrt{45}\ p (p + 1)/2\ (r/d)^2`, which bends no parameter by more than that over
    the error, times the root of the number of bins (Cauchy and Schwarz), in standard errors.
    """
    power = 1 if data.kind == "response" else 2
    apart = np.abs(others - peak).astype(np.float64)
    under = np.abs(data.values[others]) * (0.5 * width / apart) ** power
    missed = 2.0 / np.sqrt(45.0) * power * (power + 1) / 2.0 * (reach / apart) ** 2 * under
    near = apart + max(reach / 2.0, REACH_BINS / 2.0) <= 2 * MOST_BINS
    return np.asarray(near & (missed * np.sqrt(2.0 * reach) > MOST_BIAS * data.errors[peak]))


def clearance_of(starts: tuple[int, ...]) -> float:
    """Return how many bins around the first of some peaks are nearer to it than to others."""
    nearest = min((abs(other - starts[0]) for other in starts[1:]), default=2 * MOST_BINS)
    return max(nearest / 2.0, LEAST_BINS / 2.0)


@final
@dataclass(frozen=True, slots=True, eq=False)
class FittedModes:
    """The modes that fit a peak (the first) and its neighbours, and the errors of chance."""

    shape: SmearedModes
    fit: ModesFit
    chance: Chance
    covariance: FloatArray  # of the weighted values
    errors: FloatArray

    @property
    def followed(self) -> float:
        """How much of the squared errors the fit follows: its penalty."""
        return float(np.sum(self.fit.basis * (self.covariance @ self.fit.basis)))

    @property
    def scale(self) -> float:
        """Squared misfit over its expectation by chance [-]."""
        left = float(np.trace(self.covariance)) - self.followed
        return self.fit.squares / max(left, 1e-3 * self.fit.residual.size)

    @property
    def spread(self) -> FloatArray:
        """Variances of the logarithms of frequencies and ratios, the misfit included."""
        slopes = self.fit.slopes
        inverse = np.linalg.pinv(slopes.T @ slopes) @ slopes.T
        return np.asarray(np.diag(inverse @ self.covariance @ inverse.T) * max(1.0, self.scale))


def fitted_modes(
    spectra: CrossSpectra,
    data: PeakData,
    bins: IndexArray,
    starts: tuple[int, ...],
    maxima: IndexArray,
) -> FittedModes:
    """Return the modes that fit these bins, as many as the data tell apart."""
    kernel = _kernel(spectra)
    shape = SmearedModes(data.kind, bins, kernel, spectra.n_fft, spectra.sample_rate)
    frequency = spectra.frequency[list(starts)]
    near = bins[np.abs(bins - starts[0]) <= clearance_of(starts)]
    alone = replace(shape, bins=near)
    first = best_ratio(
        alone, data.values[near], data.errors[near], float(frequency[0]), FIRST_RATIOS
    )
    ratio = first * frequency[0] / frequency
    fit = fit_modes(shape, data.values[bins], data.errors[bins], frequency, ratio)
    found = _refitted(spectra, data, shape, fit)
    while found.scale > 1.0 and found.fit.frequency.size < MOST_MODES:
        more = _with_further_mode(spectra, data, shape, found, maxima)
        if more is None:
            break
        found = more
    return found


def _kernel(spectra: CrossSpectra) -> AbstractCorrelation:
    """Return the correlation of the averaging, which multiplies the decay of a mode."""
    if spectra.decay_rate is not None:
        return DecayCorrelation(spectra.decay_rate / spectra.sample_rate)
    return correlation_of(spectra.window_name, spectra.window)


def _refitted(
    spectra: CrossSpectra, data: PeakData, shape: SmearedModes, fit: ModesFit
) -> FittedModes:
    """Return modes fitted again with the errors that they themselves imply."""
    chance = _chance(spectra, data, shape.bins, fit)
    errors = chance.errors
    values = data.values[shape.bins] - chance.bias
    again = fit_modes(shape, values, errors, fit.frequency, fit.ratio)
    return FittedModes(shape, again, chance, _weighted(chance, errors, data.kind), errors)


def _with_further_mode(
    spectra: CrossSpectra,
    data: PeakData,
    shape: SmearedModes,
    found: FittedModes,
    maxima: IndexArray,
) -> FittedModes | None:
    """Return a reading with one more mode if the information criterion falls, else None."""
    values = data.values[shape.bins] - found.chance.bias
    trials = []
    for place in _candidates(shape.bins, found, maxima):
        frequency = float(spectra.frequency[place])
        ratio = spectra.bin_width / frequency
        trial = fit_modes(
            shape,
            values,
            found.errors,
            np.append(found.fit.frequency, frequency),
            np.append(found.fit.ratio, ratio),
        )
        if trial.converged:
            trials.append(trial)
    if not trials:
        return None
    best = min(trials, key=lambda trial: trial.squares)
    more = FittedModes(shape, best, found.chance, found.covariance, found.errors)
    gained = (found.fit.squares - best.squares) / max(1.0, more.scale)
    if gained <= 2.0 * (more.followed - found.followed):
        return None
    settled = _refitted(spectra, data, shape, best)
    return settled if settled.fit.converged else None


def _candidates(bins: IndexArray, found: FittedModes, maxima: IndexArray) -> Iterator[int]:
    """Yield where another mode may be: at the largest misfit, at the peaks beside the bins."""
    missed = np.sum(found.fit.residual.reshape(-1, bins.size) ** 2, axis=0)
    yield int(bins[int(np.argmax(missed))])
    below, above = maxima[maxima < bins[0]], maxima[maxima > bins[-1]]
    if below.size:
        yield int(below.max())
    if above.size:
        yield int(above.min())


def _chance(spectra: CrossSpectra, data: PeakData, bins: IndexArray, fit: ModesFit) -> Chance:
    """Return the errors of the values: by theory where the excitation was steady and random."""
    smearing = smearing_of(spectra)
    wanted = (
        0.5
        * spectra.n_segments
        * (1.0 - UNSTEADY_DEVIATIONS / np.sqrt(spectra.effective_averages))
    )
    transient = spectra.decay_rate is not None
    if transient or float(data.lit_segments[bins].mean()) < wanted:
        is_complex = data.kind == "response"
        return plain_chance(smearing, data.errors[bins], is_complex=is_complex)
    missing = None if data.missing is None else data.missing[bins]
    return steady_chance(smearing, data.kind, spectra.frequency[bins], fit, missing)


def _weighted(chance: Chance, errors: FloatArray, kind: Kind) -> FloatArray:
    """Return the covariance of values over their errors."""
    every = errors if kind == "density" else np.concatenate([errors, errors])
    return np.asarray(chance.covariance / (every * every[:, np.newaxis]))
