"""Whether a verdict holds on every test by itself, whether it was fitted or held out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from shakerproc.comparison.floor import over_draws, sensor_shares
from shakerproc.comparison.free_run_error import (
    Scored,
    fall,
    free_run_error,
    pooled,
    standard_error,
)
from shakerproc.comparison.noise import EXCESS, Noise
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.least_squares import Fit
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.found import Found
from shakerproc.diagnosis.selection.choice import (
    NEGLIGIBLE,
    TENTH,
    bare,
    leaves_more,
    standing_of,
)
from shakerproc.diagnosis.selection.errors import floors_of, scored_tests
from shakerproc.diagnosis.selection.scores import SURE, Score


@final
@dataclass(frozen=True, slots=True)
class OneTest:
    """Error of a model in one test, where a verdict on all tests hides it.

    Attributes
    ----------
    name : str
        Name of the test.
    fitted : bool
        Whether that is of what was fitted; else of what was held out.
    error, floor : float
        What is left, and what noise alone would leave [-].
    instead_of : tuple of str
        Tests that are marked as held out.
    """

    name: str
    fitted: bool
    error: float
    floor: float
    instead_of: tuple[str, ...]


Simulated: TypeAlias = Sequence[Mapping[int, Scored] | None]
"""Tests as a hypothesis simulates them, what was fitted and what was held out."""


def simulated_by(data: DataSet, form: Form, fit: Fit) -> Simulated:
    """Return tests as a fit simulates them in a form (see `scored_tests`)."""
    return [scored_tests(data, fit, part) for part in (form.scored_fitted, form.held_out)]


def unexplained_tests(found: Found, score: Score, simulated: Simulated) -> list[OneTest]:
    """Return the tests of which a hypothesis surely leaves more than noise, the worst first.

    By the rule of the whole: more than noise and what it becomes in the model, by three
    standard errors, and more than sensors are calibrated to.
    """
    out = []
    for (windows, fitted), own_part in zip(_parts(found), simulated, strict=True):
        scored = own_part or {}
        own = {i: pooled([sensor_shares(one, _noise(found, i))]) for i, one in scored.items()}
        suspect = {i: one for i, one in scored.items() if _exceeds(one, own[i])}
        for i, floor in (_floors(found, score, windows) if suspect else {}).items():
            if i in suspect and _exceeds(suspect[i], floor):
                out.append(_told(found, i, suspect[i], floor, fitted=fitted))
    return sorted(out, key=lambda one: one.floor / one.error)


def doubtful(found: Found) -> bool:
    """Return whether what stands leaves noise of what was held out, but more of a test.

    Of one that it was fitted to: what was held out may not exercise all that is missing.
    """
    standing = standing_of(found)
    chosen = standing[0] if standing else bare(found)
    if leaves_more(found, chosen):
        return False
    simulated = simulated_by(found.data, found.form, chosen.fit)
    return bool(unexplained_tests(found, chosen, simulated))


def shown_by_one(found: Found, simulated: Simulated) -> OneTest | None:
    """Return the test that alone shows what was chosen; None where another may, or one is all.

    A test shows it where its error surely falls, by a tenth at least, from the model that
    stands without any effect, and does not where it surely falls by less. `simulated` is by
    what was chosen.
    """
    shown: dict[int, tuple[Scored, bool]] = {}
    seen, unsure = set[int](), set[int]()
    without = simulated_by(found.data, found.form, bare(found).fit)
    for (_, fitted), one, other in zip(_parts(found), without, simulated, strict=True):
        before, after = one or {}, other or {}
        for i in before.keys() & after.keys():
            seen.add(i)
            less, spread = fall((before[i],), (after[i],))
            tenth = TENTH * free_run_error([before[i]])
            if less > max(SURE * spread, tenth):
                shown.setdefault(i, (after[i], fitted))
            elif less + SURE * spread > tenth:
                unsure.add(i)
    if len(shown) != 1 or len(seen) < 2 or unsure - shown.keys():
        return None
    (i, (scored, fitted)), *_ = shown.items()
    return _told(found, i, scored, float("nan"), fitted=fitted)


def _parts(found: Found) -> tuple[tuple[Windows, bool], ...]:
    """Return the fitted part, then the held-out part."""
    return (found.form.scored_fitted, True), (found.form.held_out, False)


def _noise(found: Found, test: int) -> Noise:
    return found.data.tests[test].noise_density


def _floors(found: Found, score: Score, windows: Windows) -> Mapping[int, float]:
    """Return the error that noise alone would leave of each test [-]."""
    held_out = windows is found.form.held_out
    floors = (
        found.floors_under(score) if held_out else floors_of(found.data, score.fit, windows)
    )
    return {i: pooled([over_draws(draws)]) for i, draws in floors.items()}


def _exceeds(test: Scored, floor: float) -> bool:
    """Return whether an error is surely more than a noise floor, and than calibration."""
    error = free_run_error([test])
    if not (np.isfinite(floor) and error > max(NEGLIGIBLE, EXCESS * floor)):
        return False
    return error - SURE * standard_error([test]) > EXCESS * floor


def _told(found: Found, test: int, scored: Scored, floor: float, *, fitted: bool) -> OneTest:
    marked = [one.name for one in found.data.tests if one.arrays.hold_out]
    error = free_run_error([scored])
    return OneTest(found.data.tests[test].name, fitted, error, floor, tuple(marked))
