"""How effects enter the race: from all their starts at once, at the first nudging rate.

A window that begins anew has a start for every mode, more of them than there are sensors; a
model that is held needs none.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, gone_on
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.hypotheses.hypothesis import Addition
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.base import Base, Moved
from shakerproc.diagnosis.nudged.starts import Group, Tried, as_in_file, beyond, own_starts
from shakerproc.diagnosis.selection.scores import FAR, gain_of
from shakerproc.numerals import numeral

FITTED: Final = 12
"""Laws in joints that are fitted, of those that leave least so far, beside the best in every
joint [-]."""

FROM: Final = 2
"""Starts of each that are fitted [-]."""

STEPS: Final = 2
"""Steps of such a fit; those that still leave least then take as many again [-]."""

APART: Final = 0.2
"""Change of a coordinate from which on a start is another one [-]."""

SHORT: Final = 2
"""Numbers of the laws that tell which joints may have the effect: of 18 drawn chains one of
these led in the right joint in 17, by up to 93 errors, and was 1.4 behind in the other [-]."""

DECADE: Final = 10.0
"""Ratio of forces from which on they are two starts: between them the least squares of the
force find the size (see `Base`) [-]."""


def entered(
    on: Fit, known: Known, say: Callable[[str], None]
) -> tuple[dict[Group, Fit], dict[str, str]]:
    """Return effects in every joint at the first rate, and why others failed.

    Starts of all are compared, each in one run (see `Base`); those that leave least are
    fitted, and laws that contain these begin where they ended, too. In joints whose short laws
    leave far more than those of another, none is fitted, and longer ones are not tried.
    """
    bases, every = _bases(on), own_starts(on, known)
    short = [group for group in every if len(known[group[1]][group[0]].free) <= SHORT]
    ends = {group: _ends(on, bases, group, every[group], say) for group in short}
    behind = _far_behind(ends)
    longer = [group for group in every if group not in ends and group[1] not in behind]
    ends |= {group: _ends(on, bases, group, every[group], say) for group in longer}
    failed = {
        " ".join((kind, *words)): "its motion runs away"
        for (kind, _, words), begun in ends.items()
        if not begun
    }
    if behind:
        where = ", ".join(" and ".join(joint) for joint in known if joint in behind)
        left_out = f"laws of more than {numeral(SHORT)} numbers between {where}"
        failed[left_out] = "shorter ones leave far more there than in another joint"
    say("the best of them")
    fits: dict[Group, Fit] = {}
    near = {group: begun for group, begun in ends.items() if group[1] not in behind}
    _fit_the_best(on, near, fits)
    for group in list(near):
        old = [] if group in fits else near[group]
        begun = [*old, *bases[0].best(beyond(group, known, fits))]
        near[group] = sorted(begun, key=_level)[:FROM]
    _fit_the_best(on, near, fits)
    for group, begun in {**ends, **near}.items():
        there = _fitted(on, begun[0], rounds=0) if begun and group not in fits else None
        if there is not None:
            fits[group] = there
    return fits, failed


def _ends(
    on: Fit, bases: Sequence[Base], group: Group, starts: Sequence[Tried],
    say: Callable[[str], None],
) -> list[Moved]:  # fmt: skip
    """Return the starts of an effect that leave least with the bases' numbers moved."""
    say(f"{group[0]} between {' and '.join(group[1])}")
    begun = [one for base in bases for one in base.best(_of(base, starts))]
    begun += bases[-1].best(_in_wells(on, starts))
    return sorted(begun, key=_level)[:FROM]


def _far_behind(ends: Mapping[Group, Sequence[Moved]]) -> set[Joint]:
    """Return the joints whose best law so far leaves far more than the best of all."""
    least: dict[Joint, Moved] = {}
    for (_, joint, _), begun in ends.items():
        for one in begun:
            least[joint] = min(least.get(joint, one), one, key=_level)
    best = min(least.values(), key=_level, default=None)
    return {j for j, one in least.items() if best and gain_of(best.logs, one.logs).t >= FAR}


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


def _fit_the_best(
    on: Fit, ends: Mapping[Group, Sequence[Moved]], fits: dict[Group, Fit]
) -> None:
    """Fit the laws in joints that leave least so far, from new starts and where they ended."""
    levels = {group: [one.level for one in begun] for group, begun in ends.items()}
    for group, one in fits.items():
        levels[group].append(one.level)
    order = sorted((g for g in levels if levels[g]), key=lambda g: min(levels[g]))
    first = {group[1]: group for group in reversed(order)}
    rounds = STEPS - bool(on.data.model.structures)  # which go on along the same slopes
    for group in dict.fromkeys([*order[:FITTED], *first.values()]):
        tried = [_fitted(on, one, rounds=rounds) for one in ends[group]]
        if group in fits:
            tried.append(gone_on(fits[group], rounds=rounds))
        there = [one for one in tried if one is not None]
        if there:
            fits[group] = min(there, key=lambda one: one.level)


def _fitted(on: Fit, moved: Moved, *, rounds: int) -> Fit | None:
    return fit(
        on.data, moved.hypothesis, moved.x, on.windows, rounds=rounds, channels=on.channels,
        step=FARTHEST_STEP,
    )  # fmt: skip


def _level(moved: Moved) -> float:
    return moved.level


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
