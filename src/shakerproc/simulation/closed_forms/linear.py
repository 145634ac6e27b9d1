r"""The mass on a spring and a damper, or with dry friction (eq. 3.8-3.27 of the thesis).

Eq. 3.19 prints ``v < 0`` for both signs; the third line is ``v > 0``. Eq. 3.23 prints
:math:`c\dot x` for the power; it is :math:`c\dot x^2`, and the result
:math:`\pi c\omega X^2` is right.
"""

import numpy as np

from shakerproc import checks
from shakerproc.data import FloatArray


def natural_frequency(mass: float, stiffness: float) -> float:
    r"""Return the undamped natural frequency, :math:`\sqrt{k/m} / 2\pi` [Hz] (Table 3.1).

    Parameters
    ----------
    mass : float
        Mass [kg].
    stiffness : float
        Stiffness [N/m].

    Raises
    ------
    ValueError
        If a parameter is not above 0.
    """
    checks.positive("mass", mass, "kg")
    checks.positive("stiffness", stiffness, "N/m")
    return float(np.sqrt(stiffness / mass) / (2.0 * np.pi))


def critical_damping(mass: float, stiffness: float) -> float:
    r"""Return the damping above which nothing oscillates, :math:`2\sqrt{k m}` [N s/m].

    The thesis' listing (appendix B) puts the force :math:`\kappa` [N] of the power law in the
    place of the stiffness; in SI that is not a damping.

    Parameters
    ----------
    mass : float
        Mass [kg].
    stiffness : float
        Stiffness [N/m].
    """
    return 4.0 * np.pi * mass * natural_frequency(mass, stiffness)


def steady_amplitude(
    frequency: FloatArray, mass: float, damping: float, stiffness: float, force: float
) -> FloatArray:
    r"""Return the amplitude of the forced motion (eq. 3.8).

    .. math:: X = F_0 / \sqrt{(k - m\omega^2)^2 + (c\omega)^2}

    Parameters
    ----------
    frequency : (...) array
        Forcing frequency [Hz].
    mass : float
        Mass [kg].
    damping : float
        Viscous damping [N s/m].
    stiffness : float
        Stiffness [N/m].
    force : float
        Amplitude of the force [N].

    Returns
    -------
    (...) array
        Amplitude of the displacement [m].
    """
    omega = 2.0 * np.pi * frequency
    return force / np.hypot(stiffness - mass * omega**2, damping * omega)


def steady_phase(
    frequency: FloatArray, mass: float, damping: float, stiffness: float
) -> FloatArray:
    r"""Return by how much the motion lags the force, from 0 to :math:`\pi` [rad] (eq. 3.9).

    The printed :math:`\tan^{-1}` jumps to :math:`-\pi/2` past resonance; the lag is the angle
    in the right quadrant.

    Parameters
    ----------
    frequency : (...) array
        Forcing frequency [Hz].
    mass : float
        Mass [kg].
    damping : float
        Viscous damping [N s/m].
    stiffness : float
        Stiffness [N/m].
    """
    omega = 2.0 * np.pi * frequency
    return np.arctan2(damping * omega, stiffness - mass * omega**2)


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


def forced_motion(
    time: FloatArray,
    forcing_frequency: float,
    *,
    natural: float,
    damping_ratio: float,
    static_deflection: float,
    initial_displacement: float = 0.0,
    initial_velocity: float = 0.0,
) -> FloatArray:
    r"""Return the whole motion under :math:`F_0 \sin\omega t` (eq. 3.12).

    The thesis leaves :math:`X_h` and :math:`\phi_h` open; here they follow from the state at
    time 0.

    Parameters
    ----------
    time : (n,) array
        Instants [s].
    forcing_frequency : float
        Frequency of the force [Hz].
    natural : float
        Natural frequency [Hz].
    damping_ratio : float
        :math:`\zeta`, above 0 and below 1 [-].
    static_deflection : float
        :math:`\delta_{st} = F_0 / k` [m].
    initial_displacement : float
        Displacement at time 0 [m].
    initial_velocity : float
        Velocity at time 0 [m/s].

    Returns
    -------
    (n,) array
        Displacement [m].
    """
    omega, omega_n = 2.0 * np.pi * forcing_frequency, 2.0 * np.pi * natural
    omega_d = 2.0 * np.pi * damped_frequency(natural, damping_ratio)
    ratio = np.array(forcing_frequency / natural)
    amplitude = static_deflection * magnification(ratio, damping_ratio)
    lag = phase_lag(ratio, damping_ratio)
    cosine = initial_displacement + amplitude * np.sin(lag)
    sine = (
        initial_velocity - amplitude * omega * np.cos(lag) + damping_ratio * omega_n * cosine
    ) / omega_d
    decay = np.exp(-damping_ratio * omega_n * time)
    free = decay * (cosine * np.cos(omega_d * time) + sine * np.sin(omega_d * time))
    return np.asarray(amplitude * np.sin(omega * time - lag) + free)


def equivalent_viscous_damping(
    sliding_force: float, frequency: FloatArray, amplitude: FloatArray
) -> FloatArray:
    r"""Return the viscous damping that dissipates as much per cycle (eq. 3.24) [N s/m].

    .. math:: c_{eq} = 4 F_c / (\pi \omega X)

    Parameters
    ----------
    sliding_force : float
        Friction force :math:`F_c = \mu F_N` [N].
    frequency : (...) array
        Frequency of the motion [Hz].
    amplitude : (...) array
        Amplitude of the motion :math:`X` [m].
    """
    return 4.0 * sliding_force / (2.0 * np.pi**2 * frequency * amplitude)


def equivalent_viscous_damping_ratio(
    sliding_force: float,
    frequency: FloatArray,
    amplitude: FloatArray,
    mass: float,
    natural: float,
) -> FloatArray:
    r"""Return eq. 3.24 as a damping ratio, :math:`c_{eq} / (2 m \omega_n)` [-] (eq. 3.25).

    Parameters
    ----------
    sliding_force : float
        Friction force [N].
    frequency : (...) array
        Frequency of the motion [Hz].
    amplitude : (...) array
        Amplitude of the motion [m].
    mass : float
        Mass [kg].
    natural : float
        Natural frequency [Hz].
    """
    damping = equivalent_viscous_damping(sliding_force, frequency, amplitude)
    return damping / (4.0 * np.pi * mass * natural)


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
