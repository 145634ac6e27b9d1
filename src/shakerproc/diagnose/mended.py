"""The model with what a diagnosis found: to be run free against the same tests."""

from collections.abc import Mapping
from dataclasses import replace

from shakerproc.diagnose.adding import effect_of
from shakerproc.diagnose.result import Diagnosis
from shakerproc.diagnosis.result import Estimate, Finding
from shakerproc.models import EFFECTS, Element, Model


def mended(model: Model, diagnosis: Diagnosis) -> Model | None:
    """Return a model with the effects that were found and the linear numbers fitted with them.

    None where the diagnosis names no model that would do: where nothing in the library fits,
    or the tests cannot tell. Springs and dampers that share a joint with another of their kind
    keep their numbers, as the fit knows their sum alone.
    """
    if diagnosis.verdict in {"outside library", "cannot tell"}:
        return None
    elements = [
        _refitted(element, model, diagnosis.linear) for element in model.elements
    ] + [
        _element(effect) for effect in diagnosis.effects if effect.kind in EFFECTS
    ]  # fmt: skip
    return replace(model, elements=tuple(elements))


def _element(effect: Finding) -> Element:
    first, second = effect.between
    return Element(effect_of(effect.kind, effect.parameters), (first, second))


def _refitted(element: Element, model: Model, linear: Mapping[str, Estimate]) -> Element:
    kind, (first, second) = element.effect.kind, element.between
    if kind not in {"spring", "damper"} or not _alone(element, model):
        return element
    number = "stiffness" if kind == "spring" else "damping"
    found = linear.get(f"{number} {first}-{second}") or linear.get(f"{number} {second}-{first}")
    if found is None or getattr(element.effect, number) is None:
        return element
    return Element(replace(element.effect, **{number: found.value}), element.between)  # type: ignore[type-var]


def _alone(element: Element, model: Model) -> bool:
    """Return whether an element is the only one of its kind between its places."""
    same = [
        other
        for other in model.elements
        if other.effect.kind == element.effect.kind
        and set(other.between) == set(element.between)
    ]
    return len(same) == 1
