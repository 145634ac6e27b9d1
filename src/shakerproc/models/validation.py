"""Whether a model can stand: places that exist, a way to the base, nothing that runs away."""

import difflib
from typing import TYPE_CHECKING

import numpy as np

from shakerproc.errors import ModelError
from shakerproc.models.coordinates import Coordinates, coordinates_of, mobility, resolved
from shakerproc.models.effects.attached_mode import AttachedMode
from shakerproc.models.effects.base import AbstractMemorylessEffect
from shakerproc.models.effects.spring import Spring
from shakerproc.numerals import numeral

if TYPE_CHECKING:
    from shakerproc.data import FloatArray
    from shakerproc.models.model import Element, Model

BASE = "base"
_RANK = 1e-9
"""Share of a motion below which rounding alone is left [-]."""


def check_model(model: "Model") -> None:
    """Pass a model that can be simulated.

    Raises
    ------
    ModelError
        If it cannot, with what is wrong and what to do.
    """
    _check_places(model)
    alone = coordinates_of(model, ())
    held = _springs_hold(alone, model.elements)  # then no other element need be asked
    if not held:
        _check_base_is_reached(model, alone)
    elements = resolved(model)
    if not held:
        _check_nothing_runs_away(model, elements)


def check_sampled(model: "Model", sample_rate: float) -> None:
    """Pass a model whose structures have no mode that samples do not tell.

    Parameters
    ----------
    model : Model
        The model.
    sample_rate : float
        Samples per second of a recording [Hz].

    Raises
    ------
    ModelError
        If one lies beyond half the sample rate.
    """
    for name, structure in model.structures.items():
        for i, mode in enumerate(structure.modes, 1):
            if mode.frequency > 0.5 * sample_rate:
                raise ModelError(
                    f"{model.title}: mode {i} of {name} at {numeral(mode.frequency)} Hz lies "
                    f"beyond half the sample rate of {numeral(sample_rate)} Hz. Leave it out."
                )


def check_unscaled(model: "Model", doing: str) -> None:
    """Raise where the model depends on the conditions of a test.

    Parameters
    ----------
    model : Model
        The model.
    doing : str
        What knows no conditions, for the message.

    Raises
    ------
    ModelError
        If a condition scales an element of it.
    """
    for element in model.elements:
        if element.scaled_by is not None:
            kind, name = element.effect.kind, element.scaled_by.condition
            raise ModelError(
                f"{model.title}: {kind} between {' and '.join(element.between)} is scaled by "
                f"{name}, and {doing} cannot yet take a model under conditions of tests. Write "
                f"its numbers at one {name}, without scaled_by."
            )


def _check_places(model: "Model") -> None:
    if not model.masses and not model.structures:
        raise ModelError(
            f"{model.title}: no masses. Give at least one, such as coupon: 28.6 g."
        )
    if BASE in model.masses:
        raise ModelError(f"{model.title}: {BASE} is the shaker table and has no mass here.")
    _check_structures(model)
    for element in model.elements:
        _check_element(model, element)
    for name, sensor in model.sensors.items():
        _check_place(model, sensor.at, f"sensor {name}")
    if model.excitation.on == BASE:
        raise ModelError(
            f"{model.title}: {model.excitation.kind} on {BASE}. Name the mass that it acts on."
        )
    if model.excitation.on is not None:
        _check_place(model, model.excitation.on, "excitation")
    imposed = model.excitation.on if model.excitation.imposed else None
    if imposed in model.points:
        raise ModelError(
            f"{model.title}: the displacement of {imposed}, a point of a structure, cannot be "
            f"imposed. Impose that of a mass, or let a force act."
        )
    for name, sensor in model.sensors.items():
        if sensor.measures == "force" and sensor.at != imposed:
            raise ModelError(
                f"{model.title}: sensor {name} measures the force at {sensor.at}, which is "
                f"known only where the displacement is imposed. Write excitation: "
                f"{{displacement of: {sensor.at}}}, or take the sensor out."
            )


def _check_structures(model: "Model") -> None:
    named: dict[str, str] = dict.fromkeys(model.masses, "a mass") | {BASE: "the shaker table"}
    for name, structure in model.structures.items():
        for point in structure.points:
            if point in named:
                raise ModelError(
                    f"{model.title}: structures: the point {point!r} of {name} is also the "
                    f"name of {named[point]}. Names of places are unique in a model."
                )
            named[point] = f"a point of {name}"
        if model.excitation.moves_base:
            try:
                structure.participations  # noqa: B018
            except ValueError as error:
                raise ModelError(f"{model.title}: structure {name}: {error}.") from error


