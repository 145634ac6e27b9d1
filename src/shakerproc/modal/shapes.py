r"""Mode shapes: alike or not, in one phase or not, scaled for a drawing, expanded (SEREP).

A measured shape at all points of a model is

.. math:: \hat\psi = \Phi \Phi_a^+ \psi_a

with the shapes of the model at all points, :math:`\Phi`, and at the sensors, :math:`\Phi_a`. A
sensor that is left out is predicted from the others with the error (Allen's PRESS)

.. math:: e_i = \frac{(\psi_a - \Phi_a \Phi_a^+ \psi_a)_i}{1 - (\Phi_a \Phi_a^+)_{ii}}

Of a mode that one sensor alone tells, the others say nothing: it is 0 in what they predict.
Of the modes nearest in frequency as many are taken as predict the sensors that are left out
best: more modes than that follow the noise of the sensors.

References
----------
.. [1] J. O'Callahan, P. Avitabile and R. Riemer, "System equivalent reduction expansion process
   (SEREP)", 7th International Modal Analysis Conference, 29-37, 1989.
.. [2] D. M. Allen, "The relationship between variable selection and data augmentation and a
   method for prediction", Technometrics 16, 125-127, 1974.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import ComplexArray, FloatArray


def mac(first: ComplexArray, second: ComplexArray) -> FloatArray:
    r"""Return the modal assurance criterion of every pair of shapes.

    .. math:: MAC = \frac{|\phi^H \psi|^2}{(\phi^H \phi)(\psi^H \psi)}

    Parameters
    ----------
    first, second : (..., n, n_sensors) complex arrays
        Shapes, in any scale [-].

    Returns
    -------
    (n_first, n_second) array
        0 (nothing in common) to 1 (alike up to a factor) [-].

    References
    ----------
    .. [1] R. J. Allemang, "The modal assurance criterion: twenty years of use and abuse",
       Sound and Vibration 37, 14-23, 2003.
    """
    a, b = np.atleast_2d(first), np.atleast_2d(second)
    power = np.outer(np.sum(np.abs(a) ** 2, axis=1), np.sum(np.abs(b) ** 2, axis=1))
    shared = np.abs(a.conj() @ b.T) ** 2
    result: FloatArray = np.zeros(shared.shape)
    np.divide(shared, power, out=result, where=power > 0.0)
    return np.minimum(result, 1.0)


def phase_collinearity(shapes: ComplexArray) -> FloatArray:
    r"""Return the modal phase collinearity of each shape.

    .. math:: MPC = \left( \frac{\lambda_1 - \lambda_2}{\lambda_1 + \lambda_2} \right)^2

    with the eigenvalues of the covariance of real and imaginary parts.

    Parameters
    ----------
    shapes : (n_modes, n_sensors) complex array
        Shapes, in any scale [-].

    Returns
    -------
    (n_modes,) array
        1 where all sensors move in one phase, 0 where the phases are all over the place [-].

    References
    ----------
    .. [1] R. S. Pappa, K. B. Elliott and A. Schenk, "Consistent-mode indicator for the
       eigensystem realization algorithm", J. Guidance, Control, Dynamics 16, 852-858, 1993.
    """
    real, imaginary = shapes.real, shapes.imag
    xx, yy = np.sum(real**2, axis=1), np.sum(imaginary**2, axis=1)
    xy = np.sum(real * imaginary, axis=1)
    total = (xx + yy) ** 2
    result: FloatArray = np.zeros(total.shape)
    np.divide((xx - yy) ** 2 + 4.0 * xy**2, total, out=result, where=total > 0.0)
    return result


def normalised(shapes: ComplexArray) -> ComplexArray:
    """Return shapes turned to their mean phase, the largest component 1.

    Parameters
    ----------
    shapes : (n_modes, n_sensors) complex array
        Shapes, in any scale and phase [-].

    Returns
    -------
    (n_modes, n_sensors) complex array
        As real as a turn can make them; largest magnitude 1, its sign positive [-].
    """
    squares = np.sum(shapes**2, axis=1, keepdims=True)
    turned = shapes * np.exp(-0.5j * np.angle(squares))
    largest = np.argmax(np.abs(turned), axis=1)[:, np.newaxis]
    pivot = np.take_along_axis(turned, largest, axis=1)
    scale = np.where(pivot.real < 0.0, -1.0, 1.0) * np.abs(pivot)
    return np.asarray(turned / np.where(scale == 0.0, 1.0, scale))


def scaled_to(shapes: ComplexArray, others: ComplexArray) -> ComplexArray:
    """Return shapes in the size and sign that come closest to others, by least squares.

    Parameters
    ----------
    shapes, others : (n_modes, n_sensors) complex arrays
        Shapes of the same modes, each turned to its own mean phase [-].

    Returns
    -------
    (n_modes, n_sensors) complex array
        Times a real factor: the phase stays [-].
    """
    power = np.sum(np.abs(shapes) ** 2, axis=1)
    shared = np.sum((shapes.conj() * others).real, axis=1)
    factor = np.ones(power.shape)
    np.divide(shared, power, out=factor, where=power > 0.0)
    return np.asarray(shapes * factor[:, np.newaxis])


def without_chance(shapes: ComplexArray, variance: FloatArray) -> ComplexArray:
    r"""Return shapes whose imaginary parts are as small as their scatter makes likely.

    .. math:: \operatorname{Im}\, \hat\phi = \operatorname{Im}\, \phi \; \max\left(0,
              1 - \frac{\sum \sigma^2}{\sum (\operatorname{Im}\, \phi)^2}\right)

    the sums over the sensors of a mode. Imaginary parts about zero, as of a structure whose
    damping is spread as its stiffness is, are what chance adds to a shape; those of a truly
    complex mode stand out of their scatter and stay.

    Parameters
    ----------
    shapes : (n_modes, n_sensors) complex array
        Turned to their mean phase [-].
    variance : (n_modes, n_sensors) array
        Of their imaginary parts [-].

    Returns
    -------
    (n_modes, n_sensors) complex array
        Shapes [-].

    References
    ----------
    .. [1] B. Efron and C. Morris, "Stein's estimation rule and its competitors: an empirical
       Bayes approach", J. American Statistical Association 68, 117-130, 1973.
    """
    power = np.sum(shapes.imag**2, axis=1)
    chance = np.sum(variance, axis=1)
    kept = np.zeros(power.shape)
    np.divide(power - chance, power, out=kept, where=power > chance)
    return np.asarray(shapes.real + 1j * shapes.imag * kept[:, np.newaxis])


ALONE: Final = 1e-9
"""Of a sensor that alone tells the amplitude of a mode, what rounding leaves of one less its
leverage [-]: shares of a shape by its root are none."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Expansion:
    """Measured shapes at all points of a model.

    Attributes
    ----------
    shapes : (n_modes, n_points) complex array
        In the scale of the measured shapes [-].
    n_used : (n_modes,) array
        Number of modes of the model that each is made of.
    missed : (n_modes,) array
        What the expansion leaves of the sensors over what they measured, rms [-].
    left_out : (n_modes,) array
        Error of each sensor as predicted from the others over what they measured, rms [-].
    """

    shapes: ComplexArray
    n_used: FloatArray
    missed: FloatArray
    left_out: FloatArray


