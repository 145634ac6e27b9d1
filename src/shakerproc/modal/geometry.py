"""Where sensors sit and how a mode moves them, as points, lines and surfaces in a plane."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import ComplexArray, FloatArray
from shakerproc.geometry import Place, Wireframe
from shakerproc.runs.roles import NEAR

FLAT: Final = 1e-3
"""Extent across a line of sensors below which they sit on it, as a share of its length [-]."""

SHOWN: Final = 0.18
"""Largest motion that is drawn, as a share of the extent of the sensors [-]."""

ROOM: Final = SHOWN / 2.0
"""Around a drawing, for the names, as a share of the extent of the sensors [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """A structure projected into the plane of a drawing.

    Attributes
    ----------
    rest : (n_places, 2) array
        Sensors, then further nodes, across and up; the largest extent is 1 [-].
    motion : (n_sensors, n_places, 2) array
        How far a unit of each sensor's motion moves each place in the drawing [-].
    seats : tuple of int
        Place of each sensor.
    edges : tuple of (int, int)
        Measured places that are joined by a line: of the wireframe, else a shortest net.
    still : tuple of (int, int)
        Lines with an end that no sensor measures: they are drawn at rest alone.
    faces : tuple of tuple of int
        Measured places around each surface.
    scaled : bool
        Whether positions are those of the log, not just the order of the sensors.
    """

    rest: FloatArray
    motion: FloatArray
    seats: tuple[int, ...]
    edges: tuple[tuple[int, int], ...]
    still: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]
    scaled: bool

    @property
    def measured(self) -> list[int]:
        """Places at which a sensor sits."""
        return sorted(set(self.seats))

    @property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Lower left and upper right of whatever a shape may reach, and room for names [-]."""
        reach = np.abs(self.motion).sum(axis=0)
        low, high = (self.rest - reach).min(axis=0), (self.rest + reach).max(axis=0)
        return low - ROOM, high + ROOM

    @property
    def upright_faces(self) -> list[tuple[int, ...]]:
        """The surfaces, all one way around in the drawing: no two of them cancel out."""
        return [f if _area(self.rest[list(f)]) >= 0.0 else f[::-1] for f in self.faces]

    def moved(self, shape: ComplexArray, phase: float) -> FloatArray:
        """Return where the places are at a phase of the motion [rad], (n_places, 2)."""
        now = np.real(shape * np.exp(1j * phase))
        return np.asarray(self.rest + np.einsum("s,spk->pk", now, self.motion))

    def labels(self, names: Sequence[str]) -> dict[int, str]:
        """Return the names of the sensors by their place, those of one place together."""
        columns: dict[int, list[str]] = {}
        for place, name in zip(self.seats, names, strict=True):
            columns.setdefault(place, []).append(name)
        return {place: ", ".join(here) for place, here in columns.items()}

    def fitting(self, labels: Mapping[int, str], letter: tuple[float, float]) -> dict[int, str]:
        """Return the labels that find room, in their order.

        `letter` is how wide and high a letter is, as a share of the extent [-].
        """
        shown: dict[int, str] = {}
        taken: list[tuple[FloatArray, float]] = []
        for place, text in labels.items():
            here, half = self.rest[place], letter[0] * len(text) / 2.0
            ways = ((np.abs(here - there), half + other) for there, other in taken)
            if all(x > reach or y > letter[1] for (x, y), reach in ways):
                taken.append((here, half))
                shown[place] = text
        return shown


def geometry_of(
    positions: Sequence[Place | None],
    directions: Sequence[Place | None],
    wireframe: Wireframe | None = None,
) -> Geometry:
    """Return sensors and the structure that they sit on, projected for a drawing.

    Parameters
    ----------
    positions : sequence of (x, y, z)
        Of the sensors [m]; where one is missing, all stand in a row in their order.
    directions : sequence of (x, y, z)
        Along which they measure [-]; z where it is missing.
    wireframe : Wireframe, optional
        Lines and surfaces over nodes; a sensor sits at the node of its position.

    Returns
    -------
    Geometry
        Sensors at one position are one place.
    """
    n = len(positions)
    known = [p for p in positions if p is not None]
    drawn = wireframe is not None and bool(wireframe.edges)
    scaled = len(known) == n and (drawn or len({*known}) > 1)
    points = np.array(known) if scaled else np.column_stack([np.arange(n), np.zeros((n, 2))])
    along = np.array([(0.0, 0.0, 1.0) if d is None or not scaled else d for d in directions])
    places, index = np.unique(points.round(9), axis=0, return_inverse=True)
    seats = tuple(int(i) for i in index.reshape(-1))
    edges = _net(places)
    faces: list[tuple[int, ...]] = []
    if wireframe is not None and drawn and scaled:
        places, edges, faces = _on_wireframe(places, wireframe)
    view = _view(places, along)
    rest = (places - places.mean(axis=0)) @ view.T
    extent = float(np.ptp(rest, axis=0).max()) or 1.0
    motion = SHOWN * motion_of(seats, along, len(places)) @ view.T
    count = len({*seats})
    return Geometry(
        rest / extent,
        motion,
        seats,
        tuple(e for e in edges if max(e) < count),
        tuple(e for e in edges if max(e) >= count),
        tuple(f for f in faces if max(f) < count),
        scaled,
    )


def motion_of(seats: Sequence[int], along: FloatArray, n_places: int) -> FloatArray:
    """Return how a unit of each sensor's motion moves each place.

    Parameters
    ----------
    seats : sequence of int
        Place of each sensor.
    along : (n_sensors, 3) array
        Directions along which they measure [-].
    n_places : int
        Number of places.

    Returns
    -------
    (n_sensors, n_places, 3) array
        By least squares: the motion that the sensors of a place, at right angles or not, tell
        of it, none across them [-].
    """
    motion = np.zeros((len(seats), n_places, 3))
    for place in {*seats}:
        rows = [i for i, seat in enumerate(seats) if seat == place]
        motion[rows, place] = np.linalg.pinv(along[rows]).T
    return motion


def _area(corners: FloatArray) -> float:
    """Return twice the area of a polygon, less than 0 of one that runs clockwise [-]."""
    x, y = corners.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def _on_wireframe(
    places: FloatArray, wireframe: Wireframe
) -> tuple[FloatArray, list[tuple[int, int]], list[tuple[int, ...]]]:
    """Return places and then further nodes [m], and lines and surfaces over both."""
    used = wireframe.used
    where = np.array([wireframe.nodes[node] for node in used])
    nearest_nodes = scipy.spatial.cKDTree(places).query(where)
    distances, nearest = np.atleast_1d(nearest_nodes[0]), np.atleast_1d(nearest_nodes[1])
    index: dict[int, int] = {}
    more: list[FloatArray] = []
    for node, distance, place, position in zip(used, distances, nearest, where, strict=True):
        index[node] = int(place) if distance <= NEAR else len(places) + len(more)
        if distance > NEAR:
            more.append(position)
    edges = [(index[a], index[b]) for a, b in wireframe.edges if index[a] != index[b]]
    faces = [tuple(index[node] for node in one) for one in wireframe.surfaces]
    return np.vstack([places, *more]), edges, faces


def _view(places: FloatArray, along: FloatArray) -> FloatArray:
    """Return the two axes of the drawing, (2, 3): side on for a line, else from a corner."""
    centred = places - places.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    across = axes[0] * np.where(axes[0][np.argmax(np.abs(axes[0]))] < 0.0, -1.0, 1.0)
    projection = along - np.outer(along @ across, across)
    in_line = sizes.size < 2 or sizes[1] < FLAT * max(sizes[0], 1e-300)
    if in_line and np.linalg.matrix_rank(projection, tol=FLAT) < 2:
        up = projection[int(np.argmax(np.linalg.norm(projection, axis=1)))]
        size = float(np.linalg.norm(up))
        up = up / size if size > FLAT else np.cross(across, np.roll(across, 1))
        up = up * (-1.0 if up[int(np.argmax(np.abs(up)))] < 0.0 else 1.0)
        upright = abs(across[2]) > 0.7
        return np.stack([up, across] if upright else [across, up])
    root = np.sqrt(0.5)
    return np.array([[root, -root, 0.0], [0.35, 0.35, 0.87]])


def _net(places: FloatArray) -> list[tuple[int, int]]:
    """Return the shortest net of lines over all places."""
    distances = np.linalg.norm(places[:, np.newaxis] - places[np.newaxis], axis=-1)
    tree = scipy.sparse.csgraph.minimum_spanning_tree(distances).tocoo()
    return [(int(a), int(b)) for a, b in zip(tree.row, tree.col, strict=True)]
