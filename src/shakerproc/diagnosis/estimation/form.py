"""The form of the residual in which hypotheses are compared: whole tests, or windows."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, final

from shakerproc.diagnosis.estimation.data_set import HORIZON, RUN_IN, DataSet, Windows
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.estimation.passed_noise import with_passed_noise
from shakerproc.diagnosis.estimation.stacks import TAPS
from shakerproc.diagnosis.estimation.windows import whole_tests, windows_of

HORIZONS: Final = (5.0, HORIZON, 50.0)
"""Horizons in periods of the joint's motion (see `DataSet.unit_s`), beside the whole test."""

ROUNDS: Final = 10
"""Steps of the search at the horizon [-]."""


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
    """

    horizon: float | None
    fitted: Windows
    scored_fitted: Windows
    held_out: Windows

    def knowing(self, data: DataSet, found: Fit) -> "Form":
        """Return the form with what noise of the input becomes in the motion of a fit."""
        fitted = with_passed_noise(data, found, self.fitted)
        alike = self.scored_fitted is self.fitted
        return replace(
            self,
            fitted=fitted,
            scored_fitted=fitted
            if alike
            else with_passed_noise(data, found, self.scored_fitted),
            held_out=with_passed_noise(data, found, self.held_out),
        )


def carried(data: DataSet, found: Fit, forms: Sequence[Form]) -> Fit | None:
    """Return a fit carried over to one form after the other; None where it runs away.

    Parameters
    ----------
    data : DataSet
        The tests.
    found : Fit
        On shorter windows.
    forms : sequence of Form
        The next ones, the shorter first: a long one alone is full of local minima.
    """
    here: Fit | None = found
    for form in forms:
        if here is not None and len(form.fitted):
            here = fit(
                data, here.hypothesis, here.x, form.fitted, rounds=ROUNDS,
                channels=here.channels,
            )  # fmt: skip
    return here


def forms_of(data: DataSet) -> list[Form]:
    """Return windows of every horizon, and whole tests where they begin at rest."""
    rate = data.tests[0].sample_rate
    found = []
    for periods in HORIZONS:
        length_s = (periods + RUN_IN) * data.unit_s
        run_in = TAPS + int(data.run_in_s(length_s) * rate)
        length = TAPS + int(length_s * rate)
        parts = [
            windows_of(data, length, held_out=kept, most=most, run_in=own)
            for kept, most, own in ((False, 40, 0), (False, 40, run_in), (True, 80, run_in))
        ]
        found.append(Form(length / rate, *parts))
    if all(test.at_rest for test in data.tests):
        whole = whole_tests(data, held_out=False)
        found.append(Form(None, whole, whole, whole_tests(data, held_out=True)))
    return found
