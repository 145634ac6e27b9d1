"""The model with what a diagnosis found: to be run free against the same tests."""

from collections.abc import Mapping
from dataclasses import replace

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.hypotheses.naming import element_names, mass_name, sharing
from shakerproc.diagnosis.result import Diagnosis
from shakerproc.models import EFFECTS, Element, Model
from shakerproc.models.effects.base import AbstractEffect


def updated_model(model: Model, diagnosis: Diagnosis) -> Model | None:
    """Return a model with the effects that were found and its own numbers as fitted with them.

    Where no effect of the library will do, the missing force stands in as a table. None where
    the diagnosis names no model that would do: where the tests cannot tell, or there is no
    table.
    """
    added = [
        Element(effect_of(one.kind, one.parameters), (one.between[0], one.between[1]))
        for one in diagnosis.effects
        if one.kind in EFFECTS
    ]
    if diagnosis.verdict == "outside library" and diagnosis.outside is not None:
        added = [diagnosis.outside.element()]
    elif diagnosis.verdict in {"outside library", "cannot tell"}:
        return None
    fitted = with_numbers(model, diagnosis.linear)
    modes = tuple(mode.as_mode() for mode in diagnosis.modes)
    return replace(fitted, elements=(*fitted.elements, *added), modes=(*fitted.modes, *modes))


def with_numbers(model: Model, numbers: Mapping[str, Estimate]) -> Model:
    """Return a model with its own numbers as fitted, by their names (see `naming`).

    Springs that share a joint keep their numbers where only their sum is known.
    """
    elements = list(model.elements)
    for (i, name), value in fitted_values(model, numbers).items():
        effect = replace(elements[i].effect, **{name: value})  # type: ignore[type-var]
        elements[i] = replace(elements[i], effect=effect)
    masses = {
        mass: value if found is None else _number(found)
        for mass, value in model.masses.items()
        for found in [numbers.get(mass_name(mass))]
    }
    return replace(model, masses=masses, elements=tuple(elements))


def fitted_values(
    model: Model, numbers: Mapping[str, Estimate]
) -> dict[tuple[int, str], float]:
    """Return the fitted numbers of a model's elements by their index and parameter [SI]."""
    names = element_names(model.elements)
    turned = element_names([
        replace(element, between=element.between[::-1]) for element in model.elements
    ])
    known = {key: numbers.get(names[key]) or numbers.get(turned[key]) for key in names}
    return {
        (i, name): _number(estimate)
        for (i, name), estimate in known.items()
        if estimate is not None
        and getattr(model.elements[i].effect, name) is not None
        and all(known[j, name] is not None for j in sharing(model, i, name))
    }


def _number(estimate: Estimate) -> float:
    """Return the value of an estimate that is no word."""
    return float(estimate.value)


def effect_of(kind: str, numbers: Mapping[str, Estimate]) -> AbstractEffect:
    """Return the effect with these numbers."""
    return EFFECTS[kind].of_numbers({name: one.value for name, one in numbers.items()})
