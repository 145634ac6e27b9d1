"""Laws that contain one that was fitted, begun where it ended."""

from collections.abc import Callable, Iterator, Sequence
from itertools import islice
from typing import Final

from shakerproc.diagnosis.estimation.beginnings import Tried, as_told, least_left
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, gone_on
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.starts import extended

FIRST_ROUNDS: Final = 2
"""Steps of a fit from the best beginnings: what they are worth shows by then [-]."""

STARTS: Final = 64
"""Beginnings of each law that are tried [-]."""


def richer_laws(
    data: DataSet, known: Known, found: Fit, windows: Windows,
    *, rounds: int, say: Callable[[str], None],
) -> Iterator[Fit]:  # fmt: skip
    """Yield the laws that contain a fitted one and leave less, those of few numbers first.

    They begin where it ended, with the model's own numbers as told where it went far from
    them: those imitate what it lacks.

    Parameters
    ----------
    data : DataSet
        The tests as they are compared now.
    known : mapping of joint to mapping of str to Identification
        What each effect says of each joint.
    found : Fit
        The law that was fitted.
    windows : Windows
        What it was fitted to.
    rounds : int
        Steps at most of the beginning that leaves least after the first few.
    say : callable
        Called with what is being tried.
    """
    last = found.hypothesis.added[-1]
    laws = known[last.between]
    for kind in sorted(laws, key=lambda kind: len(laws[kind].free)):
        ended: list[Tried] = [
            (hypothesis, x, found.channels)
            for contained in laws[kind].contains
            if contained.limit and contained.kind == last.kind
            for hypothesis, x in islice(extended(kind, laws[kind], contained, found), STARTS)
        ]
        if not ended:
            continue
        say(f"{kind} between {' and '.join(last.between)}")
        if found.is_far:
            ended = list(map(as_told, ended))
        tried = [
            fit(data, h, x, windows, rounds=FIRST_ROUNDS, channels=channels)
            for h, x, channels in _apart(least_left(data, ended, windows))
        ]
        ends = [one for one in tried if one is not None]
        for first in sorted(ends, key=lambda one: one.level)[:1]:
            arrived = gone_on(first, rounds=rounds)
            if arrived.level < found.level:
                yield arrived


def _apart(ordered: Sequence[Tried]) -> list[Tried]:
    """Return the two beginnings that leave least, the middle one and the last.

    Those next to the simpler law leave least before the first step, and may lead back to it.
    """
    chosen = dict.fromkeys((0, 1, len(ordered) // 2, len(ordered) - 1))
    return [ordered[i] for i in chosen if 0 <= i < len(ordered)]
