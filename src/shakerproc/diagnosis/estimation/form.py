"""The form of the residual in which hypotheses are compared: whole tests, or windows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.noise import EXCESS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, fit, fit_plainly
from shakerproc.diagnosis.estimation.parts import FEWEST_BLOCKS, HORIZON, RUN_IN, Windows
from shakerproc.diagnosis.estimation.passed_noise import with_open_numbers, with_passed_noise
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.diagnosis.estimation.stacks import TAPS
from shakerproc.diagnosis.estimation.windows import (
    whole_from_starts,
    whole_stretches,
    whole_tests,
    windows_of,
)
from shakerproc.diagnosis.nudged.ladder import pieces
from shakerproc.errors import DiagnosisError

HORIZONS: Final = (5.0, HORIZON, 50.0)
"""Horizons in periods of the joint's motion (see `Lengths`), beside the whole test."""

ROUNDS: Final = 10
"""Steps of the search at the horizon [-]."""

BEST_ROUNDS: Final = 30
"""The same for the best hypothesis, by which the others and the horizon are judged: valleys of
friction are long [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Form:
    """The form of the residual in which hypotheses are compared.

    Attributes
    ----------
    horizon : float or None
        Length of the windows [s]; None where whole tests are predicted.
    fitted, scored_fitted, held_out : Windows
        What is fitted to, the same as it is scored, and what was held out.
    beyond : tuple of Form
        Longer ones, the first of which noise lets predict, though the best that was tried did
        not.
    """

    horizon: float | None
    fitted: Windows
    scored_fitted: Windows
    held_out: Windows
    beyond: "tuple[Form, ...]" = ()

    def knowing(self, data: DataSet, found: Fit) -> "Form":
        """Return the form with what noise of the input becomes in the motion of a fit."""
        scored = with_passed_noise(data, found, self.scored_fitted)
        alike = np.array_equal(self.fitted.table, scored.table)
        return replace(
            self,
            fitted=replace(self.fitted, passed=scored.passed)
            if alike
            else with_passed_noise(data, found, self.fitted),
            scored_fitted=scored,
            held_out=with_passed_noise(data, found, self.held_out),
        )

    def told_by(self, data: DataSet, there: Fit) -> "Form":
        """Return the form with what a fit to it leaves open of its numbers."""
        return replace(self, held_out=with_open_numbers(data, there, self.held_out))

    def starts_of(self, data: DataSet, found: Fit) -> FloatArray | None:
        """Return starts of what is fitted to, each told by the first periods of its window.

        A start that is fitted to a whole window at once may stay in another well, or on the
        other side of a wall, than the measured motion was. None where a fit does not follow
        the motion, or where windows begin at rest.
        """
        return self.told_starts(data, found) if found.follows_most else None

    def told_starts(self, data: DataSet, found: Fit) -> FloatArray | None:
        """Return the same, whatever the fit leaves; None where windows begin at rest."""
        if self.scored_fitted.run_in is None:
            return None
        settled = with_starts_fitted(data, found, self.scored_fitted)
        return None if settled is None else settled.starts


def carried(
    data: DataSet, found: Fit, forms: Sequence[Form], *, rounds: int = ROUNDS,
    begun: bool = False,
) -> Fit | None:  # fmt: skip
    """Return a fit carried over to one form after the other; None where it runs away.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        On shorter windows.
    forms : sequence of Form
        The next ones, the shorter first: a long one alone is full of local minima.
    rounds : int
        Steps at each.
    begun : bool
        Whether it is a start, whose windows begin where its numbers tell, whatever it leaves.
        Measured starts are off by noise, which grows in a long window, and numbers that are
        right would move first to make up for it.
    """
    here: Fit | None = found
    for form in forms:
        if here is not None and len(form.fitted):
            told = form.told_starts(data, here) if begun else form.starts_of(data, here)
            here = fit(
                data, here.hypothesis, here.x, form.fitted, rounds=rounds,
                channels=here.channels, starts=told,
            )  # fmt: skip
    return here


def arrived(data: DataSet, found: Fit, form: Form, *, rounds: int = BEST_ROUNDS) -> Fit | None:
    """Return the best fit carried over to a form; what is rarely exercised fitted, too.

    The cost is logarithmic: a few blocks that leave far more than noise do not rule it. That
    may be where motions part, or where alone a number shows: the force at which all slips, say.
    There plain squares lead, and what they lead to is taken if it leaves less.

    Parameters
    ----------
    data, found, rounds
        As for `carried`.
    form : Form
        What it is carried over to.
    """
    there = carried(data, found, [form], rounds=rounds)
    if there is None or not there.follows_most or there.chi_square <= EXCESS**2:
        return there
    plain = fit_plainly(there, rounds=ROUNDS)
    if plain is None or plain.level >= there.level:
        return there
    again = fit(
        data, plain.hypothesis, plain.x, form.fitted, rounds=rounds, channels=plain.channels,
        starts=plain.starts,
    )  # fmt: skip
    return again if again is not None and again.level < there.level else there


def forms_of(data: DataSet) -> list[Form]:
    """Return windows of every horizon, and whole tests or parts of them.

    Whole tests where they begin at rest; else what is fitted to, and what was held out, each
    stretch with a start of its own, and at last whole tests, each with one start. Of structures
    the longest alone.
    """
    if data.model.structures:
        return [_of_structures(data)]
    rate = data.tests[0].sample_rate
    found = []
    for periods in HORIZONS:
        length_s = (periods + RUN_IN) * data.lengths.unit_s
        length, run_in = TAPS + int(length_s * rate), _run_in(data, length_s)
        fitted, scored, held_out = (
            windows_of(data, length, held_out=kept, most=most, run_in=own)
            for kept, most, own in ((False, 40, 0), (False, 40, run_in), (True, 80, run_in))
        )
        found.append(Form(length / rate, fitted, scored, held_out))
    if all(test.at_rest for test in data.tests):
        whole = whole_tests(data, held_out=False)
        return [*found, Form(None, whole, whole, whole_tests(data, held_out=True))]
    for parts_of in (whole_stretches, whole_from_starts):
        longest_s = max((f.horizon or 0.0 for f in found if _judges(f)), default=0.0)
        run_in = _run_in(data, longest_s)
        fitted, scored, held_out = (
            parts_of(data, held_out=kept, run_in=own)
            for kept, own in ((False, 0), (False, run_in), (True, run_in))
        )
        parts = (fitted, scored, held_out)
        sizes = [int(part.table[:, 2].min()) for part in parts if len(part)]
        shortest_s = min(sizes, default=0) / rate
        if shortest_s > longest_s:
            found.append(Form(shortest_s, fitted, scored, held_out))
    return found


def usable_forms(data: DataSet) -> list[Form]:
    """Return the horizons at which something is fitted to and something held out.

    Raises
    ------
    DiagnosisError
        If the tests are too short for any.
    """
    held = [f for f in forms_of(data) if _holds(f.fitted) and _holds(f.held_out)]
    forms = [f for f in held if _blocks(data, f.held_out) >= FEWEST_BLOCKS] or held[:1]
    if not forms:
        raise DiagnosisError(
            f"{data.model.title}: the tests are too short, or their drive repeats "
            "itself too often, to fit to one part and judge by another; record two seconds at "
            "least, or mark another test hold_out: true."
        )
    return forms


def _holds(windows: Windows) -> bool:
    """Return whether windows hold more than the filter of the residual takes."""
    return len(windows) > 0 and int(windows.table[:, 2].min()) > 2 * TAPS


def _blocks(data: DataSet, windows: Windows) -> int:
    """Return how many blocks windows are scored in."""
    block = data.lengths.block_s * data.tests[0].sample_rate
    return sum(max(1, round(float(size) / block)) for size in windows.table[:, 2])


def _judges(form: Form) -> bool:
    """Return whether something is fitted and something held out."""
    return min(len(form.fitted), len(form.held_out)) > 0


def _of_structures(data: DataSet) -> Form:
    """Return whole tests, or their parts: held at first, until the start is forgotten.

    A start of every mode has more numbers than sensors tell.
    """
    if all(test.at_rest for test in data.tests):
        whole = whole_tests(data, held_out=False)
        return Form(None, whole, whole, whole_tests(data, held_out=True))
    fitted, held_out = (pieces(data, 0.0, 1.0, held_out=kept) for kept in (False, True))
    sizes = [int(mask.sum()) for mask in (*fitted.counted, *held_out.counted)]
    return Form(min(sizes, default=0) / data.tests[0].sample_rate, fitted, fitted, held_out)


def _run_in(data: DataSet, length_s: float) -> int:
    """Return the samples of a window that tell its start."""
    return TAPS + int(data.lengths.run_in_s(length_s) * data.tests[0].sample_rate)
