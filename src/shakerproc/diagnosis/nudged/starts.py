"""Where fits of one more effect begin: its own starts, wells, where simpler laws end."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.hypotheses.hypothesis import Addition, Hypothesis, addition
from shakerproc.diagnosis.hypotheses.joints import Joint, Known, wells_of
from shakerproc.models.identification import Contained, Identification, Values

Group: TypeAlias = tuple[str, Joint, tuple[str, ...]]
"""Kind, joint, and the words of the variant."""

Tried: TypeAlias = tuple[Hypothesis, FloatArray]
"""A hypothesis and its coordinates."""


def own_starts(on: Fit, known: Known) -> dict[Group, list[Tried]]:
    """Return where each effect, joint and variant begins on top of a fit, the simple first.

    But those that it has: the same law twice in a joint has the numbers of one.
    """
    groups: dict[Group, list[Tried]] = {}
    for joint, laws in known.items():
        for kind, law in laws.items():
            if (kind, joint) in on.hypothesis.names:
                continue
            for values in law.starts:
                one = addition(kind, joint, law, values)
                groups.setdefault((kind, joint, tuple(one.words.values())), []).extend([
                    _with(on, one, values, on.x),
                    _with(on, one, values, as_in_file(on.hypothesis, on.x)),
                    *_in_wells(on, one, values),
                ])
    size = {key: len(known[key[1]][key[0]].free) for key in groups}
    return {key: groups[key] for key in sorted(groups, key=lambda key: size[key])}


def beyond(group: Group, known: Known, ended: Mapping[Group, Fit]) -> list[Tried]:
    """Return where an effect may begin from where those that it contains ended."""
    kind, joint, words = group
    return [
        tried
        for contained in known[joint][kind].contains
        for (other, there, _), one in ended.items()
        if other == contained.kind and there == joint
        for tried in extended(kind, known[joint][kind], contained, one, words)
    ]


def extended(
    kind: str,
    law: Identification,
    contained: Contained,
    ended: Fit,
    words: tuple[str, ...] | None = None,
) -> Iterator[Tried]:
    """Yield where an effect may begin from where one that it contains ended.

    In the place of that, in the same joint; of a variant alone where `words` are given.
    """
    *others, last = ended.hypothesis.added
    *before, own = ended.hypothesis.parts(ended.x)
    beside = replace(ended.hypothesis, added=tuple(others))
    for values in contained.extend({**last.fixed, **last.values(own)}):
        one = addition(kind, last.between, law, values)
        if words is None or tuple(one.words.values()) == words:
            yield beside.with_added(one), np.concatenate([*before, one.transformed(values)])


def as_in_file(hypothesis: Hypothesis, x: FloatArray) -> FloatArray:
    """Return coordinates with the model's own numbers as its file tells them.

    Those that were fitted without an effect imitate it, and lead away from it.
    """
    own = len(hypothesis.own)
    return np.concatenate([np.zeros(own), x[own:]])


def _with(on: Fit, one: Addition, values: Values, x: FloatArray) -> Tried:
    return on.hypothesis.with_added(one), np.concatenate([x, one.transformed(values)])


def _in_wells(on: Fit, one: Addition, values: Values) -> Iterator[Tried]:
    """Yield starts of a law in a joint whose stiffness in the file is that of a well.

    Only of laws of which nothing but the size is free (see `wells_of`). The sizes of the
    starts tell nothing then: the first stands for all.
    """
    law, none = one.identification, on.hypothesis
    springs = [
        i for i, n in enumerate(none.own)
        if n.name == "stiffness" and n.element is not None and n.sign > 0.0
        and set(none.model.elements[n.element].between) == set(one.between)
    ]  # fmt: skip
    only_size = tuple(law.scaled) == tuple(law.free) and len(law.scaled) == 1
    if not springs or not only_size or values != law.starts[0]:
        return
    spring, name = springs[0], law.scaled[0]
    nearby, effect = none.own[spring].value(none.model), one.element(one.transformed(values))
    turned = tuple(replace(n, sign=-1.0) if i == spring else n for i, n in enumerate(none.own))
    largest = on.data.largest_across(one.between)
    for size, stiffness in wells_of(effect.effect, nearby, largest):
        if stiffness >= 0.0:
            continue
        there = {**values, name: size * float(values[name])}
        x = as_in_file(none, on.x)
        x[spring] = np.log(-stiffness / nearby)
        extra = one.transformed(there)
        yield replace(none, own=turned).with_added(one), np.concatenate([x, extra])
