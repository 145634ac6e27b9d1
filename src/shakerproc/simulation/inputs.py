"""Inputs of a model, prepared for the steppers."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray
from shakerproc.simulation.pieces import (
    ROUNDING,
    Chirp,
    Hold,
    InterpolationError,
    Signal,
    interpolation_error,
    pieces_of_samples,
    pieces_of_signal,
)

MISSED: Final = 1e-4
"""Share of the largest value by which pieces may miss the band-limited signal through measured
samples: a tenth of the noise of a good recorder, 60 dB [-]."""

FINEST: Final = 8
"""Parts of a sample at most in which measured samples are prepared [-]."""

MOST_SAMPLES: Final = 2e7
"""Samples of a simulated run: an hour at the laboratory's rate."""


@final
@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Input:
    """Input of the model, prepared once for any number of simulations.

    Attributes
    ----------
    pieces : (n_pieces, degree + 1) array
        The input over each part of a sample, in powers of the share of it that has passed.
    stride : int
        Parts of a sample.
    sample_rate : float
        Samples per second of the response [Hz].
    span : int
        Samples that a piece covers, where it is longer than one.
    surplus : int
        Samples at the end of the last piece that are not wanted.
    missed : float
        Share of its amplitude by which the pieces may miss a function of time, or the
        band-limited signal through samples [-].
    interpolation : InterpolationError, optional
        The latter, near the ends and elsewhere.
    imposed : (2, n_samples) array, optional
        Displacement [m] and velocity [m/s] at the samples, where these are imposed on a mass;
        the pieces are its acceleration.
    """

    pieces: FloatArray
    stride: int
    sample_rate: float
    span: int = 1
    surplus: int = 0
    missed: float = 0.0
    interpolation: InterpolationError | None = None
    imposed: FloatArray | None = None

    @property
    def missed_between(self) -> float:
        """Share of the largest value that pieces miss of samples, the ends apart [-]."""
        return 0.0 if self.interpolation is None else self.interpolation.middle

    @property
    def part(self) -> float:
        """Length of a piece [s]."""
        return self.span / (self.sample_rate * self.stride)

    @property
    def n_samples(self) -> int:
        """Samples of the response, the one at time 0 included."""
        n_pieces = len(self.pieces)
        return n_pieces * self.span // self.stride + 1 - self.surplus

    @property
    def samples(self) -> FloatArray:
        """The input at the samples, (n,) array."""
        if self.span == 1:
            return np.append(self.pieces[:: self.stride, 0], np.sum(self.pieces[-1]))
        shares = np.arange(1, self.span + 1) / self.span
        powers = np.vander(shares, self.pieces.shape[1], increasing=True)
        values = (self.pieces @ powers.T).ravel()
        return np.append(self.pieces[0, 0], values)[: self.n_samples]


def prepare(
    excitation: FloatArray | Signal,
    sample_rate: float,
    *,
    duration: float | None = None,
    upsample: int = 1,
    hold: Hold = "band-limited",
    tolerance: float = ROUNDING,
) -> Input:
    """Return the input of simulations, from samples or from a function of time.

    Parameters
    ----------
    excitation : (n,) array or function
        Samples of the input, or the input as a function of time, in its SI unit.
    sample_rate : float
        Samples per second, of the input and of the response [Hz].
    duration : float, optional
        Length of a response to a function of time [s].
    upsample : int
        Into how many parts to cut each sample first; see `pieces.pieces_of_samples`.
    hold : {"band-limited", "linear"}
        What the input does between its samples.
    tolerance : float
        By which share of its amplitude the pieces of a chirp may miss it [-].

    Raises
    ------
    ValueError
        If there are fewer than two samples, or a function comes without a duration.
    """
    checks.positive("sample_rate", sample_rate, "Hz")
    if callable(excitation):
        if duration is None:
            raise ValueError("a function of time needs a duration")
        checks.positive("duration", duration, "s")
        n_intervals = max(1, round(duration * sample_rate))
        pieces = pieces_of_signal(
            excitation, n_intervals * upsample, sample_rate * upsample, tolerance
        )
        return Input(pieces, upsample, sample_rate, missed=tolerance)
    samples = np.asarray(excitation, dtype=float)
    if samples.ndim != 1 or samples.size < 2:
        raise ValueError(f"excitation must be (n,) samples, at least 2, not {samples.shape}")
    if not np.all(np.isfinite(samples)):
        at = int(np.flatnonzero(~np.isfinite(samples))[0])
        raise ValueError(f"excitation must be finite; sample {at} is {samples[at]}")
    pieces = pieces_of_samples(samples, upsample=upsample, hold=hold)
    if hold == "linear":
        return Input(pieces, upsample, sample_rate)
    error = interpolation_error(samples, pieces, upsample)
    return Input(pieces, upsample, sample_rate, missed=error.largest, interpolation=error)


