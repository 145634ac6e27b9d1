"""Laws that contain one that was fitted, begun where it ended."""

from collections.abc import Callable, Iterator, Sequence

from shakerproc.diagnosis.estimation.beginnings import Beginnings, Tried, as_told, least_left
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, gone_on
from shakerproc.diagnosis.estimation.one_more import FIRST_ROUNDS
from shakerproc.diagnosis.estimation.parts import Windows


def richer_laws(
    begin: Beginnings, data: DataSet, found: Fit, windows: Windows,
    *, rounds: int, say: Callable[[str], None],
) -> Iterator[Fit]:  # fmt: skip
    """Yield the laws that contain a fitted one and leave less, those of few numbers first.

    They begin where it ended, with the model's own numbers as told where it went far from
    them: those imitate what it lacks.

    Parameters
    ----------
    begin : Beginnings
        Where fits of one more effect begin.
    data : DataSet
        The tests as they are compared now.
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
    known = begin.known[last.between]
    for kind in sorted(known, key=lambda kind: len(known[kind].free)):
        ended = [
            one
            for contained in known[kind].contains
            if contained.limit and contained.kind == last.kind
            for one in begin.extended((kind, last.between), contained, found)
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
