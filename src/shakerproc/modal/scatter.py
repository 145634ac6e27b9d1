"""How far the modes of one fit scatter over several records, or over the parts of one."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.modal.likelihood import fit
from shakerproc.modal.lines import Lines, lines_subset
from shakerproc.modal.modal_model import NORMAL_95, ModeSet
from shakerproc.modal.selection import price_of
from shakerproc.modal.stabilisation import damping_of, frequency_of
from shakerproc.numerals import numeral

MUCH: Final = 2.0
"""Ratio of the scatter over records to what their own intervals allow, from which on a mode is
said to change from record to record [-]."""

MOST_LINES: Final = 4_000
"""Lines of a record that its own poles are refined on."""


TESTS: Final = (
    "tests",
    "the structure is not the same in all of them, or not linear; analyse them apart",
)
"""What the records of one fit are, and what it means that a mode scatters over them."""

BLOWS: Final = ("blows", TESTS[1])
"""The same of the blows of one test."""

PARTS: Final = (
    "parts of the record",
    "it moves with level or time: the structure is not linear, or changes",
)
"""The same of the parts of one record."""


def with_scatter(
    modes: ModeSet, records: Sequence[Lines], kind: tuple[str, str] = TESTS
) -> ModeSet:
    """Return the modes with their scatter over the records, and intervals that allow for it.

    Each record is fitted alone, from the common poles. Where they scatter more than their own
    intervals allow, the interval of the common mode is widened by that ratio (`widening`).

    Parameters
    ----------
    modes : ModeSet
        Of all records together.
    records : sequence of Lines
        What it was found from, each alone.
    kind : (str, str)
        What the records are, and what it means that a mode scatters over them, in words.

    References
    ----------
    .. [1] R. T. Birge, "The calculation of errors by the method of least squares", Physical
       Review 40, 207-227, 1932.
    """
    if not modes.poles.size:
        return modes
    named, meaning = kind
    values, errors = _alone(modes, records)
    ratio, wider = widening(values, errors)
    scatter = _deviation(values)
    moving = [
        f"mode {i + 1} ({modes.frequency[i]:.5g} Hz) scatters over the {named} by "
        f"{numeral(100.0 * scatter[0, i], 2)} % in frequency and "
        f"{numeral(100.0 * scatter[1, i], 2)} % in damping, {numeral(ratio[:, i].max(), 2)} "
        f"times what their intervals allow: {meaning}"
        for i in range(modes.poles.size)
        if ratio[:, i].max() > MUCH
    ]
    return replace(
        modes,
        frequency_error=modes.frequency_error * wider[0],
        damping_error=modes.damping_error * wider[1],
        scatter=scatter,
        interval_from=f"{modes.interval_from}, wider where the {named} scatter more",
        notes=(*modes.notes, *moving),
    )


def widening(values: FloatArray, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much values scatter more than their errors say, and intervals are widened.

    Of few records the ratio is uncertain itself: an interval that rests on it is one of
    Student's t.

    Parameters
    ----------
    values : (n_records, ...) array
        What each record says; NaN where one says nothing.
    errors : (n_records, ...) array
        Their standard deviations, by each record alone.

    Returns
    -------
    ratio : (...) array
        Birge's [-].
    wider : (...) array
        Factor of the errors, 1.96 of which are the 95 % interval [-]; 1 or more.
    """
    weight = np.where(np.isnan(values), 0.0, 1.0 / errors**2)
    filled = np.nan_to_num(values)
    free = np.maximum((weight > 0.0).sum(axis=0) - 1, 1)
    total = np.maximum(weight.sum(axis=0), 1e-300)
    mean = (weight * filled).sum(axis=0) / total
    ratio = np.sqrt((weight * (filled - mean) ** 2).sum(axis=0) / free)
    student = scipy.special.stdtrit(free, 0.975) / NORMAL_95
    return ratio, np.where(ratio > 1.0, ratio * student, 1.0)


def _deviation(values: FloatArray) -> FloatArray:
    """Return standard deviations over records, NaN where fewer than two show the mode."""
    seen = ~np.isnan(values)
    count = seen.sum(axis=0)
    mean = np.nansum(values, axis=0) / np.maximum(count, 1)
    square = np.nansum((values - mean) ** 2, axis=0) / np.maximum(count - 1, 1)
    return np.asarray(np.where(count > 1, np.sqrt(square), np.nan))


def _alone(modes: ModeSet, records: Sequence[Lines]) -> tuple[FloatArray, FloatArray]:
    """Return ln(frequency) and ln(damping) from each record alone, and their errors.

    Both are (n_records, 2, n_modes), NaN where a record does not show the mode, as of a force
    at its node.
    """
    values = np.full((len(records), 2, modes.poles.size), np.nan)
    errors = np.ones_like(values)
    for number, record in enumerate(records):
        acting = np.abs(record.inputs).max(axis=1) > 0.0
        own = lines_subset(record, slice(None, None, -(-record.frequency.size // MOST_LINES)))
        own = replace(own, inputs=own.inputs[acting])
        seen = np.flatnonzero(fit(own, modes.poles, 0).losses > price_of(own))
        alone = fit(own, modes.poles[seen])
        if not seen.size:
            continue
        spread = np.sqrt(np.diag(alone.covariance)).reshape(-1, 2)
        near = np.argmin(np.abs(np.subtract.outer(modes.poles[seen], alone.poles)), axis=1)
        found = frequency_of(alone.poles[near]), damping_of(alone.poles[near])
        values[number][:, seen] = np.log(np.stack(found))
        errors[number][:, seen] = np.maximum(spread[near][:, ::-1].T, 1e-12)
    return values, errors


def scatter_text(modes: ModeSet, mode: int) -> list[str]:
    """Return the scatter of a mode over tests of one fit in %: of frequency, and of damping."""
    if modes.scatter is None:
        return []
    return [
        "one test" if np.isnan(value) else numeral(100.0 * value, 2)
        for value in modes.scatter[:, mode]
    ]
