"""Elements in parallel with an element: the numbers some effects take from them."""

from collections.abc import Collection, Iterator
from dataclasses import fields, replace
from typing import TYPE_CHECKING

import numpy as np

from shakerproc.errors import ModelError
from shakerproc.models.effects.base import AbstractEffect, DependsOnSurroundings
from shakerproc.models.effects.spring import Spring

if TYPE_CHECKING:
    from shakerproc.models.model import Element, Model


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
    return max(filter(None, map(_own_stiffness, others)), default=None)


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


def _own_stiffness(effect: AbstractEffect) -> float | None:
    names = {field.name for field in fields(effect)}  # type: ignore[arg-type]
    if isinstance(effect, DependsOnSurroundings) or "stiffness" not in names:
        return None
    return float(effect.stiffness)  # type: ignore[attr-defined]
