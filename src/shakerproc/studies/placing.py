"""Setting a parameter of a model or a run by its place, such as ``elements.gap.clearance``."""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Final

from shakerproc.finite_elements.thermal import clearances_at
from shakerproc.models import Element, Model
from shakerproc.models.effects import Gap, OffsetGap
from shakerproc.studies.study import StudyRun, Warmth

TEMPERATURE: Final = "joint.temperature"
"""The place that sets the clearance of every gap by thermal expansion."""

RUN_UNITS: Final[Mapping[str, str]] = {
    "from": "Hz",
    "to": "Hz",
    "frequency": "Hz",
    "phase": "rad",
    "duration": "s",
    "sample rate": "Hz",
    "initial displacement": "m",
    "initial velocity": "m/s",
    "settle": "1",
    "seed": "1",
    "tolerance": "1",
}
"""Places of a run and their units; ``level`` takes that of the model's excitation."""

RUN_FIELDS: Final[Mapping[str, str]] = {"from": "from_hz", "to": "to_hz"}


def unit_of_place(model: Model, place: str, warmth: Warmth | None = None) -> str:
    """Return the SI unit of a place; ``1`` for a plain number.

    Raises
    ------
    ValueError
        If there is no such place, with what there is.
    """
    if place == TEMPERATURE:
        _check_temperature(model, warmth)
        return "K"
    head, *rest = place.split(".")
    if head == "masses" and len(rest) == 1:
        _one_of("mass", rest[0], list(model.masses))
        return model.unit_of("kg")
    if head == "run" and len(rest) == 1:
        if rest[0] == "level":
            return model.drive_unit
        _one_of("key of the run", rest[0], [*RUN_UNITS, "level"])
        return RUN_UNITS[rest[0]]
    if head == "elements" and len(rest) == 2:
        effect = model.elements[_index(model, rest[0])].effect
        _one_of(f"parameter of {effect.kind}", rest[1], list(effect.parameters))
        return model.unit_of(effect.parameters[rest[1]].unit)
    raise ValueError(
        f"expected a place such as elements.gap.clearance, "
        f"masses.{next(iter(model.masses), 'coupon')}, run.level or {TEMPERATURE}, "
        f"got {place!r}"
    )


def placed(
    model: Model,
    run: StudyRun | None,
    places: Sequence[str],
    value: float,
    warmth: Warmth | None = None,
) -> tuple[Model, StudyRun | None]:
    """Return model and run with a value [SI] set at every place."""
    for place in places:
        head, *rest = place.split(".")
        if place == TEMPERATURE and warmth is not None:
            model = at_temperature(model, warmth, value)
        elif head == "masses":
            model = replace(model, masses={**model.masses, rest[0]: value})
        elif head == "elements":
            model = _with_parameter(model, _index(model, rest[0]), rest[1], value)
        elif run is not None:
            run = _with_field(run, rest[0], value)
    return model, run


def at_temperature(model: Model, warmth: Warmth, temperature: float) -> Model:
    """Return the model with the clearances that its gaps have at a temperature [K].

    A joint that is squeezed has no clearance; that it then grips is not modelled.
    """
    change = temperature - warmth.reference
    elements = []
    for element in model.elements:
        effect = element.effect
        if isinstance(effect, Gap | OffsetGap):
            wider = 0.5 * (_play_at(effect, warmth, change) - _play_of(effect))
            effect = _widened(effect, wider)
        elements.append(Element(effect, element.between))
    return replace(model, elements=tuple(elements))


def clearance_of(model: Model) -> float | None:
    """Return half the play of the first gap of a model [m]; None where it has none."""
    gaps = (e.effect for e in model.elements if isinstance(e.effect, Gap | OffsetGap))
    return next((0.5 * _play_of(gap) for gap in gaps), None)


def _play_of(gap: Gap | OffsetGap) -> float:
    if isinstance(gap, Gap):
        return 2.0 * gap.clearance
    return gap.clearance_positive + gap.clearance_negative


def _play_at(gap: Gap | OffsetGap, warmth: Warmth, change: float) -> float:
    fit = replace(warmth.fit, opening=warmth.fit.insert + _play_of(gap))
    return max(0.0, clearances_at(fit, change).play)


def _widened(gap: Gap | OffsetGap, wider: float) -> Gap | OffsetGap:
    if isinstance(gap, Gap):
        return replace(gap, clearance=max(0.0, gap.clearance + wider))
    return replace(
        gap,
        clearance_positive=max(0.0, gap.clearance_positive + wider),
        clearance_negative=max(0.0, gap.clearance_negative + wider),
    )


def _check_temperature(model: Model, warmth: Warmth | None) -> None:
    """Pass a model whose gap knows how it expands.

    Raises
    ------
    ValueError
        If it has no gap, or the study names no coupon with a joint.
    """
    if warmth is None:
        raise ValueError(
            f"{TEMPERATURE} needs the key coupon: a coupon file with the size and material of "
            f"its joint"
        )
    if clearance_of(model) is None:
        raise ValueError(f"{TEMPERATURE} needs a gap or an offset_gap in the model")


def _with_parameter(model: Model, index: int, name: str, value: float) -> Model:
    elements = list(model.elements)
    effect = replace(elements[index].effect, **{name: value})  # type: ignore[type-var]
    elements[index] = Element(effect, elements[index].between)
    return replace(model, elements=tuple(elements))


def _with_field(run: StudyRun, name: str, value: float) -> StudyRun:
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
