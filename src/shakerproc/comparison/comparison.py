"""A model compared with a campaign: where and by how much they disagree."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.comparison.bands import BandErrors, band_errors
from shakerproc.comparison.drift import TimeErrors, time_errors
from shakerproc.comparison.errors import Pair, SensorErrors, errors_of, pair_of
from shakerproc.comparison.floor import (
    Floor,
    density_of,
    floor_draws,
    floor_of,
    with_more_refuted,
)
from shakerproc.comparison.free_run_error import Scored, free_run_error, pooled
from shakerproc.comparison.harmonics import HarmonicErrors, harmonic_errors
from shakerproc.comparison.held_out import held_out as held_out_of
from shakerproc.comparison.joints import JointMotion, NotTold, joint_motions
from shakerproc.comparison.measured import Measured, usable_tests, with_repeats
from shakerproc.comparison.noise import NOT_REFUTED
from shakerproc.comparison.prediction import Prediction, predict
from shakerproc.comparison.refit import Refit, refit
from shakerproc.comparison.sensors import check_driven
from shakerproc.comparison.windows import EvenWindows
from shakerproc.models import Model
from shakerproc.testlog import TestLog

NOTED: Final = 0.01
"""Constant of a force over its rms from which on it is told [-]."""

_EXCHANGED = -0.6  # correlation of the logarithms of measured and predicted gains
_LEAST_SPREAD = 0.25  # spread of the logarithms of gains, below which they tell nothing
_LEAST_COHERENCE = 0.5  # coherence below which a gain is noise
_FEWEST_BINS = 12  # bins
_SOURCES = 5  # of noise, one after the other, and what a model leaves of the last


@final
@dataclass(frozen=True, eq=False)
class TestComparison:
    """One test.

    Attributes
    ----------
    model : Model
        The model.
    prediction : Prediction
        What was measured and what the model says.
    floor : Floor
        Noise of the test.
    """

    __test__ = False
    model: Model
    prediction: Prediction
    floor: Floor

    @cached_property
    def pair(self) -> Pair:
        """Spectra of what was measured and of what the model says."""
        return pair_of(self.prediction)

    @cached_property
    def errors(self) -> tuple[SensorErrors, ...]:
        """Errors of every sensor."""
        return errors_of(self.prediction, self.pair)

    @cached_property
    def harmonics(self) -> tuple[HarmonicErrors, ...] | None:
        """Harmonics of every sensor, in sweeps and at tones."""
        return harmonic_errors(self.prediction)

    @cached_property
    def time(self) -> TimeErrors:
        """Error along the test."""
        return time_errors(self.prediction)

    @cached_property
    def _motions(self) -> tuple[tuple[JointMotion, ...], tuple[NotTold, ...]]:
        return joint_motions(self.model, self.measured)

    @property
    def joints(self) -> tuple[JointMotion, ...]:
        """Force and motion of every joint of which the recordings tell both."""
        return self._motions[0]

    @property
    def not_told(self) -> tuple[NotTold, ...]:
        """The other joints, and what the recordings lack."""
        return self._motions[1]

    @property
    def measured(self) -> Measured:
        """The test as it was measured."""
        return self.prediction.measured

    @property
    def notes(self) -> tuple[str, ...]:
        """The constant that was fitted beside the force, where it is more than a hundredth."""
        own, given = self.prediction.own, self.measured.input
        rms = float(np.sqrt(np.mean(given**2)))
        if not abs(own.constant) > NOTED * rms:
            return ()
        return (
            f"{self.measured.run}: a constant of {own.constant / rms:+.0%} of its rms was "
            "fitted to the force, whose mean was taken off: the mean of a recording is no "
            "offset.",
        )

    @property
    def error(self) -> float:
        """The free-run error of the test [-]."""
        return free_run_error([self.prediction.scored])

    @property
    def noise(self) -> float:
        """The floor of the test's error; not a number where its noise is unknown [-]."""
        return pooled([self.floor.share])


