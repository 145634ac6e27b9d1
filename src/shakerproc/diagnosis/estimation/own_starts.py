"""From which of its own numbers a model starts, beside an effect."""

from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.hypotheses.hypothesis import FARTHEST, Hypothesis, hypothesis_of
from shakerproc.diagnosis.hypotheses.joints import joints_of
from shakerproc.diagnosis.screening import FreeLaw, Start
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model
from shakerproc.models.effects import Table


def as_in(none: Hypothesis, other: Model) -> FloatArray:
    """Return the coordinates of the own numbers as another model has them, as far as usual."""
    ratios = np.array([number.value(other) / number.value(none.model) for number in none.own])
    return _coordinates(ratios)


def own_start(none: Hypothesis, start: Start) -> FloatArray:
    """Return the logarithms of the model's own numbers that go with a start."""
    signs = np.array([number.sign for number in none.own])
    return _coordinates(signs * _ratios(none, start))


def turned(none: Hypothesis, start: Start) -> Hypothesis:
    """Return the model whose own numbers have the signs that go with a start."""
    signs = np.where(_ratios(none, start) < 0.0, -1.0, 1.0)
    own = (replace(n, sign=float(sign)) for n, sign in zip(none.own, signs, strict=True))
    return replace(none, own=tuple(own))


def as_table(model: Model, law: FreeLaw) -> tuple[Hypothesis, FloatArray] | None:
    """Return a model with a force without a name, and its own numbers that go with it.

    None where the force pushes away at its end, so that no body would stay there.
    """
    element = Element(law.effect, law.between)
    try:
        hypothesis = hypothesis_of(replace(model, elements=(*model.elements, element)))
    except ModelError:
        return None
    start = Start(
        Table.kind, law.between, {}, law.stiffness, law.damping, law.explained, law.predicted,
        law.t, law.left,
    )  # fmt: skip
    return hypothesis, own_start(hypothesis, start)


def _coordinates(ratios: FloatArray) -> FloatArray:
    return np.asarray(np.log(np.clip(ratios, 1.0 / FARTHEST, FARTHEST)))


def _ratios(none: Hypothesis, start: Start) -> FloatArray:
    """Return the own numbers that go with a start over those of the file."""
    joints = joints_of(none.model)
    ratios = np.ones(len(none.own))
    for i, number in enumerate(none.own):
        if number.element is None or number.name not in {"stiffness", "damping"}:
            continue
        joint = tuple(none.model.elements[number.element].between)
        if joint in joints:
            changes = start.stiffness if number.name == "stiffness" else start.damping
            ratios[i] += changes[joints.index(joint)]
    return ratios
