"""Forces of effects as columns: of what may be missing, of what a model has already."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.screening.equations import Equations
from shakerproc.diagnosis.screening.laws import force_along
from shakerproc.diagnosis.screening.motion import Motions
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.errors import ModelError
from shakerproc.models import Model
from shakerproc.models.coordinates import resolved
from shakerproc.models.effects import AbstractEffect
from shakerproc.models.laws import Law as Formula

_STEP: Final = 1e-3
"""Share by which each number is changed for its slope: the screening is linear in it [-]."""


def columns_of(
    equations: Equations, motions: Motions, between: Joint, effects: Sequence[AbstractEffect]
) -> FloatArray:
    """Return the whitened columns of effects in one joint; zeros where a force fails."""
    absolute = effects[0].absolute
    motion = motions.across(between, absolute=absolute)
    rates = [test.sample_rate for test in equations.tests]
    forces = [
        np.array([force_along(e, motion[s.test], s, rates[s.test]) for e in effects])
        for s in equations.stretches
    ]
    for force in forces:
        force[~np.all(np.isfinite(force), axis=1)] = 0.0
    direction = equations.linear.direction(between, second_only=absolute)
    return equations.columns(forces, direction)


def own_columns(model: Model, equations: Equations, motions: Motions) -> FloatArray:
    """Return columns of the model's own nonlinear elements, and of each of their numbers.

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
        effects = [element.effect, *_nearby(element.effect)]
        columns = columns_of(equations, motions, element.between, effects)
        found += [columns[:1], (columns[1:] - columns[0]) / _STEP]
    return np.concatenate(found)


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
