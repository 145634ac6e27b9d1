"""Forces of the nonlinear elements that a model has already, as columns of the screening."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.screening.equations import Equations
from shakerproc.diagnosis.screening.laws import force_along
from shakerproc.diagnosis.screening.motion import Motions
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model
from shakerproc.models.effects import AbstractEffect
from shakerproc.models.laws import Law as Formula
from shakerproc.models.parallel_elements import resolved

_STEP: Final = 1e-3
"""Share by which each number is changed for its slope: the screening is linear in it [-]."""


def own_columns(model: Model, equations: Equations, motions: Motions) -> FloatArray:
    """Return what the model's own nonlinear elements show, and by each of their numbers.

    What the linear model leaves holds their forces; what is to be added explains the rest.
    Their sizes and numbers remain free, to first order.

    Returns
    -------
    (n_columns, n_blocks, n_rows) array
        Whitened; zeros where a force fails.
    """
    found = [equations.nuisances[:0]]
    for element in resolved(model):
        if all(row.law is Formula.LINEAR for row in element.effect.rows()):
            continue
        columns = _columns(element, equations, motions)
        found += [columns[:1], (columns[1:] - columns[0]) / _STEP]
    return np.concatenate(found)


def _columns(element: Element, equations: Equations, motions: Motions) -> FloatArray:
    """Return the columns of an element as it is, and with each number changed."""
    effect, between = element.effect, element.between
    motion = motions.across(between, absolute=effect.absolute)
    rates = [test.sample_rate for test in equations.tests]
    effects = [effect, *_nearby(effect)]
    forces = [
        np.array([force_along(e, motion[s.test], s, rates[s.test]) for e in effects])
        for s in equations.stretches
    ]
    for force in forces:
        force[~np.all(np.isfinite(force), axis=1)] = 0.0
    direction = equations.linear.direction(between, second_only=effect.absolute)
    return equations.columns(forces, direction)


def _nearby(effect: AbstractEffect) -> Iterator[AbstractEffect]:
    """Yield the effect with one number after the other changed, where it can be."""
    for name, parameter in effect.parameters.items():
        value = getattr(effect, name)
        if parameter.choices or not isinstance(value, (int, float)) or not value:
            continue
        try:
            yield replace(effect, **{name: (1.0 + _STEP) * value})  # type: ignore[type-var]
        except (ValueError, ModelError):
            continue
