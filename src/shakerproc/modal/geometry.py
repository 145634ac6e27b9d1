"""Where sensors sit and how a mode moves them, as points and lines in a plane."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray

FLAT: Final = 1e-3
"""Extent across a line of sensors below which they sit on it, as a share of its length [-]."""

SHOWN: Final = 0.18
"""Largest motion that is drawn, as a share of the extent of the sensors [-]."""

Place = tuple[float, float, float]


@final
@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """Sensors projected into the plane of a drawing.

    Attributes
    ----------
    rest : (n_places, 2) array
        Where they are at rest, across and up; the largest extent is 1 [-].
    motion : (n_sensors, n_places, 2) array
        How far a unit of each sensor's motion moves each place in the drawing [-].
    edges : tuple of (int, int)
        Places that are joined by a line: a shortest net over all.
    scaled : bool
        Whether positions are those of the log, not just the order of the sensors.
    """

    rest: FloatArray
    motion: FloatArray
    edges: tuple[tuple[int, int], ...]
    scaled: bool

    def moved(self, shape: ComplexArray, phase: float) -> FloatArray:
        """Return where the places are at a phase of the motion [rad], (n_places, 2)."""
        now = np.real(shape * np.exp(1j * phase))
        return np.asarray(self.rest + np.einsum("s,spk->pk", now, self.motion))


def geometry_of(
    positions: Sequence[Place | None], directions: Sequence[Place | None]
) -> Geometry:
    """Return sensors projected for a drawing.

    Parameters
    ----------
    positions : sequence of (x, y, z)
        Of the sensors [m]; where one is missing, all stand in a row in their order.
    directions : sequence of (x, y, z)
        Along which they measure [-]; z where it is missing.

    Returns
    -------
    Geometry
        Sensors at one position are one place.
    """
    n = len(positions)
    known = [p for p in positions if p is not None]
    scaled = len(known) == n and len({*known}) > 1
    points = np.array(known) if scaled else np.column_stack([np.arange(n), np.zeros((n, 2))])
    along = np.array([(0.0, 0.0, 1.0) if d is None or not scaled else d for d in directions])
    places, index = np.unique(points.round(9), axis=0, return_inverse=True)
    view = _view(places, along)
    rest = (places - places.mean(axis=0)) @ view.T
    extent = float(np.ptp(rest, axis=0).max()) or 1.0
    motion = np.zeros((n, places.shape[0], 2))
    motion[np.arange(n), index.reshape(-1)] = SHOWN * along @ view.T
    return Geometry(rest / extent, motion, _net(places), scaled)


def _view(places: FloatArray, along: FloatArray) -> FloatArray:
    """Return the two axes of the drawing, (2, 3): side on for a line, else from a corner."""
    centred = places - places.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=True)
    across = axes[0] * np.where(axes[0][np.argmax(np.abs(axes[0]))] < 0.0, -1.0, 1.0)
    left = along - np.outer(along @ across, across)
    in_line = sizes.size < 2 or sizes[1] < FLAT * max(sizes[0], 1e-300)
    if in_line and np.linalg.matrix_rank(left, tol=FLAT) < 2:
        up = left[int(np.argmax(np.linalg.norm(left, axis=1)))]
        size = float(np.linalg.norm(up))
        up = up / size if size > FLAT else np.cross(across, np.roll(across, 1))
        up = up * (-1.0 if up[int(np.argmax(np.abs(up)))] < 0.0 else 1.0)
        upright = abs(across[2]) > 0.7
        return np.stack([up, across] if upright else [across, up])
    root = np.sqrt(0.5)
    return np.array([[root, -root, 0.0], [0.35, 0.35, 0.87]])


def _net(places: FloatArray) -> tuple[tuple[int, int], ...]:
    """Return the shortest net of lines over all places."""
    apart = np.linalg.norm(places[:, np.newaxis] - places[np.newaxis], axis=-1)
    tree = scipy.sparse.csgraph.minimum_spanning_tree(apart).tocoo()
    return tuple((int(a), int(b)) for a, b in zip(tree.row, tree.col, strict=True))
