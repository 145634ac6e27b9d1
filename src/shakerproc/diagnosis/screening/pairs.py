"""A second effect beside one that is known: the same regression, with the first in common."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.screening.laws import Law, law_at, laws_of, one_of_each_shape
from shakerproc.diagnosis.screening.refining import completed_with, slopes_of
from shakerproc.diagnosis.screening.shared import Screening, screening_of
from shakerproc.diagnosis.screening.start import Start
from shakerproc.diagnosis.screening.starts import alike, ranked
from shakerproc.diagnosis.screening.transfer import Joint
from shakerproc.models import Model
from shakerproc.models.identification import Identification, Values


def screen_pairs(
    model: Model,
    tests: Sequence[Test],
    identifications: Mapping[Joint, Mapping[str, Identification]],
    first: tuple[str, Joint, Values],
) -> tuple[Start, ...]:
    """Return starts of every second effect beside a first, best first.

    Size and coordinates of the first remain free, to first order.

    Parameters
    ----------
    model : Model
        The linear model, without the first effect.
    tests : sequence of Test
        What may be fitted to.
    identifications : mapping of joint to mapping of str to Identification
        Every effect that may be missing in each joint, and the first.
    first : (str, (str, str), mapping)
        Kind, joint and values of the effect that is known.

    Raises
    ------
    ValueError
        If the model cannot have the first effect.
    """
    kind, joint, values = first
    known = law_at(model, joint, kind, identifications[joint][kind], values)
    if known is None:
        raise ValueError(f"the model cannot have a {kind} between {' and '.join(joint)}")
    joints = tuple(identifications)
    screening = completed_with(screening_of(model, tests, joints), known)
    screening = beside(screening, known)
    laws = [
        law
        for one in joints
        for law in laws_of(model, one, identifications[one])
        if (law.kind, law.between) != (kind, joint)
    ]
    return ranked(screening, laws)


def beside(screening: Screening, known: Law) -> Screening:
    """Return a screening with an effect and its slopes among what is common."""
    columns: FloatArray = np.concatenate([screening.beside, *slopes_of(screening, known)])
    return replace(screening, beside=columns).with_motions(screening.motions)


def both_at_once(
    model: Model,
    tests: Sequence[Test],
    identifications: Mapping[Joint, Mapping[str, Identification]],
    count: int,
) -> tuple[tuple[Start, Start], ...]:
    """Return the pairs of effects that together explain most, the best first.

    Two effects that are equally strong hide each other: beside a third that imitates both
    neither is found.

    Parameters
    ----------
    model : Model
        The linear model.
    tests : sequence of Test
        What may be fitted to.
    identifications : mapping of joint to mapping of str to Identification
        Every effect that may be missing in each joint.
    count : int
        Pairs to return.
    """
    screening = screening_of(model, tests, tuple(identifications))
    laws = one_of_each_shape([
        law
        for joint in identifications
        for law in laws_of(model, joint, identifications[joint])
    ])
    laws = tuple(law for own in alike(laws) for law in own)
    columns = np.concatenate([screening.columns(own) for own in alike(laws)])
    first, second, explained = screening.regression.pairs(
        columns, np.array([law.one_sign for law in laws])
    )
    regression = screening.regression
    cost = regression.cost / screening.equations.n_numbers
    found: dict[frozenset[tuple[object, ...]], tuple[Start, Start]] = {}
    for i, j, share in zip(first, second, explained, strict=True):
        names = frozenset((law.kind, law.between) for law in (laws[i], laws[j]))
        if len(names) < 2 or names in found:
            continue
        amplitudes = regression.together(columns[[i, j]])
        found[names] = tuple(
            _as_start(laws[k], float(a), (float(share), cost), len(identifications))
            for k, a in zip((i, j), amplitudes, strict=True)
        )  # type: ignore[assignment]
        if len(found) == count:
            break
    return tuple(found.values())


def _as_start(
    law: Law, amplitude: float, explains: tuple[float, float], n_joints: int
) -> Start:
    unchanged = (0.0,) * n_joints
    explained, cost = explains
    return Start(
        law.kind, law.between, law.scaled(amplitude) if amplitude else law.values, unchanged,
        unchanged, explained, explained, 0.0, (1.0 - explained) * cost,
    )  # fmt: skip
