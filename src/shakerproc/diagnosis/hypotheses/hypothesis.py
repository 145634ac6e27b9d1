"""A hypothesis: the model with free numbers, and the effects that it would lack."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from shakerproc.data import FloatArray
from shakerproc.diagnosis.hypotheses.own_numbers import (
    OWN_SPREAD,
    OwnNumber,
    modal_numbers,
    with_values,
)
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects import EFFECTS, AbstractEffect
from shakerproc.models.identification import Identification

Coordinates = Mapping[str, float | str]

FARTHEST: Final = float(np.exp(3.0 * OWN_SPREAD))
"""Factor beyond which a number is not that of the model file any more, three standard
deviations: a unit is wrong, or it imitates something, as damping a joint that holds [-]."""

FAR: Final = 3.0
"""The same in standard deviations of what is known of a number beforehand, where a model has
one; of several the farthest may depart as far by the same chance [-]."""

OWN_REACH: Final = 7.0
"""Largest change of that logarithm: a factor of 1000 [-]."""


@final
@dataclass(frozen=True, slots=True)
class Addition:
    """An effect that the model may lack, in one joint.

    Attributes
    ----------
    kind : str
        Key of the effect.
    between : (str, str)
        The two places.
    identification : Identification
        Its coordinates, with their bounds for this joint.
    fixed : mapping of str to str or float
        What is not free: words, and numbers that only set a scale.
    """

    kind: str
    between: tuple[str, str]
    identification: Identification
    fixed: Coordinates

    @property
    def effect(self) -> type[AbstractEffect]:
        """The effect."""
        return EFFECTS[self.kind]

    @property
    def names(self) -> tuple[str, ...]:
        """The free coordinates, in order."""
        return tuple(self.identification.free)

    @property
    def words(self) -> dict[str, str]:
        """Words that tell its variant by name: the side of a stop."""
        return {name: value for name, value in self.fixed.items() if isinstance(value, str)}

    def values(self, x: FloatArray) -> dict[str, float]:
        """Return coordinates in SI units from transformed ones."""
        free = self.identification.free.items()
        return {name: one.from_fitted(float(v)) for (name, one), v in zip(free, x, strict=True)}

    def transformed(self, values: Coordinates) -> FloatArray:
        """Return transformed coordinates from those in SI units, within their bounds."""
        free = self.identification.free.items()
        return np.array([one.to_fitted(float(values[name])) for name, one in free])

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the least and largest transformed coordinates."""
        free = self.identification.free.values()
        limits = [(one.to_fitted(one.low), one.to_fitted(one.high)) for one in free]
        both = np.array(limits, float).reshape(-1, 2)
        return both[:, 0], both[:, 1]

    def parameters(self, x: FloatArray) -> dict[str, float | str]:
        """Return the arguments of the effect.

        Raises
        ------
        ValueError
            If the effect cannot take these numbers.
        """
        return dict(self.identification.numbers({**self.fixed, **self.values(x)}))

    def element(self, x: FloatArray) -> Element:
        """Return the element with these numbers.

        Raises
        ------
        ValueError
            If the effect cannot take them.
        """
        effect = self.effect.of_numbers(self.parameters(x))
        return Element(effect, self.between, self.identification.scaled_by)


def addition(
    kind: str, between: tuple[str, str], identification: Identification, start: Coordinates
) -> Addition:
    """Return an effect that may be missing, with what is fixed taken from where it starts."""
    fixed = {name: value for name, value in start.items() if name not in identification.free}
    return Addition(kind, between, identification, fixed)


@final
@dataclass(frozen=True, slots=True)
class Hypothesis:
    """The model with free numbers and added effects.

    The vector x holds the logarithms of the sizes of the model's own numbers over those of the
    file, then the transformed coordinates of each added effect.

    Attributes
    ----------
    model : Model
        The model that is fitted.
    own : tuple of OwnNumber
        Its free numbers.
    added : tuple of Addition
        Effects on top.
    """

    model: Model
    own: tuple[OwnNumber, ...]
    added: tuple[Addition, ...] = ()

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of the added effects."""
        return tuple(one.kind for one in self.added)

    @property
    def names(self) -> frozenset[tuple[str, tuple[str, str]]]:
        """Kind and joint of each added effect."""
        return frozenset((one.kind, one.between) for one in self.added)

    @property
    def size(self) -> int:
        """Free numbers."""
        return len(self.own) + sum(len(one.names) for one in self.added)

    def parts(self, x: FloatArray) -> tuple[FloatArray, ...]:
        """Return the own part of x [-], and that of each added effect."""
        edges = np.cumsum([len(self.own), *(len(one.names) for one in self.added)])
        return tuple(np.split(x, edges[:-1]))

    @property
    def frees_masses(self) -> bool:
        """Whether masses are free, as where a force drives the model."""
        return any(number.is_mass for number in self.own)

    def model_at(self, x: FloatArray) -> Model:
        """Return the model with these numbers, and those that follow from its surroundings.

        Raises
        ------
        ModelError
            If no model can have them.
        """
        own, *added = self.parts(x)
        values = [
            number.value(self.model) * number.sign * factor
            for number, factor in zip(self.own, np.exp(own), strict=True)
        ]
        try:
            more = [one.element(part) for one, part in zip(self.added, added, strict=True)]
            found = with_values(self.model, self.own, values, more)
            elements = resolved(found)
            alike = all(a is b for a, b in zip(elements, found.elements, strict=True))
            return found if alike else replace(found, elements=elements)
        except ValueError as error:
            raise ModelError(f"{self.model.title}: {error}") from error

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return the least and the largest x."""
        reach = np.full(len(self.own), OWN_REACH)
        each = [one.bounds() for one in self.added]
        low = np.concatenate([-reach, *(one[0] for one in each)])
        return low, np.concatenate([reach, *(one[1] for one in each)])

    def prior_spread(self) -> FloatArray:
        """Return the standard deviations of x known beforehand; infinite for effects."""
        free = np.full(self.size - len(self.own), np.inf)
        return np.concatenate([[number.spread for number in self.own], free])

    def far(self, x: FloatArray) -> NDArray[np.bool_]:
        """Return which of the model's own numbers are not its own any more, by x [-]."""
        own = len(self.own)
        farthest = -ndtri(ndtr(-FAR) / max(own, 1))  # an elastic body has dozens
        return np.asarray(np.abs(x[:own]) > farthest * self.prior_spread()[:own])

    def with_added(self, one: Addition) -> "Hypothesis":
        """Return the hypothesis with one more effect, whose coordinates come last in x."""
        return replace(self, added=(*self.added, one))


def hypothesis_of(model: Model) -> Hypothesis:
    """Return the hypothesis that nothing is missing: all numbers of the model are free.

    But for references, which only say where another number holds.

    Masses are free where a force drives, which tells them; a moving base tells only their
    ratios to the stiffnesses.
    """
    own = [
        OwnNumber(i, name)
        for i, element in enumerate(model.elements)
        for name, parameter in element.effect.parameters.items()
        if not (parameter.choices or parameter.reference)
        and _is_free(getattr(element.effect, name))
    ]
    if model.excitation.kind == "force":
        own += [OwnNumber(None, name) for name in model.masses]
    return Hypothesis(model, (*own, *modal_numbers(model)))


def _is_free(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value != 0.0
