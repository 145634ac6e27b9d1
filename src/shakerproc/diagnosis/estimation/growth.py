"""Windows that grow: short ones widen the basin of attraction, long ones sharpen it."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.levels import level_at
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels
from shakerproc.diagnosis.estimation.residual_slopes import FARTHEST_STEP
from shakerproc.diagnosis.estimation.run_in import found_again
from shakerproc.diagnosis.estimation.stacks import TAPS
from shakerproc.diagnosis.estimation.windows import whole_from_starts, whole_tests, windows_of
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis


@final
@dataclass(frozen=True, slots=True)
class Condition:
    """Condition under which an effect is fitted to longer windows.

    Attributes
    ----------
    wanted : str
        Kind that is fitted to all windows, whatever it leaves; none if empty.
    below : float
        Level (see `Fit`) that others have to stay below in the shortest windows [-].
    explained : bool
        Whether the hypothesis without the effect leaves no more than noise: others have to
        outdo it then.
    """

    wanted: str = ""
    below: float = np.inf
    explained: bool = False


NONE: Final = Condition()
"""No condition but those that hold for every effect."""


LENGTHS: Final = (2.0, 5.0, 15.0)
"""Lengths of the windows in periods of the joint's motion, each a factor of two to three."""

WINDOWS: Final = (80, 60, 40)
"""Windows of each length: as many as tell the numbers to a few per cent."""

LOOKED_AT: Final = 26
"""Of the shortest windows so many in which starts of fits are compared: a third of them [-]."""

LEAST_RESIDUALS: Final = 4.0
"""Residuals of a window at least over the numbers of its start, those of a mode besides: else
any hypothesis fits [-]."""

ROUNDS: Final = (6, 4, 4)
"""Steps of the search in each."""


@final
@dataclass(frozen=True, eq=False)
class Stages:
    """Windows of growing length.

    Attributes
    ----------
    windows : tuple of Windows
        The shorter ones first.
    rounds : tuple of int
        Steps of the search in each.
    whole : Windows, optional
        Whole tests, where all begin at rest: nothing is to be known of their starts.
    """

    windows: tuple[Windows, ...]
    rounds: tuple[int, ...] = ROUNDS
    whole: Windows | None = None

    @cached_property
    def looked_at(self) -> Windows:
        """Some of the shortest windows, in which starts of fits are compared."""
        return self.windows[0].some(LOOKED_AT)


def stages_of(data: DataSet) -> Stages:
    """Return the windows of a search; tests that are too short for any as wholes."""
    rate = data.tests[0].sample_rate
    least = LEAST_RESIDUALS * 2 * (data.model.n_coordinates + 1) / data.n_sensors
    at_rest = all(test.at_rest for test in data.tests)
    windows = [
        windows_of(
            data, TAPS + max(int(n * rate * data.lengths.unit_s), math.ceil(least)),
            held_out=False, most=most,
        )
        for n, most in zip(LENGTHS, WINDOWS, strict=True)
    ]  # fmt: skip
    some = tuple(filter(len, windows)) or (whole_from_starts(data, held_out=False),)
    return Stages(
        some, ROUNDS[: len(some)], whole_tests(data, held_out=False) if at_rest else None
    )


def grown(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    stages: Stages,
    channels: Channels | None = None,
) -> Fit | None:
    """Return a hypothesis fitted through all lengths; None where it runs away in one."""
    found: Fit | None = None
    for windows, rounds in zip(stages.windows, stages.rounds, strict=True):
        if found is None:
            found = fit(
                data, hypothesis, x, windows, rounds=rounds, channels=channels,
                step=FARTHEST_STEP,
            )  # fmt: skip
        else:
            found = lengthened(data, found, x, windows, rounds)
        if found is None:
            return None
    return found


def lengthened(
    data: DataSet, found: Fit, other: FloatArray, windows: Windows, rounds: int
) -> Fit | None:
    """Return a fit to longer windows; None where it runs away.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        To shorter windows.
    other : (n_x,) array
        Where to start if that is better than where the shorter windows ended.
    windows : Windows
        The longer ones.
    rounds : int
        Steps at most.
    """
    channels = found.channels
    starts = (found.x, other)
    levels = [level_at(data, found.hypothesis, x, windows, channels) for x in starts]
    x = starts[int(np.argmin(levels))]
    one = fit(
        data, found.hypothesis, x, windows, rounds=rounds, channels=channels,
        step=found.steps,
    )  # fmt: skip
    if one is None:
        return None
    return found_again(data, one, rounds=rounds, known=found.follows_most)
