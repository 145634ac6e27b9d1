"""The mass on a spring and a damper (eq. 3.8-3.12 and 3.27 of the thesis)."""

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
