"""A stretch of a decay as one decaying sinusoid, by least squares."""

from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.spectra.decays.isolation import DecayEnvelope
from shakerproc.spectra.decays.reading import (
    Reading,
    reading_of,
    weighted_middle,
    within_stretch,
)

LEAST: Final = 8
"""Independent values of an envelope in a stretch at least [-]: six parameters of sixteen."""

STEPS: Final = 8
"""Steps of Gauss and Newton; from the parabolas they converge in three to five [-]."""


def read_envelope(envelope: DecayEnvelope, start: float, stop: float) -> Reading | None:
    r"""Return frequency and damping of a stretch by least squares.

    .. math:: z(t) = e^{a + p t + q t^2}

    is fitted to the envelope, with complex :math:`a`, :math:`p` and :math:`q`, from parabolas
    through logarithm and phase on; time is that from the middle of the power. The pole is
    :math:`p`; :math:`q` takes up how frequency and damping change within the stretch. What is
    left is taken for white noise of that stretch; intervals are those of Student's law.

    Parameters
    ----------
    envelope : DecayEnvelope
        Of the mode.
    start, stop : float
        The stretch [s].

    Returns
    -------
    Reading or None
        None where it holds too few values.
    """
    inside = (envelope.time >= start) & (envelope.time <= stop)
    time, values = envelope.time[inside], envelope.values[inside]
    if time.size < LEAST or not np.abs(values).min() > 0.0:
        return None
    weights = np.abs(values) ** 2
    middle = weighted_middle(time, weights)
    half_width = 0.5 * float(np.ptp(time))
    design = np.vander((time - middle) / half_width, 3, increasing=True)
    root = np.abs(values)
    target = np.log(np.abs(values)) + 1j * np.unwrap(np.angle(values))
    found, *_ = np.linalg.lstsq(design * root[:, np.newaxis] + 0j, target * root, rcond=None)
    for _ in range(STEPS):
        wave = np.exp(design @ found)
        step, *_ = np.linalg.lstsq(design * wave[:, np.newaxis], values - wave, rcond=None)
        if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
            return None  # noise, not a decay
        found = found + step
    wave = np.exp(design @ found)
    slopes = design * wave[:, np.newaxis]
    freedom = time.size - design.shape[1]
    power = float(np.sum(np.abs(values - wave) ** 2)) / freedom
    covariance = power * np.linalg.inv((slopes.conj().T @ slopes).real)
    half = float(scipy.special.stdtrit(2 * freedom, 0.975) * np.sqrt(0.5 * covariance[1, 1]))
    amplitude, pole, bend = float(np.exp(found[0].real)), found[1] / half_width, found[2]
    half /= half_width
    return reading_of(
        complex(pole) + 2j * np.pi * envelope.frequency,
        (
            half + within_stretch(pole.real, bend.real),
            half + within_stretch(pole.real, bend.imag),
        ),
        middle,
        amplitude,
        float(np.sqrt(power)) / amplitude,
    )
