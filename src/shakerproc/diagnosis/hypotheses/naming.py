"""Names of the model's own numbers in a diagnosis."""

from collections.abc import Sequence

from shakerproc.diagnosis.hypotheses.own_numbers import OwnNumber
from shakerproc.models import Element, Model


def element_names(elements: Sequence[Element]) -> dict[tuple[int, str], str]:
    """Return a name for every parameter of every element, by its index and the parameter.

    Stiffness and damping of a joint are called after it; where several elements of one joint
    have a parameter of one name, all but the first say their kind, and their place in the file
    where that is not enough.
    """
    found: dict[tuple[int, str], str] = {}
    for i, element in enumerate(elements):
        place = "-".join(element.between)
        for name in element.effect.parameters:
            kind = f"{element.effect.kind}.{name}"
            wanted = (f"{name} {place}", f"{kind} {place}", f"{kind}.{i + 1} {place}")
            found[i, name] = next(text for text in wanted if text not in found.values())
    return found


def own_names(model: Model, numbers: Sequence[OwnNumber]) -> list[str]:
    """Return the names of the free numbers of a model."""
    elements = element_names(model.elements)
    return [
        mode_name(number.name, *number.mode)
        if number.mode is not None
        else mass_name(number.name)
        if number.element is None
        else elements[number.element, number.name]
        for number in numbers
    ]


def mode_name(what: str, structure: str, index: int) -> str:
    """Return the name of frequency or damping of a mode of a structure."""
    return f"{what} {structure}, mode {index + 1}"


def mass_name(mass: str) -> str:
    """Return the name of a mass."""
    return f"mass {mass}"


def sharing(model: Model, index: int, name: str) -> list[int]:
    """Return the elements of the same joint with a parameter of this name, by their index."""
    places = set(model.elements[index].between)
    return [
        i
        for i, element in enumerate(model.elements)
        if set(element.between) == places and name in element.effect.parameters
    ]
