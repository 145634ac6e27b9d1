"""The input between its samples, as a polynomial over each of them."""

from collections.abc import Callable
from typing import Literal, TypeAlias

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.simulation.chirps import ROUNDING, Chirp
from shakerproc.simulation.interpolation import finer
from shakerproc.simulation.kernels.powers import through

Hold: TypeAlias = Literal["band-limited", "linear"]
Signal: TypeAlias = Callable[[FloatArray], FloatArray]
"""A function of time [s] that gives the input, in its SI unit."""

_ANALYTIC_DEGREE = 9


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
