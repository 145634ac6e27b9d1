r"""The mass on a spring with dry friction (eq. 3.18-3.25), exactly and by equivalent damping.

Eq. 3.19 prints ``v < 0`` for both signs; the third line is ``v > 0``. Eq. 3.23 prints
:math:`c\dot x` for the power; it is :math:`c\dot x^2`, and the result
:math:`\pi c\omega X^2` is right.
"""

import numpy as np

from shakerproc.data import FloatArray


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


def coulomb_sliding_bound(frequency_ratio: FloatArray, n_instants: int = 4001) -> FloatArray:
    r"""Return the least amplitude, over :math:`F_c / k`, at which the mass never sticks [-].

    .. math::
        S = \max_{0 < \tau < \pi}
            \frac{U (\cos\tau - \cos(\tau / r)) + \sin(\tau / r) / r}{\sin\tau}

    Parameters
    ----------
    frequency_ratio : (...) array
        Forcing frequency over natural frequency, :math:`r` [-].
    n_instants : int
        Instants of the half cycle at which the maximum is sought.

    Returns
    -------
    (...) array
        Bound [-].
    """
    angle = np.linspace(0.0, np.pi, n_instants + 2)[1:-1]
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
