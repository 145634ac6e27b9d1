"""From a model of the files to the structure the observer knows, and back to names."""

from dataclasses import dataclass

import numpy as np

from shakerproc.diagnose.candidates import Candidate, Motion, library
from shakerproc.diagnose.problem import Hypothesis, Parameters, Term
from shakerproc.diagnose.structure import Joint, Sensing, Structure
from shakerproc.errors import DiagnosisError
from shakerproc.models import BASE, Model

ORDERS = {
    "acceleration": (2, True),
    "velocity": (1, True),
    "displacement": (0, True),
    "relative velocity": (1, False),
    "relative displacement": (0, False),
}


@dataclass(frozen=True, slots=True, eq=False)
class Skeleton:
    """The linear part of a model with the names of its places, and its other effects.

    Attributes
    ----------
    structure : Structure
        Masses, joints, sensors.
    places : tuple of str
        Name of each mass.
    sensors : tuple of str
        Name of each sensor.
    terms, values : tuples
        Effects that the model has already, and their numbers.
    """

    structure: Structure
    places: tuple[str, ...]
    sensors: tuple[str, ...]
    terms: tuple[Term, ...]
    values: tuple[tuple[float, ...], ...]

    def between(self, joint: int) -> tuple[str, str]:
        """Return the two places of a joint."""
        own = self.structure.joints[joint]
        return self._name(own.a), self._name(own.b)

    def _name(self, mass: int) -> str:
        return BASE if mass < 0 else self.places[mass]


def skeleton(model: Model, sensors: tuple[str, ...]) -> Skeleton:
    """Return the skeleton of a model that is watched by these of its sensors.

    Raises
    ------
    DiagnosisError
        If a sensor is unknown, or measures what cannot be used, or the model has what this
        search does not know.
    """
    _check_known(model)
    places = tuple(model.masses)
    index = {name: i for i, name in enumerate(places)} | {BASE: -1}
    pairs: dict[tuple[int, int], list[float]] = {}
    other = []
    for element in model.elements:
        a, b = (index[name] for name in element.between)
        sign = 1.0
        if b < 0 or (a > b >= 0):
            a, b, sign = b, a, -1.0
        pair = pairs.setdefault((a, b), [0.0, 0.0])
        effect = element.effect
        if effect.kind == "spring":
            pair[0] += effect.stiffness  # type: ignore[attr-defined]
        elif effect.kind == "damper":
            damping = effect.damping  # type: ignore[attr-defined]
            if damping is None:
                inverse = sum(1.0 / model.masses[places[i]] for i in (a, b) if i >= 0)
                ratio = effect.damping_ratio  # type: ignore[attr-defined]
                damping = (
                    2.0 * ratio * np.sqrt(max(_spring(model, element.between), 0.0) / inverse)
                )
            pair[1] += float(damping)
        else:
            other.append((effect, (a, b), sign))
    joints = []
    for (a, b), (k, c) in pairs.items():
        scale = np.sqrt(max(k, 1e-12) * model.masses[places[b]])
        joints.append(Joint(a, b, max(k, 1e-9), c if c > 0.0 else 1e-3 * float(scale)))
    structure = Structure(
        np.array(list(model.masses.values())),
        tuple(joints),
        tuple(_sensing(model, name, index) for name in sensors),
        index[model.excitation.on] if model.excitation.on is not None else -1,
    )
    terms, values = [], []
    for effect, pair_key, _ in other:
        joint = list(pairs).index(pair_key)
        term, numbers = known_term(effect, joint)
        terms.append(term)
        values.append(numbers)
    return Skeleton(structure, places, sensors, tuple(terms), tuple(values))


def unknown(model: Model) -> str:
    """Return what this search does not know of a model; nothing where it knows all of it."""
    if model.excitation.kind not in {"base acceleration", "force"}:
        return f"the excitation is {model.excitation.kind}"
    if model.modes:
        return "the model has modes"
    if any(_spring(model, element.between) < 0.0 for element in model.elements):
        return "a joint has a negative stiffness"
    return ""


