"""Residuals of windows under given numbers, without a fit."""

from shakerproc.data import FloatArray
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.least_squares import Fit, perfect
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.point import Channels
from shakerproc.diagnosis.estimation.residual_slopes import Linearisation
from shakerproc.diagnosis.estimation.window_starts import with_place_told
from shakerproc.diagnosis.hypotheses.hypothesis import Hypothesis
from shakerproc.errors import ModelError


def level_at(
    data: DataSet,
    hypothesis: Hypothesis,
    x: FloatArray,
    windows: Windows,
    channels: Channels | None = None,
) -> float:
    """Return the level of the residual (see `Fit`) of numbers as they are; infinite if none.

    Windows begin where the forces of the hypothesis let them.

    Parameters
    ----------
    data, hypothesis, x, windows, channels
        As for `fit`.
    """
    linearisation = Linearisation(data, hypothesis, windows)
    try:
        here = linearisation.point(x, channels or perfect(data))
        state = linearisation.residual(here)
    except ModelError:
        return float("inf")
    if state is None:
        return float("inf")
    here, state = with_place_told(linearisation, here, state)
    return linearisation.level(state[0], here)


def predicted_rows(data: DataSet, found: Fit, windows: Windows) -> FloatArray | None:
    """Return the mean square of the residual over the noise in every block [-]."""
    linearisation = Linearisation(data, found.hypothesis, windows)
    here = linearisation.point_with(found.x, found.channels, found.starts)
    state = linearisation.residual(here)
    return None if state is None else linearisation.blocks(state[0], here)
