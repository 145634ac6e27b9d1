"""Poly-reference least-squares complex frequency fits of every order, by reduced equations."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray

RIDGE: Final = 1e-13
"""Added to the diagonal of the normal equations, as a share of its mean [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class OrderPoles:
    """Poles of one polynomial order.

    Attributes
    ----------
    order : int
        Order of the denominator.
    poles : (n_poles,) complex array
        Stable ones with a positive frequency, by frequency [rad/s].
    shapes : (n_poles, n_responses) complex array
        Residues of the responses up to a factor, largest 1 [-].
    """

    order: int
    poles: ComplexArray
    shapes: ComplexArray


@final
@dataclass(frozen=True, slots=True, eq=False)
class Sums:
    """Sums over the lines from which the normal equations of every order are made.

    Attributes
    ----------
    spacing : float
        Sample interval of the basis exp(-i omega spacing) [s].
    inputs : (2 n + 1, q, q) complex array
        Sums of conj(E) E z^k for lags -n to n.
    crossed : (n_responses, 2 n + 1, q, p) complex array
        Sums of conj(E) Y z^k.
    outputs : (2 n + 1, p, p) complex array
        Sums of conj(Y) Y z^k over lines and responses.
    """

    spacing: float
    inputs: ComplexArray
    crossed: ComplexArray
    outputs: ComplexArray


def lagged_sums(
    frequency: FloatArray, inputs: ComplexArray, outputs: ComplexArray, highest: int
) -> Sums:
    r"""Return the sums that the normal equations of all orders share.

    The equation error of response o is :math:`\beta_o(z) E - \alpha(z) Y_o`, with
    :math:`z = e^{-i \omega \Delta}`. With E = 1 and the response functions as Y it is the
    poly-reference fit with a right matrix fraction; with the spectra of the inputs and a 1 as E
    and the spectra of the responses as Y it is the fit of spectra, whose 1 takes up the
    transient (leakage).

    Parameters
    ----------
    frequency : (n_lines,) array
        Lines of the band [Hz].
    inputs : (q, n_lines) complex array
        What the numerators multiply [-].
    outputs : (n_responses, p, n_lines) complex array
        What the denominator multiplies [unit of the functions].
    highest : int
        Highest order that will be asked for.

    Returns
    -------
    Sums
        For `poles_of_order`.

    References
    ----------
    .. [1] B. Peeters, H. Van der Auweraer, P. Guillaume and J. Leuridan, "The PolyMAX
       frequency-domain method: a new standard for modal parameter estimation?", Shock and
       Vibration 11, 395-409, 2004.
    """
    spacing = 0.5 / float(frequency[-1])
    scale = np.sqrt(np.mean(np.abs(outputs) ** 2, axis=(1, 2), keepdims=True))
    scaled = outputs / np.where(scale > 0.0, scale, 1.0)
    level = np.sqrt(np.mean(np.abs(inputs) ** 2, axis=1, keepdims=True))
    driven = inputs / np.where(level > 0.0, level, 1.0)
    powers = _powers(frequency, spacing, highest)
    in_in = np.einsum("al,bl->abl", driven.conj(), driven)
    in_out = np.einsum("al,obl->oabl", driven.conj(), scaled)
    out_out = np.einsum("oal,obl->abl", scaled.conj(), scaled)
    return Sums(
        spacing,
        np.moveaxis(in_in @ powers.T, -1, 0),
        np.moveaxis(in_out @ powers.T, -1, 1),
        np.moveaxis(out_out @ powers.T, -1, 0),
    )


def _powers(frequency: FloatArray, spacing: float, highest: int) -> ComplexArray:
    """Return z^k for lags -highest to highest, (2 highest + 1, n_lines)."""
    lags = np.arange(-highest, highest + 1)
    return np.asarray(np.exp(-2j * np.pi * spacing * np.outer(lags, frequency)))


def poles_of_order(sums: Sums, order: int) -> OrderPoles:
    """Return the stable poles of one order, with the shapes that go with them.

    Parameters
    ----------
    sums : Sums
        Made for this order or a higher one.
    order : int
        Order of the denominator.

    Returns
    -------
    OrderPoles
        Poles between 0 and the upper end of the band.

    Raises
    ------
    ValueError
        If the sums do not reach to that order.
    """
    reach = sums.inputs.shape[0] // 2
    if not 1 <= order <= reach:
        raise ValueError(f"order must be 1 to {reach}, not {order}")
    p = sums.outputs.shape[1]
    r = _toeplitz(sums.inputs, order)
    t = _toeplitz(sums.outputs, order)
    s = np.stack([_toeplitz(one, order) for one in sums.crossed])
    r += RIDGE * np.trace(r) / r.shape[0] * np.eye(r.shape[0])
    factor = scipy.linalg.cho_factor(r)
    numerators = scipy.linalg.cho_solve(factor, np.concatenate(list(s), axis=1))
    numerators = np.moveaxis(numerators.reshape(r.shape[0], s.shape[0], -1), 1, 0)
    m = t - np.einsum("oqa,oqb->ab", s, numerators)
    free = m[p:, p:] + RIDGE * np.trace(m) / m.shape[0] * np.eye(m.shape[0] - p)
    alpha = np.concatenate([np.eye(p), -np.linalg.solve(free, m[p:, :p])])
    return _roots(sums, alpha.reshape(order + 1, p, p), numerators, order)


def _toeplitz(lagged: ComplexArray, order: int) -> FloatArray:
    """Return the real block Toeplitz matrix whose block (k, l) is the sum of lag l - k."""
    centre = lagged.shape[0] // 2
    index = np.arange(order + 1)
    blocks = lagged.real[centre + index[np.newaxis, :] - index[:, np.newaxis]]
    rows, columns = lagged.shape[1:]
    n = order + 1
    return np.ascontiguousarray(blocks.transpose(0, 2, 1, 3)).reshape(n * rows, n * columns)


def _roots(sums: Sums, alpha: FloatArray, numerators: FloatArray, order: int) -> OrderPoles:
    """Return the poles and participations of the denominator and numerators of one order."""
    p = alpha.shape[1]
    companion = np.zeros((order * p, order * p))
    companion[: (order - 1) * p, p:] = np.eye((order - 1) * p)
    # alpha_0 = 1: in w = 1/z the polynomial is monic, w^n + alpha_1 w^(n-1) + ...
    companion[(order - 1) * p :] = -alpha[:0:-1].transpose(1, 0, 2).reshape(p, order * p)
    values, vectors = np.linalg.eig(companion)
    with np.errstate(divide="ignore"):
        poles = np.asarray(np.log(values + 0j) / sums.spacing, dtype=np.complex128)
    nyquist = np.pi / sums.spacing
    inside = (poles.imag > 1e-6 * nyquist) & (poles.imag < 0.999 * nyquist)
    stable = np.flatnonzero(inside & (poles.real < 0.0))
    kept = stable[np.argsort(poles.imag[stable])]
    roots = 1.0 / values[kept]
    right = vectors[:p, kept]
    powers = roots[np.newaxis, :] ** np.arange(order + 1)[:, np.newaxis]
    q = sums.inputs.shape[1]
    flat = alpha.reshape((order + 1) * p, p)
    beta = (numerators @ flat).reshape(numerators.shape[0], order + 1, q, p)
    shapes = np.einsum("okqp,km,pm->mqo", beta, powers, right)
    n_driven = max(1, q - 1)  # the last is the 1 of a transient, if there is one
    strongest = np.argmax(np.linalg.norm(shapes[:, :n_driven], axis=2), axis=1)
    chosen = shapes[np.arange(len(kept)), strongest]
    return OrderPoles(order, poles[kept], unit_shapes(chosen))


def unit_shapes(shapes: ComplexArray) -> ComplexArray:
    """Return shapes whose largest component is 1. `shapes` may be in any unit."""
    if not shapes.size:
        return shapes
    largest = np.argmax(np.abs(shapes), axis=1)
    pivot = shapes[np.arange(shapes.shape[0]), largest][:, np.newaxis]
    return shapes / np.where(pivot == 0.0, 1.0, pivot)
