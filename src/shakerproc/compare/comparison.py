"""A model held against a campaign: everything by which they part."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from shakerproc.compare.bands import BandErrors, band_errors
from shakerproc.compare.drift import TimeErrors, time_errors
from shakerproc.compare.errors import Pair, SensorErrors, errors_of, pair_of
from shakerproc.compare.floor import Floor, floors_of
from shakerproc.compare.harmonics import HarmonicErrors, harmonic_errors
from shakerproc.compare.joints import JointMotion, joint_motions
from shakerproc.compare.measured import Measured, usable_tests
from shakerproc.compare.prediction import Prediction, predict
from shakerproc.compare.refit import Refit, refit
from shakerproc.models import Model
from shakerproc.testlog import TestLog

_EXCHANGED = -0.6  # correlation of the logarithms of measured and predicted gains
_LEAST_SPREAD = 0.25  # spread of the logarithms of gains, below which they tell nothing
_LEAST_COHERENCE = 0.5  # coherence below which a gain is noise
_FEWEST_BINS = 12  # bins


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestComparison:
    """One test.

    Attributes
    ----------
    prediction : Prediction
        What was measured and what the model says.
    pair : Pair
        Their spectra.
    errors : tuple of SensorErrors
        One for every sensor.
    floor : Floor
        Noise of the test.
    harmonics : tuple of HarmonicErrors, optional
        One for every sensor, in sweeps and at tones.
    time : TimeErrors, optional
        Error along the test, where the motion is predictable.
    joints : tuple of JointMotion
        Force and motion of every joint that can be judged.
    """

    __test__ = False
    prediction: Prediction
    pair: Pair
    errors: tuple[SensorErrors, ...]
    floor: Floor
    harmonics: tuple[HarmonicErrors, ...] | None
    time: TimeErrors | None
    joints: tuple[JointMotion, ...]

    @property
    def measured(self) -> Measured:
        """The test as it was measured."""
        return self.prediction.measured

    @property
    def error(self) -> float:
        """Rms over the sensors of their errors [-]."""
        return float(np.sqrt(np.mean([error.error**2 for error in self.errors])))

    @property
    def noise(self) -> float:
        """Rms over the sensors of their noise; not a number where it is unknown [-]."""
        return float(np.sqrt(np.mean(self.floor.share**2)))


@final
@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """A model held against a campaign.

    Attributes
    ----------
    model : Model
        The model, refitted if that was asked.
    tests : tuple of TestComparison
        In the order of the log.
    bands : BandErrors
        Where in frequency it fails.
    refit : Refit, optional
        The fit that came first.
    left_out : tuple of str
        Which tests took no part since a channel did not measure, a sentence each.
    warnings : tuple of str
        What looks wrong with the log, a sentence each.
    """

    model: Model
    tests: tuple[TestComparison, ...]
    bands: BandErrors
    refit: Refit | None
    left_out: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def error(self) -> float:
        """Rms over the tests of their errors [-]."""
        return float(np.sqrt(np.mean([test.error**2 for test in self.tests])))

    @property
    def held_out(self) -> float | None:
        """The same over the tests that are held out; None without any [-]."""
        kept = [test.error**2 for test in self.tests if test.measured.test.hold_out]
        return float(np.sqrt(np.mean(kept))) if kept else None


def compare(
    model: Model,
    log: TestLog,
    *,
    fit: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Return where and by how much a model and the tests of a log part.

    Parameters
    ----------
    model : Model
        The model; its sensors name the channels they are held against.
    log : TestLog
        The campaign.
    fit : bool
        Whether to fit the numbers of the model first, to tests that are not held out.
    tell : callable
        Told what is going on.

    Raises
    ------
    DiagnosisError
        If the model and the log do not fit together.
    ShakerprocError
        If a recording cannot be used, or the model runs away.
    """
    usable = usable_tests(log, model)
    return compare_tests(model, usable.tests, left_out=usable.left_out, fit=fit, tell=tell)


def compare_tests(
    model: Model,
    tests: Sequence[Measured],
    *,
    left_out: Sequence[str] = (),
    fit: bool = False,
    tell: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Return the same for tests that are in memory."""
    fitted = None
    if fit:
        fitted = refit(model, tests, tell)
        model = fitted.model
    both = [_spectra(model, test, tell) for test in tests]
    predictions, pairs = [b[0] for b in both], [b[1] for b in both]
    floors = floors_of(predictions, pairs)
    compared = tuple(
        TestComparison(
            prediction=prediction,
            pair=pair,
            errors=errors_of(prediction, pair),
            floor=floor,
            harmonics=harmonic_errors(prediction),
            time=time_errors(prediction),
            joints=joint_motions(model, prediction),
        )
        for prediction, pair, floor in zip(predictions, pairs, floors, strict=True)
    )
    return Comparison(
        model, compared, band_errors(predictions, pairs, floors), fitted, tuple(left_out),
        _exchanged(model, both),
    )  # fmt: skip


def _spectra(
    model: Model, test: Measured, tell: Callable[[str], None]
) -> tuple[Prediction, Pair]:
    tell(f"test {test.name}")
    prediction = predict(model, test)
    return prediction, pair_of(prediction)


def _exchanged(model: Model, both: Sequence[tuple[Prediction, Pair]]) -> tuple[str, ...]:
    """Return a warning for every response that peaks where the model has its dips.

    Only a base that is driven can be taken for a response: both are accelerations.
    """
    if model.excitation.on is not None:
        return ()
    warnings = []
    for prediction, pair in both:
        for i, name in enumerate(prediction.measured.sensors):
            known = np.minimum(pair.coherence[i], pair.coherence_model[i]) > _LEAST_COHERENCE
            used = pair.excited & known
            if np.count_nonzero(used) < _FEWEST_BINS:
                continue
            gain, predicted = (np.log(np.abs(h[i, used])) for h in (pair.h1, pair.h1_model))
            if min(gain.std(), predicted.std()) < _LEAST_SPREAD:
                continue
            correlation = float(np.corrcoef(gain, predicted)[0, 1])
            if correlation < _EXCHANGED:
                warnings.append(
                    f"{prediction.measured.run}: controls and responses may be exchanged: over "
                    f"{gain.size} frequencies the gain of {name} is small where the model's is "
                    f"large (correlation {correlation:.2f}). Check the roles in the log."
                )
    return tuple(warnings)
