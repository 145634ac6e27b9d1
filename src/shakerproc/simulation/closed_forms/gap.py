"""The mass with free play, on one-sided springs and on a power law: exact free frequencies."""

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.data import FloatArray


def gap_backbone(amplitude: FloatArray, clearance: float) -> FloatArray:
    r"""Return the exact free frequency over that without clearance [-].

    .. math:: \frac{\omega}{\omega_n} = \frac{1}{1 + \frac{2 a}{\pi (A - a)}}

    For free play of different size on the two sides, take the mean clearance, and for the
    amplitude the mean of the two extremes.

    Parameters
    ----------
    amplitude : (...) array
        Amplitude :math:`A`, above the clearance [m].
    clearance : float
        Free play on either side :math:`a` [m].

    Returns
    -------
    (...) array
        Frequency ratio, from 0 to 1 [-].

    Raises
    ------
    ValueError
        If an amplitude does not reach the contact.
    """
    checks.not_negative("clearance", clearance, "m")
    _reaches(amplitude, clearance)
    return 1.0 / (1.0 + 2.0 * clearance / (np.pi * (amplitude - clearance)))


def gap_describing_function(amplitude: FloatArray, clearance: float) -> FloatArray:
    r"""Return the stiffness that a harmonic motion feels, over the contact stiffness [-].

    .. math::
        \frac{k_{eq}}{k} = 1 - \frac{2}{\pi} \left(\arcsin\frac{a}{A}
            + \frac{a}{A} \sqrt{1 - \frac{a^2}{A^2}}\right)

    Parameters
    ----------
    amplitude : (...) array
        Amplitude, at or above the clearance [m].
    clearance : float
        Free play on either side [m].

    Raises
    ------
    ValueError
        If an amplitude does not reach the contact.

    References
    ----------
    .. [1] A. Gelb and W. E. Vander Velde, "Multiple-Input Describing Functions and Nonlinear
       System Design", McGraw-Hill, 1968, app. B.
    """
    _reaches(amplitude, clearance)
    share = clearance / amplitude
    return 1.0 - 2.0 / np.pi * (np.arcsin(share) + share * np.sqrt(1.0 - share**2))


def gap_harmonic_backbone(amplitude: FloatArray, clearance: float) -> FloatArray:
    """Return the free frequency ratio with one harmonic [-].

    It is high by 53 % at A/a = 1.05, 2.3 % at 2 and 0.04 % at 10 against `gap_backbone`.

    Parameters
    ----------
    amplitude : (...) array
        Amplitude, at or above the clearance [m].
    clearance : float
        Free play on either side [m].
    """
    return np.sqrt(gap_describing_function(amplitude, clearance))


def bilinear_frequency_ratio(stiffness_ratio: FloatArray) -> FloatArray:
    r"""Return the free frequency with a stop at rest, over that without it [-].

    .. math:: \frac{\omega}{\omega_1} = \frac{2 \sqrt{1 + s}}{1 + \sqrt{1 + s}}

    Parameters
    ----------
    stiffness_ratio : (...) array
        Stiffness of the one-sided stop over that of the spring, :math:`s` [-].

    References
    ----------
    .. [1] S. W. Shaw and P. J. Holmes, "A periodically forced piecewise linear oscillator",
       Journal of Sound and Vibration 90, 129-155, 1983.
    """
    stiffer = np.sqrt(1.0 + stiffness_ratio)
    return np.asarray(2.0 * stiffer / (1.0 + stiffer))


def power_law_frequency(
    amplitude: FloatArray,
    mass: float,
    force: float,
    reference_displacement: float,
    exponent: float,
) -> FloatArray:
    r"""Return the exact free frequency on :math:`F = \kappa |x/a|^p \mathrm{sgn}\,x` [Hz].

    .. math::
        T = 4 \sqrt{\frac{m (p + 1) A}{2 \kappa (A/a)^p}} \;
            \frac{\sqrt\pi \, \Gamma(1 + \frac{1}{p+1})}{\Gamma(\frac12 + \frac{1}{p+1})}

    Eq. 3.15 of the thesis writes the exponent as :math:`2n - 1`; its listing and eq. 6.6 as
    :math:`n`. Here it is the exponent itself.

    Parameters
    ----------
    amplitude : (...) array
        Amplitude :math:`A` [m].
    mass : float
        Mass [kg].
    force : float
        Force :math:`\kappa` at the reference displacement [N].
    reference_displacement : float
        :math:`a` [m].
    exponent : float
        :math:`p`, above 0 [-].

    Returns
    -------
    (...) array
        Frequency [Hz].

    Raises
    ------
    ValueError
        If a parameter is not above 0.
    """
    checks.positive("mass", mass, "kg")
    checks.positive("force", force, "N")
    checks.positive("reference_displacement", reference_displacement, "m")
    checks.positive("exponent", exponent, "-")
    share = 1.0 / (exponent + 1.0)
    shape = np.sqrt(np.pi) * scipy.special.gamma(1.0 + share) / scipy.special.gamma(0.5 + share)
    restoring = force * (amplitude / reference_displacement) ** exponent
    return np.asarray(
        1.0 / (4.0 * shape * np.sqrt(mass * amplitude / (2.0 * share * restoring)))
    )


def displacement_amplitude(acceleration: FloatArray, frequency: FloatArray) -> FloatArray:
    r"""Return the displacement of a table at constant acceleration (eq. 5.5, figure 5.14) [m].

    .. math:: A = a_0 / (4 \pi^2 f^2)

    The formula above eq. 5.5 lacks a :math:`\pi`; the text's number, 0.00155 mm at 400 Hz and
    1 g, is right.

    Parameters
    ----------
    acceleration : (...) array
        Amplitude of the acceleration [m/s²].
    frequency : (...) array
        Frequency [Hz].
    """
    return acceleration / (2.0 * np.pi * frequency) ** 2


def _reaches(amplitude: FloatArray, clearance: float) -> None:
    smallest = float(np.min(amplitude))
    if not smallest > clearance:
        raise ValueError(
            f"amplitude must be above the clearance {clearance:g} m, not {smallest:g} m: "
            f"inside it there is no contact and no frequency"
        )