@final
@dataclass(frozen=True, eq=False)
class Comparison:
    """A model compared with a campaign.

    Attributes
    ----------
    model : Model
        The model, refitted if that was asked.
    tests : tuple of TestComparison
        In the order of the log.
    refit : Refit, optional
        The fit that came first.
    left_out : tuple of str
        Which tests took no part since a channel did not measure, a sentence each.
    """

    model: Model
    tests: tuple[TestComparison, ...]
    refit: Refit | None
    left_out: tuple[str, ...] = ()

    @cached_property
    def bands(self) -> BandErrors:
        """Where in frequency the model fails."""
        tests = self.tests
        return band_errors(
            [t.prediction for t in tests], [t.pair for t in tests],
            [density_of(t.prediction, t.pair) for t in tests],
        )  # fmt: skip

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What looks wrong with the log, a sentence each."""
        return exchanged(self.model, [(t.prediction, t.pair) for t in self.tests])

    @property
    def error(self) -> float:
        """The free-run error over all tests [-]."""
        return free_run_error([test.prediction.scored for test in self.tests])

    @property
    def noise(self) -> float:
        """The floor of that error; not a number where noise is unknown [-]."""
        return pooled([test.floor.share for test in self.tests])

    @property
    def held_out(self) -> float | None:
        """The free-run error over what is held out; None where nothing is [-]."""
        kept = self.scored_held_out
        return free_run_error(kept) if any(test.counted.any() for test in kept) else None

    @property
    def fitted(self) -> float | None:
        """The free-run error over what is not held out; None where all is [-]."""
        rest = self._scored(held_out=False)
        return free_run_error(rest) if any(test.counted.any() for test in rest) else None

    @property
    def held_out_noise(self) -> float | None:
        """The floor of the error over what is held out; None where nothing is [-]."""
        kept = [
            test.floor.share
            for test, scored in zip(self.tests, self.scored_held_out, strict=True)
            if scored.counted.any()
        ]
        return pooled(kept) if kept else None

    @property
    def scored_held_out(self) -> tuple[Scored, ...]:
        """Scored part of every test: tests that the log marks, else blocks of each."""
        return self._scored(held_out=True)

    def _scored(self, *, held_out: bool) -> tuple[Scored, ...]:
        """Return every test with what is held out of it, or all but that."""
        kept = held_out_of([test.measured for test in self.tests])
        return tuple(
            test.prediction.scored.within(inside == held_out)
            for test, inside in zip(self.tests, kept, strict=True)
        )

    @property
    def windows(self) -> dict[str, EvenWindows]:
        """Windows of the tests whose motion is predicted in windows, by their names."""
        found = {test.measured.name: test.prediction.windows for test in self.tests}
        return {name: windows for name, windows in found.items() if windows is not None}


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
        The model; its sensors name the channels they are compared with.
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
    windows: Mapping[str, EvenWindows] = MappingProxyType({}),
    tell: Callable[[str], None] = lambda _: None,
) -> Comparison:
    """Return the comparison of tests that are in memory.

    `windows` are those of another model, by the name of the test, so that both models are
    scored alike.
    """
    check_driven(model)
    fitted = None
    if fit:
        fitted = refit(model, tests, tell)
        model = fitted.model
    compared = [_compared(model, test, windows.get(test.name), tell) for test in tests]
    compared = _with_next_floors(model, compared, tests)
    return Comparison(model, tuple(compared), fitted, tuple(left_out))


def _compared(
    model: Model, test: Measured, windows: EvenWindows | None, tell: Callable[[str], None]
) -> TestComparison:
    tell(f"test {test.name}")
    prediction = predict(model, test, windows=windows)
    return TestComparison(model, prediction, floor_of(prediction))


def _with_next_floors(
    model: Model, compared: Sequence[TestComparison], tests: Sequence[Measured]
) -> list[TestComparison]:
    """Return the tests with floors that no error refutes on what is held out of the fit."""
    kept = held_out_of(tests)
    refuted = dict.fromkeys((test.name for test in tests), NOT_REFUTED)
    found = list(compared)
    for _ in range(_SOURCES):
        before = dict(refuted)
        for test, one, inside in zip(tests, found, kept, strict=True):
            if inside.any():
                part, noise = one.prediction.scored.within(inside), one.measured.noise
                draws = floor_draws(part, noise, one.prediction.moved)
                refuted[test.name] = with_more_refuted(part, noise, draws, before[test.name])
        if refuted == before:
            break
        measured = with_repeats(tests, refuted)
        for i, test in enumerate(tests):
            more, less = refuted[test.name], before[test.name]
            if more != less:
                prediction = replace(found[i].prediction, measured=measured[i])
                if (more.inputs, more.share) != (less.inputs, less.share):
                    prediction = predict(model, measured[i], windows=prediction.windows)
                found[i] = replace(
                    found[i], prediction=prediction, floor=floor_of(prediction, more)
                )
    return found


def exchanged(model: Model, both: Sequence[tuple[Prediction, Pair]]) -> tuple[str, ...]:
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


def scored_alike(
    *comparisons: Comparison, tell: Callable[[str], None] = lambda _: None
) -> tuple[Comparison, ...]:
    """Return comparisons of which each test is scored in the same windows for every model.

    Where the motion of one model cannot be predicted for a whole test, the others are scored in
    its windows too; of several, the shortest count.

    Parameters
    ----------
    comparisons : Comparison
        Of one model each, with the same tests.
    tell : callable
        Told what is going on.
    """
    shared: dict[str, EvenWindows] = {}
    for found in comparisons:
        for name, windows in found.windows.items():
            if name not in shared or windows.n_samples < shared[name].n_samples:
                shared[name] = windows
    return tuple(_in_windows(found, shared, tell) for found in comparisons)


def _in_windows(
    found: Comparison, shared: dict[str, EvenWindows], tell: Callable[[str], None]
) -> Comparison:
    own = found.windows
    if all(own.get(name) is windows for name, windows in shared.items()):
        return found
    again = compare_tests(
        found.model, [test.measured for test in found.tests], left_out=found.left_out,
        windows=shared, tell=tell,
    )  # fmt: skip
    return replace(again, refit=found.refit)
