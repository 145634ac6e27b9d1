r"""Formulas of one mass, exact or as the thesis prints them, printed errors put right.

The Duffing oscillator of section 3.6:

.. math:: \ddot x + \omega_n^2 x + \mu x^3 = F \cos\omega t

From eq. 3.29 on the thesis divides by the mass: its :math:`\mu` there is the coefficient of
eq. 3.28 over the mass [1/(m² s²)] and its :math:`F` a force over the mass [m/s²]. These
functions keep to that.
"""

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc import checks
from shakerproc.data import FloatArray


def magnification(frequency_ratio: FloatArray, damping_ratio: float) -> FloatArray:
    r"""Return amplitude over static deflection (eq. 3.10, figure 3.1 a) [-].

    .. math:: X / \delta_{st} = 1 / \sqrt{(1 - r^2)^2 + (2 \zeta r)^2}

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r` [-].
    damping_ratio : float
        :math:`\zeta` [-].
    """
    return 1.0 / np.hypot(1.0 - frequency_ratio**2, 2.0 * damping_ratio * frequency_ratio)


def phase_lag(frequency_ratio: FloatArray, damping_ratio: float) -> FloatArray:
    r"""Return the lag behind the force, 0 to :math:`\pi` [rad] (eq. 3.11, figure 3.1 b).

    As in eq. 3.9, the printed :math:`\tan^{-1}` is off by :math:`\pi` past resonance.

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r` [-].
    damping_ratio : float
        :math:`\zeta` [-].
    """
    return np.arctan2(2.0 * damping_ratio * frequency_ratio, 1.0 - frequency_ratio**2)


def damped_frequency(frequency: float, damping_ratio: float) -> float:
    r"""Return the frequency of free decay, :math:`f_n \sqrt{1 - \zeta^2}` [Hz] (eq. 3.27).

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz].
    damping_ratio : float
        :math:`\zeta`, from 0 to below 1 [-].

    Raises
    ------
    ValueError
        If the damping is critical or above.
    """
    if not 0.0 <= damping_ratio < 1.0:
        raise ValueError(f"damping_ratio must lie in 0 to below 1, not {damping_ratio:g}")
    return float(frequency * np.sqrt(1.0 - damping_ratio**2))


def coulomb_harmonic_amplitude(
    frequency_ratio: FloatArray, friction_ratio: float
) -> FloatArray:
    r"""Return amplitude over static deflection by equivalent damping (eq. 3.26 with 3.24) [-].

    .. math:: X / \delta_{st} = \sqrt{1 - (4 F_c / \pi F_0)^2} \, / \, |1 - r^2|

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r`, other than 1 [-].
    friction_ratio : float
        :math:`F_c / F_0`, below :math:`\pi / 4` [-].

    Raises
    ------
    ValueError
        If the friction is too large for the formula.
    """
    if not 0.0 <= friction_ratio < np.pi / 4.0:
        raise ValueError(f"friction_ratio must lie in 0 to below pi/4, not {friction_ratio:g}")
    return np.asarray(
        np.sqrt(1.0 - (4.0 * friction_ratio / np.pi) ** 2) / np.abs(1.0 - frequency_ratio**2)
    )


def coulomb_amplitude(frequency_ratio: FloatArray, friction_ratio: float) -> FloatArray:
    r"""Return the exact amplitude over static deflection of motion that never sticks [-].

    .. math::
        \frac{X}{\delta_{st}} = \sqrt{V^2 - (F_c / F_0)^2 U^2}, \quad
        V = \frac{1}{1 - r^2}, \quad U = \frac{1}{r} \tan\frac{\pi}{2 r}

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r` [-].
    friction_ratio : float
        :math:`F_c / F_0` [-].

    Returns
    -------
    (...) array
        Amplitude ratio [-].

    Raises
    ------
    ValueError
        If the mass would stick at one of the frequencies (see `coulomb_sliding_bound`).

    References
    ----------
    .. [1] J. P. Den Hartog, "Forced vibrations with combined Coulomb and viscous friction",
       Transactions of the ASME 53, 107-115, 1931.
    """
    square = _dynamic(frequency_ratio) ** 2 - (friction_ratio * _turning(frequency_ratio)) ** 2
    sticking = ~(square > (friction_ratio * coulomb_sliding_bound(frequency_ratio)) ** 2)
    if np.any(sticking):
        where = np.atleast_1d(frequency_ratio)[np.atleast_1d(sticking)][0]
        raise ValueError(
            f"the mass sticks at frequency ratio {where:g} with F_c / F_0 = "
            f"{friction_ratio:g}; the closed form holds for motion without rest"
        )
    return np.sqrt(square)


def coulomb_sliding_bound(frequency_ratio: FloatArray) -> FloatArray:
    r"""Return the least amplitude, over :math:`F_c / k`, at which the mass never sticks [-].

    .. math::
        S = \max_{0 < \tau < \pi}
            \frac{U (\cos\tau - \cos(\tau / r)) + \sin(\tau / r) / r}{\sin\tau}

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r` [-].

    Returns
    -------
    (...) array
        Bound [-].
    """
    angle = np.linspace(0.0, np.pi, 4003)[1:-1]  # the ends are 0 over 0
    inverse = 1.0 / np.asarray(frequency_ratio)[..., None]
    turning = _turning(np.asarray(frequency_ratio))[..., None]
    above = turning * (np.cos(angle) - np.cos(angle * inverse))
    return np.asarray(
        np.max((above + inverse * np.sin(angle * inverse)) / np.sin(angle), axis=-1)
    )


