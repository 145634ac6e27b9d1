"""A sine whose frequency changes evenly in time, and its pieces, computed by recurrence."""

from dataclasses import dataclass
from fractions import Fraction
from math import frexp, ldexp, pi
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.kernels.powers import chirp_pieces

ROUNDING: Final = 1e-15
"""Share of its amplitude by which rounding alone makes a signal miss [-]."""

_HIGHEST: Final = 24
_DIGITS: Final = 53  # of a number, in base 2


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
