r"""The mass on a Duffing spring, with free play, stops or a power law: exact frequencies.

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


def duffing_harmonic_frequency(
    amplitude: FloatArray, natural: float, cubic: float, force: float
) -> FloatArray:
    r"""Return the forcing frequency that gives an amplitude, without damping (eq. 3.47) [Hz].

    .. math:: \omega^2 = \omega_n^2 + \tfrac34 \mu A^2 - F / A

    This is harmonic balance with one harmonic. With :math:`\mu = 0` it is eq. 3.48, with
    :math:`F = 0` eq. 3.49.

    Parameters
    ----------
    amplitude : (...) array
        Amplitude, negative where the motion opposes the force [m].
    natural : float
        Frequency of small motion [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass [1/(m² s²)].
    force : float
        :math:`F`, force amplitude over mass [m/s²].

    Returns
    -------
    (...) array
        Frequency [Hz].

    Raises
    ------
    ValueError
        If no frequency gives one of the amplitudes.
    """
    omega_n = 2.0 * np.pi * natural
    square = omega_n**2 + 0.75 * cubic * amplitude**2 - force / amplitude
    if np.any(square < 0.0):
        worst = np.atleast_1d(amplitude)[np.argmin(np.atleast_1d(square))]
        raise ValueError(f"no forcing frequency gives the amplitude {worst:g} m")
    return np.asarray(np.sqrt(square) / (2.0 * np.pi))


def duffing_harmonic_force(
    amplitude: FloatArray, frequency: FloatArray, natural: float, cubic: float
) -> FloatArray:
    """Return the force over mass that eq. 3.46 balances [m/s²].

    Parameters
    ----------
    amplitude : (...) array
        Amplitude [m].
    frequency : (...) array
        Forcing frequency [Hz].
    natural : float
        Frequency of small motion [Hz].
    cubic : float
        Cubic coefficient over mass [1/(m² s²)].
    """
    square = (2.0 * np.pi) ** 2 * (natural**2 - frequency**2)
    return square * amplitude + 0.75 * cubic * amplitude**3


def duffing_amplitudes(
    frequency: float, natural: float, cubic: float, force: float
) -> FloatArray:
    r"""Return every amplitude at a forcing frequency without damping: one or three (eq. 3.46).

    Parameters
    ----------
    frequency : float
        Forcing frequency [Hz].
    natural : float
        Frequency of small motion [Hz].
    cubic : float
        :math:`\mu`, cubic coefficient over mass, other than 0 [1/(m² s²)].
    force : float
        Force amplitude over mass [m/s²].

    Returns
    -------
    (1,) or (3,) array
        Signed amplitudes in rising order [m].
    """
    square = (2.0 * np.pi) ** 2 * (natural**2 - frequency**2)
    roots = np.roots([0.75 * cubic, 0.0, square, -force])
    real = np.abs(roots.imag) < 1e-9 * np.abs(roots)
    return np.sort(roots[real].real)


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
