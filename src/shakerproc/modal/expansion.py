r"""Measured shapes expanded to all points of a model by its modes (SEREP).

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

ALONE: Final = 1e-9
"""Of a sensor that alone tells the amplitude of a mode, what rounding leaves of one less its
leverage [-]."""


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
    inverse = np.linalg.pinv(at_sensors.T)
    size = float(np.linalg.norm(shape))
    left = shape - at_sensors.T @ (inverse @ shape)
    free = 1.0 - np.einsum("ms,ms->s", at_sensors, inverse).real
    told = free > ALONE
    predicted = np.abs(left) / np.where(told, free, 1.0)
    for i in np.flatnonzero(~told):
        rest = np.arange(shape.size) != i
        others = np.linalg.pinv(at_sensors.T[rest]) @ shape[rest]
        predicted[i] = np.abs(shape[i] - at_sensors[:, i] @ others)
    return (
        at_points.T @ (inverse @ shape),
        float(np.linalg.norm(left)) / size,
        float(np.linalg.norm(predicted)) / size,
    )
