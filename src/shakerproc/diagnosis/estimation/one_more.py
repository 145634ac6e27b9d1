"""The search for one more effect on top of a hypothesis, over windows that grow."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.beginnings import (
    BEST_STARTS,
    Beginnings,
    Tried,
    grouped,
    least_left,
)
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.growth import NONE, Condition, Stages, lengthened
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.estimation.run_in import found_again
from shakerproc.diagnosis.estimation.sampling import as_recorded
from shakerproc.diagnosis.hypotheses.joints import Joint, Known
from shakerproc.diagnosis.nudged.starts import Group
from shakerproc.diagnosis.screening import Start
from shakerproc.diagnosis.selection.scores import (
    FAR,
    LEAST,
    Score,
    as_fitted,
    gain,
    is_better,
    worth_a_fit,
)

FIRST_ROUNDS: Final = 2
"""Steps of a fit from the best of these: what they are worth shows by then [-]."""

ARRIVAL_ROUNDS: Final = 12
"""Steps more of those that go on to longer windows [-]."""

KEPT: Final = 6
"""Hypotheses that are fitted to longer windows and at the horizon [-]."""

LEAST_KEPT: Final = 2
"""Of these so many however far behind the best: two steps tell little of a curved law [-]."""


@final
class OneMore:
    """The search for one effect on top of a hypothesis.

    Attributes
    ----------
    failed : dict of str to str
        Effects that could not be simulated, with the reason.
    least : float
        Least level (see `Fit`) that was reached in the shortest windows [-].
    """

    def __init__(
        self, data: DataSet, on: Fit, known: Known, stages: Stages, *, linear: FloatArray,
        say: Callable[[str], None], condition: Condition = NONE,
    ) -> None:  # fmt: skip
        self.data, self.on, self.known, self.stages, self.say = data, on, known, stages, say
        self.condition, self.begin = condition, Beginnings(on, known, linear)
        self.failed: dict[str, str] = {}
        self.least = np.inf
        self._first_fits: dict[Group, Fit] = {}
        self._grown: dict[tuple[Group, Windows], Fit | None] = {}

    def found(self, starts: Sequence[Start]) -> list[Fit]:
        """Return the effects that may be missing, fitted to windows that grew, best first.

        Every effect is first fitted to the shortest windows, the simple ones before those
        that contain them and then begin where they ended; the best go on, of those whose level
        (see `Fit`) is below that of the condition. What was fitted before is not fitted again.
        """
        groups = grouped([start for start in starts if start.kept])
        first = self._fitted_first(groups)
        self.say("longer windows")
        first = self._first_fits = self._as_recorded(first)
        self.least = min((one.level for one in first.values()), default=np.inf)
        first = {group: one for group, one in first.items() if one.level < self.condition.below}
        promising = self._promising(groups, first)
        screened = {kind: self.begin.screened(start) for kind, start in promising.items()}
        standing = {group: self._arrived(group, first[group]) for group in promising}
        for windows, rounds in zip(
            self.stages.windows[1:], self.stages.rounds[1:], strict=True
        ):
            fits: dict[Group, Fit] = {}
            for group in sorted(standing, key=lambda group: self._size(group[0], group[1])):
                key = group, windows
                if key not in self._grown:
                    begun = standing[group], screened[group]
                    one = lengthened(self.data, *begun, windows, rounds)
                    self._grown[key] = self._from_simpler(group, one, fits, windows, rounds)
                one = self._grown[key]
                if one is not None:
                    fits[group] = one
            if _follow(standing) and not _follow(fits):
                break  # the motion cannot be predicted as far ahead
            worth = self._worth_going_on(list(fits.values()), windows, rounds)
            wanted = self.condition.wanted
            standing = {g: one for g, one in fits.items() if one in worth or g[0] == wanted}
        return sorted(standing.values(), key=lambda one: one.level)

    def _fitted_first(self, groups: Mapping[Group, Sequence[Start]]) -> dict[Group, Fit]:
        """Return the fits to the shortest windows, the simple ones first."""
        first = self._first_fits
        for group in sorted(groups, key=lambda group: self._size(group[0], group[1])):
            if group in first:
                continue
            self.say(f"{group[0]} between {' and '.join(group[1])}")
            best = self._first(group, groups[group], first)
            if best is None:
                self.failed[" ".join((group[0], *group[2]))] = "its motion runs away"
            else:
                first[group] = best
        return first

    def every(self, starts: Sequence[Start]) -> list[Fit]:
        """Return the best fit of each effect not far behind, in its longest windows."""
        fits = self._fitted_first(grouped(starts))
        best: dict[tuple[str, Joint], Fit] = {}
        for group in self._near(sorted(fits, key=lambda group: fits[group].level)):
            grown = [self._grown.get((group, windows)) for windows in self.stages.windows]
            longest = [one for one in (fits[group], *grown) if one is not None][-1]
            best.setdefault(group[:2], longest)
        return list(best.values())

    def _as_recorded(self, first: dict[Group, Fit]) -> dict[Group, Fit]:
        """Return the fits with accelerations compared as the recorder took them.

        The best of them tells, if it explains anything (see `as_recorded`).
        """
        if not first:
            return first
        best, on = min(first.values(), key=lambda one: one.level), self.on
        alone = level_at(self.data, on.hypothesis, on.x, best.windows, on.channels)
        data = as_recorded(self.data, best) if best.level < alone else self.data
        if data is self.data:
            return first
        self.data = data
        self._grown.clear()
        return {
            group: self._again(one, FIRST_ROUNDS if one.level < alone else 0)
            for group, one in first.items()
        }

    def _again(self, one: Fit, rounds: int) -> Fit:
        """Return a fit to the tests as they are compared now."""
        again = fit(
            self.data, one.hypothesis, one.x, one.windows, rounds=rounds,
            channels=one.channels, starts=one.starts, step=FARTHEST_STEP,
        )  # fmt: skip
        return one if again is None else again

    def _arrived(self, group: Group, one: Fit) -> Fit:
        """Return a fit to the shortest windows that goes on until it has arrived there.

        Longer windows lead nowhere from where a few steps of a curved law have ended. Laws
        that contain it begin where it ended, there.
        """
        kind, joint, _ = group
        key = group, one.windows
        if one.converged or self.known[joint][kind].contains or key in self._grown:
            return self._grown.get(key) or one
        found = fit(
            self.data, one.hypothesis, one.x, one.windows, rounds=ARRIVAL_ROUNDS,
            channels=one.channels, step=one.steps,
        )  # fmt: skip
        better = one if found is None or found.level > one.level else found
        better = found_again(self.data, better, rounds=ARRIVAL_ROUNDS)
        self._grown[key] = better
        return better

    def _worth_going_on(self, fits: Sequence[Fit], windows: Windows, rounds: int) -> list[Fit]:
        """Return the fits that may be the best where the windows are longer.

        A second effect has to outdo the first alone, fitted to the same windows.
        """
        scores = self._scores(fits)
        on = self.on
        if not (self.condition.explained or on.hypothesis.added):
            return worth_a_fit(scores, self.known)
        alone = self._scores([
            fit(self.data, on.hypothesis, on.x, windows, rounds=rounds, channels=on.channels)
        ])
        if on.hypothesis.added:
            better = [s for s in scores if all(is_better(s, one) for one in alone)]
            return worth_a_fit(better, self.known)
        return worth_a_fit([*alone, *scores], self.known)

    def _scores(self, fits: Sequence[Fit | None]) -> list[Score]:
        scores = [as_fitted(self.data, one) for one in fits if one is not None]
        return [score for score in scores if score is not None]

    def _promising(
        self, groups: Mapping[Group, Sequence[Start]], first: Mapping[Group, Fit]
    ) -> dict[Group, Start]:
        """Return the best few and those that are not far behind, with their best start.

        Besides the one that explained most in the screening: what remembers longer than the
        shortest windows last shows in those as little as anything. Not where a law that it
        contains leaves less.
        """
        order = sorted(first, key=lambda group: first[group].level)
        outdone = {
            group
            for group, one in first.items()
            if any(own.level < one.level for own in self.begin.contained(group, first).values())
        }
        screened = sorted(
            first.keys() - outdone, key=lambda group: min(s.left for s in groups[group])
        )
        near = self._near(order[:KEPT])
        asked = [group for group in order if group[0] == self.condition.wanted]
        chosen = dict.fromkeys([*asked, *order[:LEAST_KEPT], *screened[:1], *near])
        return {group: min(groups[group], key=lambda s: s.left) for group in chosen}

    def _near(self, order: Sequence[Group]) -> list[Group]:
        """Return those that are not far behind the first of them in the shortest windows."""
        scores = self._scores([self._first_fits[group] for group in order])
        near = {score.fit for score in scores if gain(scores[0], score).t < FAR}
        return [group for group in order if self._first_fits[group] in near]

    def _size(self, kind: str, joint: Joint) -> int:
        return len(self.known[joint][kind].free)

    def _first(
        self, group: Group, starts: Sequence[Start], simpler: Mapping[Group, Fit]
    ) -> Fit | None:
        """Return the best fit to the shortest windows from all starts."""
        kind, joint, _ = group
        identification = self.known[joint][kind]
        tried = [*self.begin.of(starts), *self.begin.beyond(group, simpler)]
        screened = self.begin.of([min(starts, key=lambda start: start.left)])
        chosen = self._best(tried, screened, simplest=not identification.contains)
        fits = [
            fit(
                self.data, h, x, self.stages.windows[0], rounds=FIRST_ROUNDS,
                channels=channels, step=FARTHEST_STEP,
            )
            for h, x, channels in chosen
        ]  # fmt: skip
        return min(filter(None, fits), key=lambda one: one.level, default=None)

    def _from_simpler(
        self,
        group: Group,
        found: Fit | None,
        simpler: Mapping[Group, Fit],
        windows: Windows,
        rounds: int,
    ) -> Fit | None:
        """Return a fit, sought anew where a law that it contains has ended, if no better.

        The simpler one had not arrived when this one began beyond it.
        """
        tried = self.begin.beyond(group, simpler)
        reached = [one.level for one in self.begin.contained(group, simpler).values()]
        if not tried or (found is not None and found.level < min(reached) - LEAST):
            return found
        others = [
            fit(self.data, hypothesis, x, windows, rounds=rounds, channels=channels)
            for hypothesis, x, channels in least_left(self.data, tried, windows)[:2]
            if found is None
            or level_at(self.data, hypothesis, x, windows, channels) < found.level
        ]
        good = [one for one in (found, *others) if one is not None]
        return min(good, key=lambda one: one.level, default=None)

    def _best(
        self, tried: Sequence[Tried], screened: Sequence[Tried], *, simplest: bool
    ) -> list[Tried]:
        """Return the best starts with numbers and sensors as told, and the best of the others.

        Besides the best that was screened: of laws that remember, those that do next to
        nothing leave less before the first step than those that are nearly right. Numbers and
        gains that imitate the effect without it explain more at first and lead
        away from it. What is rare shows in whole tests alone: there the best starts of what
        nothing simpler leads to are sought, too.
        """
        told = [one for one in tried if one[2] is None]
        others = [one for one in tried if one[2] is not None]
        first, whole = self.stages.looked_at, self.stages.whole
        near = least_left(self.data, told, first)
        found = [*near[:2], *least_left(self.data, others, first)[:2]]
        found += least_left(self.data, screened, first)[:1]
        if whole is not None and simplest:
            found += least_left(self.data, near[:BEST_STARTS], whole)[:2]
        return list({one[1].tobytes(): one for one in found}.values())


def _follow(fits: Mapping[Group, Fit]) -> bool:
    """Return whether the one that leaves least follows the motion in most windows."""
    best = min(fits.values(), key=lambda one: one.level, default=None)
    return best is not None and best.follows_most
