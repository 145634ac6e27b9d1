"""How effects enter the race: from all their starts at once, at the first nudging rate.

A window that begins anew has a start for every mode, more of them than there are sensors; a
model that is held needs none.
"""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.hypotheses.hypothesis import Addition
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.base import Base, Moved
from shakerproc.diagnosis.nudged.starts import Group, Tried, beyond, own_starts

FOLLOWED: Final = (24, 12, 6)
"""Laws in joints that are followed by steps, of those that leave least so far, beside the best
in every joint: half of them each time [-]."""

STEPPED: Final = 2
"""Starts of each that are followed [-]."""

STEPS: Final = 3
"""Steps that are followed each time [-]."""

OWN_STARTS: Final = 2
"""Numbers of a law that contains others up to which it has starts of its own; one of more
begins where those have ended [-]."""

DECADE: Final = 10.0
"""Ratio of forces from which on they are two starts: between them the least squares of the
force find the size (see `Base`) [-]."""


def entered(
    on: Fit, known: Known, say: Callable[[str], None]
) -> tuple[dict[Group, Fit], dict[str, str]]:
    """Return effects in every joint at the first rate, and why others failed.

    Starts of all are compared; those that leave least are followed, and laws that contain these
    begin where they ended. The slopes by the model's own numbers are those without any effect,
    so that a law takes as few runs in a structure of many modes as in one mass.
    """
    base = Base(on, on.windows)
    failed: dict[str, str] = {}
    begun: dict[Group, list[Moved]] = {}
    every = own_starts(on, known)
    for group, starts in every.items():
        law = known[group[1]][group[0]]
        if law.contains and len(law.free) > OWN_STARTS:
            continue
        say(f"{group[0]} between {' and '.join(group[1])}")
        tried = [one for one in starts if np.array_equal(one[1][: on.x.size], on.x)]
        best = base.best(_thinned(tried))
        if best:
            begun[group] = best
        else:
            failed[" ".join((group[0], *group[2]))] = "its motion runs away"
    ends = {group: best[:STEPPED] for group, best in begun.items()}
    _step(base, ends, _promising(ends, FOLLOWED[0]))
    fits = {group: _as_fit(base, moved[0]) for group, moved in ends.items() if moved}
    simple = {group: one for group, one in fits.items() if one is not None}
    for group in every:
        if group not in begun and (tried := beyond(group, known, simple)):
            say(f"{group[0]} between {' and '.join(group[1])}")
            ends[group] = base.best(tried)[:STEPPED]
            _step(base, ends, [group])
    for most in FOLLOWED[1:]:
        _step(base, ends, _promising(ends, most))
    fits = {group: _as_fit(base, moved[0]) for group, moved in ends.items() if moved}
    return {group: one for group, one in fits.items() if one is not None}, failed


def _promising(ends: dict[Group, list[Moved]], most: int) -> list[Group]:
    """Return the laws in joints that leave least so far, the best in every joint among them."""
    order = sorted((group for group in ends if ends[group]), key=lambda g: _level(ends[g][0]))
    first = {group[1]: group for group in reversed(order)}
    return list(dict.fromkeys([*order[:most], *first.values()]))


def _step(base: Base, ends: dict[Group, list[Moved]], groups: Sequence[Group]) -> None:
    """Let laws go on by steps from where they are, to one end of each."""
    for group in groups:
        moved = [base.stepped(own, x, STEPS) for _, own, x in ends[group]]
        ends[group] = sorted((one for one in moved if one is not None), key=_level)[:1]


def _as_fit(base: Base, moved: Moved) -> Fit | None:
    on = base.fit
    return fit(on.data, moved[1], moved[2], on.windows, rounds=0, channels=on.channels)


def _level(moved: Moved) -> float:
    return moved[0]


def _thinned(starts: Sequence[Tried]) -> list[Tried]:
    """Return the starts of one law, of those that differ in the size of its force a few."""
    each: dict[tuple[float, ...], list[tuple[float, Tried]]] = {}
    for hypothesis, x in starts:
        shape, size = _shape_and_size(hypothesis.added[-1], x)
        each.setdefault(shape, []).append((size, (hypothesis, x)))
    return [one for shape in sorted(each) for one in _decades(each[shape])]


def _decades(sized: Sequence[tuple[float, Tried]]) -> list[Tried]:
    """Return starts of one shape, no two within a decade, from the middle on."""
    middle_first = sorted(range(len(sized)), key=lambda i: abs(i - len(sized) // 2))
    kept: list[tuple[float, Tried]] = []
    for i in middle_first:
        if all(not 1.0 / DECADE < sized[i][0] / size < DECADE for size, _ in kept):
            kept.append(sized[i])
    return [one for _, one in kept]


def _shape_and_size(added: Addition, x: FloatArray) -> tuple[tuple[float, ...], float]:
    """Return the shape of a law beside the size of its force, and that size [its unit]."""
    values = added.values(x[-len(added.names) :])
    sizes = [float(values.pop(name)) for name in added.identification.scaled]
    size = sizes[0] if sizes else 1.0
    shape = (*values.values(), *(other / size for other in sizes[1:]))
    return tuple(float(f"{value:.6g}") for value in shape), size