def prepare_displacement(
    displacement: FloatArray, sample_rate: float, *, upsample: int = 1
) -> Input:
    """Return the input of simulations in which the displacement of a mass is imposed.

    The motion between samples is that of `prepare`, quintics that meet with their slopes and
    curvatures; the mass gets their acceleration and starts with their motion.

    Parameters
    ----------
    displacement : (n,) array
        Displacement of the mass against the base [m].
    sample_rate, upsample
        As for `prepare` [Hz].

    Raises
    ------
    ValueError
        As `prepare` does.
    """
    given = prepare(displacement, sample_rate, upsample=upsample)
    return _imposed(given, np.asarray(displacement, dtype=float))


def _imposed(given: Input, displacement: FloatArray) -> Input:
    """Return the input whose pieces are those of a displacement as that of its acceleration."""
    rate = given.sample_rate * given.stride
    k = np.arange(given.pieces.shape[1])
    accelerations = (given.pieces * (k * (k - 1) * rate**2))[:, 2:]
    velocity = np.append(given.pieces[:, 1], given.pieces[-1] @ k)[:: given.stride] * rate
    motion = np.stack((displacement, velocity))
    return replace(given, pieces=np.ascontiguousarray(accelerations), imposed=motion)


def prepare_measured(samples: FloatArray, sample_rate: float, *, imposed: bool) -> Input:
    """Return the input of simulations from a measurement, in as many parts as it needs.

    A drive up to a third of the sample rate is missed by pieces of a sample each; a joint that
    slips for a moment where it is largest feels that. Of noise up to half the rate more parts
    miss as much as fewer.

    Parameters
    ----------
    samples : (n,) array
        The measured input, in its SI unit.
    sample_rate : float
        Samples per second [Hz].
    imposed : bool
        Whether it is the displacement of a mass.
    """
    made = prepare_displacement if imposed else prepare
    given = made(samples, sample_rate)
    while given.missed_between > MISSED and given.stride < FINEST:
        finer = made(samples, sample_rate, upsample=2 * given.stride)
        if finer.missed_between > 0.5 * given.missed_between:
            break
        given = finer
    return given


def prepare_like(samples: FloatArray, given: Input) -> Input:
    """Return the input through samples that differ by noise from those of another one.

    In as many parts; its pieces are taken to miss as much.

    Parameters
    ----------
    samples : (n,) array
        The input, in its SI unit; a displacement where the other imposes one [m].
    given : Input
        Of `prepare` or `prepare_displacement`, from as many samples.
    """
    pieces = pieces_of_samples(samples, upsample=given.stride, hold="band-limited")
    like = replace(given, pieces=pieces)
    return like if given.imposed is None else _imposed(like, samples)


def with_constant(given: Input, value: float) -> Input:
    """Return an input with a constant besides [m/s^2 or N]."""
    if value == 0.0:
        return given
    pieces = given.pieces.copy()
    pieces[:, 0] += value
    return replace(given, pieces=pieces)


def prepare_long(
    signal: Chirp, sample_rate: float, duration: float, span: int, tolerance: float
) -> Input | None:
    """Return the input in pieces of several samples each, for steps as long as they.

    Parameters
    ----------
    signal : Chirp
        What shakes the model.
    sample_rate : float
        Samples per second of the response [Hz].
    duration : float
        Length of the response [s].
    span : int
        Samples of a piece.
    tolerance : float
        By which share of its amplitude the pieces may miss it [-].

    Returns
    -------
    Input or None
        None where the signal turns too far in a piece.
    """
    n_intervals = max(1, round(duration * sample_rate))
    n_pieces = -(-n_intervals // span)
    pieces = signal.pieces(n_pieces, sample_rate / span, tolerance)
    if pieces is None:
        return None
    return Input(pieces, 1, sample_rate, span, n_pieces * span - n_intervals, tolerance)


def as_input(
    excitation: FloatArray | Signal | Input,
    sample_rate: float | None,
    *,
    duration: float | None,
    tolerance: float,
    imposed: bool = False,
) -> Input:
    """Return an input as it is, or made by `prepare`.

    `excitation` is in [m/s²], [N] or [m], `sample_rate` in [Hz], `duration` in [s], `tolerance`
    a share [-].

    Raises
    ------
    ValueError
        If an input comes with a sample rate, or anything else without one.
    """
    if isinstance(excitation, Input):
        if sample_rate is not None:
            raise ValueError("an Input has a sample rate of its own")
        if imposed != (excitation.imposed is not None):
            raise ValueError("an imposed displacement takes what prepare_displacement made")
        return excitation
    if sample_rate is None:
        raise ValueError("the excitation needs a sample rate")
    if imposed:
        if callable(excitation):
            raise ValueError("an imposed displacement is given by its samples")
        return prepare_displacement(excitation, sample_rate)
    return prepare(
        excitation, sample_rate, duration=duration, tolerance=max(tolerance, ROUNDING)
    )
