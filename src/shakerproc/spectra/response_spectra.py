"""Responses of oscillators: shock, vibration and fatigue damage spectra."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray

HIGHEST: Final = 0.1
"""Highest natural frequency, as a share of the sample rate [-] (ISO 18431-4)."""

STEPS: Final = 40
"""Steps of a period of the oscillator at least: 0.3 % of a peak are missed at most."""

PARTS: Final = (
    "primary_positive",
    "primary_negative",
    "residual_positive",
    "residual_negative",
    "maximax",
)
"""While the shock lasts and after it, each way; and the largest magnitude of all."""

QUANTITIES: Final = (
    "absolute_acceleration",
    "relative_velocity",
    "relative_displacement",
    "pseudo_velocity",
    "equivalent_static_acceleration",
)
"""What of the oscillator; the last two are the displacement times ω and ω²."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ShockSpectra:
    """Shock response spectra of some channels.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Natural frequencies [Hz].
    damping : float
        Damping ratio of every oscillator [-].
    values : dict
        By quantity and part, (n_channels, n_frequencies) arrays, negative parts as magnitudes
        [m/s², m/s or m].
    """

    frequency: FloatArray
    damping: float
    values: dict[str, dict[str, FloatArray]]


def logarithmic_frequencies(low: float, high: float, per_octave: int) -> FloatArray:
    """Return frequencies from low up to high, so many to an octave, both ends included [Hz].

    Raises
    ------
    ValueError
        If they do not rise from above 0, or there is less than one to an octave.
    """
    if not 0.0 < low < high or per_octave < 1:
        raise ValueError(f"no {per_octave} frequencies an octave from {low:g} to {high:g} Hz")
    octaves = np.log2(high / low)
    count = int(np.floor(octaves * per_octave + 1e-9)) + 1
    steps = low * 2.0 ** (np.arange(count) / per_octave)
    return steps if steps[-1] > high * (1.0 - 1e-9) else np.append(steps, high)


def shock_spectra(
    blocks: Iterable[FloatArray],
    sample_rate: float,
    frequency: FloatArray,
    damping: float,
) -> ShockSpectra:
    r"""Return the shock response spectra of base accelerations.

    The oscillator on the base follows

    .. math:: \ddot z + 2 \zeta \omega \dot z + \omega^2 z = -\ddot u

    and is solved exactly for an acceleration that is straight between the samples (ramp
    invariant), from rest. What comes after the last sample is a free decay, whose largest
    values are those of its closed form.

    Parameters
    ----------
    blocks : iterable of (n_channels, n_samples) arrays
        Acceleration of the base, one part after the other [m/s²].
    sample_rate : float
        Samples per second [Hz].
    frequency : (n_frequencies,) array
        Natural frequencies [Hz].
    damping : float
        Damping ratio, below 1 [-].

    Returns
    -------
    ShockSpectra
        All quantities and parts.

    Raises
    ------
    ValueError
        If the damping ratio is not from 0 to below 1, or a frequency is not from above 0 to a
        tenth of the sample rate.

    References
    ----------
    .. [1] ISO 18431-4:2007, Mechanical vibration and shock - Signal processing - Part 4:
       Shock-response spectrum analysis.
    .. [2] D. O. Smallwood, "An improved recursive formula for calculating shock response
       spectra", Shock and Vibration Bulletin 51(2), 211-217, 1981.
    """
    from shakerproc.spectra.kernels import follow_oscillators  # loads the compiler: late

    if not 0.0 <= damping < 1.0:
        raise ValueError(f"damping must be from 0 to below 1, not {damping:g}")
    highest = HIGHEST * sample_rate * (1.0 + 1e-9)
    if not ((frequency > 0.0) & (frequency <= highest)).all():
        raise ValueError(f"frequencies must lie above 0 and up to {highest:g} Hz")
    omega = 2.0 * np.pi * frequency
    substeps = np.ceil(STEPS * frequency / sample_rate).astype(np.int64)
    steps = transitions(omega / sample_rate / substeps, damping)
    states, extremes = np.zeros((0, frequency.size, 3)), np.zeros((0, frequency.size, 3, 2))
    for block in blocks:
        if not len(states):
            states = np.zeros((block.shape[0], *states.shape[1:]))
            extremes = np.zeros((block.shape[0], *extremes.shape[1:]))
        samples = np.ascontiguousarray(block)
        follow_oscillators(samples, steps, substeps, damping, states, extremes)
    after = _decay_extremes(states[..., :2], damping)
    return ShockSpectra(frequency, damping, _by_name(extremes, after, omega))


