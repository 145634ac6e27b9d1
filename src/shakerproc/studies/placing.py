"""Setting a parameter of a model or a run by its place, such as ``elements.gap.clearance``."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Final

from shakerproc.models import Element, Model
from shakerproc.studies.study import Run

RUN_UNITS: Final[Mapping[str, str]] = {
    "from": "Hz",
    "to": "Hz",
    "frequency": "Hz",
    "duration": "s",
    "sample rate": "Hz",
    "initial displacement": "m",
    "initial velocity": "m/s",
    "settle": "1",
    "seed": "1",
}
"""Places of a run and their units; ``level`` takes that of the model's excitation."""

RUN_FIELDS: Final[Mapping[str, str]] = {"from": "from_hz", "to": "to_hz"}


def unit_of_place(model: Model, place: str) -> str:
    """Return the SI unit of a place; ``1`` for a plain number.

    Raises
    ------
    ValueError
        If there is no such place, with what there is.
    """
    head, *rest = place.split(".")
    if head == "masses" and len(rest) == 1:
        _one_of("mass", rest[0], list(model.masses))
        return "kg"
    if head == "run" and len(rest) == 1:
        if rest[0] == "level":
            return "N" if model.excitation.on is not None else "m/s^2"
        _one_of("key of the run", rest[0], [*RUN_UNITS, "level"])
        return RUN_UNITS[rest[0]]
    if head == "elements" and len(rest) == 2:
        effect = model.elements[_index(model, rest[0])].effect
        _one_of(f"parameter of {effect.kind}", rest[1], list(effect.parameters))
        return effect.parameters[rest[1]].unit
    raise ValueError(
        f"expected a place such as elements.gap.clearance, masses.{next(iter(model.masses))} "
        f"or run.level, got {place!r}"
    )


def placed(
    model: Model, run: Run | None, places: Sequence[str], value: float
) -> tuple[Model, Run | None]:
    """Return model and run with a value [SI] set at every place."""
    for place in places:
        head, *rest = place.split(".")
        if head == "masses":
            model = replace(model, masses={**model.masses, rest[0]: value})
        elif head == "elements":
            model = _with_parameter(model, _index(model, rest[0]), rest[1], value)
        elif run is not None:
            run = _with_field(run, rest[0], value)
    return model, run


def _with_parameter(model: Model, index: int, name: str, value: float) -> Model:
    elements = list(model.elements)
    effect = replace(elements[index].effect, **{name: value})  # type: ignore[type-var]
    elements[index] = Element(effect, elements[index].between)
    return replace(model, elements=tuple(elements))


def _with_field(run: Run, name: str, value: float) -> Run:
    field = RUN_FIELDS.get(name, name.replace(" ", "_"))
    kinds = {f.name: f.type for f in fields(run)}
    number = int(value) if kinds[field] in {int, "int"} else value
    return replace(run, **{field: number})  # type: ignore[arg-type]


def _index(model: Model, name: str) -> int:
    """Return which element is meant, by its number from 0 or by its kind.

    Raises
    ------
    ValueError
        If it is not clear which.
    """
    if name.isdigit() and int(name) < len(model.elements):
        return int(name)
    found = [i for i, element in enumerate(model.elements) if element.effect.kind == name]
    if len(found) == 1:
        return found[0]
    kinds = ", ".join(f"{i} ({e.effect.kind})" for i, e in enumerate(model.elements))
    several = "several elements" if found else "no element"
    raise ValueError(f"{several} {name!r}; the model has {kinds}")


def _one_of(what: str, name: str, known: Sequence[str]) -> None:
    """Pass a known name.

    Raises
    ------
    ValueError
        If it is not known.
    """
    if name not in known:
        raise ValueError(f"no {what} {name!r}; there are {', '.join(known)}")
