"""Result of the search: every hypothesis with its held-out score."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np

from shakerproc.comparison.noise import EXCESS
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.diagnosis.data.sensor_faults import Hum
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import Form
from shakerproc.diagnosis.estimation.hidden_motion import completed
from shakerproc.diagnosis.estimation.least_squares import Fit, perfect
from shakerproc.diagnosis.estimation.levels import predicted_rows
from shakerproc.diagnosis.estimation.linear_model import LinearModel
from shakerproc.diagnosis.estimation.of_tests import as_free
from shakerproc.diagnosis.estimation.parts import Windows
from shakerproc.diagnosis.estimation.run_in import with_starts_fitted
from shakerproc.diagnosis.estimation.windows import whole_tests
from shakerproc.diagnosis.hypotheses.joints import Joint
from shakerproc.diagnosis.selection.errors import error_of, floors_of, pooled_floor
from shakerproc.diagnosis.selection.scores import MOSTLY_NOISE, Score, best_of, ranked, scored


@final
@dataclass(frozen=True, eq=False)
class Found:
    """All that the search found.

    Attributes
    ----------
    data : DataSet
        The tests, as recorded or corrected by what is unusual of the chain of measurement.
    linear_model : LinearModel
        What effects are judged on top of.
    form : Form
        In which hypotheses are compared.
    before : Fit
        The model as it is, nothing fitted.
    linear : Score
        Nothing is missing.
    effects : tuple of Score
        Hypotheses with effects, the best first.
    free : Score, optional
        A force without a name: a smooth table of displacement and velocity.
    behind : tuple of Fit
        Effects that left the race, as they were then.
    failed : mapping of str to str
        Hypotheses that could not be simulated, with the reason.
    corrected : bool
        Whether the tests are corrected.
    rigid : tuple of Joint
        Joints that held in every test; nothing but the linear model was tried then.
    signs : tuple of float
        -1 for each sensor that was found the wrong way round and turned, else 1.
    late : tuple of float
        By how much each sensor was found late and was advanced before all else [s].
    hums : tuple of Hum
        Hum of the mains that was taken away.
    recorded : tuple of PreparedTest
        The tests as recorded; those of `data` where none are given.
    """

    data: DataSet
    linear_model: LinearModel
    form: Form
    before: Fit
    linear: Score
    effects: tuple[Score, ...]
    free: Score | None
    behind: tuple[Fit, ...]
    failed: Mapping[str, str]
    corrected: bool = False
    rigid: tuple[Joint, ...] = ()
    signs: tuple[float, ...] = ()
    late: tuple[float, ...] = ()
    hums: tuple[Hum, ...] = ()
    recorded: tuple[PreparedTest, ...] = ()
    _left: dict[Score, float] = field(default_factory=dict)
    _floors: dict[Score, dict[int, FloatArray]] = field(default_factory=dict)
    _free_runs: dict[Score, Score | None] = field(default_factory=dict)

    def with_effects(self, scores: Sequence[Score]) -> "Found":
        """Return the result with these hypotheses, none of which fell behind."""
        tried = {score.fit.hypothesis.names for score in scores}
        left = tuple(one for one in self.behind if one.hypothesis.names not in tried)
        return replace(self, effects=tuple(ranked(scores)), behind=left)

    @property
    def best(self) -> Score:
        """The hypothesis that predicts best."""
        return best_of((self.linear, *self.effects))

    @cached_property
    def as_recorded(self) -> DataSet:
        """The tests as recorded, nothing turned, advanced or taken away."""
        turned = any(sign < 0.0 for sign in self.signs)
        chain = turned or any(self.late) or self.hums or self.corrected
        changed = chain or self.linear_model.driven
        return replace(self.data, tests=self.recorded) if changed else self.data

    @property
    def left(self) -> float:
        """The held-out error of the best [-]."""
        return self.left_by(self.best)

    @property
    def floor(self) -> float:
        """The error that noise alone makes of the motion of the best; NaN if unknown [-]."""
        return self.floor_under(self.best)

    @property
    def explained(self) -> bool:
        """Whether the best leaves no more than the noise and what it becomes in the model."""
        return self.is_explained_by(self.best)

    @property
    def is_enough(self) -> bool:
        """Whether no more is to be looked for: noise is left of most that was fitted to.

        And noise of what was held out, or of most of it: motions that part in a few places
        leave more there. What was held out alone may not exercise all that is missing.
        """
        best = self.best
        return best.is_mostly_noise or (best.fit.level <= MOSTLY_NOISE and self.explained)

    def left_by(self, score: Score) -> float:
        """Return the held-out error of a hypothesis [-]; that of each is taken once."""
        if score not in self._left:
            self._left[score] = error_of(self.data, score.fit, self.form.held_out)
        return self._left[score]

    def floors_under(self, score: Score) -> dict[int, FloatArray]:
        """Return the error that noise makes under a hypothesis, by test (see `floors_of`)."""
        if score not in self._floors:
            self._floors[score] = floors_of(self.data, score.fit, self.form.held_out)
        return self._floors[score]

    def floor_under(self, score: Score) -> float:
        """Return the noise floor over all tests; NaN if unknown [-]."""
        return pooled_floor(self.floors_under(score))

    def is_explained_by(self, score: Score) -> bool:
        """Return whether a hypothesis leaves no more than noise and what it becomes."""
        return is_within(self.left_by(score), self.floor_under(score))

    def of_tests_under(self, fit: Fit) -> FloatArray:
        """Return the numbers of each test alone by a fit (see `of_tests`), (n, n_tests) [-]."""
        settled = with_starts_fitted(self.data, fit, self.form.held_out)
        return as_free(self.data, (settled or fit).of_tests)

    @cached_property
    def whole(self) -> Windows:
        """What was held out as whole tests, each from where it begins."""
        return replace(whole_tests(self.data, held_out=True), from_rest=False)

    def free_run(self, score: Score) -> Score | None:
        """Return the score of a hypothesis in whole tests, as `compare` simulates them.

        With the sensors as recorded, what each test has of its own, and laws that remember
        nothing from before the test; None where the motion runs away, and of decays, which
        have no run from rest. That of each is taken once.
        """
        if self.data.model.excitation.role is None:
            return None
        if score not in self._free_runs:
            self._free_runs[score] = self._free_run(score.fit)
        return self._free_runs[score]

    def _free_run(self, fit: Fit) -> Score | None:
        data = self.data
        gain, delay, _ = perfect(data)
        of_tests = self.of_tests_under(fit)
        model = fit.hypothesis.model_at(fit.x)
        starts = completed(data, model, self.whole.table, of_tests)
        whole = replace(fit, gain=gain, delay=delay, of_tests=of_tests, starts=starts)
        rows = predicted_rows(data, whole, self.whole)
        return None if rows is None else Score(whole, np.log1p(rows))

    @cached_property
    def as_it_is(self) -> Score | None:
        """The model as it is in its file, scored; None where it runs away."""
        return scored(self.data, self.before, self.form.held_out)


def is_within(left: float, floor: float) -> bool:
    """Return whether an error is no more than a noise floor [-]."""
    return left <= EXCESS * floor
