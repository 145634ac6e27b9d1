"""Where fits begin: own numbers as elsewhere, a table, the starts that leave least."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels
from shakerproc.diagnosis.hypotheses.hypothesis import (
    FARTHEST,
    Hypothesis,
    hypothesis_of,
)
from shakerproc.diagnosis.hypotheses.joints import joints_of
from shakerproc.diagnosis.nudged.starts import as_in_file
from shakerproc.diagnosis.screening import FreeLaw
from shakerproc.diagnosis.selection.scores import LEAST
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model


def as_in(none: Hypothesis, other: Model) -> FloatArray:
    """Return the coordinates of the own numbers as another model has them, as far as usual."""
    ratios = np.array([number.value(other) / number.value(none.model) for number in none.own])
    return _coordinates(ratios)


def own_start(
    none: Hypothesis,
    stiffness: Sequence[float] | FloatArray,
    damping: Sequence[float] | FloatArray,
) -> FloatArray:
    """Return the logarithms of the model's own numbers that go with changes of joints.

    Parameters
    ----------
    none : Hypothesis
        The model.
    stiffness, damping : (n_joints,) array_like
        Changes in each joint over those of the file [-].
    """
    joints = joints_of(none.model)
    ratios = np.ones(len(none.own))
    for i, number in enumerate(none.own):
        if number.element is None or number.name not in {"stiffness", "damping"}:
            continue
        joint = tuple(none.model.elements[number.element].between)
        if joint in joints:
            changes = stiffness if number.name == "stiffness" else damping
            ratios[i] += changes[joints.index(joint)]
    signs = np.array([number.sign for number in none.own])
    return _coordinates(signs * ratios)


def as_table(model: Model, law: FreeLaw) -> tuple[Hypothesis, FloatArray] | None:
    """Return a model with a force without a name, and its own numbers that go with it.

    None where the force pushes away at its end, so that no body would stay there.
    """
    element = Element(law.effect, law.between)
    try:
        hypothesis = hypothesis_of(replace(model, elements=(*model.elements, element)))
    except ModelError:
        return None
    return hypothesis, own_start(hypothesis, law.stiffness, law.damping)


def _coordinates(ratios: FloatArray) -> FloatArray:
    return np.asarray(np.log(np.clip(ratios, 1.0 / FARTHEST, FARTHEST)))


Tried: TypeAlias = tuple[Hypothesis, FloatArray, Channels | None]
"""A hypothesis, its coordinates, and what the sensors do to its motion; None if nothing."""


def least_left(data: DataSet, tried: Sequence[Tried], windows: Windows) -> list[Tried]:
    """Return starts by what they leave of windows as they are, without those that run away.

    Those that leave the same are one: forces above what a joint carries, say, which no slope
    leads away from.
    """
    levels = np.array([level_at(data, h, x, windows, own) for h, x, own in tried])
    found: list[Tried] = []
    reached = -np.inf
    for i in np.argsort(levels):
        if np.isfinite(levels[i]) and levels[i] > reached + LEAST:
            found.append(tried[i])
            reached = float(levels[i])
    return found


def as_told(tried: Tried) -> Tried:
    """Return where a fit begins with the model's own numbers as its file tells them."""
    hypothesis, x, channels = tried
    return hypothesis, as_in_file(hypothesis, x), channels
