"""Where the fit of an effect begins: as screened, or where one that it contains ended."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels
from shakerproc.diagnosis.hypotheses.hypothesis import (
    FARTHEST,
    Hypothesis,
    addition,
    hypothesis_of,
)
from shakerproc.diagnosis.hypotheses.joints import Joint, Known, joints_of
from shakerproc.diagnosis.nudged.starts import Group, as_in_file, extended
from shakerproc.diagnosis.screening import FreeLaw, Start
from shakerproc.diagnosis.selection.scores import LEAST
from shakerproc.errors import ModelError
from shakerproc.models import Element, Model
from shakerproc.models.effects import Table
from shakerproc.models.identification import Contained


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


STARTS: Final = 64
"""Starts of each effect in each joint that are tried in the shortest windows [-]."""

BEST_STARTS: Final = 8
"""Of these so many, the best of the screening, are tried with all numbers that may go with
them, and in whole tests, too [-]."""

Tried: TypeAlias = tuple[Hypothesis, FloatArray, Channels | None]
"""A hypothesis, its coordinates, and what the sensors do to its motion; None if nothing."""


def grouped(starts: Sequence[Start]) -> dict[Group, list[Start]]:
    """Return starts by effect, joint and variant, each group in the order of the starts."""
    groups: dict[Group, list[Start]] = {}
    for start in starts:
        groups.setdefault((start.kind, start.between, start.words), []).append(start)
    return groups


@final
@dataclass(frozen=True, slots=True, eq=False)
class Beginnings:
    """Where the fits of one more effect on top of a hypothesis begin.

    Attributes
    ----------
    on : Fit
        The hypothesis.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    linear : (n_own,) array
        The model's own numbers as the linear model has them.
    """

    on: Fit
    known: Known
    linear: FloatArray

    def screened(self, start: Start) -> FloatArray:
        """Return the coordinates that a start of the screening means."""
        one = addition(
            start.kind, start.between, self.known[start.between][start.kind], start.values
        )
        none = self.on.hypothesis
        return np.concatenate([
            own_start(none, start), self.on.x[len(none.own) :], one.transformed(start.values)
        ])  # fmt: skip

    def of(self, starts: Sequence[Start]) -> list[Tried]:
        """Return where an effect begins by starts of the screening, the best first."""
        tried: list[Tried] = []
        for i, start in enumerate(starts[:STARTS]):
            own, other = self.on.hypothesis, turned(self.on.hypothesis, start)
            for none in [own] if other.own == own.own else [own, other]:
                told, *others = self._at(none, start)
                tried += [told, *others] if i < BEST_STARTS else [told]
        return tried

    def _at(self, none: Hypothesis, start: Start) -> list[Tried]:
        """Return an effect as it starts, beside numbers as told, as screened and as fitted.

        A number whose sign is turned is as screened in all.
        """
        known = self.known[start.between][start.kind]
        one = addition(start.kind, start.between, known, start.values)
        own = own_start(none, start)
        same = np.array([
            a.sign == b.sign for a, b in zip(none.own, self.on.hypothesis.own, strict=True)
        ])
        beside = np.concatenate([self.on.x[own.size :], one.transformed(start.values)])
        told, *others = (
            np.concatenate([np.where(same, values, own), beside])
            for values in (np.zeros(own.size), own, self.linear)
        )
        with_one = none.with_added(one)
        return [
            (with_one, told, None),
            *((with_one, x, self.on.channels) for x in others),
        ]

    def beyond(self, group: Group, simpler: Mapping[Group, Fit]) -> list[Tried]:
        """Return where an effect may begin from where those that it contains ended."""
        found = self.contained(group, simpler)
        return [
            tried
            for contained in self.known[group[1]][group[0]].contains
            for (kind, *_), fitted in found.items()
            if kind == contained.kind
            for tried in self.extended(group[:2], contained, fitted, words=group[2])
        ]

    def contained(self, group: Group, simpler: Mapping[Group, Fit]) -> dict[Group, Fit]:
        """Return the fits of those effects, in the same joint, that an effect contains."""
        kind, joint, _ = group
        kinds = {contained.kind for contained in self.known[joint][kind].contains}
        return {g: one for g, one in simpler.items() if g[0] in kinds and g[1] == joint}

    def extended(
        self,
        group: tuple[str, Joint],
        contained: Contained,
        fitted: Fit,
        words: tuple[str, ...] | None = None,
    ) -> list[Tried]:
        """Return where a richer effect may begin from where one that it contains ended."""
        kind, joint = group
        law = self.known[joint][kind]
        tried = extended(kind, law, contained, fitted, words)
        out: list[Tried] = [(hypothesis, x, fitted.channels) for hypothesis, x in tried]
        return out[:STARTS]


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
