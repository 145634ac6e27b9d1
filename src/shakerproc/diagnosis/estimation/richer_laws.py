"""Laws that contain one that was fitted, begun where it ended."""

from collections.abc import Callable, Iterator

from shakerproc.diagnosis.estimation.beginnings import Beginnings, as_told, least_left
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
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
        Steps at most of what leaves less after the first few.
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
        for h, x, channels in least_left(data, ended, windows)[:1]:
            first = fit(data, h, x, windows, rounds=FIRST_ROUNDS, channels=channels)
            if first is not None and first.level < found.level:
                arrived = fit(
                    data, h, first.x, windows, rounds=rounds, channels=first.channels,
                    starts=first.starts, step=first.steps,
                )  # fmt: skip
                yield first if arrived is None else arrived