def transitions(step: FloatArray, damping: float) -> FloatArray:
    r"""Return how an oscillator goes on over one step, its input straight.

    With time in units of :math:`1/\omega`, and displacement times :math:`\omega^2`,

    .. math:: x_{k+1} = \Phi x_k + \Gamma_0 a_k + \Gamma_1 a_{k+1}

    Parameters
    ----------
    step : (n_frequencies,) array
        :math:`\omega` times the length of the step [-].
    damping : float
        Damping ratio [-].

    Returns
    -------
    (n_frequencies, 2, 4) array
        The columns of Φ, then Γ0 and Γ1 [-].
    """
    system = np.zeros((step.size, 4, 4))
    system[:, 0, 1] = step
    system[:, 1, 0] = -step
    system[:, 1, 1] = -2.0 * damping * step
    system[:, 1, 2] = -step
    system[:, 2, 3] = 1.0  # the input rises by the last state within one step
    whole = scipy.linalg.expm(system)
    propagators = whole[:, :2, :].copy()
    # a_k + s (a_(k+1) - a_k): the first sample counts as a level, less the rise from it
    propagators[:, :, 2] = whole[:, :2, 2] - whole[:, :2, 3]
    return np.ascontiguousarray(propagators)


def _decay_extremes(state: FloatArray, damping: float) -> FloatArray:
    r"""Return the largest and smallest values of a free decay.

    Every quantity is :math:`e^{-\zeta \tau}(A \cos \nu \tau + B \sin \nu \tau)`; of what comes
    after the start, the first two turning points are the largest.

    Parameters
    ----------
    state : (..., 2) array
        Displacement and velocity at the start, in the units of `transitions`.
    damping : float
        Damping ratio [-].

    Returns
    -------
    (..., 3, 2) array
        Least and largest of displacement, velocity, absolute acceleration.
    """
    nu = np.sqrt(1.0 - damping**2)
    y, v = state[..., 0], state[..., 1]
    acceleration = -y - 2.0 * damping * v  # absolute, and relative once the base is at rest
    jerk = -v - 2.0 * damping * acceleration
    extremes = []
    for start, rate in ((y, v), (v, acceleration), (acceleration, jerk)):
        cosine, sine = start, (rate + damping * start) / nu
        slope = np.arctan2(nu * sine - damping * cosine, nu * cosine + damping * sine) / nu
        values = [start]
        first = np.where(slope < 0.0, slope + np.pi / nu, slope)
        for tau in (first, first + np.pi / nu):
            decay = np.exp(-damping * tau)
            values.append(decay * (cosine * np.cos(nu * tau) + sine * np.sin(nu * tau)))
        extremes.append(np.stack([np.min(values, axis=0), np.max(values, axis=0)], axis=-1))
    return np.stack(extremes, axis=-2)


def _by_name(
    primary: FloatArray, residual: FloatArray, omega: FloatArray
) -> dict[str, dict[str, FloatArray]]:
    """Return extremes by quantity and part, in SI."""
    scales = {
        "absolute_acceleration": (2, np.ones(omega.shape)),
        "relative_velocity": (1, 1.0 / omega),
        "relative_displacement": (0, 1.0 / omega**2),
        "pseudo_velocity": (0, 1.0 / omega),
        "equivalent_static_acceleration": (0, np.ones(omega.shape)),
    }
    arrays = {}
    for name in QUANTITIES:
        row, scale = scales[name]
        sides = [
            np.maximum(sign * part[:, :, row, side], 0.0) * scale
            for part in (primary, residual)
            for sign, side in ((1.0, 1), (-1.0, 0))
        ]
        arrays[name] = dict(zip(PARTS, [*sides, np.max(sides, axis=0)], strict=True))
    return arrays


