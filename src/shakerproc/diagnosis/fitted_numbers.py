"""Numbers of a model as tests tell them, with their covariance."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.comparison.measured import Measured
from shakerproc.data import FloatArray
from shakerproc.diagnosis.campaign import campaign_of, own_numbers
from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.data.from_files import arrays
from shakerproc.diagnosis.estimation.form import ROUNDS
from shakerproc.diagnosis.estimation.intervals import linear_estimates
from shakerproc.diagnosis.estimation.least_squares import Fit, fit
from shakerproc.diagnosis.horizon import compared
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import DiagnosisError, ModelError
from shakerproc.models import Model

HALVINGS: Final = 20
"""How often a drawn step is halved until a model can have its numbers [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class FittedNumbers:
    """A model with its numbers fitted to tests, and what these leave open.

    Attributes
    ----------
    hypothesis : Hypothesis
        The model, whose numbers are free but for references.
    x : (n_x,) array
        Logarithms of the fitted numbers over those of the file [-].
    gain : (n_sensors,) array
        Gain of each sensor [-].
    covariance : (n_x + n_sensors, n_x + n_sensors) array
        Of both: scatter of the tests, calibration, and what no test tells [-].
    untold : tuple of str
        Numbers that no test tells.
    """

    hypothesis: Hypothesis
    x: FloatArray
    gain: FloatArray
    covariance: FloatArray
    untold: tuple[str, ...]

    @property
    def model(self) -> Model:
        """The model with the fitted numbers."""
        return self.hypothesis.model_at(self.x)

    def drawn(
        self, count: int, generator: np.random.Generator
    ) -> list[tuple[Model, FloatArray]]:
        """Return models and gains of the sensors, drawn from the covariance.

        Parameters
        ----------
        count : int
            How many.
        generator : numpy.random.Generator
            Where the randomness comes from.
        """
        power, directions = np.linalg.eigh(0.5 * (self.covariance + self.covariance.T))
        normal = generator.standard_normal((count, power.size))
        steps = (normal * np.sqrt(np.maximum(power, 0.0))) @ directions.T
        n = self.x.size
        return [(self._moved(step[:n]), self.gain + step[n:]) for step in steps]

    def _moved(self, step: FloatArray) -> Model:
        """Return the model a step away, the step halved until one can have its numbers."""
        low, high = self.hypothesis.bounds()
        for halved in 0.5 ** np.arange(HALVINGS):
            try:
                return self.hypothesis.model_at(np.clip(self.x + halved * step, low, high))
            except ModelError:
                continue
        return self.model


def fit_of(
    model: Model, tests: Sequence[Measured], say: Callable[[str], None] = lambda _text: None
) -> Fit:
    """Return the fit of a model's numbers to tests, as `diagnose` fits them before effects.

    Parameters
    ----------
    model : Model
        The model, whose effects stay what they are.
    tests : sequence of Measured
        Those that may be fitted to.
    say : callable
        Called with what is being done.

    Raises
    ------
    DiagnosisError
        If the motion runs away, or the tests are too short.
    """
    say(f"numbers fitted to test {', '.join(test.name for test in tests)}")
    known = replace(model, sensors={name: model.sensors[name] for name in tests[0].sensors})
    campaign = campaign_of(known, prepared([arrays(test) for test in tests]))
    _, _, alone, _ = compared(campaign, own_numbers(campaign), [])
    if not np.all(np.isfinite(alone.logs)):
        raise DiagnosisError(f"{model.title}: its motion runs away in what was held out.")
    return alone.fit


def fit_to_fewer(found: Fit, counted: Sequence[bool]) -> Fit | None:
    """Return a fit that goes on with fewer of its tests, as far ahead as all can be predicted.

    Parameters
    ----------
    found : Fit
        To all tests.
    counted : sequence of bool
        Which of them count, in their order.

    Returns
    -------
    Fit or None
        The same where all count; None where these are too short for the horizon, or the
        motion runs away.
    """
    which = np.flatnonzero(np.array(counted)[found.windows.table[:, 0]])
    if which.size == len(found.windows):
        return found
    if not which.size:
        return None
    return fit(
        found.data, found.hypothesis, found.x, found.windows.chosen(which), rounds=ROUNDS,
        channels=found.channels, starts=None if found.starts is None else found.starts[which],
    )  # fmt: skip


def numbers_of(found: Fit) -> FittedNumbers:
    """Return the numbers of a fit, with what the tests leave open of them."""
    size = found.x.size + found.gain.size
    untold = tuple(name for name, one in linear_estimates(found).items() if one.low is None)
    covariance = found.uncertainty.total[:size, :size]
    return FittedNumbers(found.hypothesis, found.x, found.gain, covariance, untold)