def expanded(
    measured: ComplexArray, at_sensors: ComplexArray, at_points: ComplexArray, far: FloatArray
) -> Expansion | None:
    """Return measured shapes at all points of a model; None where nothing could check them.

    Parameters
    ----------
    measured : (n_modes, n_sensors) complex array
        Shapes of a test [-].
    at_sensors : (n_model, n_sensors) complex array
        Shapes of the model at the sensors [-].
    at_points : (n_model, n_points) complex array
        The same at all points [-].
    far : (n_modes, n_model) array
        How far a mode of the model is from one of the test; the nearest are taken [-].
    """
    most = min(measured.shape[1] - 1, len(at_sensors))
    if most < 1:
        return None
    rows = []
    for shape, distance in zip(measured, far, strict=True):
        order = np.argsort(distance, kind="stable")
        near = [order[: n + 1] for n in range(most)]
        tried = [_of(shape, at_sensors[some], at_points[some]) for some in near]
        best = min(range(most), key=lambda n: tried[n][2])
        rows.append((tried[best][0], best + 1.0, *tried[best][1:]))
    shapes, n_used, missed, left_out = zip(*rows, strict=True) if rows else ((),) * 4
    points = np.array(shapes, complex).reshape(len(rows), at_points.shape[1])
    return Expansion(points, np.array(n_used), np.array(missed), np.array(left_out))


def _of(
    shape: ComplexArray, at_sensors: ComplexArray, at_points: ComplexArray
) -> tuple[ComplexArray, float, float]:
    """Return a shape at all points, and how it misses the sensors, fitted and left out [-]."""
    largest = np.max(np.abs(at_sensors), axis=1, keepdims=True)
    at_sensors = np.where(np.abs(at_sensors) > ALONE**0.5 * largest, at_sensors, 0.0)
    inverse = np.linalg.pinv(at_sensors.T, rcond=ALONE**0.5)
    size = float(np.linalg.norm(shape))
    residual = shape - at_sensors.T @ (inverse @ shape)
    free = 1.0 - np.einsum("ms,ms->s", at_sensors, inverse).real
    is_determined = free > ALONE
    predicted = np.abs(residual) / np.where(is_determined, free, 1.0)
    for i in np.flatnonzero(~is_determined):
        rest = np.arange(shape.size) != i
        others = np.linalg.pinv(at_sensors.T[rest], rcond=ALONE**0.5) @ shape[rest]
        predicted[i] = np.abs(shape[i] - at_sensors[:, i] @ others)
    return (
        at_points.T @ (inverse @ shape),
        float(np.linalg.norm(residual)) / size,
        float(np.linalg.norm(predicted)) / size,
    )
