"""The numbers of a model file that are free, and how well each is known beforehand."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, final

from shakerproc.models import Element, Model

OWN_SPREAD: Final = 1.0
"""Standard deviation of the logarithm of a number of the model file: known to a factor of e.
The weakest prior that still holds a number of which the tests say nothing [-]."""

MODE_SPREADS: Final[Mapping[str, float]] = MappingProxyType({
    "frequency": 0.015,
    "damping_ratio": 0.3,
})
"""The same of a mode of a structure: finite elements are 1 to 2 % off in frequency, and damping
is known to a third (issue 42) [-]."""


@final
@dataclass(frozen=True, slots=True)
class OwnNumber:
    """A number of the model file that is free.

    Attributes
    ----------
    element : int or None
        Index among the elements of the model; None for a mass and for a mode.
    name : str
        Parameter of its effect, the name of the mass, or what of the mode.
    sign : float
        -1 where the hypothesis has it of the other sign than the file: the stiffness between
        two places to rest; else 1.
    mode : (str, int) or None
        Structure, and index among its modes.
    """

    element: int | None
    name: str
    sign: float = 1.0
    mode: tuple[str, int] | None = None

    @property
    def is_mass(self) -> bool:
        """Whether it is a mass."""
        return self.element is None and self.mode is None

    @property
    def spread(self) -> float:
        """Standard deviation of its logarithm that is known beforehand [-]."""
        return OWN_SPREAD if self.mode is None else MODE_SPREADS[self.name]

    def value(self, model: Model) -> float:
        """Return the number in a model [SI]."""
        if self.mode is not None:
            structure, index = self.mode
            return float(getattr(model.structures[structure].modes[index], self.name))
        if self.element is None:
            return float(model.masses[self.name])
        return float(getattr(model.elements[self.element].effect, self.name))

    def unit(self, model: Model) -> str:
        """Return its unit in a translation."""
        if self.mode is not None:
            return "Hz" if self.name == "frequency" else "1"
        if self.element is None:
            return "kg"
        return model.elements[self.element].effect.parameters[self.name].unit


def modal_numbers(model: Model) -> list[OwnNumber]:
    """Return frequency and damping of every elastic mode of the structures of a model."""
    return [
        OwnNumber(None, name, mode=(structure, i))
        for structure, one in model.structures.items()
        for i, mode in enumerate(one.modes)
        for name in MODE_SPREADS
        if not mode.rigid and getattr(mode, name) > 0.0
    ]


def with_values(
    model: Model,
    numbers: Sequence[OwnNumber],
    values: Sequence[float],
    more: Sequence[Element] = (),
) -> Model:
    """Return a model with other numbers, and more elements.

    Parameters
    ----------
    model : Model
        The model.
    numbers : sequence of OwnNumber
        Which.
    values : sequence of float
        What they are instead [SI].
    more : sequence of Element
        Elements after its own: neither alone need be a model.

    Raises
    ------
    ValueError
        If no model can have them.
    """
    elements, masses = list(model.elements), dict(model.masses)
    modes = {name: list(one.modes) for name, one in model.structures.items()}
    changed = set()
    for number, given in zip(numbers, values, strict=True):
        value = float(given)
        if number.mode is not None:
            structure, i = number.mode
            modes[structure][i] = replace(modes[structure][i], **{number.name: value})  # type: ignore[arg-type]
            changed.add(structure)
        elif number.element is None:
            masses[number.name] = value
        else:
            element = elements[number.element]
            effect = replace(element.effect, **{number.name: value})  # type: ignore[type-var]
            elements[number.element] = replace(element, effect=effect)
    structures = {
        name: replace(one, modes=tuple(modes[name])) if name in changed else one
        for name, one in model.structures.items()
    }
    return replace(model, masses=masses, elements=(*elements, *more), structures=structures)


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
