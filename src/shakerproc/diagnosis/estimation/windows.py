"""Which parts of the tests are simulated: whole tests from rest, or windows with own starts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.diagnosis.data import Test
from shakerproc.diagnosis.estimation.residuals import DataSet, Windows, starts_of
from shakerproc.models import Model

BLOCK_S: Final = 0.5
"""Length of blocks of which every third is kept for the score where no test is marked [s]."""

Mask = NDArray[np.bool_]


def kept_samples(tests: Sequence[Test]) -> tuple[Mask, ...]:
    """Return which samples of each test are held out.

    Tests that the log marks are held out whole; where it marks none, every third block is.
    """
    marked = any(test.arrays.hold_out for test in tests)
    out = []
    for test in tests:
        n = test.n_samples
        if marked:
            out.append(np.full(n, test.arrays.hold_out))
        else:
            block = (np.arange(n) - test.start) // round(BLOCK_S * test.sample_rate)
            out.append(block % 3 == 2)
    return tuple(out)


def whole_tests(data: DataSet, *, held_out: bool) -> Windows:
    """Return every test from its first sample on, counted where it is judged.

    Parameters
    ----------
    data : DataSet
        The tests.
    held_out : bool
        Whether what is held out counts, or what is fitted to; tests of which nothing counts
        are left out.
    """
    table, counted = [], []
    for i, (test, kept) in enumerate(zip(data.tests, kept_samples(data.tests), strict=True)):
        judged = np.zeros(test.n_samples - 1, bool)
        judged[test.start : test.stop] = True
        mask = judged & (kept == held_out)[:-1]
        if mask.any():
            last = int(np.flatnonzero(mask)[-1]) + 1
            table.append((i, 0, last))
            counted.append(mask[:last])
    return Windows(np.array(table, np.int64).reshape(-1, 3), tuple(counted))


def windows_of(
    data: DataSet,
    model: Model,
    length: int,
    *,
    held_out: bool,
    most: int,
    run_in: int = 0,
) -> Windows:
    """Return windows of one length that begin with a start of their own.

    Parameters
    ----------
    data : DataSet
        The tests.
    model : Model
        Linear model that completes the measured motion where the windows begin.
    length : int
        Samples of a window.
    held_out : bool
        Whether to take what is held out, or what is fitted to.
    most : int
        Windows at most; those with the largest responses are taken, spread over all tests.
    run_in : int
        Samples at the beginning of a window that tell its start and do not count.
    """
    found = []
    for i, (test, kept) in enumerate(zip(data.tests, kept_samples(data.tests), strict=True)):
        rows = np.abs(test.responses / data.noise[i]).max(axis=0)
        places = [
            (float(np.mean(rows[a : a + length])), i, a)
            for a in range(test.start, test.stop - length - 1, length)
            if np.all(kept[a : a + length] == held_out)
        ]
        found.append(sorted(places, reverse=True))
    share = max(1, most // max(1, sum(bool(places) for places in found)))
    chosen = sorted((i, a) for places in found for _, i, a in places[:share])
    table = np.array([(i, a, length) for i, a in chosen], np.int64).reshape(-1, 3)
    starts, scales = starts_of(model, data, table)
    whole = Windows(table, (np.arange(length) >= run_in,) * len(table), starts, scales)
    if not run_in:
        return whole
    short = table.copy()
    short[:, 2] = run_in
    own = Windows(short, (np.ones(run_in, bool),) * len(table), starts, scales)
    return replace(whole, run_in=own)
