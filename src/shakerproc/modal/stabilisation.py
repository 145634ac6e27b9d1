"""Poles over model orders: which keep their place, and the clusters that they form."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.modal.polynomials import OrderPoles, Sums, poles_of_order
from shakerproc.modal.shapes import mac

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
    found: list[NDArray[np.intp]] = []
    least = max(3, n_orders // 8)
    while True:
        count = (near & free[np.newaxis]).sum(axis=1) * free
        centre = int(np.argmax(count))
        if count[centre] < least:
            break
        members = rows[near[centre] & free]
        free &= ~near[centre]
        if np.unique(order[members]).size >= least:
            found.append(members)
    found.sort(key=lambda members: float(np.median(np.abs(poles[members]))))
    for number, members in enumerate(found):
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
        own = diagram.poles[members]
        middle = complex(np.median(own.real), np.median(own.imag))
        poles.append(middle)
        shapes.append(diagram.shapes[members[np.argmin(np.abs(own - middle))]])
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
