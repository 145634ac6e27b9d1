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
from shakerproc.diagnosis.estimation.intervals import linear_estimates
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
        The model, every number of which is free.
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


def fitted_numbers(
    model: Model, tests: Sequence[Measured], say: Callable[[str], None] = lambda _text: None
) -> FittedNumbers:
    """Return a model with its numbers fitted to tests, as `diagnose` fits them before effects.

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
    fit = alone.fit
    if not np.all(np.isfinite(alone.logs)):
        raise DiagnosisError(f"{model.title}: its motion runs away in what was held out.")
    size = fit.x.size + fit.gain.size
    untold = tuple(name for name, one in linear_estimates(fit).items() if one.low is None)
    covariance = fit.uncertainty.total[:size, :size]
    return FittedNumbers(fit.hypothesis, fit.x, fit.gain, covariance, untold)
