"""Rows that are left out: where they belong in time, and what is said of them."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray, SkippedRows
from shakerproc.recordings.text_rows import Interruptions

REMEDY: Final = (
    "Repair the file, or have such rows skipped: processing: {bad_rows: skip} in the log (or "
    "--bad-rows skip)."
)


def without_bad_rows(
    values: FloatArray, bad: Interruptions, times: FloatArray | None
) -> tuple[FloatArray, SkippedRows | None]:
    """Return the rows of a table with straight lines where rows are left out.

    A row that is left out is a gap in time. The time column says how many samples are missing
    there, none for a blank line or a header that is repeated; without one, every bad row that
    is neither counts as a sample.

    Parameters
    ----------
    values : (n_columns, n_rows) array
        The rows of numbers [units of the columns].
    bad : Interruptions
        What stands between them.
    times : (n_rows,) array, optional
        The time column [s].
    """
    if not bad.after:
        return values, None
    n_rows = values.shape[1]
    after = np.frombuffer(bad.after, dtype=np.int64)
    at, index = np.unique(after, return_inverse=True)
    lines = np.bincount(index)
    missing = np.bincount(index, weights=np.frombuffer(bad.samples, dtype=np.int8)).astype(int)
    inside = (at > 0) & (at < n_rows)
    if times is not None:
        missing[inside] = _missing_in_time(times, at[inside], lines[inside])
    missing[~inside] = 0  # nothing stands on the other side to bridge to
    shift = np.zeros(n_rows, dtype=np.int64)
    np.add.at(shift, at[inside], missing[inside])
    place = np.arange(n_rows) + np.cumsum(shift)
    whole = _bridged(values, place) if missing.any() else values
    ends = np.append(place, whole.shape[1])
    first, last = int(ends[at[0]]) - int(missing[0]), int(ends[at[-1]])
    filled = int(missing.sum())
    return whole, SkippedRows(
        count=len(bad.after),
        bridged=filled,
        first=first,
        last=last,
        message=_message(bad, filled, timed=times is not None),
    )


def refusal(bad: Interruptions, width: int) -> str:
    """Return what is wrong with the bad rows, and what to do."""
    line, found = bad.named[0]
    count = len(bad.after)
    wanted = f"{width} numbers are" if width > 1 else "a number is"
    such = f" {count} lines are no rows of numbers ({_listed(bad)})." if count > 1 else ""
    return f"line {line}: {found}, where {wanted} wanted.{such} {REMEDY}"


def _listed(bad: Interruptions) -> str:
    lines = ", ".join(str(line) for line, _ in bad.named)
    return f"lines {lines}{' and so on' if len(bad.after) > len(bad.named) else ''}"


def _message(bad: Interruptions, filled: int, *, timed: bool) -> str:
    count = len(bad.after)
    line, found = bad.named[0]
    lines = f"{count} lines that are no rows of numbers were"
    if count == 1:
        lines = "1 line that is no row of numbers was"
    where = f"{_listed(bad)}; " if count > 1 else ""
    bridged = f"{filled} samples are" if filled != 1 else "1 sample is"
    why = "as the time column says" if timed else "no time column says how many were missing"
    return (
        f"{lines} skipped ({where}line {line}: {found}); {bridged} bridged by "
        f"straight lines ({why})."
    )


def _missing_in_time(
    times: FloatArray, at: NDArray[np.int64], lines: NDArray[np.int64]
) -> FloatArray:
    """Return how many samples the time column lacks at each gap, one for a line at most.

    The step is that of the longest stretch without a gap.
    """
    edges = np.concatenate([[0], at, [times.size]])
    longest = int(np.argmax(np.diff(edges)))
    start, stop = int(edges[longest]), int(edges[longest + 1]) - 1
    step = (times[stop] - times[start]) / (stop - start) if stop > start else 0.0
    if not (np.isfinite(step) and step > 0.0):
        return np.zeros(at.size)
    gaps = np.nan_to_num((times[at] - times[at - 1]) / step, nan=0.0)
    missing: FloatArray = np.clip(np.rint(np.clip(gaps, 0.0, 1e15)) - 1.0, 0, lines)
    return missing


def _bridged(values: FloatArray, place: NDArray[np.int64]) -> FloatArray:
    every = np.arange(int(place[-1]) + 1)
    return np.stack([np.interp(every, place, row) for row in values])
