r"""Semi-empirical force limits: what a fixture that gives way would let into the specimen.

.. math:: S_{FF} \le C^2 M_0^2 S_{AA}, \quad f < f_0; \qquad
    S_{FF} \le C^2 M_0^2 S_{AA} (f_0 / f)^2, \quad f \ge f_0

with the mass :math:`M_0` of the specimen and the frequency :math:`f_0` at which the force is
largest. The drive is notched where the apparent mass :math:`S_{FF} / S_{AA}` exceeds it [1]_.

References
----------
.. [1] NASA-HDBK-7004C, "Force Limited Vibration Testing", 2012, ch. 5.
"""

from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.forecasts.notches import with_edges

C_SQUARED: Final = 4.0
"""Factor :math:`C^2`, for which the handbook's cases give 2 to 5 [-]."""

INTO: Final = "force"
"""Whose quantity is the force into the specimen."""


def force_limited(
    frequency: FloatArray, apparent_mass: FloatArray, mass: float, slope: float
) -> FloatArray:
    """Return the reduction of a drive that a semi-empirical force limit asks for.

    Parameters
    ----------
    frequency : (n_bins,) array
        Rising frequencies [Hz].
    apparent_mass : (n_bins,) array
        Mean square of force over acceleration [kg^2].
    mass : float
        Mass of the specimen [kg].
    slope : float
        Steepest edge [dB/oct].

    Returns
    -------
    (n_bins,) array
        What is taken away [dB].
    """
    first = frequency[np.argmax(apparent_mass)]
    allowed = C_SQUARED * mass**2 * np.minimum(1.0, first / frequency) ** 2
    over = 10.0 * np.log10(np.maximum(apparent_mass / allowed, 1.0))
    return with_edges(np.log2(frequency), over, slope)
