"""The input between its samples, as a polynomial over each; of chirps by recurrence."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from math import frexp, ldexp, pi
from typing import Final, Literal, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.interpolation import finer
from shakerproc.simulation.kernels.powers import chirp_pieces, through

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
    apart = 1.0 / (nodes[None, :] - nodes[:, None] + np.eye(nodes.size))
    through(np.asarray(values, dtype=float), nodes, apart, pieces)
    return pieces