def _check_element(model: "Model", element: "Element") -> None:
    kind, (first, second) = element.effect.kind, element.between
    for place in element.between:
        _check_place(model, place, f"between of {kind}")
    if first == second:
        raise ModelError(
            f"{model.title}: {kind} stands between {first} and itself. Name two places."
        )
    if mobility(model, element.between) == 0.0:
        raise ModelError(
            f"{model.title}: {kind} between {first} and {second} never moves: no mode has "
            f"a relative motion there. Add modes that have, or take the element out."
        )
    if isinstance(element.effect, AttachedMode) and second == BASE:
        raise ModelError(
            f"{model.title}: an attached mode on the {BASE} moves nothing else. Name the mass "
            f"that it sits on last."
        )


def _check_place(model: "Model", place: str, where: str) -> None:
    if place in model.places:
        return
    near = difflib.get_close_matches(place, model.places, 1)
    hint = f"did you mean {near[0]!r}?" if near else f"places are {', '.join(model.places)}."
    raise ModelError(f"{model.title}: {where}: no place {place!r}; {hint}")


def _springs_hold(alone: Coordinates, elements: "tuple[Element, ...]") -> bool:
    """Return whether springs, structures and further modes push back whatever moves.

    `alone` are the coordinates without elements.
    """
    matrix = alone.stiffness.copy()
    for element in elements:
        if isinstance(element.effect, Spring):
            across = alone.across(element.between)
            matrix += element.effect.stiffness * np.outer(across, across)
    stiffness = np.linalg.eigvalsh(matrix)
    return bool(stiffness[0] > _RANK * stiffness[-1])


def _check_base_is_reached(model: "Model", alone: Coordinates) -> None:
    """Pass a model in which no motion leaves every element as it is.

    Raises
    ------
    ModelError
        If a mass, or a structure as a rigid body, can move so.
    """
    held = [
        alone.across(element.between)
        for element in model.elements
        if not isinstance(element.effect, AttachedMode)
    ]
    if model.excitation.imposed:
        held.append(alone.at(str(model.excitation.on)))
    free = np.flatnonzero(np.diag(alone.stiffness) == 0.0)
    free = free[free < len(alone.names) - len(model.modes)]
    stretched = np.reshape(held, (-1, len(alone.names)))[:, free]
    residual = np.eye(free.size) - np.linalg.pinv(stretched, rcond=_RANK) @ stretched
    for i, coordinate in enumerate(free):
        if residual[i, i] > _RANK:
            name = alone.names[coordinate]
            what = "Add the element that holds it."
            if name not in model.masses:
                structure, mode = name.rsplit(", ", 1)
                name = f"{structure} as a rigid body ({mode}, 0 Hz)"
            raise ModelError(
                f"{model.title}: no chain of elements leads from {name} to the {BASE}. {what}"
            )


def _check_nothing_runs_away(model: "Model", elements: "tuple[Element, ...]") -> None:
    """Pass joints that push back at some displacement, on both sides.

    Raises
    ------
    ModelError
        If one does not.
    """
    imposed = {model.excitation.on} if model.excitation.imposed else set()
    for pair in {frozenset(element.between) for element in elements}:
        if pair & imposed:
            continue
        first = next(e.between for e in elements if set(e.between) == set(pair))
        for side in (1.0, -1.0):
            force = side * _static_force(elements, first, side)
            if np.any(force < 0.0) and not np.any(force > 0.0):
                name = "positive" if side > 0.0 else "negative"
                raise ModelError(
                    f"{model.title}: between {' and '.join(first)} the static force drives "
                    f"the mass away at every displacement on the {name} side. Add a spring, or "
                    f"correct the sign of a coefficient."
                )


def _static_force(
    elements: "tuple[Element, ...]", between: tuple[str, str], side: float
) -> "FloatArray":
    """Return the force at rest of all between two places, over 1 nm to 10 m, (n,) array [N].

    What is there without displacement, such as dead weight, is left out: it moves the place of
    rest, and does not grow with the way from it.
    """
    z = side * np.geomspace(1e-9, 10.0, 121)
    total = np.zeros_like(z)
    for element in elements:
        effect = element.effect
        if not isinstance(effect, AbstractMemorylessEffect):
            continue
        if set(element.between) == set(between):
            turn = 1.0 if element.between == between else -1.0
            with np.errstate(over="ignore"):  # a high power of 10 m is as good as infinite
                rest = effect.force_at(np.zeros(1), np.zeros(1))
                total += turn * (effect.force_at(turn * z, np.zeros_like(z)) - rest)
    return total
