"""Held-out data, scored and never fitted: tests that the log marks, else blocks of each."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.measured import Measured
from shakerproc.comparison.noise_sources import period_of
from shakerproc.comparison.part import periods_of
from shakerproc.data import FloatArray

BLOCKS: Final = 12
"""Blocks that a test is cut into where the log marks no test: each long against the decay of a
resonance, and several of each third in every part of a sweep [-]."""

EVERY: Final = 3
"""Of so many blocks one is held out [-]."""

PERIODS: Final = 17.0
"""Periods of the motion that a block has to hold, or there are fewer of them: the longest
windows that a slow motion is predicted in, and their run-in [-]."""


def held_out(tests: Sequence[Measured]) -> tuple[NDArray[np.bool_], ...]:
    """Return for every test which of its samples are held out, (n,) arrays."""
    return held_out_samples(
        [test.input for test in tests],
        [test.responses for test in tests],
        [(test.start, test.stop) for test in tests],
        [test.test.hold_out for test in tests],
    )


def held_out_samples(
    drives: Sequence[FloatArray],
    responses: Sequence[FloatArray],
    judged: Sequence[tuple[int, int]],
    marked: Sequence[bool],
) -> tuple[NDArray[np.bool_], ...]:
    """Return which samples of every test are held out.

    All of the tests that are marked; where none is, one of every three blocks of the judged
    part of each, each time the one before: a drive may come back with them. Blocks of a
    periodic drive repeat each other: of such tests every third is held out as a whole, and
    where there is only one of them, nothing. Of a test of few periods it is the middle third.

    Parameters
    ----------
    drives : sequence of (n,) array
        What drives each test [m/s² or N].
    responses : sequence of (n_sensors, n) array
        What each test measured, in the units of the sensors.
    judged : sequence of (int, int)
        First judged sample of each, and the first after the last.
    marked : sequence of bool
        Whether the log says `hold_out`.
    """
    found = [np.zeros(drive.size, bool) for drive in drives]
    if any(marked):
        for inside, is_marked in zip(found, marked, strict=True):
            inside[:] = is_marked
        return tuple(found)
    periodic = 0
    for drive, own, inside, (start, stop) in zip(drives, responses, found, judged, strict=True):
        if period_of(drive[start:stop]):
            periodic += 1
            inside[:] = periodic % EVERY == 0
            continue
        fitting = int(periods_of(own[:, start:stop]) / (EVERY * PERIODS))
        groups = min(max(1, fitting), BLOCKS // EVERY)
        limits = np.linspace(start, stop, EVERY * groups + 1).astype(int)
        for group in range(groups):
            last = (EVERY - 1 - group) % EVERY
            k = EVERY * group + (last if groups > 1 else EVERY // 2)
            inside[limits[k] : limits[k + 1]] = True
    return tuple(found)
