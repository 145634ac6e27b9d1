"""The model with what a diagnosis found: to be run free against the same tests."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from shakerproc.diagnosis.estimate import Estimate
from shakerproc.diagnosis.hypotheses.naming import (
    element_names,
    mass_name,
    own_names,
    sharing,
)
from shakerproc.diagnosis.hypotheses.own_numbers import OwnNumber, modal_numbers, with_values
from shakerproc.diagnosis.result import Diagnosis, Finding
from shakerproc.model_files.writing import within
from shakerproc.models import EFFECTS, Element, Model
from shakerproc.models.effects.base import AbstractEffect


def updated_model(model: Model, diagnosis: Diagnosis) -> Model | None:
    """Return a model with the effects that were found and its own numbers as fitted with them.

    Where no effect of the library will do, the missing force stands in as a table. None where
    the diagnosis names no model that would do: where the tests cannot tell, or there is no
    table.
    """
    if diagnosis.verdict == "outside library" and diagnosis.outside is not None:
        return model_with(model, [diagnosis.outside.element()], diagnosis.linear)
    if diagnosis.verdict in {"outside library", "cannot tell"}:
        return None
    return model_with(model, elements_of(diagnosis.effects), diagnosis.linear)


def elements_of(effects: Sequence[Finding]) -> list[Element]:
    """Return effects that were found as elements; faults of sensors are left out."""
    return [
        Element(effect_of(one.kind, one.parameters), (one.between[0], one.between[1]))
        for one in effects
        if one.kind in EFFECTS
    ]


def model_with(model: Model, added: Sequence[Element], linear: Mapping[str, Estimate]) -> Model:
    """Return a model with elements and its own numbers as fitted, as `add` writes them.

    Neither alone need be a model: a spring that pushes away stands beside a law that holds.

    Parameters
    ----------
    model : Model
        The model of the file.
    added : sequence of Element
        What was found.
    linear : mapping of str to Estimate
        The model's own numbers, by their names (see `naming`).
    """
    own = {name: replace(one, value=shortened(one)) for name, one in linear.items()}
    values = {
        OwnNumber(i, name): value for (i, name), value in fitted_values(model, own).items()
    }
    values |= {
        number: _number(own[name])
        for mass in model.masses
        for name, number in [(mass_name(mass), OwnNumber(None, mass))]
        if name in own
    }
    values |= {
        number: _number(own[name])
        for number in modal_numbers(model)
        for name in own_names(model, (number,))
        if name in own
    }
    return with_values(model, tuple(values), tuple(values.values()), added)


def fitted_values(
    model: Model, numbers: Mapping[str, Estimate]
) -> dict[tuple[int, str], float]:
    """Return the fitted numbers of a model's elements by their index and parameter [SI].

    Springs that share a joint keep their numbers where only their sum is known.
    """
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
    """Return the effect with these numbers, in as many digits as their intervals bear out."""
    return EFFECTS[kind].of_numbers({name: shortened(one) for name, one in numbers.items()})


def shortened(estimate: Estimate) -> float | str:
    """Return a fitted number with as many digits as its interval bears out."""
    value = estimate.value
    if isinstance(value, str):
        return value
    return within(float(value), estimate.unit, *estimate.bounds_by_tests)
