"""The input between its samples: polynomial pieces, and how far they can be trusted."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import frexp, ldexp, pi
from typing import Final, Literal, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.simulation.kernels.polynomials import chirp_pieces, through

MARGIN: Final = 256
"""Samples by which a signal is led past either end, to 0."""

PREDICTION_ORDER: Final = 32
"""Samples that a prediction looks back at."""

PREDICTION_SAMPLES: Final = 512
"""Samples near an end that a prediction is fitted to."""

PREDICTED_ENDS: Final = 20
"""Samples at either end whose interpolation rests on what was predicted."""

_SMOOTH: Final = 24.0  # shape of the Kaiser window that leads to 0: what it leaks is rounding
_CUTS: Final = 4
_STRETCH: Final = 1024

ROUNDING: Final = 1e-15
"""Share of its amplitude by which rounding alone makes a signal miss [-]."""

_HIGHEST: Final = 24

_DIGITS: Final = 53  # of a number, in base 2

Hold: TypeAlias = Literal["band-limited", "linear"]

Signal: TypeAlias = Callable[[FloatArray], FloatArray]
"""A function of time [s] that gives the input, in its SI unit."""

_ANALYTIC_DEGREE = 9


@final
@dataclass(frozen=True, slots=True)
class InterpolationError:
    """How far a sampled input may be from the band-limited signal through its samples.

    Attributes
    ----------
    first : float
        Near the first and last samples, from the interpolation of stretches of the signal as
        if they began there, scaled by how large it is at its ends; as a share of the largest
        value [-].
    middle : float
        Elsewhere: what the polynomials miss at the middle of each step, where they miss most;
        as a share of the largest value [-].
    """

    first: float
    middle: float

    @property
    def largest(self) -> float:
        """The larger of both [-]."""
        return max(self.first, self.middle)


def finer(
    samples: FloatArray, upsample: int, derivatives: int, *, beyond: int = 0
) -> tuple[FloatArray, ...]:
    """Return band-limited signals at finer steps, and their derivatives by such a step.

    Parameters
    ----------
    samples : (..., n) array
        The signals, in any unit.
    upsample : int
        Steps in a sample.
    derivatives : int
        How many derivatives.
    beyond : int
        Steps past the last sample.

    Returns
    -------
    tuple of (..., (n - 1) * upsample + 1 + beyond) arrays
        Values, first derivatives, ...
    """
    longer = led_past_its_ends(samples)
    size = _odd_fast_length(longer.shape[-1])
    spectrum = scipy.fft.rfft(longer, size)
    angle = 2j * np.pi * np.arange(spectrum.shape[-1]) / (size * upsample)
    first, count = MARGIN * upsample, (samples.shape[-1] - 1) * upsample + 1 + beyond
    return tuple(
        upsample
        * scipy.fft.irfft(spectrum * angle**order, size * upsample)[..., first : first + count]
        for order in range(derivatives + 1)
    )


def led_past_its_ends(samples: FloatArray) -> FloatArray:
    """Return samples with their prediction on both sides, (..., n + 2 MARGIN) array.

    `samples` may be in any unit.
    """
    window = np.cumsum(np.kaiser(2 * MARGIN + 1, _SMOOTH))
    fall = 1.0 - window[1::2] / window[-1]
    ends = np.stack((
        samples[..., :PREDICTION_SAMPLES][..., ::-1],
        samples[..., -PREDICTION_SAMPLES:],
    ))
    before, after = _predicted(ends) * fall
    return np.concatenate((before[..., ::-1], samples, after), axis=-1)


def interpolation_error(
    samples: FloatArray, pieces: FloatArray | None = None, upsample: int = 1
) -> InterpolationError:
    """Return how far polynomials may be from the band-limited signal through samples.

    Both are looked at in a few stretches, spread over the signal.

    Parameters
    ----------
    samples : (n,) array
        The signal, in any unit.
    pieces : ((n - 1) * upsample, degree + 1) array, optional
        Polynomials over its parts, in powers of the share of each; without them only what
        `finer` itself misses counts [unit of the samples].
    upsample : int
        Parts of a sample.
    """
    largest = float(np.max(np.abs(samples)))
    if largest == 0.0:
        return InterpolationError(0.0, 0.0)
    n = samples.size
    if n < 4:
        return InterpolationError(1.0, 1.0)
    cuts = np.unique(np.linspace(n // 4, 3 * n // 4, _CUTS).astype(int))
    earlier, length = min(_STRETCH // 2, cuts[0]), min(_STRETCH, n - cuts[-1])
    places = cuts[:, None] + np.arange(-earlier, length)
    exact = finer(samples[places], 2 * upsample, 0)[0]
    middle = 0.0
    if pieces is not None:
        steps = np.arange(-earlier * upsample, (length - 1) * upsample)
        halves = 0.5 ** np.arange(pieces.shape[1])
        interpolated = pieces[cuts[:, None] * upsample + steps] @ halves
        edge = min(PREDICTED_ENDS, earlier) * upsample
        missed = np.abs(interpolated - exact[:, 1::2])[:, edge : steps.size - edge]
        middle = float(np.max(missed, initial=0.0))
    beginnings = _error_of_beginnings(samples[places[:, earlier:]], exact, earlier)
    ends = max(
        float(np.max(np.abs(part)))
        for part in (samples[:PREDICTED_ENDS], samples[-PREDICTED_ENDS:])
    )
    return InterpolationError(max(beginnings * ends, middle) / largest, middle / largest)


def _error_of_beginnings(stretches: FloatArray, exact: FloatArray, earlier: int) -> float:
    """Return how far the first samples of stretches are missed, as a share of them.

    Parameters
    ----------
    stretches : (n_stretches, n) array
        Samples, the earlier ones kept back.
    exact : (n_stretches, m) array
        The signals through these and the earlier ones, at finer steps.
    earlier : int
        How many were kept back.
    """
    parts = (exact.shape[1] - 1) // (stretches.shape[1] + earlier - 1)
    alone = finer(stretches, parts, 0)[0][:, : PREDICTED_ENDS * parts]
    known = exact[:, earlier * parts :][:, : alone.shape[1]]
    sizes = np.max(np.abs(stretches[:, :PREDICTED_ENDS]), axis=1)
    difference = np.max(np.abs(alone - known), axis=1)
    return float(np.max(difference[sizes > 0.0] / sizes[sizes > 0.0], initial=0.0))


def _predicted(samples: FloatArray) -> FloatArray:
    """Return the continuation of samples by the linear prediction that fits them.

    Parameters
    ----------
    samples : (..., n) array
        Signals up to their ends.

    Returns
    -------
    (..., MARGIN) array
        What comes next, as it is predicted.
    """
    rows = samples.reshape(-1, samples.shape[-1])
    predicted = np.zeros((len(rows), MARGIN))
    for row, weights, ahead in zip(
        rows, _burg(rows, min(PREDICTION_ORDER, rows.shape[1] // 2)), predicted, strict=True
    ):
        state = scipy.signal.lfiltic([1.0], weights, row[: -weights.size : -1])
        ahead[:] = scipy.signal.lfilter([1.0], weights, ahead, zi=state)[0]
    return predicted.reshape(*samples.shape[:-1], MARGIN)


def _burg(samples: FloatArray, order: int) -> FloatArray:
    """Return the prediction error filters of signals by Burg's method.

    They are stable whatever the samples, and stop growing where these are predicted to
    rounding.

    Parameters
    ----------
    samples : (n_signals, n) array
        The signals.
    order : int
        How many samples a prediction looks back at.

    Returns
    -------
    (n_signals, order + 1) array
        Weights of the latest sample first [-].

    References
    ----------
    .. [1] J. P. Burg, "Maximum entropy spectral analysis", PhD thesis, Stanford, 1975.
    """
    weights = np.zeros((len(samples), order + 1))
    weights[:, 0] = 1.0
    sizes = np.max(np.abs(samples), axis=1, keepdims=True)
    samples = samples / np.where(sizes > 0.0, sizes, 1.0)
    forward, backward = samples[:, 1:], samples[:, :-1]
    # what is left of a signal that is predicted exactly: rounding of 1e-15, squared
    rounding = 1e-30 * np.sum(samples**2, axis=1)
    for reached in range(1, order + 1):
        energy = np.sum(forward**2 + backward**2, axis=1)
        known = energy > rounding
        together = np.sum(forward * backward, axis=1)
        reflection = np.where(known, -2.0 * together / np.where(known, energy, 1.0), 0.0)
        longer = weights[:, : reached + 1]
        weights[:, : reached + 1] = longer + reflection[:, None] * longer[:, ::-1]
        forward, backward = (
            forward[:, 1:] + reflection[:, None] * backward[:, 1:],
            backward[:, :-1] + reflection[:, None] * forward[:, :-1],
        )
    return weights


def _odd_fast_length(least: int) -> int:
    """Return an odd length that transforms fast: it has no frequency without a sign."""
    length = int(scipy.fft.next_fast_len(least))
    while length % 2 == 0:
        length = int(scipy.fft.next_fast_len(length + 1))
    return length


@final
@dataclass(frozen=True, slots=True)
class Chirp:
    r"""The signal :math:`A \sin(2 \pi (f_0 t + \tfrac{1}{2} \dot f t^2) + \varphi)`.

    Attributes
    ----------
    first : float
        Frequency at time 0 [Hz].
    rate : float
        How fast it changes [Hz/s].
    amplitude : float
        Amplitude [m/s^2 or N].
    phase : float
        Phase at time 0 [rad].
    """

    first: float
    rate: float
    amplitude: float
    phase: float

    def __call__(self, time: FloatArray) -> FloatArray:
        """Return the signal at times [s], an array [m/s^2 or N]."""
        turns = (0.5 * self.rate * time + self.first) * time
        rest = turns - np.floor(turns)  # a sine loses digits where its angle is large
        result: FloatArray = self.amplitude * np.sin(2.0 * pi * rest + self.phase)
        return result

    def pieces(
        self, n_intervals: int, sample_rate: float, tolerance: float
    ) -> FloatArray | None:
        """Return polynomials over intervals, in powers of the share of each that has passed.

        They are Taylor series, as long as it takes to miss the signal by no more than a share
        of its amplitude.

        `sample_rate` is in [Hz], `tolerance` a share of the amplitude [-].

        Returns
        -------
        (n_intervals, degree + 1) array or None
            None where the sine turns too far in an interval.
        """
        duration = n_intervals / sample_rate
        fastest = max(abs(self.first), abs(self.first + self.rate * duration))
        degree, missed = 0, 1.0
        while missed > tolerance or degree < 3:
            degree += 1
            missed *= 2.0 * pi * fastest / sample_rate / (degree + 1)
            if degree > _HIGHEST:
                return None
        pieces = np.empty((n_intervals, degree + 1))
        step = 1 / Fraction(sample_rate)
        bits = _DIGITS - n_intervals.bit_length()
        turning = _in_two(step * Fraction(self.first), bits)
        bending = _in_two(step * step * Fraction(self.rate) / 2, 2 * bits - _DIGITS)
        chirp_pieces(turning, bending, self.amplitude, self.phase, pieces)
        return pieces


def _in_two(value: Fraction, bits: int) -> tuple[float, float]:
    """Return a number of few bits, which multiplies whole numbers exactly, and the rest."""
    mantissa, exponent = frexp(float(value))
    short = ldexp(round(ldexp(mantissa, bits)), exponent - bits)
    return short, float(value - Fraction(short))


def pieces_of_samples(samples: FloatArray, *, upsample: int, hold: Hold) -> FloatArray:
    """Return polynomials over the intervals between samples, in powers of the share passed.

    Parameters
    ----------
    samples : (n_samples,) array
        The input, in its SI unit.
    upsample : int
        Into how many parts each interval is cut first.
    hold : {"band-limited", "linear"}
        ``band-limited`` takes the signal for one without content above half the sample rate:
        each piece is the quintic with its values, slopes and curvatures at both ends, which
        misses a sine by (omega h)^6 / 46080 (6e-7 at 500 Hz for 5.69 kHz, upsample 1), near
        both ends by more; `interpolation.interpolation_error` says by how much.
        ``linear`` draws straight lines, which droop by (omega h)^2 / 12 (2.5 % there).

    Returns
    -------
    ((n_samples - 1) * upsample, degree + 1) array
        Coefficients.
    """
    if hold == "linear":
        values = samples if upsample == 1 else finer(samples, upsample, 0)[0]
        return np.stack((values[:-1], np.diff(values)), axis=1)
    p, v, a = finer(samples, upsample, 2)
    # Hermite: value, slope and curvature at both ends of a step of length 1
    rise = np.diff(p)
    left, right = v[:-1], v[1:]
    bend, end_bend = a[:-1], a[1:]
    return np.stack(
        (
            p[:-1],
            left,
            0.5 * bend,
            10.0 * rise - 6.0 * left - 4.0 * right - 1.5 * bend + 0.5 * end_bend,
            -15.0 * rise + 8.0 * left + 7.0 * right + 1.5 * bend - end_bend,
            6.0 * rise - 3.0 * (left + right) + 0.5 * (end_bend - bend),
        ),
        axis=1,
    )


def pieces_of_signal(
    signal: Signal, n_intervals: int, sample_rate: float, tolerance: float = ROUNDING
) -> FloatArray:
    """Return polynomials of degree 9 through a function of time at ten points an interval.

    Those miss a sine by 2 (omega h / 4)^10 / 10!: below rounding up to 0.1 of the sample rate.
    Of a chirp they are its Taylor series instead, as long as the tolerance takes.

    `sample_rate` is in [Hz], `tolerance` a share of the largest value [-].

    Returns
    -------
    (n_intervals, degree + 1) array
        Coefficients, in powers of the share of the interval that has passed.
    """
    if isinstance(signal, Chirp):
        known = signal.pieces(n_intervals, sample_rate, tolerance)
        if known is not None:
            return known
    nodes = 0.5 * (1.0 - np.cos(np.pi * np.arange(_ANALYTIC_DEGREE + 1) / _ANALYTIC_DEGREE))
    shared = (
        np.arange(n_intervals + 1)[:, None] + nodes[:-1]
    )  # the last is the next one's first
    time = shared.ravel()[: n_intervals * _ANALYTIC_DEGREE + 1] / sample_rate
    values = signal(time)
    pieces = np.empty((n_intervals, nodes.size))
    inverse_distances = 1.0 / (nodes[None, :] - nodes[:, None] + np.eye(nodes.size))
    through(np.asarray(values, dtype=float), nodes, inverse_distances, pieces)
    return pieces
