"""A second effect beside one that is known: the same regression, with the first in common."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.screening.laws import Law, law_at, laws_of
from shakerproc.diagnosis.screening.refining import completed_with, slopes_of
from shakerproc.diagnosis.screening.shared import Screening, screening_of
from shakerproc.diagnosis.screening.starts import Start, ranked
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
    columns: FloatArray = np.concatenate(slopes_of(screening, known))
    return replace(screening, beside=columns).with_motions(screening.motions)
