"""Coordinates of a model, its linear part, and the numbers that effects take from it."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.models.laws import Law, Row

if TYPE_CHECKING:
    from shakerproc.models.model import Element, Model
from collections.abc import Collection
from dataclasses import fields, replace
from typing import TYPE_CHECKING

from shakerproc.errors import ModelError
from shakerproc.models.effects.base import AbstractEffect, DependsOnSurroundings
from shakerproc.models.effects.spring import Spring

BASE: Final = "base"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Coordinates:
    r"""Coordinates of a model, relative to the base, and its linear part over them.

    .. math:: M \ddot x + C \dot x + K x + \sum_e d_e f_e(d_e^T x, d_e^T \dot x) = b \, u

    Attributes
    ----------
    names : tuple of str
        The masses of the model, the modes of its structures, then ``attached 1``, ... for the
        modes attached to them and ``mode 1``, ... for further modes.
    mass : (n,) array
        Diagonal of :math:`M` [kg].
    stiffness, damping : (n, n) array
        :math:`K` [N/m], :math:`C` [N s/m].
    load : (n,) array
        Forces of a unit of the input, :math:`b` [kg] of a base acceleration, [-] of a force;
        0 where there is neither.
    places : mapping of str to (n,) array
        Displacement by unit coordinates of each mass, of each point of a structure, and of each
        attached and further mode [-].
    """

    names: tuple[str, ...]
    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    load: FloatArray
    places: Mapping[str, FloatArray]

    def at(self, place: str) -> FloatArray:
        """Return the displacement of a place by unit coordinates, (n,) array [-]."""
        return np.zeros(len(self.names)) if place == BASE else self.places[place]

    def across(self, between: tuple[str, str]) -> FloatArray:
        """Return the motion of the second place less that of the first, (n,) array [-]."""
        return self.at(between[1]) - self.at(between[0])


def coordinates_of(model: "Model", elements: "Iterable[Element] | None" = None) -> Coordinates:
    """Return the coordinates of a model and its linear part.

    Parameters
    ----------
    model : Model
        What is shaken.
    elements : iterable of Element, optional
        Its elements with every number filled in (see `resolved`), where these are at hand.
    """
    joined = tuple(resolved(model) if elements is None else elements)
    attached = [(e, row) for e in joined for row in e.effect.rows() if row.law is Law.ATTACHED]
    rigid = model.rigid_masses
    modal = [
        (f"{name}, mode {i + 1}", one, i)
        for name, one in model.structures.items()
        for i in range(len(one.with_residuals))
    ]
    names = [
        *rigid,
        *(name for name, _, _ in modal),
        *(f"attached {i + 1}" for i in range(len(attached))),
        *(f"mode {i + 1}" for i in range(len(model.modes))),
    ]
    sizes = np.concatenate([np.zeros(0), *(one.sizes for one in model.structures.values())])
    mass = np.array([
        *rigid.values(),
        *sizes**-2.0,
        *(row.values[0] for _, row in attached),
        *(mode.mass for mode in model.modes),
    ])
    shaped = slice(len(rigid), len(rigid) + len(modal))
    places = _places(model, names, sizes, shaped)
    matrices = np.zeros((2, mass.size, mass.size))
    for direction, values in _springs(model, joined, attached, places):
        for matrix, value in zip(matrices, values, strict=True):
            matrix[:] += value * np.outer(direction, direction)
    for i, (_, one, k) in enumerate(modal, shaped.start):
        omega = 2.0 * np.pi * one.with_residuals[k].frequency
        matrices[:, i, i] += (
            omega**2 * mass[i],
            2.0 * one.with_residuals[k].damping_ratio * omega * mass[i],
        )
    load = np.zeros(len(names))
    if model.excitation.moves_base:
        load = -mass
        shares = [one.participations for one in model.structures.values()]
        load[shaped] = -np.concatenate([np.zeros(0), *shares]) / sizes
    elif model.excitation.kind == "force":
        load = places[str(model.excitation.on)].copy()
    return Coordinates(tuple(names), mass, matrices[0], matrices[1], load, places)


def _places(
    model: "Model", names: Sequence[str], sizes: FloatArray, shaped: slice
) -> dict[str, FloatArray]:
    """Return the displacement of each place by unit coordinates."""
    unit = np.eye(len(names))
    places = {
        name: unit[i] for i, name in enumerate(names) if not shaped.start <= i < shaped.stop
    }
    first, used = shaped.start, 0
    for one in model.structures.values():
        count = len(one.with_residuals)
        rows = np.zeros((len(one.points), len(names)))
        rows[:, first + used : first + used + count] = one.shapes / sizes[used : used + count]
        places |= dict(zip(one.points, rows, strict=True))
        used += count
    return places


def _springs(
    model: "Model",
    elements: "Sequence[Element]",
    attached: "Sequence[tuple[Element, Row]]",
    places: Mapping[str, FloatArray],
) -> Iterator[tuple[FloatArray, Sequence[float]]]:
    """Yield direction, stiffness and damping of springs, dampers, attached modes and modes."""
    still = np.zeros_like(next(iter(places.values())))
    for element in elements:
        first, second = (places.get(place, still) for place in element.between)
        for row in element.effect.rows():
            if row.law is Law.LINEAR:
                yield second - first, row.values
    for i, (element, row) in enumerate(attached, 1):
        yield places[f"attached {i}"] - places[element.between[1]], row.values[1:]
    for i, mode in enumerate(model.modes, 1):
        held = [share * places[name] for name, share in mode.participation.items()]
        yield places[f"mode {i}"] - np.sum(held, axis=0), (mode.stiffness, mode.damping)


def parallel(model: "Model", element: "Element") -> Iterator["Element"]:
    """Yield every element between the same two places, in either order, itself too."""
    for other in model.elements:
        if set(other.between) == set(element.between):
            yield other


def parallel_stiffness(model: "Model", element: "Element") -> float | None:
    """Return the stiffness of the springs in parallel with an element [N/m].

    Where there is no spring, that of the stiffest other effect (a gap's contact, say); None
    where nothing in parallel has a stiffness.
    """
    others = [other.effect for other in parallel(model, element) if other is not element]
    springs = [effect.stiffness for effect in others if isinstance(effect, Spring)]
    if springs:
        return sum(springs)
    return max(filter(None, map(_stiffness_of, others)), default=None)


def reduced_mass(model: "Model", element: "Element") -> float:
    """Return the mass that vibrates on an element: both ends, the base infinite [kg]."""
    return 1.0 / mobility(model, element.between)


def mobility(model: "Model", between: Collection[str]) -> float:
    """Return the relative acceleration of two places by a unit force between them [1/kg]."""
    total = sum(1.0 / model.masses[name] for name in between if name in model.masses)
    for structure in model.structures.values():
        shapes = [
            sign * structure.shapes[structure.points.index(place)]
            for place, sign in zip(between, (-1.0, 1.0), strict=True)
            if place in structure.points
        ]
        total += float(np.sum(np.sum(shapes, axis=0) ** 2)) if shapes else 0.0
    return total


def resolved(model: "Model") -> tuple["Element", ...]:
    """Return the elements with every number filled in that comes from their surroundings.

    Raises
    ------
    ModelError
        If an effect needs a spring in parallel and there is none.
    """
    return tuple(_in_place(model, element) for element in model.elements)


def _in_place(model: "Model", element: "Element") -> "Element":
    effect = element.effect
    if not isinstance(effect, DependsOnSurroundings):
        return element
    stiffness = parallel_stiffness(model, element)
    if _complete(effect):
        return element
    if stiffness is None or stiffness <= 0.0:
        places = " and ".join(element.between)
        raise ModelError(
            f"{model.title}: the {effect.kind} between {places} takes the stiffness of the "
            f"spring in parallel, and there is none. Add a spring, or give its own value."
        )
    return replace(element, effect=effect.in_place(stiffness, reduced_mass(model, element)))


def _complete(effect: AbstractEffect) -> bool:
    """Return whether an effect needs nothing from its surroundings."""
    try:
        effect.rows()
    except ValueError:
        return False
    return True


def _stiffness_of(effect: AbstractEffect) -> float | None:
    names = {field.name for field in fields(effect)}  # type: ignore[arg-type]
    if isinstance(effect, DependsOnSurroundings) or "stiffness" not in names:
        return None
    return float(effect.stiffness)  # type: ignore[attr-defined]
