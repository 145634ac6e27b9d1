"""Whether a force and the motion at its own point fit each other: power only goes in."""

from typing import Final

import numpy as np

from shakerproc.spectra.responses.masks import excited
from shakerproc.spectra.welch.cross import CrossSpectra

INTEGRATIONS: Final = {"m/s^2": 1, "m/s": 0, "m": -1, "rad/s^2": 1, "rad/s": 0, "rad": -1}
"""How often a motion of a unit is integrated to a velocity."""


def power_share(
    spectra: CrossSpectra, force: int, response: int, unit: str, band: tuple[float, float]
) -> float:
    r"""Return the power that a force feeds in at a point, net over gross.

    .. math:: \frac{\sum_f \Re S_{Fv}(f)}{\sum_f |\Re S_{Fv}(f)|}

    A passive structure takes power in at every frequency where the velocity :math:`v` is that
    of the point of the force, along it. Where an exponential window of the decay rate
    :math:`\sigma` multiplied both, this holds at :math:`s = \sigma + j\omega`, so that an
    acceleration is divided by that.

    Parameters
    ----------
    spectra : CrossSpectra
        Matrix of cross spectra.
    force, response : int
        Rows of the force and of the motion.
    unit : str
        Of the motion: ``m/s^2``, ``m/s`` or ``m``.
    band : (float, float)
        Where the force reaches [Hz].

    Returns
    -------
    float
        1 where all power goes in, -1 where one of the two is the wrong way round, about 0
        where the motion is that of another point or late; 0 without any power.

    References
    ----------
    .. [1] D. J. Ewins, "Modal Testing", 2nd ed., Research Studies Press, 2000, ch. 2 and 3.
    """
    inside = excited(spectra.frequency, band) & (spectra.frequency > 0.0)
    s = (spectra.decay_rate or 0.0) + 2j * np.pi * spectra.frequency[inside]
    cross = spectra.between([force], [response])[0, 0, inside]
    power = (cross * s ** -INTEGRATIONS[unit]).real
    gross = float(np.abs(power).sum())
    return float(power.sum()) / gross if gross > 0.0 else 0.0