def _check_known(model: Model) -> None:
    """Pass a model of which this search knows everything but some effects.

    Raises
    ------
    DiagnosisError
        If it has modes, a negative stiffness, or a motion that is imposed.
    """
    found = unknown(model)
    if found:
        raise DiagnosisError(
            f"{model.title}: {found}, which diagnose and add do not know yet. Take it out, or "
            "use compare and simulate, which know it."
        )


def _spring(model: Model, between: tuple[str, str]) -> float:
    return sum(
        e.effect.stiffness  # type: ignore[attr-defined]
        for e in model.elements
        if e.effect.kind == "spring" and set(e.between) == set(between)
    )


def _sensing(model: Model, name: str, index: dict[str, int]) -> Sensing:
    if name not in model.sensors:
        known = ", ".join(model.sensors) or "none"
        raise DiagnosisError(
            f"{model.title}: the log has a response {name!r} that the model does not know; its "
            f"sensors are {known}. Name it in the model under sensors, or give it role: ignore "
            "in the log."
        )
    sensor = model.sensors[name]
    if sensor.at == BASE:
        raise DiagnosisError(
            f"{model.title}: sensor {name} sits on the base and says nothing of a joint; give "
            "its channel role: control or ignore in the log."
        )
    order, absolute = ORDERS[sensor.measures]
    if absolute and order < 2 and model.excitation.kind == "base acceleration":
        raise DiagnosisError(
            f"{model.title}: sensor {name} measures absolute {sensor.measures}, but the base "
            "moves; measure it relative to the base, or use an acceleration."
        )
    return Sensing(index[sensor.at], order, absolute)


def known_term(effect: object, joint: int) -> tuple[Term, tuple[float, ...]]:
    """Return an effect of the model as a term of the observer.

    Raises
    ------
    DiagnosisError
        If the observer does not know the effect.
    """
    scale = Motion(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0)
    kind = effect.kind  # type: ignore[attr-defined]
    for candidate in library(scale):
        if candidate.kind != kind:
            continue
        if kind == "stop" and candidate.fixed["side"] != effect.side:  # type: ignore[attr-defined]
            continue
        return Term(_at_reference(candidate, effect), joint), _numbers(candidate, effect)
    raise DiagnosisError(
        f"the model has the effect {kind}, which no diagnosis can refit; take it out, or use "
        "an effect that `shakerproc effects` marks as identifiable."
    )


def _at_reference(candidate: Candidate, effect: object) -> Candidate:
    from shakerproc.diagnose.candidates import power

    if candidate.kind == "power_law":
        return power(float(effect.reference_displacement))  # type: ignore[attr-defined]
    return candidate


def _numbers(candidate: Candidate, effect: object) -> tuple[float, ...]:
    """Return the free numbers of an effect in the order of its candidate."""

    def get(name: str) -> float:
        return float(getattr(effect, name))

    if candidate.kind in {"stribeck_friction", "lugre_friction"}:
        excess = max(get("breakaway_force") / get("sliding_force") - 1.0, 1e-6)
        head = (get("sliding_force"), excess, get("stribeck_velocity"))
        if candidate.kind == "stribeck_friction":
            return head
        bristle = get("bristle_stiffness")
        return (*head, bristle, max(get("bristle_damping") / np.sqrt(bristle), 1e-6))
    if candidate.kind == "jenkins":
        return get("stiffness"), get("slip_force") / get("stiffness")
    return tuple(get(name) for name in candidate.names)


def start_parameters(known: Skeleton) -> tuple[Hypothesis, Parameters]:
    """Return the model as it is: its hypothesis and its numbers."""
    s = known.structure
    n = len(s.sensing)
    return (
        Hypothesis(known.terms),
        Parameters(s.stiffness.copy(), s.damping.copy(), np.ones(n), np.zeros(n), known.values),
    )
