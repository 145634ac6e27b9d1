"""Least-squares complex frequency fits of every order, and the poles that keep their place."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.shapes import mac

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


MOST_DAMPING: Final = 0.2
"""Damping ratio above which a pole counts as computational [-]."""

SAME_PLACE: Final = 0.005
"""Relative distance within which a mode is the one that the user wants kept [-]."""

REACH: Final = 0.02
"""Relative distance within which a pole is looked for that is to be kept [-]."""


@final
@dataclass(frozen=True, slots=True)
class Tolerances:
    """How little a pole may change from order to order.

    Attributes
    ----------
    frequency, damping : float
        Relative change [-].
    shape : float
        Least MAC of the shapes [-].
    """

    frequency: float = 0.005
    damping: float = 0.1
    shape: float = 0.95


@final
@dataclass(frozen=True, slots=True, eq=False)
class Diagram:
    """Stabilisation diagram: every pole of every order.

    Attributes
    ----------
    order : (n_poles,) array of int
        Order of the fit.
    poles : (n_poles,) complex array
        Poles [rad/s].
    shapes : (n_poles, n_responses) complex array
        Shapes, largest component 1 [-].
    stable : (n_poles,) array of bool
        Whether frequency, damping and shape are those of a pole of the order before.
    cluster : (n_poles,) array of int
        Number of the cluster from 0, -1 for none.
    """

    order: NDArray[np.intp]
    poles: ComplexArray
    shapes: ComplexArray
    stable: NDArray[np.bool_]
    cluster: NDArray[np.intp]

    @property
    def n_clusters(self) -> int:
        """Number of clusters."""
        return int(self.cluster.max(initial=-1)) + 1


def frequency_of(poles: ComplexArray) -> FloatArray:
    """Return undamped natural frequencies [Hz] of poles [rad/s]."""
    return np.abs(poles) / (2.0 * np.pi)


def damping_of(poles: ComplexArray) -> FloatArray:
    """Return damping ratios [-] of poles [rad/s]."""
    return -poles.real / np.abs(poles)


def stabilisation(
    sums: Sums,
    orders: Sequence[int],
    band: tuple[float, float],
) -> Diagram:
    """Return the stabilisation diagram of sums over lines, with its clusters.

    Parameters
    ----------
    sums : Sums
        From `lagged_sums`, for the highest order.
    orders : sequence of int
        Rising orders of the fits.
    band : (float, float)
        Where poles are kept [Hz].

    Returns
    -------
    Diagram
        Poles by order, clusters numbered by frequency.
    """
    return diagram_of([poles_of_order(sums, order) for order in orders], band)


def diagram_of(
    every: Sequence[OrderPoles],
    band: tuple[float, float],
    tolerances: Tolerances | None = None,
) -> Diagram:
    """Return the stabilisation diagram of fits of rising order, with its clusters.

    Parameters
    ----------
    every : sequence of OrderPoles
        A fit of each order.
    band : (float, float)
        Where poles are kept [Hz].
    tolerances : Tolerances, optional
        How little a stable pole may change.
    """
    limits = tolerances or Tolerances()
    fits = [_inside(fit, band) for fit in every]
    before, stable = None, []
    for fit in fits:
        stable.append(_stable(fit, before, limits))
        before = fit
    poles = np.concatenate([fit.poles for fit in fits])
    shapes = np.concatenate([fit.shapes for fit in fits])
    order = np.concatenate([np.full(fit.poles.size, fit.order) for fit in fits])
    flags = np.concatenate(stable)
    loose = Diagram(order, poles, shapes, flags, np.full(poles.size, -1))
    return replace(loose, cluster=_clusters(loose, limits, len(fits)))


def _inside(fit: OrderPoles, band: tuple[float, float]) -> OrderPoles:
    frequency = frequency_of(fit.poles)
    kept = (frequency >= band[0]) & (frequency <= band[1])
    kept &= damping_of(fit.poles) < MOST_DAMPING
    return OrderPoles(fit.order, fit.poles[kept], fit.shapes[kept])


def _matching_poles(
    poles: ComplexArray,
    shapes: ComplexArray,
    others: ComplexArray,
    other_shapes: ComplexArray,
    limits: Tolerances,
) -> NDArray[np.bool_]:
    """Return which pairs of poles are one mode, (n, n_others)."""
    near = np.abs(np.subtract.outer(np.abs(poles), np.abs(others))) < (
        limits.frequency * np.abs(poles)[:, np.newaxis]
    )
    first, second = damping_of(poles)[:, np.newaxis], damping_of(others)[np.newaxis]
    near &= np.abs(first - second) < limits.damping * np.maximum(first, second)
    if shapes.shape[1] > 1:
        near &= mac(shapes, other_shapes) > limits.shape
    return np.asarray(near)


def _stable(
    fit: OrderPoles, before: OrderPoles | None, limits: Tolerances
) -> NDArray[np.bool_]:
    if before is None or not before.poles.size or not fit.poles.size:
        return np.zeros(fit.poles.size, dtype=bool)
    near = _matching_poles(fit.poles, fit.shapes, before.poles, before.shapes, limits)
    return np.asarray(near.any(axis=1))


def _clusters(diagram: Diagram, limits: Tolerances, n_orders: int) -> NDArray[np.intp]:
    """Return the cluster of each stable pole: the densest first, one pole of each order."""
    order, poles, shapes = diagram.order, diagram.poles, diagram.shapes
    cluster = np.full(poles.size, -1)
    rows = np.flatnonzero(diagram.stable)
    if not rows.size:
        return cluster
    near = _matching_poles(poles[rows], shapes[rows], poles[rows], shapes[rows], limits)
    near |= near.T
    free = np.ones(rows.size, dtype=bool)
    indices: list[NDArray[np.intp]] = []
    least = max(3, n_orders // 8)
    while True:
        count = (near & free[np.newaxis]).sum(axis=1) * free
        centre = int(np.argmax(count))
        if count[centre] < least:
            break
        members = rows[near[centre] & free]
        free &= ~near[centre]
        if np.unique(order[members]).size >= least:
            indices.append(members)
    indices.sort(key=lambda members: float(np.median(np.abs(poles[members]))))
    for number, members in enumerate(indices):
        cluster[members] = number
    return cluster


def candidates(diagram: Diagram) -> tuple[ComplexArray, ComplexArray, NDArray[np.intp]]:
    """Return a pole and a shape for each cluster, and over how many orders it keeps.

    Returns
    -------
    poles : (n_clusters,) complex array
        Medians of real and imaginary parts [rad/s].
    shapes : (n_clusters, n_responses) complex array
        That of the pole nearest the median [-].
    counts : (n_clusters,) array of int
        Orders at which the pole is there.
    """
    poles, shapes, counts = [], [], []
    for number in range(diagram.n_clusters):
        members = np.flatnonzero(diagram.cluster == number)
        members_poles = diagram.poles[members]
        middle = complex(np.median(members_poles.real), np.median(members_poles.imag))
        poles.append(middle)
        shapes.append(diagram.shapes[members[np.argmin(np.abs(members_poles - middle))]])
        counts.append(np.unique(diagram.order[members]).size)
    width = diagram.shapes.shape[1]
    return (
        np.array(poles, dtype=np.complex128),
        np.array(shapes, dtype=np.complex128).reshape(len(poles), width),
        np.array(counts, dtype=np.intp),
    )


def are_requested(poles: ComplexArray, keep: Sequence[float]) -> NDArray[np.bool_]:
    """Return which poles [rad/s] are those that the user wants kept, near `keep` [Hz]."""
    distance = np.abs(np.divide.outer(frequency_of(poles), np.array(keep, dtype=float)) - 1.0)
    return np.asarray(np.any(distance < SAME_PLACE, axis=1))


def requested_poles(
    diagram: Diagram, poles: ComplexArray, keep: Sequence[float]
) -> tuple[NDArray[np.intp], list[str]]:
    """Return the poles of a diagram that the user wants kept and that are none of the modes.

    Parameters
    ----------
    diagram : Diagram
        Where poles are looked for: stable ones alone.
    poles : (n_modes,) complex array
        Modes that there are already [rad/s].
    keep : sequence of float
        Where poles are to be kept [Hz].

    Returns
    -------
    rows : (n_kept,) array of int
        Rows of the diagram.
    notes : list of str
        What is not there.
    """
    rows: list[int] = []
    notes = []
    stable = np.flatnonzero(diagram.stable)
    for wanted in keep:
        there = np.append(poles, diagram.poles[rows])
        if are_requested(there, [wanted]).any():
            continue
        distance = np.abs(frequency_of(diagram.poles[stable]) / wanted - 1.0)
        if not distance.size or distance.min() > REACH:
            notes.append(f"no pole within {REACH:.0%} of {wanted:g} Hz that could be kept")
            continue
        rows.append(int(stable[np.argmin(distance)]))
    return np.array(rows, dtype=np.intp), notes
