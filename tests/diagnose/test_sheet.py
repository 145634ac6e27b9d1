"""The screening sheet against least squares on the columns themselves."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from shakerproc.diagnose.candidates import Motion, library
from shakerproc.diagnose.sheet import Entry, Sheet, freed, pairs, singles
from shakerproc.diagnose.structure import Joint, Sensing, Structure

N = 600
SINGLE = ("cubic_stiffness", "quadratic_damping", "gap", "jenkins", "contact_damping")


@pytest.fixture(scope="module")
def made():
    """A sheet of random columns; the second and the last are hidden in the residual."""
    rng = np.random.default_rng(3)
    structure = Structure(np.array([0.1]), (Joint(-1, 0, 4e4, 3.0),), (Sensing(0, 2, True),))
    base = rng.standard_normal((2, N))
    motion = Motion(1e-3, 3e-4, 0.2, 4e4, 3.0, 0.1, 100.0, 0.0, 1.0)
    kinds = {candidate.kind: candidate for candidate in library(motion)}
    entries, columns = [], []
    for kind in SINGLE:
        for inner in kinds[kind].grid(motion)[:3]:
            at = len(columns)
            entries.append(Entry(kinds[kind], 0, motion, inner, slice(at, at + 1)))
            columns.append(rng.standard_normal(N) * 10.0 ** rng.uniform(-9.0, 3.0))
    columns = np.array(columns) + 0.3 * rng.standard_normal((len(columns), 2)) @ base
    residual = base.T @ [0.02, -0.1] + 0.3 * rng.standard_normal(N)
    hidden = (1, len(columns) - 1)
    for i in hidden:
        residual = residual + columns[i] / np.linalg.norm(columns[i]) * 30.0
    inverse = np.linalg.inv(base @ base.T)
    weights = inverse @ base @ residual
    regression = SimpleNamespace(
        structure=structure, base=base, inverse=inverse, weights=weights,
        left=residual - weights @ base,
    )  # fmt: skip
    unit, shared, length = freed(columns, regression)
    sheet = Sheet(
        regression, tuple(entries), unit @ unit.T, unit @ regression.left, length, shared
    )
    return sheet, columns, residual, hidden


def solved(sheet, columns, residual):
    """Coefficients and cost of least squares on the linear columns and these."""
    table = np.vstack([sheet.regression.base, columns]).T
    found, *_ = np.linalg.lstsq(table, residual, rcond=None)
    return found, float(np.sum((residual - table @ found) ** 2))


def test_the_best_pair_is_the_hidden_one_with_the_gain_of_least_squares(made):
    sheet, columns, residual, hidden = made
    best = pairs(sheet)[0]
    kinds = {sheet.entries[i].candidate.kind for i in hidden}
    assert {part.candidate.kind for part in best.parts} == kinds
    alone = solved(sheet, columns[:0], residual)[1]
    found, cost = solved(sheet, columns[list(hidden)], residual)
    assert_allclose(best.gain, alone - cost, rtol=1e-6)
    assert_allclose(best.stiffness[0], 4e4 * (1.0 + found[0]), rtol=1e-6)
    assert_allclose(best.damping[0], 3.0 * (1.0 + found[1]), rtol=1e-6)
    fitted = {part.candidate.kind: part.values[0] for part in best.parts}
    for coefficient, i in zip(found[2:], hidden, strict=True):
        assert_allclose(fitted[sheet.entries[i].candidate.kind], coefficient, rtol=1e-6)


def test_every_pair_of_two_kinds_gains_what_least_squares_gains(made):
    sheet, columns, residual, _ = made
    alone = solved(sheet, columns[:0], residual)[1]
    for start in pairs(sheet):
        at = [
            next(
                i for i, e in enumerate(sheet.entries)
                if e.candidate is part.candidate and e.inner == part.values[1:]
            )
            for part in start.parts
        ]  # fmt: skip
        assert_allclose(start.gain, alone - solved(sheet, columns[at], residual)[1], rtol=1e-5)


def test_single_starts_gain_what_least_squares_gains(made):
    sheet, columns, residual, _ = made
    alone = solved(sheet, columns[:0], residual)[1]
    for start in singles(sheet):
        at = next(
            i for i, e in enumerate(sheet.entries)
            if e.candidate is start.last.candidate and e.inner == start.last.values[1:]
        )  # fmt: skip
        assert_allclose(
            start.gain, alone - solved(sheet, columns[[at]], residual)[1], rtol=1e-5
        )


def test_two_laws_of_one_kind_are_no_pair():
    motion = Motion(1e-3, 3e-4, 0.2, 4e4, 3.0, 0.1, 100.0, 0.0, 1.0)
    kinds = {candidate.kind: candidate for candidate in library(motion)}
    rng = np.random.default_rng(4)
    columns = rng.standard_normal((2, N))
    entries = tuple(
        Entry(kinds[kind], 0, motion, (1e-4,), slice(i, i + 1))
        for i, kind in enumerate(("jenkins", "iwan"))
    )
    regression = SimpleNamespace(
        structure=Structure(np.array([0.1]), (Joint(-1, 0, 4e4, 3.0),), ()),
        base=np.zeros((2, N)), inverse=np.zeros((2, 2)), weights=np.zeros(2),
        left=columns.sum(axis=0),
    )  # fmt: skip
    unit, shared, length = freed(columns, regression)
    right = unit @ regression.left
    assert not pairs(Sheet(regression, entries, unit @ unit.T, right, length, shared))
