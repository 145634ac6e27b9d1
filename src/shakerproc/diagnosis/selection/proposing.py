"""Open questions of a diagnosis, and the test that is proposed for them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.hypotheses.joints import Joint, joints_of, scales_of
from shakerproc.diagnosis.joint_outcomes import Locked
from shakerproc.diagnosis.result import NextTest
from shakerproc.diagnosis.selection.next_test import (
    Alternative,
    Laboratory,
    alternative_of,
    closing,
    slipping,
    telling_apart,
)
from shakerproc.diagnosis.selection.scores import Score
from shakerproc.models import Element
from shakerproc.models.effects import Gap

ALTERNATIVES: Final = 3
"""Hypotheses compared with the best: the most that a verdict calls indistinguishable [-]."""


@final
@dataclass(frozen=True, slots=True)
class Unexercised:
    """A clearance of the log that no test closed.

    Attributes
    ----------
    between : (str, str)
        The joint that moved most.
    clearance, reach : float
        The clearance, and how far the joint moved [m].
    """

    between: Joint
    clearance: float
    reach: float


def unexercised(found: Found, clearances: Sequence[float]) -> Unexercised | None:
    """Return the smallest clearance that was never closed; None if there is none.

    Parameters
    ----------
    found : Found
        How far the joints moved.
    clearances : sequence of float
        Free play that the log says the specimens have [m].
    """
    reaches = {
        joint: max(float(np.max(np.abs(m.displacement))) for m in found.data.across(joint))
        for joint in joints_of(found.data.model)
    }
    joint = max(reaches, key=lambda one: reaches[one])
    beyond = [clearance for clearance in clearances if clearance > reaches[joint]]
    return Unexercised(joint, min(beyond), reaches[joint]) if beyond else None


def as_good(standing: Sequence[Score]) -> list[Score]:
    """Return the hypotheses beside the chosen one that have other kinds and are no richer."""
    own = set(standing[0].fit.hypothesis.kinds) if standing else set()
    return [one for one in no_richer(standing) if set(one.fit.hypothesis.kinds) - own]


def no_richer(standing: Sequence[Score]) -> list[Score]:
    """Return the hypotheses beside the chosen one that have no more numbers."""
    sizes = [score.fit.hypothesis.size for score in standing]
    return [one for one, size in zip(standing[1:], sizes[1:], strict=True) if size <= sizes[0]]


def proposed(
    found: Found,
    standing: Sequence[Score],
    laboratory: Laboratory,
    *,
    verdict: str,
    locked: Sequence[Locked],
    unclosed: Unexercised | None,
) -> tuple[NextTest, ...]:
    """Return the test that would settle what is open; nothing where nothing is.

    Parameters
    ----------
    found : Found
        Every hypothesis with its fitted numbers.
    standing : sequence of Score
        Those that explain the tests alike, the chosen one first.
    laboratory : Laboratory
        What the test has to keep to.
    verdict : str
        One of the five verdicts.
    locked : sequence of Locked
        Joints that never slipped.
    unclosed : Unexercised, optional
        A clearance that no test closed.
    """
    if laboratory.model.excitation.imposed:  # as far as a machine for component tests moves
        return ()
    if laboratory.model.excitation.role is None:  # a start is no waveform
        return ()
    if verdict == "outside library":
        free = [found.free] if found.free is not None else []
        return _between(laboratory, [*free, *found.effects][:2])
    if locked and verdict == "cannot tell":
        kinds = dict.fromkeys(kind for one in standing for kind in one.fit.hypothesis.kinds)
        return slipping(laboratory, locked, tuple(kinds))
    if unclosed is not None:
        return _closing(found, laboratory, unclosed)
    return _between(laboratory, [*standing[:1], *as_good(standing)])


def _between(laboratory: Laboratory, competing: Sequence[Score]) -> tuple[NextTest, ...]:
    """Return the test between the first of several hypotheses and the others."""
    alternatives = [
        alternative for alternative in map(alternative_of, competing) if alternative is not None
    ]
    others: dict[tuple[str, ...], Alternative] = {}
    for alternative in alternatives[1:]:
        others.setdefault(alternative.kinds, alternative)
    if not others:
        return ()
    return telling_apart(laboratory, alternatives[0], list(others.values())[:ALTERNATIVES])


def _closing(found: Found, laboratory: Laboratory, open_: Unexercised) -> tuple[NextTest, ...]:
    """Return the test that closes a clearance: behind it the joint is as stiff as it is now."""
    linear = alternative_of(found.linear)
    if linear is None:
        return ()
    data, joint = found.data, open_.between
    steepness = scales_of(linear.model, data.tests, joint, data.across(joint)).steepness
    contact = Element(Gap(steepness, open_.clearance), joint)
    model = replace(linear.model, elements=(*linear.model.elements, contact))
    touching = Alternative((contact.effect.kind,), model, linear.gain)
    return closing(laboratory, linear, touching, open_.clearance, open_.reach)
