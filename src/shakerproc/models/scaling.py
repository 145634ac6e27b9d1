"""An effect whose force is a multiple of another one's, as a condition of the test makes it."""

import re
from collections.abc import Mapping
from dataclasses import fields, replace
from types import MappingProxyType
from typing import Any, Final, TypeVar

from shakerproc import checks
from shakerproc.models.effects.base import AbstractEffect

EffectT = TypeVar("EffectT", bound=AbstractEffect)

_FORCE: Final = re.compile(r"(?:N|kg)(?![A-Za-z])")
"""A unit that is proportional to force."""

UNSCALED: Final[Mapping[str, str]] = MappingProxyType({
    "stiffness_drift": "it changes the spring beside it; scale that",
    "general_bouc_wen": "its beta and gamma mean another loop at another force; take bouc_wen",
})
"""Kinds of effects that no condition scales, and why."""


def times(effect: EffectT, factor: float) -> EffectT:
    r"""Return the effect whose force is a multiple of this one's, at every motion.

    .. math:: F(z, \dot z; s p_N, p) = s F(z, \dot z; p_N, p)

    where :math:`p_N` are the parameters whose unit holds newtons (or kilograms): a law whose
    units agree has no other way to answer.

    Parameters
    ----------
    effect : AbstractEffect
        The law.
    factor : float
        Above 0 [-].

    Raises
    ------
    ValueError
        If the factor is not above 0, or no number of the effect is one of force.
    """
    checks.positive("factor", factor, "-")
    if effect.kind in UNSCALED:
        raise ValueError(f"{effect.kind} cannot be scaled: {UNSCALED[effect.kind]}")
    scaled = {
        field.name: _multiple(value, factor)
        for field in fields(effect)  # type: ignore[arg-type]
        if (value := getattr(effect, field.name)) is not None
        and _is_of_force(effect, field.name)
    }
    if not scaled:
        names = ", ".join(effect.parameters)
        raise ValueError(f"{effect.kind} has no number with a unit of force to scale ({names})")
    return replace(effect, **scaled)  # type: ignore[type-var]


def _is_of_force(effect: AbstractEffect, name: str) -> bool:
    parameter = effect.parameters[name]
    return parameter.holds == "effects" or _FORCE.match(parameter.unit) is not None


def _multiple(value: Any, factor: float) -> Any:
    if isinstance(value, tuple):
        return tuple(_multiple(one, factor) for one in value)
    return _part(value, factor) if isinstance(value, AbstractEffect) else value * factor


def _part(effect: AbstractEffect, factor: float) -> AbstractEffect:
    """Return an element of a series, scaled; one without force, such as play, as it is."""
    forceless = not any(_is_of_force(effect, name) for name in effect.parameters)
    return effect if forceless else times(effect, factor)
