"""Vibration response spectra and fatigue damage spectra of base accelerations."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra.shock import HIGHEST, STEPS, transitions


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
    from shakerproc.spectra import rainflow  # loads the compiler: late

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
            states, stacks = np.zeros((*shape, 6)), np.zeros((*shape, rainflow.STACK))
            sums = np.zeros((*shape, 3))
        n_samples += block.shape[1]
        for row, samples in enumerate(np.ascontiguousarray(block)):
            rainflow.follow_damage(
                samples, steps, substeps, damping, exponent, states[row], stacks[row], sums[row]
            )
    for row in range(len(sums)):
        rainflow.finish_damage(exponent, states[row], stacks[row], sums[row])
    count = max(n_samples, 1)
    return FatigueSpectra(
        frequency,
        np.sqrt(sums[..., 0] / count),
        np.sqrt(sums[..., 1] / count) / omega**2,
        sums[..., 2] / omega**exponent,
    )
