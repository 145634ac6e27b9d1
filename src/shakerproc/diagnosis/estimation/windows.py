"""Which parts of the tests are simulated: whole tests from rest, or windows with own starts."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.stacks import TAPS

Place: TypeAlias = tuple[float, int, int]
"""Mean response over the noise, test and first sample."""


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
    for i, (test, kept) in enumerate(zip(data.tests, data.kept, strict=True)):
        judged = np.zeros(test.n_samples - 1, bool)
        judged[test.start : test.stop] = True
        mask = judged & (kept == held_out)[:-1]
        if mask.any():
            last = int(np.flatnonzero(mask)[-1]) + 1
            table.append((i, 0, last))
            counted.append(mask[:last])
    return Windows(np.array(table, np.int64).reshape(-1, 3), tuple(counted))


def every_test(data: DataSet) -> Windows:
    """Return every test as a whole, of which everything counts."""
    sizes = [test.n_samples for test in data.tests]
    table = np.array([(i, 0, size) for i, size in enumerate(sizes)], np.int64)
    return Windows(table, tuple(np.ones(size, bool) for size in sizes))


def windows_of(
    data: DataSet,
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
    length : int
        Samples of a window.
    held_out : bool
        Whether to take what is held out, or what is fitted to.
    most : int
        Windows at most, from all tests; from small to large responses, half of them from the
        largest quarter: an effect shows where the response is large, and what the model is
        without it where it is small.
    run_in : int
        Samples at the beginning of a window that tell its start and do not count.
    """
    found = []
    for i, (test, runs) in enumerate(
        zip(data.tests, data.stretches(held_out=held_out), strict=True)
    ):
        rows = np.abs(test.responses / data.noise[i]).max(axis=0)
        places = [
            (float(np.mean(rows[a : a + length])), i, a)
            for first, last in runs
            for a in range(first, last - length, length)
        ]
        found.append(sorted(places, reverse=True))
    share = max(1, most // max(1, sum(bool(places) for places in found)))
    chosen = sorted((i, a) for places in found for _, i, a in _spread(places, share))
    return _with_starts([(i, a, length) for i, a in chosen], run_in)


def whole_stretches(data: DataSet, *, held_out: bool, run_in: int = 0) -> Windows:
    """Return each part of the tests that counts as one window, with a start of its own.

    Parameters
    ----------
    data, held_out, run_in
        As for `windows_of`.
    """
    found = [
        (i, first, last - first)
        for i, runs in enumerate(data.stretches(held_out=held_out))
        for first, last in runs
        if last - first > 2 * (run_in + TAPS)
    ]
    return _with_starts(found, run_in)


def whole_from_starts(data: DataSet, *, held_out: bool, run_in: int = 0) -> Windows:
    """Return every test with a start of its own, counted where it is judged.

    What is held out in blocks is predicted across what is fitted to, from one start.

    Parameters
    ----------
    data, held_out, run_in
        As for `windows_of`.
    """
    found, counted = [], []
    for i, (test, kept) in enumerate(zip(data.tests, data.kept, strict=True)):
        mask = (kept == held_out)[test.start : test.stop]
        mask[:run_in] = False
        if mask.any():
            last = int(np.flatnonzero(mask)[-1]) + 1
            found.append((i, test.start, last))
            counted.append(mask[:last])
    return replace(_with_starts(found, run_in), counted=tuple(counted))


def _with_starts(rows: Sequence[tuple[int, int, int]], run_in: int) -> Windows:
    """Return windows that begin with a start of their own, told by the run-in of each."""
    table = np.array(rows, np.int64).reshape(-1, 3)
    counted = tuple(np.arange(size) >= run_in for _, _, size in rows)
    whole = Windows(table, counted, from_rest=False)
    if not run_in:
        return whole
    short = table.copy()
    short[:, 2] = run_in
    own = Windows(short, (np.ones(run_in, bool),) * len(table), from_rest=False)
    return replace(whole, run_in=own)


def _spread(places: list[Place], count: int) -> list[Place]:
    """Return as many places, in the order of their responses, denser at the beginning."""
    if len(places) <= count:
        return places
    ranks = len(places) * np.linspace(0.0, 1.0, count, endpoint=False) ** 2
    each = np.maximum(ranks.astype(int), np.arange(count))
    return [places[i] for i in each]
