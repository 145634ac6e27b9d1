"""How effects enter the race: from all their starts at once, at the first nudging rate.

A window that begins anew has a start for every mode, more of them than there are sensors; a
model that is held needs none.
"""

from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.hypotheses.hypothesis import Addition
from shakerproc.diagnosis.hypotheses.joints import Known
from shakerproc.diagnosis.nudged.base import Base, Moved
from shakerproc.diagnosis.nudged.starts import Group, Tried, as_in_file, beyond, own_starts

FOLLOWED: Final = (12, 12)
"""Laws in joints that are followed by steps, one time after the other, of those that leave
least so far, beside the best in every joint [-]."""

FITTED: Final = 6
"""Of these so many are fitted by all their numbers and those of the tests at last [-]."""

STEPPED: Final = 2
"""Starts of each that are followed [-]."""

STEPS: Final = 3
"""Steps that are followed each time [-]."""

APART: Final = 0.2
"""Change of a coordinate from which on a start is another one [-]."""

DECADE: Final = 10.0
"""Ratio of forces from which on they are two starts: between them the least squares of the
force find the size (see `Base`) [-]."""


def entered(
    on: Fit, known: Known, say: Callable[[str], None]
) -> tuple[dict[Group, Fit], dict[str, str]]:
    """Return effects in every joint at the first rate, and why others failed.

    Starts of all are compared; those that leave least are followed, and laws that contain these
    begin where they ended, too. The slopes by the model's own numbers are those without any
    effect, so that a law takes as few runs in a structure of many modes as in one mass.
    """
    bases = _bases(on)
    failed: dict[str, str] = {}
    ends: dict[Group, list[_End]] = {}
    every = own_starts(on, known)
    for group, starts in every.items():
        say(f"{group[0]} between {' and '.join(group[1])}")
        begun = [end for base in bases for end in _begun(base, _of(base, starts))]
        begun += _begun(bases[-1], _in_wells(on, starts))
        ends[group] = sorted(begun, key=_level)[:STEPPED]
        if not ends[group]:
            failed[" ".join((group[0], *group[2]))] = "its motion runs away"
    _step(ends, _promising(ends, FOLLOWED[0]))
    simple = _as_fits(ends)
    for group in every:
        if richer := beyond(group, known, simple):
            begun = [*ends[group], *_begun(bases[0], richer)]
            ends[group] = sorted(begun, key=_level)[:STEPPED]
    for most in FOLLOWED[1:]:
        _step(ends, _promising(ends, most))
    return _as_fits(ends, _promising(ends, FITTED)), failed


def _bases(on: Fit) -> list[Base]:
    """Return a fit, and the same with the model's own numbers as its file tells them.

    Numbers that were fitted without an effect imitate it, and lead away from it.
    """
    x = as_in_file(on.hypothesis, on.x)
    file = fit(on.data, on.hypothesis, x, on.windows, rounds=0, channels=on.channels)
    is_apart = file is not None and bool(np.any(np.abs(x - on.x) > APART))
    return [Base(one, on.windows) for one in ((on, file) if is_apart else (on,)) if one]


def _of(base: Base, starts: Sequence[Tried]) -> list[Tried]:
    """Return the starts at the numbers of a base, of sizes of a force a few."""
    own = base.fit.x
    return _thinned([one for one in starts if np.array_equal(one[1][: own.size], own)])


def _in_wells(on: Fit, starts: Sequence[Tried]) -> list[Tried]:
    """Return the starts between two places to rest, whose sizes no line tells."""
    return [one for one in starts if one[0].own != on.hypothesis.own]


def _begun(base: Base, starts: Sequence[Tried]) -> list["_End"]:
    return [(base, moved) for moved in base.best(starts)]


def _promising(ends: dict[Group, list["_End"]], most: int) -> list[Group]:
    """Return the laws in joints that leave least so far, the best in every joint among them."""
    order = sorted((group for group in ends if ends[group]), key=lambda g: _level(ends[g][0]))
    first = {group[1]: group for group in reversed(order)}
    return list(dict.fromkeys([*order[:most], *first.values()]))


def _step(ends: dict[Group, list["_End"]], groups: Sequence[Group]) -> None:
    """Let laws go on by steps from where they are, to one end of each."""
    for group in groups:
        tried = [(base, base.stepped(own, x, STEPS)) for base, (_, own, x) in ends[group]]
        moved = [(base, one) for base, one in tried if one is not None]
        ends[group] = sorted(moved, key=_level)[:1]


def _as_fits(ends: dict[Group, list["_End"]], near: Sequence[Group] = ()) -> dict[Group, Fit]:
    """Return the fits of laws where they are; some go on from there by all their numbers."""
    fits = {
        group: _as_fit(*own[0], rounds=STEPS if group in near else 0)
        for group, own in ends.items()
        if own
    }
    return {group: one for group, one in fits.items() if one is not None}


def _as_fit(base: Base, moved: Moved, *, rounds: int) -> Fit | None:
    on = base.fit
    return fit(
        on.data, *moved[1:], on.windows, rounds=rounds, channels=on.channels, step=FARTHEST_STEP
    )  # fmt: skip


_End: TypeAlias = tuple[Base, Moved]
"""Where steps have led, and whose slopes they follow."""


def _level(end: _End) -> float:
    return end[1][0]


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