def _dynamic(frequency_ratio: FloatArray) -> FloatArray:
    return 1.0 / (1.0 - frequency_ratio**2)


def _turning(frequency_ratio: FloatArray) -> FloatArray:
    return np.tan(np.pi / (2.0 * frequency_ratio)) / frequency_ratio


def duffing_harmonic_free_frequency(
    amplitude: FloatArray, natural: float, cubic: float
) -> FloatArray:
    r"""Return the free frequency in first approximation (eq. 3.39, 3.42, 3.49) [Hz].

    .. math:: \omega^2 = \omega_n^2 + \tfrac34 \mu A^2

    High by 0.39 % at :math:`\mu A^2 = \omega_n^2`, by 2.22 % in the limit.

    Parameters
    ----------
    amplitude : (...) array
        Amplitude :math:`A` [m].
    natural : float
        Frequency of small motion, 0 or above [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].
    """
    omega_n = 2.0 * np.pi * natural
    return np.sqrt(omega_n**2 + 0.75 * cubic * amplitude**2) / (2.0 * np.pi)


def duffing_free_frequency(amplitude: FloatArray, natural: float, cubic: float) -> FloatArray:
    r"""Return the exact free frequency [Hz].

    .. math::
        \omega = \frac{\pi \sqrt{\omega_n^2 + \mu A^2}}{2 K(k^2)}, \quad
        k^2 = \frac{\mu A^2}{2 (\omega_n^2 + \mu A^2)}

    Parameters
    ----------
    amplitude : (...) array
        Amplitude :math:`A` [m].
    natural : float
        Frequency of small motion, 0 or above [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].

    References
    ----------
    .. [1] I. Kovacic and M. J. Brennan, "The Duffing Equation", Wiley, 2011, sec. 4.2.
    """
    rate, modulus = _elliptic(amplitude, natural, cubic)
    return rate / (4.0 * scipy.special.ellipk(modulus))


def duffing_free_motion(
    time: FloatArray, amplitude: float, natural: float, cubic: float
) -> FloatArray:
    r"""Return the exact free motion from rest at the amplitude, :math:`A\,\mathrm{cn}` [m].

    Parameters
    ----------
    time : (n,) array
        Instants [s].
    amplitude : float
        Displacement at time 0 [m].
    natural : float
        Frequency of small motion [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].
    """
    rate, modulus = _elliptic(np.asarray(amplitude), natural, cubic)
    return np.asarray(amplitude * scipy.special.ellipj(rate * time, modulus)[1])


def duffing_perturbation_motion(
    time: FloatArray, amplitude: float, natural: float, cubic: float
) -> FloatArray:
    r"""Return the free motion in first perturbation (eq. 3.41 with the factor it lacks) [m].

    .. math:: x = A \cos\omega t + \mu \frac{A^3}{32 \omega^2} (\cos 3\omega t - \cos\omega t)

    Eq. 3.41 is printed without the :math:`\mu` of :math:`x = x_0 + \mu x_1`, and
    :math:`C_2` above eq. 3.40 with :math:`\omega` for :math:`\omega^2`.

    Parameters
    ----------
    time : (n,) array
        Instants [s].
    amplitude : float
        Displacement at time 0, where the mass is at rest [m].
    natural : float
        Frequency of small motion [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].
    """
    omega = 2.0 * np.pi * duffing_harmonic_free_frequency(np.array(amplitude), natural, cubic)
    third = cubic * amplitude**3 / (32.0 * omega**2)
    return np.asarray(
        (amplitude - third) * np.cos(omega * time) + third * np.cos(3.0 * omega * time)
    )


def duffing_response_frequencies(
    amplitude: FloatArray, natural: float, damping_rate: float, cubic: float, force: float
) -> tuple[FloatArray, FloatArray]:
    r"""Return the two forcing frequencies that give an amplitude, with damping (figure 3.9).

    .. math:: [(\omega_n^2 - \omega^2 + \tfrac34 \mu A^2)^2 + (\delta\omega)^2] A^2 = F^2

    Parameters
    ----------
    amplitude : (n,) array
        Amplitudes, above 0 [m].
    natural : float
        Frequency of small motion [Hz].
    damping_rate : float
        :math:`\delta`, damping over mass [1/s].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].
    force : float
        Force amplitude over mass [m/s²].

    Returns
    -------
    two (n,) arrays
        Lower and upper frequency [Hz]; NaN where there is none, as the curve is not a function.
    """
    centre = (2.0 * np.pi * natural) ** 2 + 0.75 * cubic * amplitude**2 - 0.5 * damping_rate**2
    inner = (centre**2 - ((2.0 * np.pi * natural) ** 2 + 0.75 * cubic * amplitude**2) ** 2) + (
        force / amplitude
    ) ** 2
    spread = np.sqrt(np.where(inner >= 0.0, inner, np.nan))
    squares = (centre - spread, centre + spread)
    lower, upper = (np.sqrt(np.where(s >= 0.0, s, np.nan)) / (2.0 * np.pi) for s in squares)
    return lower, upper


def _elliptic(
    amplitude: FloatArray, natural: float, cubic: float
) -> tuple[FloatArray, FloatArray]:
    """Return the rate [rad/s] and the parameter of the elliptic cosine."""
    square = (2.0 * np.pi * natural) ** 2 + cubic * amplitude**2
    return np.sqrt(square), cubic * amplitude**2 / (2.0 * square)


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