@final
@dataclass(frozen=True, slots=True, eq=False)
class FatigueSpectra:
    """Response and damage of oscillators under vibration, (n_channels, n_frequencies) arrays.

    Attributes
    ----------
    frequency : (n_frequencies,) array
        Natural frequencies [Hz].
    acceleration : array
        Root mean square of the absolute acceleration: the vibration response spectrum [m/s²].
    displacement : array
        Root mean square of the relative displacement [m].
    damage : array
        Sum over all cycles of the amplitude of the pseudo-velocity to the exponent: the fatigue
        damage spectrum, for a stress equal to it and one cycle to failure at 1 m/s
        [(m/s)^exponent].
    """

    frequency: FloatArray
    acceleration: FloatArray
    displacement: FloatArray
    damage: FloatArray


def fatigue_spectra(
    blocks: Iterable[FloatArray],
    sample_rate: float,
    frequency: FloatArray,
    *,
    damping: float,
    exponent: float,
) -> FatigueSpectra:
    r"""Return vibration response and fatigue damage spectra.

    The stress in an oscillator goes with its relative displacement, and across natural
    frequencies with its pseudo-velocity. Cycles are counted by rainflow, and damage is added up
    after Basquin and Miner:

    .. math:: D(f) = \sum_i n_i (\omega z_i)^b

    Parameters
    ----------
    blocks : iterable of (n_channels, n_samples) arrays
        Acceleration of the base, one part after the other [m/s²].
    sample_rate : float
        Samples per second [Hz].
    frequency : (n_frequencies,) array
        Natural frequencies [Hz].
    damping : float
        Damping ratio, below 1 [-].
    exponent : float
        Of the S-N curve, b [-].

    Returns
    -------
    FatigueSpectra
        For every channel.

    Raises
    ------
    ValueError
        If a frequency is not from above 0 to a tenth of the sample rate, or the damping or the
        exponent is out of range.

    References
    ----------
    .. [1] C. Lalanne, "Mechanical Vibration and Shock Analysis, vol. 5: Specification
       Development", 3rd ed., ISTE and Wiley, 2014.
    .. [2] G. R. Henderson and A. G. Piersol, "Fatigue damage related descriptor for random
       vibration test environments", Sound and Vibration 29(10), 20-24, 1995.
    """
    from shakerproc.spectra import kernels

    if not 0.0 < damping < 1.0 or not 0.0 < exponent < 50.0:
        raise ValueError(f"no damage at a damping of {damping:g} and an exponent {exponent:g}")
    highest = HIGHEST * sample_rate * (1.0 + 1e-9)
    if not ((frequency > 0.0) & (frequency <= highest)).all():
        raise ValueError(f"frequencies must lie above 0 and up to {highest:g} Hz")
    omega = 2.0 * np.pi * frequency
    substeps = np.ceil(STEPS * frequency / sample_rate).astype(np.int64)
    steps = transitions(omega / sample_rate / substeps, damping)
    states, stacks, sums = (np.zeros((0, 0)),) * 3
    n_samples = 0
    for block in blocks:
        if not n_samples:
            shape = (len(block), frequency.size)
            states, stacks = np.zeros((*shape, 6)), np.zeros((*shape, kernels.STACK))
            sums = np.zeros((*shape, 3))
        n_samples += block.shape[1]
        for row, samples in enumerate(np.ascontiguousarray(block)):
            kernels.follow_damage(
                samples, steps, substeps, damping, exponent, states[row], stacks[row], sums[row]
            )
    for row in range(len(sums)):
        kernels.finish_damage(exponent, states[row], stacks[row], sums[row])
    count = max(n_samples, 1)
    return FatigueSpectra(
        frequency,
        np.sqrt(sums[..., 0] / count),
        np.sqrt(sums[..., 1] / count) / omega**2,
        sums[..., 2] / omega**exponent,
    )
