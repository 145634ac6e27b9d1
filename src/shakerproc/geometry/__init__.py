"""Nodes, lines and surfaces of a structure, and the data sets of universal files with them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final, TypeAlias, final

Place: TypeAlias = tuple[float, float, float]
Axes: TypeAlias = tuple[Place, Place, Place]

LEAST: Final[Mapping[str, int]] = {"lines": 2, "surfaces": 3}
"""Nodes of a line and of a surface at least."""


@final
@dataclass(frozen=True, slots=True)
class Wireframe:
    """Nodes, lines and surfaces of a structure.

    Attributes
    ----------
    nodes : mapping
        Position of each node, by its number [m].
    lines : tuple of tuple of int
        Nodes along each line.
    surfaces : tuple of tuple of int
        Nodes around each surface.
    axes : mapping
        Unit vectors x, y and z of the nodes that have a coordinate system of their own [-].
    notes : tuple of str
        What its file holds and is not drawn, a sentence each.
    """

    nodes: Mapping[int, Place]
    lines: tuple[tuple[int, ...], ...] = ()
    surfaces: tuple[tuple[int, ...], ...] = ()
    axes: Mapping[int, Axes] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for kind in LEAST:
            for number, one in enumerate(getattr(self, kind), 1):
                if problem := problem_of(self.nodes, kind, one):
                    raise ValueError(f"{kind} {number}: {problem}")

    @property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Pairs of nodes that a line or the border of a surface joins, each pair once."""
        found = (pair for one in self.lines for pair in pairwise(one))
        borders = (pair for one in self.surfaces for pair in pairwise((*one, one[0])))
        pairs = ((min(pair), max(pair)) for each in (found, borders) for pair in each)
        return tuple(dict.fromkeys(pair for pair in pairs if pair[0] != pair[1]))

    @property
    def used(self) -> tuple[int, ...]:
        """Nodes of the lines and surfaces."""
        return tuple(sorted({node for edge in self.edges for node in edge}))

    def turned(self, node: int, direction: Place) -> Place:
        """Return a direction in the coordinate system of a node along the global axes [-]."""
        axes = self.axes.get(node)
        if axes is None:
            return direction
        x, y, z = (
            sum(v * axis[i] for v, axis in zip(direction, axes, strict=True)) for i in range(3)
        )
        return x, y, z


def numbered_nodes(
    places: Sequence[Place | None], wireframe: Wireframe | None
) -> tuple[list[int], Wireframe]:
    """Return the number of the node at each place, and the geometry with all of these nodes.

    Parameters
    ----------
    places : sequence of (x, y, z)
        Of sensors [m]; one that is not known has a node without coordinates.
    wireframe : Wireframe, optional
        Whose numbers count where a place is that of a node; others follow behind.
    """
    nodes = {} if wireframe is None else dict(wireframe.nodes)
    numbers = {place: number for number, place in nodes.items()}
    free = max(nodes, default=0) + 1
    found = []
    for place in places:
        number = free if place is None else numbers.setdefault(place, free)
        free = max(free, number + 1)
        found.append(number)
        if place is not None:
            nodes[number] = place
    if wireframe is None:
        return found, Wireframe(nodes)
    return found, replace(wireframe, nodes=nodes)


def problem_of(nodes: Mapping[int, Place], kind: str, one: Sequence[int]) -> str:
    """Return why nodes are no line or surface; empty where they are one.

    `kind` is ``lines`` or ``surfaces``, else one node is enough; `nodes` are those with
    coordinates [m].
    """
    unknown = next((node for node in one if node not in nodes), None)
    if unknown is not None:
        return f"node {unknown} has no coordinates; {_known(nodes)}"
    least = LEAST.get(kind, 1)
    if len(set(one)) < least:
        text = ", ".join(map(str, one)) or "none"
        return f"expected {least} nodes or more, got {text}"
    return ""


def _known(nodes: Mapping[int, Place]) -> str:
    """Return which nodes have coordinates, as far as a line holds them."""
    runs = [f"{a}" if a == b else f"{a} to {b}" for a, b in _runs(sorted(nodes))]
    more = f" and {len(runs) - 6} more ranges" if len(runs) > 6 else ""
    return f"those that have are {', '.join(runs[:6])}{more}" if runs else "none has"


def _runs(numbers: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Yield first and last of each row of numbers without a gap."""
    first = 0
    for i, number in enumerate(numbers):
        if i + 1 == len(numbers) or numbers[i + 1] != number + 1:
            yield numbers[first], number
            first = i + 1
