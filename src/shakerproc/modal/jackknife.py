"""Scatter of modes over fits that each leave out a part of a record."""

from collections.abc import Sequence

import numpy as np

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.polynomials import OrderPoles
from shakerproc.modal.shapes import normalised, scaled_to
from shakerproc.modal.stabilisation import Diagram, damping_of, frequency_of


def jackknife(
    others: Sequence[Sequence[OrderPoles]],
    diagram: Diagram,
    poles: ComplexArray,
    shapes: ComplexArray,
    scale: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the scatter of modes over fits that each leave out a block of the record.

    A mode is looked for again at the orders at which the whole record has shown it.

    Parameters
    ----------
    others : sequence of sequences of OrderPoles
        For each block that is left out, fits of every order.
    diagram : Diagram
        Of the whole record.
    poles : (n_modes,) complex array
        Modes of the whole record [rad/s].
    shapes : (n_modes, n_responses) complex array
        Theirs, turned to their mean phase [-].
    scale : (n_responses,) array
        What the shapes of the fits are to be multiplied with [-].

    Returns
    -------
    errors : (2, n_modes) array
        Standard deviations of ln damping and ln frequency [-].
    chance : (n_modes, n_responses) array
        Variances of the imaginary parts of the shapes [-].

    References
    ----------
    .. [1] B. Efron and C. Stein, "The jackknife estimate of variance", Annals of Statistics 9,
       586-596, 1981.
    """
    values = np.empty((len(others), 2, poles.size))
    turned = np.empty((len(others), *shapes.shape), dtype=np.complex128)
    for block, fits in enumerate(others):
        own, again = _again(fits, diagram, poles)
        values[block] = np.log(damping_of(own)), np.log(frequency_of(own))
        turned[block] = scaled_to(normalised(again * scale), shapes)
    if not others:
        return np.zeros((2, 0)), np.zeros(shapes.shape)
    share = (len(others) - 1) / len(others)
    errors = np.sqrt(share * np.sum((values - values.mean(axis=0)) ** 2, axis=0))
    imaginary = turned.imag
    chance = share * np.sum((imaginary - imaginary.mean(axis=0)) ** 2, axis=0)
    return np.asarray(errors), np.asarray(chance)


def _again(
    fits: Sequence[OrderPoles], diagram: Diagram, poles: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return poles and shapes of modes in other fits, at the orders at which each was found.

    Not a number, and no shape, where no such order has a pole.
    """
    stable = np.flatnonzero(diagram.stable)
    found: list[complex] = []
    shapes: list[ComplexArray] = []
    for pole in poles:
        nearest = stable[np.argmin(np.abs(diagram.poles[stable] - pole))]
        number = diagram.cluster[nearest]
        there = diagram.order[diagram.cluster == number] if number >= 0 else []
        orders = {*there, diagram.order[nearest]}
        own = [fit for fit in fits if fit.order in orders and fit.poles.size]
        if not own:
            found.append(complex(np.nan, np.nan))
            shapes.append(np.zeros(diagram.shapes.shape[1], dtype=np.complex128))
            continue
        near = [int(np.argmin(np.abs(fit.poles - pole))) for fit in own]
        every = np.array([fit.poles[row] for fit, row in zip(own, near, strict=True)])
        middle = complex(np.median(every.real), np.median(every.imag))
        first = int(np.argmin(np.abs(every - middle)))
        found.append(middle)
        shapes.append(own[first].shapes[near[first]])
    return np.array(found, dtype=np.complex128), np.array(shapes, dtype=np.complex128)
